//! Drag of the air on triangles.

use super::{Motion, Oracle, Vec3, add, cross, dot, sub};

impl Oracle {
    /// Drag on each node of each triangle, and its power.
    pub(super) fn add_drag(&self, motion: &mut Motion) -> f64 {
        let Motion { positions, velocities, forces } = motion;
        let (factor, turning) = self.drag;
        let mut power = 0.0;
        for nodes in &self.triangles {
            let nodes = nodes.map(|node| node as usize);
            let [a, b, c]: [Vec3; 3] = nodes.map(|node| positions[node]);
            let normal = cross(sub(b, a), sub(c, a));
            for node in nodes {
                let ([x, y, _], [u, v, w]) = (positions[node], velocities[node]);
                let wind = [u - turning * y, v + turning * x, w];
                let resistance = factor * dot(normal, wind).abs();
                power -= resistance * dot(wind, velocities[node]);
                add(&mut forces[node], -resistance, wind);
            }
        }
        power
    }
}
