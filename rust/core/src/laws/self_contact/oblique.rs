//! Oblique gaps: closest points at a border, where others may hold the layers apart.
//!
//! A node above one triangle of a flat layer is beside the next: the gap to that one ends at the edge between both, and
//! is oblique. An impulse along it would brake a node that slides over the edge, without friction. So pairs with an
//! oblique gap come after others, and have an impulse where they would then come nearer than
//!
//!     d_m - min(2 delta, 0.1 d_m),   delta = settled dt/beta
//!
//! with the depth delta at which sweeps may leave a pair: after its first turn they change none by less than `settled`.
//! A node that has slid over the edge is above the next triangle at d_m - delta at least, where both keep the same.
//! Where its gap ceases to be oblique, the push apart is slow.
//!
//! A node above a fold is beside the layer behind its edge: the gap to that one is along the normal, and becomes
//! oblique as the node slides over the edge. So the gap at the end of the drift counts too, where a pair comes closer
//! and does not only slide.

use std::array::from_fn;

use nalgebra::Vector3;

use super::contact::{Drifting, row};
use super::ends::{ENOUGH, Ends};
use super::look::Near;
use crate::arrays::state::NodeVectors;

/// Cosine of the angle between a gap and the normal of a triangle, or of two edges, up to which it is oblique.
const OBLIQUE: f64 = 0.999_999;
/// By which such a pair keeps less than d_m, relative to delta.
const SLACK: f64 = 2.0;
/// Way of the closest points past each other relative to d_m, and cosine of its angle with the gap, beyond which the
/// gap at the end counts too.
const FAR: f64 = 0.1;
const STEEP: f64 = 0.1;

/// The distance that a pair with an oblique gap keeps, by d_m and delta \[m\].
pub(super) fn least_of_oblique(kept: f64, depth: f64) -> f64 {
    kept - (SLACK * depth).min((1.0 - ENOUGH) * kept)
}

impl Ends {
    /// Whether the gap ends at a border and is oblique.
    fn are_oblique(&self) -> bool {
        !self.are_inner() && self.distance().abs() <= OBLIQUE * self.normal.norm() * self.gap.norm()
    }
}

impl Near {
    /// Whether the gap is oblique, or is so at the end of a drift in which its closest points move far enough.
    pub(super) fn is_oblique(&self, positions: &NodeVectors, drifting: &Drifting<'_>) -> bool {
        let has_edges = self.pair.has_edges();
        let points = self.nodes.map(|node| row(positions, node as usize));
        if Ends::with(self.weights, self.gap.into(), points, has_edges).are_oblique() {
            return true;
        }
        let ways = self.nodes.map(|node| row(drifting.velocities, node as usize) * drifting.dt);
        let way: Vector3<f64> = ways.iter().zip(self.weights).map(|(way, weight)| way * weight).sum();
        let gap = Vector3::from(self.gap);
        let is_far = way.norm() > FAR * self.kept && way.dot(&gap).abs() > STEEP * way.norm() * gap.norm();
        is_far && Ends::of(from_fn(|q| points[q] + ways[q]), has_edges).are_oblique()
    }
}
