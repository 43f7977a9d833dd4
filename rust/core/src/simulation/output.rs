//! The state shown at an output time between two steps.
//!
//! It is shown in place of the state at the end of the last step, which is held and put back before the next step.
//! Output times therefore cut no step, and results do not depend on them. A run with steps chosen by their error
//! interpolates within its last step. A run of constant step takes a side step: from the end of the last step, by a
//! second instance of the method with the same history, as long as the rest of the way. A side step counts neither as a
//! step nor as evaluations.

use super::Simulation;
use crate::arrays::history::History;
use crate::arrays::state::State;
use crate::error::Result;
use crate::integrators::{Embedded, Endpoint};
use crate::model::checks::within;

/// Most steps to an output time: more are an input error.
const MOST_STEPS: f64 = 1e15;
/// An output time this close to the end of a step is the end of that step: a share of dt, and a number of units in the
/// last place of the time.
const SAME_TIME: (f64, f64) = (1e-9, 8.0);

/// An output time, and what its state displaces.
pub(super) struct Output {
    time: f64,
    /// `None` where the output time is the end of a step.
    held: Option<Held>,
}

/// Data at the end of the last step, while those of an output time are in place.
struct Held {
    state: State,
    work: Vec<f64>,
    /// The histories of the laws, which a side step changes too.
    histories: Option<Vec<History>>,
}

impl Simulation {
    /// Time \[s\]: the output time that is shown, or the end of the last step.
    pub fn time(&self) -> f64 {
        self.output.as_ref().map_or_else(|| self.step_end_time(), |output| output.time)
    }

    /// The time at the end of the last step \[s\].
    pub fn step_end_time(&self) -> f64 {
        let of_constant_step = || self.time_of_whole_step(self.step_count);
        self.adaptive.as_ref().map_or_else(of_constant_step, |adaptive| adaptive.step_end_time)
    }

    /// The output time, where it is not the end of the last step \[s\].
    pub(super) fn output_time(&self) -> Option<f64> {
        self.output.as_ref().map(|output| output.time)
    }

    /// Steps towards `time`, at most `most` times, and shows the state there. Whether `time` was reached. The next
    /// `step` continues from the end of the last step.
    ///
    /// # Errors
    /// `OutOfRange` for a time before the present one or not finite, or too many steps ahead; otherwise as `step`.
    pub fn reach(&mut self, time: f64, most: u64) -> Result<bool> {
        within("time [s]", time, time.is_finite(), "it is finite")?;
        let now = self.time();
        within("time [s]", time, time >= now || self.is_same_time(time, now), "it is not before the present time")?;
        let is_passed =
            if self.adaptive.is_some() { self.step_past(time, most)? } else { self.step_up_to(time, most)? };
        if is_passed {
            if !self.is_finite() {
                self.check(false)?;
            }
            self.show(time)?;
        }
        Ok(is_passed)
    }

    /// Takes at most so many steps chosen by their error, until one ends at `time` or later. Whether one does. A jump
    /// at its end is passed where `time` is that of the jump.
    fn step_past(&mut self, time: f64, most: u64) -> Result<bool> {
        for _ in 0..most {
            if self.step_end_time() >= time {
                break;
            }
            self.whole_step()?;
        }
        let end = self.step_end_time();
        if time >= end || self.is_same_time(time, end) {
            self.put_step_end_back();
            self.pass_due_jumps()?;
        }
        Ok(end >= time)
    }

    /// Takes at most so many constant steps, as many as end at `time` or before, and passes the jumps up to `time`.
    /// Whether those were all.
    fn step_up_to(&mut self, time: f64, most: u64) -> Result<bool> {
        self.steps_until(time)?;
        let mut left = most;
        loop {
            let jump = self.next_jump().filter(|&jump| jump <= time || self.is_same_time(time, jump));
            let ahead = self.steps_until(jump.unwrap_or(time))?.saturating_sub(self.step_count);
            self.step(ahead.min(left))?;
            if ahead > left {
                return Ok(false);
            }
            left -= ahead;
            let Some(jump) = jump else { return Ok(true) };
            self.put_step_end_back();
            self.go_past(jump)?;
            if left == 0 {
                return Ok(false);
            }
            left -= 1;
        }
    }

    /// Number of whole steps up to `time`, of a run of constant step.
    fn steps_until(&self, time: f64) -> Result<u64> {
        let steps = (time - self.origin) / self.dt;
        within("time [s]", time, steps <= MOST_STEPS, "it is at most 10^15 steps of dt ahead")?;
        let nearest = steps.round().max(0.0);
        let is_step = self.is_same_time(time, self.origin + nearest * self.dt);
        Ok(self.origin_step + if is_step { nearest } else { steps.floor().max(0.0) } as u64)
    }

    pub(super) fn is_same_time(&self, time: f64, other: f64) -> bool {
        let (share, ulps) = SAME_TIME;
        let rounding = ulps * f64::EPSILON * time.abs().max(self.origin.abs());
        (time - other).abs() <= (share * self.dt).max(rounding)
    }

