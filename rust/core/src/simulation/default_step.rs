//! The default step of a run of constant step: it follows from the scene, the method and its settings alone, so that it
//! depends neither on the end of the run nor on its outputs.

use super::Simulation;
use crate::error::{Error, Result};
use crate::simulation::implicit;
use crate::stability::Limit;

/// Least number of default steps in a power of ten of a second: rounding shortens a step by at most one in this.
const LEAST_COUNT: f64 = 100.0;

impl Simulation {
    /// The step of a run whose step is not given.
    ///
    /// # Errors
    /// `NoStiffness` for a scene without stability limit.
    pub(super) fn default_step(&self, limit: &Limit) -> Result<f64> {
        let longest = if self.properties().is_implicit && limit.largest_frequency > 0.0 {
            implicit::LONG_STEP * 2.0 / limit.largest_frequency
        } else if limit.dt.is_finite() {
            (self.settings.margin * limit.dt).min(self.resonance_bound(limit))
        } else {
            return Err(Error::NoStiffness);
        };
        Ok(rounded(longest))
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
