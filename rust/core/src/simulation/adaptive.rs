//! Steps chosen by their error, for methods with an error estimate.
//!
//! The run steps ahead of the output time, and interpolates within its last step (`output`). No step crosses a jump.

use super::{AdaptiveProgress, Simulation};
use crate::error::{Error, Result};
use crate::integrators::{Controller, Endpoint};
use crate::model::checks::{positive, within};

/// First step of a scene without a stability limit \[s\]; later steps grow up to fivefold each.
const FIRST_STEP: f64 = 1e-6;
/// A step that ends before a jump by less than this share of itself, less 1, ends at the jump.
const STRETCH: f64 = 1.1;

/// State of the step control.
pub(super) struct Adaptive {
    /// The time at the end of the last step \[s\].
    pub(super) step_end_time: f64,
    pub(super) controller: Controller,
    first_dt: f64,
}

impl Simulation {
    /// Whether steps are chosen by their error.
    pub fn is_adaptive(&self) -> bool {
        self.adaptive.is_some()
    }

    /// Number of rejected steps.
    pub fn rejected_count(&self) -> u64 {
        self.adaptive.as_ref().map_or(0, |adaptive| adaptive.controller.rejected_count)
    }

    /// Sets up the step control.
    pub(super) fn adapt(&mut self, limit: f64) -> Result<()> {
        let first_dt = if limit.is_finite() { self.settings.margin * limit } else { FIRST_STEP };
        self.adaptive = Some(Adaptive { step_end_time: 0.0, controller: Controller::new(first_dt), first_dt });
        Ok(())
    }

    /// One accepted step from the end of the last one.
    pub(super) fn adaptive_step(&mut self) -> Result<()> {
        let jump = self.next_jump();
        let Some(adaptive) = &mut self.adaptive else { return Ok(()) };
        let time = adaptive.step_end_time;
        loop {
            let mut end = time + adaptive.controller.dt;
            if let Some(jump) = jump.filter(|jump| jump - time <= STRETCH * adaptive.controller.dt) {
                (adaptive.controller.dt, end) = (jump - time, jump);
            }
            let dt = adaptive.controller.dt;
            if dt <= f64::EPSILON * adaptive.first_dt.max(time) {
                break;
            }
            let Some(method) = self.integrator.embedded() else { return Ok(()) };
            let from = Endpoint { time, state: &self.state, work: &self.ledger.work };
            let error = method.attempt(&mut self.mechanics, from, dt, &self.settings.tolerance);
            if adaptive.controller.accepts(error) {
                method.accept(&mut self.state, &mut self.ledger.work);
                adaptive.step_end_time = end;
                self.step_count += 1;
                self.set_moved();
                return Ok(());
            }
        }
        let what = format!("no step is small enough for the tolerance of {:e}", self.settings.tolerance.relative);
        let now = self.energy_terms();
        let place = "the last attempted step was below rounding".to_owned();
        let mut fault = self.described(what, place, self.most_changed(&now), &now);
        fault.remedy += "; or allow a larger error per step";
        Err(self.roll_back(fault))
    }

    /// Restarts the step control at an earlier time; the count of rejected steps is kept.
    pub(super) fn roll_back_adaptive(&mut self, time: f64) {
        if let Some(adaptive) = &mut self.adaptive {
            adaptive.step_end_time = time;
            adaptive.controller =
                Controller { rejected_count: adaptive.controller.rejected_count, ..Controller::new(adaptive.first_dt) };
        }
    }

    pub(super) fn adaptive_progress(&self) -> Option<AdaptiveProgress> {
        let adaptive = self.adaptive.as_ref()?;
        Some(AdaptiveProgress { step_end_time: adaptive.step_end_time, controller: adaptive.controller })
    }

    pub(super) fn resume_adaptive(&mut self, saved: Option<&AdaptiveProgress>) -> Result<()> {
        match (&mut self.adaptive, saved) {
            (Some(adaptive), Some(saved)) => {
                positive("saved step [s]", saved.controller.dt)?;
                within("saved time [s]", saved.step_end_time, saved.step_end_time.is_finite(), "it is finite")?;
                (adaptive.step_end_time, adaptive.controller) = (saved.step_end_time, saved.controller);
                Ok(())
            }
            (None, None) => Ok(()),
            (adaptive, _) => Err(Error::LengthMismatch {
                what: "the saved step control",
                found: usize::from(saved.is_some()),
                expected: usize::from(adaptive.is_some()),
                per: "run whose steps are chosen by their error",
            }),
        }
    }
}
