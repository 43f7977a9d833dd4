//! Newton's method with a search along each correction, for forces with kinks and steps that Newton's method does not
//! solve: a slack flat film under a load across it has no stiffness there until it is taut.
//!
//! The end of a step of forces with a potential is a stationary point of
//!
//!     phi(a') = sum m |a' - a_free|^2 (1 - am)/2 + U(x_f)/(c h^2)
//!
//! whose negative gradient is M times the residual r. A correction d from a positive definite matrix descends, and
//! g(s) = d . M r(a' + s d) is the slope -dphi/ds: its zero is the lowest point along d (Matthies and Strang, Int. J.
//! Numer. Methods Eng. 14, 1979). A full step is taken while g(1) is at least -`SLOPE` g(0); otherwise s is found by
//! regula falsi. Only forces are evaluated, no energies. A film that bears no compression has a convex phi, with one
//! lowest point, which this reaches from any guess.

use super::{GeneralizedAlpha, Interval, ROUNDING, TOLERANCE, largest};
use crate::integrators::System;

/// Largest number of corrections, and of evaluations along one.
const CORRECTIONS: u32 = 200;
const EVALUATIONS: u32 = 20;
/// Slope at which a search along a correction ends, over that at its start.
const SLOPE: f64 = 0.5;

impl GeneralizedAlpha {
    /// Finds a' by descent; a failure gives the node with the largest last correction.
    pub(super) fn descend(&mut self, system: &mut dyn System, interval: &Interval<'_>) -> Result<(), usize> {
        let (size, scale) = (interval.from.positions.amax(), self.beta * interval.h * interval.h);
        self.guess(system, interval);
        self.evaluate(system, interval);
        for _ in 0..CORRECTIONS {
            self.statistics.iterations += 1;
            if !self.residual.sum().is_finite() || !self.factorise(system, interval) {
                break;
            }
            self.correction.copy_from(&self.residual);
            system.solve(&mut self.correction);
            let (displacement, (_, correction)) = (self.largest_displacement(interval), largest(&self.correction));
            if scale * correction <= TOLERANCE[0] * displacement + TOLERANCE[1] * size {
                return Ok(());
            }
            if !self.search(system, interval) {
                // The last evaluation becomes that of `next` again.
                self.trial.copy_from(&self.next);
                self.evaluate(system, interval);
                if scale * correction <= ROUNDING[0] * displacement + ROUNDING[1] * size {
                    return Ok(());
                }
                break;
            }
            self.next.copy_from(&self.trial);
        }
        Err(largest(&self.correction).0)
    }

    /// Moves `trial` along the correction to where the slope is small. Whether there is such a place.
    fn search(&mut self, system: &mut dyn System, interval: &Interval<'_>) -> bool {
        let start = system.mass_product(&self.correction, &self.residual);
        let (mut share, mut low, mut high) = (1.0, (0.0, start), None);
        for _ in 0..EVALUATIONS {
            self.trial.copy_from(&self.next);
            self.trial.zip_apply(&self.correction, |a, correction| *a += share * correction);
            self.evaluate(system, interval);
            let slope = system.mass_product(&self.correction, &self.residual);
            if slope.abs() <= SLOPE * start || (slope > 0.0 && share == 1.0) {
                return true;
            }
            if slope > 0.0 {
                low = (share, slope);
            } else {
                // Also where it is not finite.
                high = Some((share, slope));
            }
            share = match high {
                // At least a tenth of the interval from either end.
                Some((end, of_end)) if of_end.is_finite() => {
                    let part: f64 = low.1 / (low.1 - of_end);
                    low.0 + part.clamp(0.1, 0.9) * (end - low.0)
                }
                Some((end, _)) => low.0 + 0.1 * (end - low.0),
                None => return false,
            };
        }
        false
    }
}
