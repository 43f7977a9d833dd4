//! The default step of a run of constant step. It follows from the scene, the method and its settings alone, so that it
//! depends neither on the end of the run nor on its outputs. Three bounds apply, of which the smallest counts:
//!
//! 1. stability: a share of the limit, or of an implicit method `LONG_STEP` explicit limits 2/omega;
//! 2. slow motion: the frequency error c (omega dt)^p of the method (`Properties::frequency_error`) at the rate at
//!    which the frame turns velocities, 2 Omega, and at the frequency of the external loads,
//!    omega^2 = (mean |a|^2)^1/2 / size;
//! 3. response: the same at the frequency of the response of the scene to its loads at the start, where few elements
//!    carry the motion, so that their own vibration is the motion. With M a the force at the start and K the stiffness,
//!    (K + omega_0^2 M) u = M a,   omega^2 = (u . M a)/(u . M u),   omega_0 the frequency of 2.
//!
//!    Where there are no loads, or no element bears them, as in a slack cord that falls, nothing is known of the
//!    motion: in a scene of few nodes it is the largest frequency, since a cord becomes taut with all its modes.
//!
//! An error of 1 % of the motion is reached after 0.01 over the frequency error, in radians.

use super::tolerance::ULPS;
use super::{Simulation, implicit};
use crate::arrays::history::History;
use crate::arrays::state::NodeVectors;
use crate::error::{Error, Result};
use crate::integrators::System;
use crate::linear::lanczos::apply;
use crate::linear::tangent::Weights;
use crate::model::checks::positive;
use crate::stability::Limit;

/// Least number of default steps in a power of ten of a second: rounding shortens a step by at most one in this.
const LEAST_COUNT: f64 = 100.0;

/// Frequency errors of slow motion and of the response that a default step may have, and the free nodes up to which a
/// scene without loads has the largest frequency as that of its motion. An implicit method is chosen for its long
/// steps.
struct Allowed {
    slow: f64,
    response: f64,
    few_nodes: usize,
}
const EXPLICIT: Allowed = Allowed { slow: 5e-7, response: 5e-5, few_nodes: 60 };
const IMPLICIT: Allowed = Allowed { slow: 1e-5, response: 1e-3, few_nodes: 1 };

/// Number of iterations for the response, the residual at which they are enough, relative to the loads, and nodes
/// beyond which they are not tried.
const ITERATIONS: usize = 60;
const RESIDUAL: f64 = 1e-2;
const MOST_NODES: usize = 1000;
/// Free nodes up to which the same holds of loads that no element bears: those of a tip on one segment.
const FALLING_NODES: usize = 1;
/// Least omega^2 of a response that elements bear, in omega_0^2.
const LEAST_BORNE: f64 = 2.0;
/// Least omega_0, relative to the largest frequency.
const LEAST_SHIFT: f64 = 1e-5;

impl Simulation {
    /// Changes the step. The count of steps restarts; the ledger continues. An adaptive run attempts it next.
    ///
    /// # Errors
    /// `OutOfRange`.
    pub fn set_dt(&mut self, dt: f64) -> Result<()> {
        positive("dt [s]", dt)?;
        if let Some(adaptive) = &mut self.adaptive {
            adaptive.controller.dt = dt;
            return Ok(());
        }
        let is_between = self.continue_from_output();
        self.count_anew(self.time());
        (self.good.origin, self.good.origin_step, self.good.step_count) = (self.good.time, 0, 0);
        let (is_started, before) = (self.integrator.is_started(), self.energy_shift(self.dt));
        let is_longer = is_between || dt > self.dt;
        self.dt = dt;
        if is_longer && is_started && self.mechanics.has_impulses() {
            // Impulses were those for a shorter drift.
            let shift = self.ledger.start_shift;
            self.integrator.restore_history(History::default());
            self.good.history = History::default();
            self.start_if_needed();
            self.ledger.start_shift = shift;
        }
        if is_started {
            // The modified energy depends on the step.
            self.ledger.start_shift += self.energy_shift(dt) - before;
        }
        Ok(())
    }

