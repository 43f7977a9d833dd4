//! Jumps: times at which schedules have two values.
//!
//! No step crosses one. The last step before it is as long as what is left, and the method starts anew from it, so that
//! it keeps its order. Up to the jump all that depends on time is held to its values before (`Spin::time_of`). At the
//! jump nodes that move as prescribed are displaced, bodies stand elsewhere, and where the rate of the hub jumps by
//! dOmega, free nodes keep their velocities in space:
//!
//!     v := v - dOmega z x r                                                                                   [m/s]
//!
//! What that changes of the energy terms is recorded as such (`Ledger::record_jump`), without the work of the impulse
//! where the velocity of a moved node jumps as well. A state at the time of a jump is that after it. A jump at the
//! start, or before, is none.

use super::Simulation;
use crate::arrays::history::History;
use crate::error::Result;
use crate::evaluation::mechanics::Mechanics;

/// The times at which schedules jump, ascending, each once \[s\].
pub(super) fn times(mechanics: &Mechanics) -> Vec<f64> {
    let mut found: Vec<f64> = mechanics.laws.iter().flat_map(|law| law.jumps()).collect();
    found.extend(mechanics.spin.schedule.iter().flat_map(|schedule| schedule.jumps()));
    found.sort_unstable_by(f64::total_cmp);
    found.dedup();
    found
}

/// The first and the last time of the interval between two jumps that begins at `origin` or before \[s\].
pub(super) fn interval(jumps: &[f64], origin: f64) -> Option<[f64; 2]> {
    let next = jumps.partition_point(|&jump| jump <= origin);
    let first = if next == 0 { f64::NEG_INFINITY } else { jumps[next - 1] };
    let last = jumps.get(next).map_or(f64::INFINITY, |jump| jump.next_down());
    (!jumps.is_empty()).then_some([first, last])
}

impl Simulation {
    /// The next jump \[s\].
    pub(super) fn next_jump(&self) -> Option<f64> {
        self.jumps.get(self.jumps.partition_point(|&jump| jump <= self.origin)).copied()
    }

    /// Finds the interval between two jumps that follows from `origin`.
    pub(super) fn find_interval(&mut self) {
        self.mechanics.spin.interval = interval(&self.jumps, self.origin);
    }

    /// Counts steps anew, from a time \[s\].
    pub(super) fn count_anew(&mut self, time: f64) {
        (self.origin, self.origin_step, self.step_count) = (time, 0, 0);
        self.find_interval();
    }

    /// The time at the end of a constant step, by its number \[s\].
    pub(super) fn time_of_whole_step(&self, number: u64) -> f64 {
        self.origin + (number.saturating_sub(self.origin_step)) as f64 * self.dt
    }

    /// The time at the end of a constant step, by its number, or of a jump before it \[s\].
    pub fn time_of_step(&self, number: u64) -> f64 {
        let end = self.time_of_whole_step(number);
        self.next_jump().map_or(end, |jump| jump.min(end))
    }

    /// Passes the jumps at the end of the last step, or so near that no step leads there.
    pub(super) fn pass_due_jumps(&mut self) -> Result<()> {
        while let Some(jump) = self.next_jump() {
            let end = self.step_end_time();
            if jump > end && !self.is_same_time(jump, end) {
                break;
            }
            self.pass(jump)?;
        }
        Ok(())
    }

    /// Passes the jumps before the end of the next constant step.
    pub(super) fn pass_jumps_within_step(&mut self) -> Result<()> {
        while let Some(jump) = self.next_jump().filter(|_| self.adaptive.is_none()) {
            let end = self.time_of_whole_step(self.step_count + 1);
            if jump >= end || self.is_same_time(jump, end) {
                break;
            }
            self.go_past(jump)?;
        }
        Ok(())
    }

    /// Takes the rest of a constant step up to a jump, which counts as none, and passes it, unless it was passed.
    pub(super) fn go_past(&mut self, jump: f64) -> Result<()> {
        if self.next_jump() != Some(jump) {
            return Ok(());
        }
        let time = self.step_end_time();
        if !self.is_same_time(jump, time) {
            self.start_if_needed();
            let work = &mut self.ledger.work;
            self.integrator.step(&mut self.mechanics, time, jump - time, &mut self.state, work);
            (self.origin, self.origin_step) = (jump, self.step_count);
            self.set_moved();
            self.refuse_stall()?;
            self.mechanics.accept(self.state.at(jump));
        }
        self.pass(jump)
    }

    /// Passes a jump, from the state just before it.
    fn pass(&mut self, jump: f64) -> Result<()> {
        (self.origin, self.origin_step) = (jump, self.step_count);
        self.roll_back_adaptive(jump);
        self.regular_check()?;
        let (before, rate) = (self.energy_terms(), self.hub_rate());
        let turning = self.mechanics.turning_energy(self.state.at(jump));
        let (mut work, shift) = (vec![0.0; self.laws().len()], self.ledger.start_shift - self.energy_shift(self.dt));
        self.find_interval();
        self.keep_velocities_in_space(self.hub_rate() - rate);
        let impulse = self.mechanics.turning_impulse(jump, &self.state);
        self.mechanics.set_moved(jump, &mut self.state, &mut work);
        // The motor does the work of that impulse alone.
        let turned = self.mechanics.turning_energy(self.state.at(jump)) - turning - impulse;
        self.ledger.start_turning.iter_mut().for_each(|start| *start += turned);
        self.ledger.work.iter_mut().zip(&work).for_each(|(all, own)| *all += own);
        self.mechanics.restart_paths(self.state.at(jump));
        let after = self.energy_terms();
        self.ledger.record_jump(&before, &after, work.iter().sum());
        self.integrator.restore_history(History::default());
        self.start_if_needed();
        self.ledger.start_shift = shift + self.energy_shift(self.dt);
        self.record_good(after);
        Ok(())
    }

    /// Free nodes keep their velocities in space where the rate of the hub jumps \[rad/s\].
    fn keep_velocities_in_space(&mut self, jump: f64) {
        if jump == 0.0 {
            return;
        }
        let (positions, velocities) = (&self.state.positions, &mut self.state.velocities);
        for (node, _) in self.mechanics.inverse_masses.iter().enumerate().filter(|(_, inverse)| **inverse > 0.0) {
            velocities[(node, 0)] += jump * positions[(node, 1)];
            velocities[(node, 1)] -= jump * positions[(node, 0)];
        }
    }
}
