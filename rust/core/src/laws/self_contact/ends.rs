//! Fast pairs: closest points that are others at the end of a step.
//!
//! Impulses act on the closest points of the start of a step, and along their gap. Where the layers move further within
//! the step than they keep, other points come together, and the distance at the end is another one, by terms of second
//! order. Pairs whose nodes do count as near whatever their closest points do, unless a direction keeps them apart
//! (`look`). Those whose closest points do are measured at the end: where they would be too near, or on the other side,
//! they go on with the closest points of the end and its normal n, on the side of the start,
//!
//!     n . sum of w_q (x_q + dt u_q) >= d_m    or   v_n >= (d_m - n . sum of w_q x_q) / dt
//!
//! with less than d_m where the gap is oblique, and are swept again: sequential linearisation of the constraint at the
//! end of the step. It replaces what restitution asks for, of few pairs: what rebounds is seldom near at the end. The
//! next step begins with the impulse of the last round alone.

use nalgebra::Vector3;

use super::contact::{Contact, Drifting, limit, row, shares_and_mass};
use crate::arrays::state::NodeVectors;
use crate::contact::closest::{edge_edge, node_triangle};
use crate::simd::lanes::{F64x8, LANES};

/// Cosines of the angles by which a normal turns within a step, up to which its side follows from that of the start,
/// and follows surely.
const SOME_SIDE: f64 = 0.1;
const SAME_SIDE: f64 = 0.5;
/// Share of the distance that a pair keeps, below which it goes on with the closest points of the end.
pub(super) const ENOUGH: f64 = 0.9;

/// The closest points of a pair and the normal of its layers, for the positions of its nodes.
pub(super) struct Ends {
    weights: [f64; 4],
    pub(super) gap: Vector3<f64>,
    pub(super) normal: Vector3<f64>,
}

impl Ends {
    pub(super) fn of(points: [Vector3<f64>; 4], has_edges: bool) -> Self {
        let x = points.map(|point| [point.x, point.y, point.z].map(|value| F64x8([value; LANES])));
        let found = if has_edges { edge_edge(x) } else { node_triangle(x) };
        Self::with(found.weights.map(|weight| weight.0[0]), found.gap.map(|gap| gap.0[0]).into(), points, has_edges)
    }

    /// Those with these weights and this gap.
    pub(super) fn with(weights: [f64; 4], gap: Vector3<f64>, points: [Vector3<f64>; 4], has_edges: bool) -> Self {
        let [p, a, b, c] = points;
        let normal = if has_edges { (a - p).cross(&(c - b)) } else { (b - a).cross(&(c - a)) };
        Self { weights, gap, normal }
    }

    /// The distance, negative where it is on the other side of the normal.
    pub(super) fn distance(&self) -> f64 {
        self.normal.dot(&self.gap)
    }

    /// Whether the closest points are inside.
    pub(super) fn are_inner(&self) -> bool {
        self.weights.iter().all(|weight| *weight != 0.0)
    }
}

impl Contact {
    /// The closest points at the end of a drift, with the normal on the side of the start, which is known where it
    /// turns by less than an angle with this cosine.
    fn at_end(&self, positions: &NodeVectors, drifting: &Drifting<'_>, cosine: f64) -> Option<Ends> {
        let end = self.nodes.map(|node| row(positions, node) + row(drifting.velocities, node) * drifting.dt);
        let mut ends = Ends::of(end, self.pair.has_edges());
        let normal = if ends.are_inner() { ends.normal } else { ends.gap };
        let (along, size) = (normal.dot(&self.side), normal.norm());
        ends.normal = normal * (along.signum() / size);
        (along.abs() > cosine * size).then_some(ends)
    }

    /// Whether, after all impulses, it passes through within the drift.
    pub(super) fn passes(&self, positions: &NodeVectors, drifting: &Drifting<'_>) -> bool {
        let relative = self.relative(drifting.velocities);
        let is_kept = relative.dot(&self.normal) >= self.limit - self.settled;
        if is_kept && relative.norm() * drifting.dt <= self.kept {
            return false;
        }
        let ends = self.at_end(positions, drifting, SAME_SIDE);
        ends.is_some_and(|ends| ends.are_inner() && ends.distance() <= 0.0)
    }

    /// Takes the closest points of the end of a drift, where it would be too near there. Whether it does.
    pub(super) fn go_on_with_ends(
        &mut self,
        positions: &NodeVectors,
        inverse_masses: &[f64],
        drifting: &Drifting<'_>,
    ) -> bool {
        let dt = drifting.dt;
        if (self.relative(drifting.velocities) * dt).norm() <= self.kept {
            return false;
        }
        let Some(ends) = self.at_end(positions, drifting, SOME_SIDE) else { return false };
        if ends.distance() >= ENOUGH * self.least {
            return false;
        }
        let (shares, mass) = shares_and_mass(ends.weights, self.nodes, inverse_masses);
        if mass == 0.0 {
            return false;
        }
        let start = self.nodes.map(|node| row(positions, node));
        let gap: Vector3<f64> = start.iter().zip(ends.weights).map(|(x, weight)| x * weight).sum();
        let before = ends.normal.dot(&gap);
        (self.weights, self.shares, self.normal, self.mass) = (ends.weights, shares, ends.normal, mass);
        (self.target, self.limit) = ((self.least - before) / dt, limit(self.kept, before, dt));
        // Impulses so far are given.
        (self.pressed, self.along, self.turn) = (0.0, Vector3::zeros(), 0);
        true
    }
}