    /// The step of a run whose step is not given.
    ///
    /// # Errors
    /// `NoStiffness` for a scene without stability limit.
    pub(super) fn default_step(&mut self, limit: &Limit) -> Result<f64> {
        let is_implicit = self.properties().is_implicit;
        let stable = if is_implicit && limit.largest_frequency > 0.0 {
            implicit::LONG_STEP * 2.0 / limit.largest_frequency
        } else if limit.dt.is_finite() {
            (self.settings.margin * limit.dt).min(self.resonance_bound(limit))
        } else {
            return Err(Error::NoStiffness);
        };
        let allowed = if is_implicit { IMPLICIT } else { EXPLICIT };
        let (error, exponent) = self.properties().frequency_error;
        let accurate =
            |allowed: f64, frequency: f64| match (allowed / error).powf(1.0 / f64::from(exponent)) / frequency {
                dt if dt > 0.0 => dt,
                _ => f64::INFINITY,
            };
        let slow = self.slow_frequency();
        let response = self.response_frequency(slow, limit.largest_frequency, allowed.few_nodes);
        Ok(rounded(stable.min(accurate(allowed.slow, slow)).min(accurate(allowed.response, response))))
    }

    /// Accelerations at present by the laws whose rows `takes` \[m/s2\].
    fn accelerations_by(&mut self, takes: impl Fn(&Self, usize) -> bool) -> NodeVectors {
        let mut accelerations = NodeVectors::zeros(self.mechanics.masses.len());
        let state = self.state.clone();
        let at = self.mechanics.instant(state.at(self.time()));
        for row in (0..self.mechanics.laws.len()).filter(|row| takes(self, *row)).collect::<Vec<_>>() {
            self.mechanics.add_forces_of(row, at, &mut accelerations);
        }
        for mut column in accelerations.column_iter_mut() {
            column.iter_mut().zip(&self.mechanics.inverse_masses).for_each(|(value, inverse)| *value *= inverse);
        }
        accelerations
    }

    /// Frequency of the frame and of the motion under external loads \[rad/s\].
    fn slow_frequency(&mut self) -> f64 {
        let frame_rate = 2.0 * self.frame_rate();
        let external = self.accelerations_by(|all, row| !all.mechanics.laws[row].properties().is_internal);
        let (free, masses) = (&self.mechanics.inverse_masses, &self.mechanics.masses);
        let rows = external.row_iter().zip(free.iter().zip(masses)).filter(|(_, (inverse, _))| **inverse > 0.0);
        let (squares, mass) =
            rows.fold((0.0, 0.0), |(sum, mass), (row, (_, m))| (sum + m * row.norm_squared(), mass + m));
        let size = self.state.positions.column_iter().map(|column| (column.max() - column.min()).powi(2));
        let by_load = (squares / mass / size.sum::<f64>()).powf(0.25);
        if by_load.is_finite() { frame_rate.max(by_load) } else { frame_rate }
    }

    /// Frequency of the response to the forces at the start \[rad/s\]; 0 where it is not found.
    fn response_frequency(&mut self, slow: f64, largest: f64, few_nodes: usize) -> f64 {
        let loads = self.accelerations_by(|_, _| true);
        let shift = slow.max(LEAST_SHIFT * largest);
        let rounding = ULPS * f64::EPSILON * largest * largest * self.state.positions.amax();
        let is_loaded = loads.amax() > rounding;
        let square = if is_loaded { self.response_square(&loads, shift) } else { Some(0.0) };
        let few_nodes = if is_loaded { few_nodes.min(FALLING_NODES) } else { few_nodes };
        let free = self.mechanics.inverse_masses.iter().filter(|inverse| **inverse > 0.0).count();
        match square {
            Some(square) if square < LEAST_BORNE * shift * shift && free <= few_nodes => largest,
            square => square.unwrap_or(0.0).sqrt(),
        }
    }