    /// Shows the state at `time`, in the last step of an adaptive run, else less than a step after the last one.
    pub(super) fn show(&mut self, time: f64) -> Result<()> {
        self.put_step_end_back();
        let step_end = self.step_end_time();
        let is_after_jump = self.origin == step_end;
        if self.adaptive.is_some() {
            if time < step_end && is_after_jump {
                self.output = Some(Output { time, held: None });
            } else if time < step_end {
                self.interpolate(step_end, time);
            }
        } else if self.is_same_time(time, step_end) {
            self.output = Some(Output { time, held: None });
        } else {
            self.take_side_step(step_end, time)?;
        }
        Ok(())
    }

    fn interpolate(&mut self, step_end: f64, time: f64) {
        let Some(method) = self.integrator.embedded() else { return };
        let end = Endpoint { time: step_end, state: &self.state, work: &self.ledger.work };
        let (state, work) = Embedded::interpolate(method, end, time);
        let (state, work) = (std::mem::replace(&mut self.state, state), std::mem::replace(&mut self.ledger.work, work));
        self.mechanics.set_moved(time, &mut self.state, &mut self.ledger.work);
        self.output = Some(Output { time, held: Some(Held { state, work, histories: None }) });
    }

    fn take_side_step(&mut self, step_end: f64, time: f64) -> Result<()> {
        self.start_if_needed();
        let (dt, evaluation_count) = (time - step_end, self.mechanics.evaluation_count);
        let mut side = self.side.take().unwrap_or_else(|| (self.method.make)(&self.options()));
        side.restore_history(self.integrator.history());
        let (state, work, histories) = (self.state.clone(), self.ledger.work.clone(), self.mechanics.histories());
        side.step(&mut self.mechanics, step_end, dt, &mut self.state, &mut self.ledger.work);
        self.mechanics.evaluation_count = evaluation_count;
        self.mechanics.set_moved(time, &mut self.state, &mut self.ledger.work);
        self.mechanics.accept(self.state.at(time));
        let stall = side.implicit().and_then(|method| method.stalled());
        self.side = Some(side);
        self.output = Some(Output { time, held: Some(Held { state, work, histories: Some(histories) }) });
        stall.map_or(Ok(()), |stall| Err(self.stalled(stall)))
    }

    /// Puts the state at the end of the last step back in place, for the next one.
    pub(super) fn put_step_end_back(&mut self) {
        if let Some(Output { held: Some(mut held), .. }) = self.output.take() {
            self.swap(&mut held);
        }
    }

    fn swap(&mut self, held: &mut Held) {
        std::mem::swap(&mut self.state, &mut held.state);
        std::mem::swap(&mut self.ledger.work, &mut held.work);
        if let Some(histories) = &mut held.histories {
            let shown = self.mechanics.histories();
            self.mechanics.restore_histories(&std::mem::replace(histories, shown));
        }
    }

    /// Checks the state that is shown, where it lies between two steps, for values out of bounds; then calls `check`
    /// with the state at the end of the last step in place. The balance is that of the steps: so output times do not
    /// decide whether a run is stopped. A run that ends within its first step has no other balance than that of the
    /// state it shows.
    pub(super) fn at_last_step(&mut self, is_end: bool, check: impl FnOnce(&mut Self) -> Result<()>) -> Result<()> {
        if self.output.as_ref().is_some_and(|output| output.held.is_some()) {
            let now = self.energy_terms();
            let is_all = is_end && self.step_count == 0;
            let fault = if is_all { self.fault(&now) } else { self.fault_of_state(&now) };
            if let Some(fault) = fault {
                return Err(self.roll_back(fault));
            }
        }
        let Some(Output { time, mut held }) = self.output.take() else { return check(self) };
        held.iter_mut().for_each(|held| self.swap(held));
        check(self)?;
        held.iter_mut().for_each(|held| self.swap(held));
        self.output = Some(Output { time, held });
        Ok(())
    }

    /// A state shown between two steps becomes that at the end of a step, from which steps are counted anew. Whether
    /// there was one.
    pub(super) fn continue_from_output(&mut self) -> bool {
        let Some(Output { time, held: Some(_) }) = self.output.take() else { return false };
        match (&mut self.adaptive, &mut self.side) {
            (Some(adaptive), _) => adaptive.step_end_time = time,
            (None, Some(side)) => {
                std::mem::swap(&mut self.integrator, side);
                self.count_anew(time);
            }
            (None, None) => {}
        }
        true
    }

    /// State, work, and histories of the laws at the end of the last step.
    pub(super) fn at_step_end(&self) -> (&State, &[f64], Vec<History>) {
        let held = self.output.as_ref().and_then(|output| output.held.as_ref());
        let (state, work) = held.map_or((&self.state, &self.ledger.work), |held| (&held.state, &held.work));
        let histories = held.and_then(|held| held.histories.clone());
        (state, work, histories.unwrap_or_else(|| self.mechanics.histories()))
    }
}
