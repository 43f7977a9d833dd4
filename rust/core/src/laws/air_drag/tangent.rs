//! The Jacobian of the drag F = -f |n . V| V on each node of a triangle, with n = (b - a) x (c - a),
//! V = v + Omega x r:
//!
//!     dF/dV = -f (|n . V| + sign(n . V) V n^T),     dF/dn = -f sign(n . V) V V^T
//!
//! and V . dn = db . ((c - a) x V) + dc . (V x (b - a)); the derivative by a is minus the sum of those by b and c.

use nalgebra::Matrix3;

use super::AirDrag;
use crate::arrays::jacobian::{Block, JacobianBlocks, at};
use crate::laws::Instant;

impl AirDrag {
    pub(super) fn jacobian(&self, instant: Instant<'_>, jacobian: &mut dyn JacobianBlocks) {
        let rate = self.rate(instant.frame);
        let turning = Matrix3::new(0.0, -rate, 0.0, rate, 0.0, 0.0, 0.0, 0.0, 0.0);
        for (batch, lane, nodes) in self.facets.elements.each() {
            let r = nodes.map(|node| at(instant.positions, node));
            let (to_b, to_c) = (r[1] - r[0], r[2] - r[0]);
            let (normal, factor) = (to_b.cross(&to_c), self.factor * self.facets.presence[batch].0[lane]);
            for k in 0..3 {
                let wind = at(instant.velocities, nodes[k]) + turning * r[k];
                let flow = normal.dot(&wind);
                let along = -factor * 1.0_f64.copysign(flow);
                let by_wind = Block::identity() * (-factor * flow.abs()) + wind * normal.transpose() * along;
                jacobian.by_velocity(nodes[k], nodes[k], &by_wind);
                jacobian.by_position(nodes[k], nodes[k], &(by_wind * turning));
                let by_b = wind * to_c.cross(&wind).transpose() * along;
                let by_c = wind * wind.cross(&to_b).transpose() * along;
                jacobian.by_position(nodes[k], nodes[1], &by_b);
                jacobian.by_position(nodes[k], nodes[2], &by_c);
                jacobian.by_position(nodes[k], nodes[0], &-(by_b + by_c));
            }
        }
    }
}
