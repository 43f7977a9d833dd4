//! The Jacobian of the damping of the film, with the stress eta C : dE/dt. The derivative by the gradient of velocity
//! has a material part; that by the deformation gradient has a material and a geometric part.

use super::TriangleDamping;
use crate::arrays::jacobian::{JacobianBlocks, at, of_differences};
use crate::laws::Instant;

impl TriangleDamping {
    pub(in crate::laws) fn visit_couplings(&self, visit: &mut dyn FnMut(&[u32])) {
        self.flat.elements.each().for_each(|(.., nodes)| visit(&nodes));
    }

    pub(in crate::laws) fn jacobian(&self, instant: Instant<'_>, jacobian: &mut dyn JacobianBlocks) {
        for (batch, lane, nodes) in self.flat.elements.each() {
            let position = self.flat.single(batch, lane, nodes.map(|node| at(instant.positions, node)));
            let velocity = self.flat.single(batch, lane, nodes.map(|node| at(instant.velocities, node)));
            let elastic = self.flat.taut(batch, lane) * self.time[batch].0[lane];
            // dE/dt is bilinear in both gradients: its derivative by one is the derivative of the strain of the other.
            let (by_velocity, by_position) = (position.strain_derivative(), velocity.strain_derivative());
            let ([f1, f2], [g1, g2]) = (position.gradient, velocity.gradient);
            let rate = nalgebra::Vector3::new(f1.dot(&g1), f2.dot(&g2), 0.5 * (f1.dot(&g2) + f2.dot(&g1)));
            let stress = elastic * rate;
            let with_velocity = position.material(&(elastic * by_velocity));
            let with_position =
                position.material(&(elastic * by_position)) + position.geometric([stress[0], stress[1], stress[2]]);
            of_differences(nodes, &position.by_sides(&with_velocity), |i, j, block| jacobian.by_velocity(i, j, block));
            of_differences(nodes, &position.by_sides(&with_position), |i, j, block| jacobian.by_position(i, j, block));
        }
    }
}
