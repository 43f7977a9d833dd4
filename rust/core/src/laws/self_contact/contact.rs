//! A pair that may have an impulse.

use nalgebra::Vector3;

use super::look::{Near, RECOVERY, least_approach};
use super::oblique::least_of_oblique;
use super::surface::Pair;
use crate::arrays::state::NodeVectors;
use crate::contact::separation::comes_near;
use crate::simd::lanes::{F64x8, SimdF64};
use crate::simd::map::Formula;

/// Share of the distance that a pair keeps, below which it may not come after all sweeps.
const NEAREST: f64 = 0.25;
/// The change of velocity below which a pair is left as it is: relative to the distance that it keeps in a step, and to
/// v_r. With beta = 0.02 what is left is that of a pair that is by an eighth of this distance too near.
const SETTLED: [f64; 2] = [0.0025, 0.125];

/// Coefficients of the law.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Coefficients {
    pub(super) friction: f64,
    pub(super) restitution: f64,
    /// beta.
    pub(super) share_of_depth: f64,
}

/// A pair that may have an impulse.
pub(super) struct Contact {
    pub(super) pair: Pair,
    pub(super) nodes: [usize; 4],
    /// w_q, and w_q/m_q \[1/kg\].
    pub(super) weights: [f64; 4],
    pub(super) shares: [f64; 4],
    pub(super) normal: Vector3<f64>,
    /// The normal at the start of the step, on whose side the pair stays.
    pub(super) side: Vector3<f64>,
    /// m_r; 0 where no node is free \[kg\].
    pub(super) mass: f64,
    /// d_m, and the distance to which impulses let it come, which is less where the gap is oblique \[m\].
    pub(super) kept: f64,
    pub(super) least: f64,
    /// Least v_n, and that below which the nodes become a rigid zone \[m/s\].
    pub(super) target: f64,
    pub(super) limit: f64,
    /// Change of v_n below which it is left as it is \[m/s\].
    pub(super) settled: f64,
    /// lam and the tangential impulse \[N s\].
    pub(super) pressed: f64,
    pub(super) along: Vector3<f64>,
    pub(super) turn: u64,
}

/// Velocities of the drift, as impulses change them.
pub(super) struct Drifting<'a> {
    /// u \[m/s\].
    pub(super) velocities: &'a mut NodeVectors,
    /// Velocities v at the kick \[m/s\].
    pub(super) own: &'a NodeVectors,
    /// By which an impulse turns u: w dt/2, with w of the accelerations of Coriolis.
    pub(super) turn: f64,
    pub(super) dt: f64,
}

/// u = v + dt/2 a, with the kick of slow accelerations.
pub(super) struct Drifted {
    pub(super) half: f64,
    pub(super) slow: f64,
}

impl Formula<3, 1> for Drifted {
    #[inline(always)]
    fn row<V: SimdF64>(&self, [v, a, slow]: [V; 3], _: [V; 1]) -> [V; 1] {
        [v + V::all(self.half) * a + V::all(self.slow) * slow]
    }
}

impl Contact {
    /// That of a pair that comes near, whose gap may be oblique; `None` where the distance is 0.
    pub(super) fn of(
        near: &Near,
        is_oblique: bool,
        of: Coefficients,
        inverse_masses: &[f64],
        drifting: &Drifting<'_>,
    ) -> Option<Self> {
        let gap = Vector3::from(near.gap);
        let distance = gap.norm();
        if distance <= 0.0 {
            return None;
        }
        let nodes = near.nodes.map(|node| node as usize);
        let (shares, mass) = shares_and_mass(near.weights, nodes, inverse_masses);
        let settled = (SETTLED[0] * near.kept / drifting.dt).min(SETTLED[1] * RECOVERY);
        let depth = settled * drifting.dt / of.share_of_depth;
        let least = if is_oblique { least_of_oblique(near.kept, depth) } else { near.kept };
        let [room, dt, share] = [distance - least, drifting.dt, of.share_of_depth].map(F64x8::all);
        Some(Self {
            pair: near.pair,
            nodes,
            weights: near.weights,
            shares,
            normal: gap / distance,
            side: gap / distance,
            mass,
            kept: near.kept,
            least,
            target: least_approach(room, dt, share).0[0],
            limit: limit(near.kept, distance, drifting.dt),
            settled,
            pressed: 0.0,
            along: Vector3::zeros(),
            turn: 0,
        })
    }

    /// Raises the target to what restitution asks for, by the relative velocities at the kick and of the drift, both
    /// before impulses.
    pub(super) fn rebound(&mut self, restitution: f64, own: Vector3<f64>, drift: Vector3<f64>) {
        let own = own.dot(&self.normal);
        if own < 0.0 {
            // v_n is to change by -(1 + e) v_n, and the velocity of the drift with it.
            self.target = self.target.max(drift.dot(&self.normal) - (1.0 + restitution) * own);
        }
    }

    /// The gap at the end of the drift, with the closest points of its start \[m\].
    pub(super) fn gap_after(&self, near: &Near, drifting: &Drifting<'_>) -> Vector3<f64> {
        Vector3::from(near.gap) + self.relative(drifting.velocities) * drifting.dt
    }

    /// The relative velocity, the sum of w_q u_q \[m/s\].
    pub(super) fn relative(&self, velocities: &NodeVectors) -> Vector3<f64> {
        let mut sum = Vector3::zeros();
        for (node, weight) in self.nodes.into_iter().zip(self.weights) {
            for axis in 0..3 {
                sum[axis] += weight * velocities[(node, axis)];
            }
        }
        sum
    }
}

/// w_q/m_q \[1/kg\], and m_r, 0 where no node is free \[kg\].
pub(super) fn shares_and_mass(weights: [f64; 4], nodes: [usize; 4], inverse_masses: &[f64]) -> ([f64; 4], f64) {
    let shares: [f64; 4] = std::array::from_fn(|k| weights[k] * inverse_masses[nodes[k]]);
    let inverse: f64 = weights.iter().zip(shares).map(|(weight, share)| weight * share).sum();
    (shares, if inverse > 0.0 { 1.0 / inverse } else { 0.0 })
}

/// v_n below which a pair at a distance comes much too near within a step \[m/s\].
pub(super) fn limit(kept: f64, distance: f64, dt: f64) -> f64 {
    ((NEAREST * kept - distance) / dt).min(0.0)
}

/// The vector of a node.
pub(super) fn row(vectors: &NodeVectors, node: usize) -> Vector3<f64> {
    vectors.row(node).transpose()
}

/// Whether a pair comes nearer than `least` at any time of the drift, in straight lines. With the present closest
/// points its gap becomes `then`, which may be too small while others pass at a distance.
pub(super) fn comes_too_near(
    near: &Near,
    least: f64,
    then: Vector3<f64>,
    positions: &NodeVectors,
    drifting: &Drifting<'_>,
) -> bool {
    let gap = Vector3::from(near.gap);
    let way = then - gap;
    let share = (-gap.dot(&way) / way.norm_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    if (gap + way * share).norm() < least {
        return true;
    }
    let point = |node: u32, time: f64| row(positions, node as usize) + row(drifting.velocities, node as usize) * time;
    let firsts = if near.pair.has_edges() { 2 } else { 1 };
    let mut hull = [Vector3::zeros(); 8];
    let mut count = 0;
    for time in [0.0, drifting.dt] {
        let corners = near.nodes.map(|node| point(node, time));
        for first in &corners[..firsts] {
            for second in &corners[firsts..] {
                hull[count] = first - second;
                count += 1;
            }
        }
    }
    comes_near(&hull[..count], least)
}
