//! Rigid zones, where impulses do not suffice: nodes of pairs that stay too near after all sweeps move on together.
//!
//! An edge in the wedge of a fold has two pairs with nearly opposite normals, of which sequential impulses let one win.
//! The nodes of such pairs, joined where they have some in common, take the velocities of the rigid body of their
//! momentum and angular momentum for the step, so that they keep their distances: Provot, Collision and self-collision
//! handling in cloth model (1997); Bridson, Fedkiw and Anderson (SIGGRAPH 2002).

use nalgebra::{Matrix3, Vector3};

use super::contact::row;
use crate::arrays::state::NodeVectors;

/// Principal moments of inertia below this share of the largest count as none: the zone does not turn about that axis.
const FLAT: f64 = 1e-9;

/// Zones, as the number of each node's own, so that those that come and go allocate no memory.
#[derive(Default)]
pub(super) struct Zones {
    /// The zone of each node, a number that ascends in order of its last pair that joined nodes; 0 of those in none.
    of: Vec<u32>,
    /// The last one of these numbers.
    last: u32,
    /// The nodes in zones.
    nodes: Vec<usize>,
}

impl Zones {
    pub(super) fn new(nodes: usize) -> Self {
        Self { of: vec![0; nodes], ..Self::default() }
    }

    /// Forgets all.
    pub(super) fn clear(&mut self) {
        self.nodes.drain(..).for_each(|node| self.of[node] = 0);
        self.last = 0;
    }

    /// Whether there is none.
    pub(super) fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// Adds the nodes of a pair, and joins the zones that have one of them. Whether they were not in one zone already.
    pub(super) fn add(&mut self, nodes: [usize; 4]) -> bool {
        let joined = nodes.map(|node| self.of[node]);
        if joined[0] != 0 && joined == [joined[0]; 4] {
            return false;
        }
        self.last += 1;
        for &node in &self.nodes {
            if joined.contains(&self.of[node]) {
                self.of[node] = self.last;
            }
        }
        for node in nodes {
            if std::mem::replace(&mut self.of[node], self.last) == 0 {
                self.nodes.push(node);
            }
        }
        true
    }

    /// Calls `set` with each node and its velocity in a rigid zone, zone by zone and in order of nodes. Held nodes keep
    /// theirs, and so does what they hold.
    pub(super) fn visit(
        &mut self,
        positions: &NodeVectors,
        velocities: &NodeVectors,
        masses: &[f64],
        inverse_masses: &[f64],
        mut set: impl FnMut(usize, Vector3<f64>),
    ) {
        let Self { of, nodes, .. } = self;
        nodes.sort_unstable_by_key(|&node| (of[node], node));
        for zone in nodes.chunk_by(|&node, &other| of[node] == of[other]) {
            let held = zone.iter().filter(|&&node| inverse_masses[node] == 0.0);
            let count = held.clone().count();
            if count > 0 {
                let mean = held.map(|&node| row(velocities, node)).sum::<Vector3<f64>>() / count as f64;
                zone.iter().filter(|&&node| inverse_masses[node] > 0.0).for_each(|&node| set(node, mean));
                continue;
            }
            let mass: f64 = zone.iter().map(|&node| masses[node]).sum();
            let mean = |vectors: &NodeVectors| {
                zone.iter().map(|&node| row(vectors, node) * masses[node]).sum::<Vector3<f64>>() / mass
            };
            let (centre, velocity) = (mean(positions), mean(velocities));
            let (mut inertia, mut momentum) = (Matrix3::zeros(), Vector3::zeros());
            for &node in zone {
                let (arm, own) = (row(positions, node) - centre, row(velocities, node) - velocity);
                inertia += (Matrix3::identity() * arm.norm_squared() - arm * arm.transpose()) * masses[node];
                momentum += arm.cross(&own) * masses[node];
            }
            // No eigenvalues of what is not finite.
            if !(momentum.sum() + inertia.sum()).is_finite() {
                continue;
            }
            let axes = inertia.symmetric_eigen();
            let most = axes.eigenvalues.max();
            let mut rate = Vector3::zeros();
            for (axis, &moment) in axes.eigenvectors.column_iter().zip(axes.eigenvalues.iter()) {
                if moment > FLAT * most {
                    rate += axis * (axis.dot(&momentum) / moment);
                }
            }
            for &node in zone {
                set(node, velocity + rate.cross(&(row(positions, node) - centre)));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_zone_keeps_momentum_and_distances() {
        let positions = NodeVectors::from_fn(6, |node, axis| (1.3 * node as f64 + 2.7 * axis as f64).sin());
        let mut velocities = NodeVectors::from_fn(6, |node, axis| (0.3 + 3.1 * node as f64 + 1.9 * axis as f64).cos());
        let masses = [1.0, 2.0, 0.5, 1.5, 0.7, 1.1];
        let inverse = masses.map(|mass: f64| 1.0 / mass);
        let momenta = |velocities: &NodeVectors| {
            let of = |node: usize| {
                let (x, v) = (positions.row(node).transpose(), velocities.row(node).transpose());
                (v * masses[node], x.cross(&v) * masses[node])
            };
            (0..6).map(of).fold((Vector3::zeros(), Vector3::zeros()), |(p, l), (q, k)| (p + q, l + k))
        };
        let before = momenta(&velocities);
        let mut zones = Zones::new(6);
        assert!(zones.add([0, 1, 2, 3]) && zones.add([3, 4, 1, 0]) && !zones.add([4, 2, 0, 1]));
        let mut rigid = Vec::new();
        zones.visit(&positions, &velocities, &masses, &inverse, |node, velocity| rigid.push((node, velocity)));
        assert_eq!(rigid.len(), 5);
        rigid.iter().for_each(|(node, velocity)| velocities.set_row(*node, &velocity.transpose()));
        let after = momenta(&velocities);
        assert!((before.0 - after.0).norm() < 1e-14 && (before.1 - after.1).norm() < 1e-14);
        for i in 0..5 {
            for j in 0..i {
                let apart = positions.row(i) - positions.row(j);
                assert!(apart.dot(&(velocities.row(i) - velocities.row(j))).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn what_is_held_holds_its_zone() {
        let positions = NodeVectors::from_fn(4, |node, axis| (node * axis) as f64);
        let velocities = NodeVectors::from_fn(4, |node, _| node as f64);
        let mut zones = Zones::new(4);
        zones.add([0, 1, 2, 3]);
        let inverse = [1.0, 1.0, 0.0, 1.0];
        let mut set = Vec::new();
        zones.visit(&positions, &velocities, &[1.0; 4], &inverse, |node, velocity| set.push((node, velocity)));
        assert_eq!(set, [0, 1, 3].map(|node| (node, Vector3::repeat(2.0))));
    }
}