    /// omega^2 of the response to loads; `None` where it is not found.
    fn response_square(&mut self, loads: &NodeVectors, shift: f64) -> Option<f64> {
        // Iterations give the exact response of few nodes, with slack cords taut as they soon will be.
        let response = if self.properties().is_implicit && loads.len() > ITERATIONS {
            self.response_by_factor(loads, shift)
        } else {
            self.response_by_iteration(loads, shift)
        }?;
        let weighted = |other: &NodeVectors| self.mechanics.mass_product(&response, other);
        let square = weighted(loads) / weighted(&response);
        (square.is_finite() && square > 0.0).then_some(square)
    }

    /// u by the factor of an implicit method; `None` for a tangent that is not positive definite: an unstable start is
    /// left by slower motion than its vibrations.
    fn response_by_factor(&mut self, loads: &NodeVectors, shift: f64) -> Option<NodeVectors> {
        let state = self.state.clone();
        let at = state.at(self.time());
        let weights = Weights { mass: shift * shift, damping: 0.0, stiffness: 1.0 };
        let is_factorised = self.mechanics.factorise(at, weights);
        let mut response = loads.clone();
        self.mechanics.solve(&mut response);
        is_factorised.then_some(response)
    }

    /// u by the method of conjugate gradients, of the stiffest linearisation, with y = M^1/2 u; `None` where the
    /// iterations are not enough: many elements carry the motion, which is then slower than their vibrations.
    fn response_by_iteration(&self, loads: &NodeVectors, shift: f64) -> Option<NodeVectors> {
        if loads.nrows() > MOST_NODES {
            return None;
        }
        let at = self.instant();
        let roots: Vec<f64> = self.mechanics.inverse_masses.iter().map(|inverse| inverse.sqrt()).collect();
        let stiffness = |p: &NodeVectors, out: &mut NodeVectors| {
            let linearised = self.mechanics.laws.iter().filter_map(|law| law.linearisation());
            linearised.for_each(|law| law.add_stiffness_product(at, p, out));
        };
        let scale = |vectors: &mut NodeVectors, factor: fn(f64) -> f64| {
            for mut column in vectors.column_iter_mut() {
                column.iter_mut().zip(&roots).for_each(|(value, root)| *value *= factor(*root));
            }
        };
        let mut residual = loads.clone();
        scale(&mut residual, |root| if root > 0.0 { 1.0 / root } else { 0.0 });
        let (mut y, mut direction) = (NodeVectors::zeros(residual.nrows()), residual.clone());
        let mut square = residual.norm_squared();
        let (end, enough) = (1e-20 * square, RESIDUAL * RESIDUAL * square);
        for _ in 0..ITERATIONS {
            if square <= end {
                break;
            }
            let image = apply(&stiffness, &roots, &direction) + &direction * (shift * shift);
            let length = square / direction.dot(&image);
            y += &direction * length;
            residual -= image * length;
            let next = residual.norm_squared();
            direction = &residual + direction * (next / square);
            square = next;
        }
        scale(&mut y, |root| root);
        (square <= enough).then_some(y)
    }
}

/// The longest step up to `longest` of which a whole number makes the least power of ten of a second that is
/// `LEAST_COUNT` steps or longer \[s\]. So round times are the ends of steps.
fn rounded(longest: f64) -> f64 {
    let decade = |exponent: i32| format!("1e{exponent}").parse().unwrap_or(f64::INFINITY);
    let least = LEAST_COUNT * longest;
    let first = least.log10().floor() as i32;
    let period = (first..first + 3).map(decade).find(|period: &f64| *period >= least);
    period.map_or(longest, |period| period / (period / longest).ceil())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_whole_number_of_default_steps_makes_a_power_of_ten_of_a_second() {
        assert_eq!(rounded(3.55e-6), 1e-3 / 282.0);
        assert_eq!(rounded(1e-5), 1e-5);
        for longest in [1e-300, 7.3e-9, 9.99e-6, 1.0001e-5, 0.0273, 2.0, 4e10] {
            let dt = rounded(longest);
            assert!(dt <= longest && dt >= 0.99 * longest, "{longest}: {dt}");
        }
    }
}
