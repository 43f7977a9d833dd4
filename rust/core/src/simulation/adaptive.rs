//! Steps chosen by their error, for methods with an error estimate.
//!
//! The run steps ahead of the output time, and interpolates within its last step. Output times therefore cut no step,
//! and results do not depend on them.

use super::{AdaptiveProgress, Simulation};
use crate::arrays::state::State;
use crate::error::{Error, Result};
use crate::integrators::{Controller, Embedded, Endpoint};
use crate::model::checks::positive;

/// First step of a scene without a stability limit \[s\]; later steps grow up to fivefold each.
const FIRST_STEP: f64 = 1e-6;

/// State of the step control.
pub(super) struct Adaptive {
    /// The time at the end of the last step \[s\].
    step_end_time: f64,
    /// The output time \[s\].
    pub(super) output_time: f64,
    /// State and work at the end of the last step, while those of an earlier output time are in place.
    held_step_end: Option<(State, Vec<f64>)>,
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
        let tolerance = self.settings.tolerance;
        positive("tolerance", tolerance.relative)?;
        positive("length of the tolerance [m]", tolerance.length)?;
        positive("speed of the tolerance [m/s]", tolerance.speed)?;
        let first_dt = if limit.is_finite() { self.settings.margin * limit } else { FIRST_STEP };
        self.adaptive = Some(Adaptive {
            step_end_time: 0.0,
            output_time: 0.0,
            held_step_end: None,
            controller: Controller::new(first_dt),
            first_dt,
        });
        Ok(())
    }

    /// Steps until `time` is passed, at most `most` times, then interpolates at `time`. Whether `time` was reached.
    ///
    /// # Errors
    /// As `step`.
    pub fn reach(&mut self, time: f64, most: u64) -> Result<bool> {
        for _ in 0..most {
            match &self.adaptive {
                Some(adaptive) if adaptive.step_end_time < time => self.step(1)?,
                _ => break,
            }
        }
        let is_reached = self.adaptive.as_ref().is_some_and(|adaptive| adaptive.step_end_time >= time);
        if is_reached {
            self.interpolate(time);
        }
        Ok(is_reached)
    }

    /// One accepted step from the end of the last one.
    pub(super) fn adaptive_step(&mut self) -> Result<()> {
        self.restore_step_end();
        let Some(adaptive) = &mut self.adaptive else { return Ok(()) };
        let time = adaptive.step_end_time;
        loop {
            let dt = adaptive.controller.dt;
            if dt <= f64::EPSILON * adaptive.first_dt.max(time) {
                break;
            }
            let Some(method) = self.integrator.embedded() else { return Ok(()) };
            let from = Endpoint { time, state: &self.state, work: &self.ledger.work };
            let error = method.attempt(&mut self.mechanics, from, dt, &self.settings.tolerance);
            if adaptive.controller.accepts(error) {
                method.accept(&mut self.state, &mut self.ledger.work);
                adaptive.step_end_time = time + dt;
                adaptive.output_time = adaptive.step_end_time;
                self.step_count += 1;
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

    /// Puts the state at the end of the last step in place, for the next one.
    fn restore_step_end(&mut self) {
        if let Some(adaptive) = &mut self.adaptive
            && let Some((state, work)) = adaptive.held_step_end.take()
        {
            (self.state, self.ledger.work, adaptive.output_time) = (state, work, adaptive.step_end_time);
        }
    }

    /// Interpolates the state at `time`, at most that of the end of the last step.
    fn interpolate(&mut self, time: f64) {
        self.restore_step_end();
        let Some(adaptive) = &mut self.adaptive else { return };
        if time < adaptive.step_end_time
            && let Some(method) = self.integrator.embedded()
        {
            let end = Endpoint { time: adaptive.step_end_time, state: &self.state, work: &self.ledger.work };
            let (state, work) = Embedded::interpolate(method, end, time);
            adaptive.held_step_end =
                Some((std::mem::replace(&mut self.state, state), std::mem::replace(&mut self.ledger.work, work)));
            adaptive.output_time = time;
        }
    }

    /// State and work at the end of the last step.
    pub(super) fn state_at_step_end(&self) -> (&State, &[f64]) {
        let held = self.adaptive.as_ref().and_then(|adaptive| adaptive.held_step_end.as_ref());
        held.map_or((&self.state, &self.ledger.work), |(state, work)| (state, work))
    }

    /// The output time becomes the end of the last step.
    pub(super) fn restart_adaptive(&mut self) {
        if let Some(adaptive) = &mut self.adaptive {
            (adaptive.step_end_time, adaptive.held_step_end) = (adaptive.output_time, None);
        }
    }

    /// Restarts the step control at an earlier time; the count of rejected steps is kept.
    pub(super) fn roll_back_adaptive(&mut self, time: f64) {
        if let Some(adaptive) = &mut self.adaptive {
            (adaptive.step_end_time, adaptive.output_time, adaptive.held_step_end) = (time, time, None);
            adaptive.controller =
                Controller { rejected_count: adaptive.controller.rejected_count, ..Controller::new(adaptive.first_dt) };
        }
    }

    pub(super) fn adaptive_progress(&self) -> Option<AdaptiveProgress> {
        let adaptive = self.adaptive.as_ref()?;
        Some(AdaptiveProgress {
            step_end_time: adaptive.step_end_time,
            output_time: adaptive.output_time,
            controller: adaptive.controller,
        })
    }

    pub(super) fn resume_adaptive(&mut self, saved: Option<&AdaptiveProgress>) -> Result<()> {
        match (&mut self.adaptive, saved) {
            (Some(adaptive), Some(saved)) => {
                positive("saved step [s]", saved.controller.dt)?;
                (adaptive.step_end_time, adaptive.output_time, adaptive.controller) =
                    (saved.step_end_time, saved.step_end_time, saved.controller);
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

    pub(super) fn interpolate_saved(&mut self, saved: Option<&AdaptiveProgress>) {
        if let Some(saved) = saved {
            self.interpolate(saved.output_time);
        }
    }
}
