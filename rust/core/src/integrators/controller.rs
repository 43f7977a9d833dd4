//! Control of an adaptive step, proportional and integral (Gustafsson 1991), with the constants of DOPRI5 in Hairer,
//! Norsett and Wanner, Solving Ordinary Differential Equations I, section II.4:
//!
//!     dt_next = dt min(5, max(1/10, 0.9 err^-(1/5 - 3/4 beta) err_last^beta)),   beta = 0.04
//!
//! The step does not grow directly after a rejected step.

const BETA: f64 = 0.04;
const EXPONENT: f64 = 0.2 - 0.75 * BETA;
const SAFETY: f64 = 0.9;
const LARGEST_FACTOR: f64 = 5.0;
const LEAST_FACTOR: f64 = 0.1;
/// Lower bound of err_last: a smaller error predicts nothing about the next.
const LEAST_ERROR: f64 = 1e-4;

/// The next step, and the outcome of the attempts so far.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Controller {
    /// The next step to attempt \[s\].
    pub dt: f64,
    /// Error of the last accepted step.
    pub last_error: f64,
    /// Whether the last attempt was rejected.
    pub was_rejected: bool,
    /// Number of rejected steps so far.
    pub rejected_count: u64,
}

impl Controller {
    /// A controller with the first step `dt`.
    pub fn new(dt: f64) -> Self {
        Self { dt, last_error: LEAST_ERROR, was_rejected: false, rejected_count: 0 }
    }

    /// Whether a step with this error is accepted (1 or less); chooses the next step.
    pub fn accepts(&mut self, error: f64) -> bool {
        let scaled = error.max(1e-30).powf(EXPONENT);
        if error <= 1.0 {
            let factor = SAFETY * self.last_error.powf(BETA) / scaled;
            let largest = if self.was_rejected { 1.0 } else { LARGEST_FACTOR };
            self.dt *= factor.clamp(LEAST_FACTOR, LARGEST_FACTOR).min(largest);
            self.last_error = error.max(LEAST_ERROR);
            self.was_rejected = false;
            return true;
        }
        self.dt *= if error.is_finite() { (SAFETY / scaled).clamp(LEAST_FACTOR, 1.0) } else { LEAST_FACTOR };
        self.was_rejected = true;
        self.rejected_count += 1;
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_grow_on_small_errors_and_shrink_on_large_ones_within_bounds() {
        let mut controller = Controller::new(1.0);
        assert!(controller.accepts(0.0) && controller.dt == LARGEST_FACTOR);
        assert!(!controller.accepts(1e9) && controller.dt == LARGEST_FACTOR * LEAST_FACTOR);
        let before = controller.dt;
        assert!(controller.accepts(1e-9) && controller.dt == before, "no growth after a rejected step");
        assert!(!controller.accepts(f64::NAN) && !controller.accepts(f64::INFINITY));
        assert_eq!(controller.rejected_count, 3);
        let (before, _) = (controller.dt, controller.accepts(1.0));
        assert!(controller.dt < before);
    }
}
