//! The jacobian of the film's damping, a stress eta C : dE/dt: with the gradient of velocity by the rate of strain, with
//! that of position by the rate of strain and by the geometric part.

use super::TriangleDamping;
use crate::arrays::jacobian::{JacobianBlocks, at, of_differences};
use crate::laws::Instant;

impl TriangleDamping {
    pub(in crate::laws) fn nodes(&self, visit: &mut dyn FnMut(&[u32])) {
        self.flat.elements.each().for_each(|(.., nodes)| visit(&nodes));
    }

    pub(in crate::laws) fn jacobian(&self, instant: Instant<'_>, jacobian: &mut dyn JacobianBlocks) {
        let taut = self.flat.taut();
        for (batch, lane, nodes) in self.flat.elements.each() {
            let here = self.flat.one(batch, lane, nodes.map(|node| at(instant.positions, node)));
            let moving = self.flat.one(batch, lane, nodes.map(|node| at(instant.velocities, node)));
            let elastic = taut * self.time[batch].0[lane];
            // dE/dt is bilinear in both gradients, so each one's slope is the other's strain slope.
            let (by_rate, by_place) = (here.strain_slope(), moving.strain_slope());
            let ([f1, f2], [g1, g2]) = (here.gradient, moving.gradient);
            let rate = nalgebra::Vector3::new(f1.dot(&g1), f2.dot(&g2), 0.5 * (f1.dot(&g2) + f2.dot(&g1)));
            let stress = elastic * rate;
            let with_velocity = here.by_stress(&(elastic * by_rate));
            let with_position =
                here.by_stress(&(elastic * by_place)) + here.geometric([stress[0], stress[1], stress[2]]);
            of_differences(nodes, &here.by_sides(&with_velocity), |i, j, block| jacobian.by_velocity(i, j, block));
            of_differences(nodes, &here.by_sides(&with_position), |i, j, block| jacobian.by_position(i, j, block));
        }
    }
}
