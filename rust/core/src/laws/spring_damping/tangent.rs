//! The Jacobian of the force of a dashpot, c (d . w) d / d^2, with d from end to end and w its rate:
//!
//!     dF/dw = c d d^T / d^2
//!     dF/dd = c [d w^T + (d . w) (1 - 2 d d^T / d^2)] / d^2
//!
//! At its limit the force is +-N e with N = k (max(l, l_cr) - l_cr), so that, as for a spring,
//!
//!     dF/dw = 0
//!     dF/dd = +-[N' e e^T + N/l (1 - e e^T)]

use super::SpringDamping;
use crate::arrays::jacobian::{Block, JacobianBlocks, at, of_link};
use crate::laws::Instant;

impl SpringDamping {
    pub(super) fn jacobian(&self, instant: Instant<'_>, jacobian: &mut dyn JacobianBlocks) {
        if let Some(film) = &self.film {
            film.jacobian(instant, jacobian);
        }
        let dashpots =
            self.networks.iter().flat_map(|own| own.links.elements.each().map(move |element| (&own.dashpots, element)));
        for (dashpots, (batch, lane, nodes)) in dashpots {
            let [i, j] = nodes;
            let d = at(instant.positions, j) - at(instant.positions, i);
            let w = at(instant.velocities, j) - at(instant.velocities, i);
            let square = d.norm_squared().max(f64::MIN_POSITIVE);
            let factor = dashpots.coefficient[batch].0[lane] / square;
            let (outer, rate) = (d * d.transpose(), d.dot(&w));
            let limit = dashpots.limit.as_ref().map(|springs| springs[batch].excess_at(lane, square.sqrt()));
            if let Some((excess, derivative)) = limit
                && (factor * rate * square.sqrt()).abs() >= excess
            {
                let sign = if rate == 0.0 { 0.0 } else { rate.signum() };
                let per_length = excess / square.sqrt();
                let block = outer * ((derivative - per_length) / square) + Block::identity() * per_length;
                of_link(nodes, &(block * sign), |i, j, block| jacobian.by_position(i, j, block));
                continue;
            }
            of_link(nodes, &(outer * factor), |i, j, block| jacobian.by_velocity(i, j, block));
            let rotation = Block::identity() * rate - outer * (2.0 * rate / square);
            of_link(nodes, &((d * w.transpose() + rotation) * factor), |i, j, block| jacobian.by_position(i, j, block));
        }
    }
}
