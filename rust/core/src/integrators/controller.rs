//! The controller of an adaptive step: proportional and integral (Gustafsson 1991), with the constants of DOPRI5 in Hairer,
//! Norsett and Wanner, Solving Ordinary Differential Equations I, section II.4:
//!
//!     dt_next = dt min(5, max(1/10, 0.9 err^-(1/5 - 3/4 beta) err_last^beta)),   beta = 0.04
//!
//! and no amplification right after a rejected step.

const BETA: f64 = 0.04;
const EXPONENT: f64 = 0.2 - 0.75 * BETA;
const SAFETY: f64 = 0.9;
const GROWTH: f64 = 5.0;
const SHRINKAGE: f64 = 0.1;
/// Below this an error says nothing about the next.
const LEAST_ERROR: f64 = 1e-4;

/// The step to try next, and how the tries went.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Controller {
    /// The step to try next \[s\].
    pub dt: f64,
    /// Error of the last accepted step.
    pub last_error: f64,
    /// Whether the last try was rejected.
    pub was_rejected: bool,
    /// Tries rejected so far.
    pub rejected_count: u64,
}

impl Controller {
    /// A controller that tries `dt` first.
    pub fn new(dt: f64) -> Self {
        Self { dt, last_error: LEAST_ERROR, was_rejected: false, rejected_count: 0 }
    }

    /// Whether a try with this error is accepted (at 1 or below); chooses the next step.
    pub fn judge(&mut self, error: f64) -> bool {
        let raised = error.max(1e-30).powf(EXPONENT);
        if error <= 1.0 {
            let factor = SAFETY * self.last_error.powf(BETA) / raised;
            let most = if self.was_rejected { 1.0 } else { GROWTH };
            self.dt *= factor.clamp(SHRINKAGE, GROWTH).min(most);
            self.last_error = error.max(LEAST_ERROR);
            self.was_rejected = false;
            return true;
        }
        self.dt *= if error.is_finite() { (SAFETY / raised).clamp(SHRINKAGE, 1.0) } else { SHRINKAGE };
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
        assert!(controller.judge(0.0) && controller.dt == GROWTH);
        assert!(!controller.judge(1e9) && controller.dt == GROWTH * SHRINKAGE);
        let before = controller.dt;
        assert!(controller.judge(1e-9) && controller.dt == before, "no amplification after a rejected try");
        assert!(!controller.judge(f64::NAN) && !controller.judge(f64::INFINITY));
        assert_eq!(controller.rejected_count, 3);
        let (before, _) = (controller.dt, controller.judge(1.0));
        assert!(controller.dt < before);
    }
}
