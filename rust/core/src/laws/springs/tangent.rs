//! The Jacobian of the force of a spring. With d from end to end, l = |d|, e = d/l and the tension N(l),
//!
//!     dF/dd = N' e e^T + N/l (1 - e e^T)
//!
//! N' = k, and 0 below the critical length, where only the second, geometric part remains: negative in a buckled
//! spring, zero in a slack tether.

use super::{Parameters, Springs};
use crate::arrays::jacobian::{Block, JacobianBlocks, at, of_link};
use crate::laws::Instant;

impl Springs {
    pub(super) fn jacobian(&self, instant: Instant<'_>, jacobian: &mut dyn JacobianBlocks) {
        for (batch, lane, nodes) in self.links.elements.each() {
            let d = at(instant.positions, nodes[1]) - at(instant.positions, nodes[0]);
            let Parameters { stiffness, rest_length, critical_length } = self.parameters[batch];
            let [k, rest, critical] = [stiffness, rest_length, critical_length].map(|values| values.0[lane]);
            let l = d.norm();
            let tension = k * (l.max(critical) - rest);
            // As in the force, which tends to zero over the last 1e-12 of the rest length.
            let per_length = tension / l.max(1e-12 * rest);
            let derivative = if l > critical { k } else { 0.0 };
            let along = (derivative - per_length) / (l * l).max(f64::MIN_POSITIVE);
            of_link(nodes, &(d * d.transpose() * along + Block::identity() * per_length), |i, j, block| {
                jacobian.by_position(i, j, block);
            });
        }
    }
}
