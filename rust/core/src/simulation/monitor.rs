//! The monitor: regular checks, the search for the first fault, and the return to the last good state. `diagnosis`
//! decides on faults and describes them.

use std::ops::Range;

use super::Simulation;
use super::diagnosis::Fault;
use crate::arrays::state::{NodeVectors, PhasePoint};
use crate::error::{Error, Result};
use crate::evaluation::ledger::EnergyTerms;

impl Simulation {
    /// Checks the last step for a fault, between two regular checks, and the state that is shown: without effect on the
    /// ledger, hence on results. The energy balance is judged at the end of a run only: at regular checks it is judged
    /// alike whatever outputs are asked for.
    ///
    /// # Errors
    /// `Unstable`; the state is then that of the last good regular check.
    pub fn check(&mut self, is_end: bool) -> Result<()> {
        self.at_last_step(is_end, |simulation| {
            if is_end {
                simulation.mechanics.end(simulation.state.at(simulation.time()));
            }
            let now = simulation.energy_terms();
            if is_end || simulation.fault_of_state(&now).is_some() { simulation.refuse_fault(&now) } else { Ok(()) }
        })
    }

    /// Records the largest changes.
    pub(super) fn record_exchange(&mut self) {
        let now = self.energy_terms();
        self.ledger.largest_change = self.ledger.reference_energy(&now);
    }

    /// Checks for a fault, and records the largest changes and the good state.
    pub(super) fn regular_check(&mut self) -> Result<()> {
        self.mechanics.check_before_good(self.state.at(self.time()));
        let now = self.energy_terms();
        self.refuse_fault(&now)?;
        self.ledger.largest_change = self.ledger.reference_energy(&now);
        self.record_good(now);
        Ok(())
    }

    fn refuse_fault(&mut self, now: &EnergyTerms) -> Result<()> {
        let Some(mut fault) = self.fault(now) else {
            return Ok(());
        };
        // A certain fault has a first instant; a residual of the energy balance has none.
        if self.adaptive.is_none() && fault.is_certain {
            fault = self.first_fault().unwrap_or(fault);
        }
        Err(self.roll_back(fault))
    }

    /// Repeats the steps since the last good check, with a check after each, and stops at the first fault: by the
    /// regular check a fault has often spread from its origin.
    fn first_fault(&mut self) -> Option<Fault> {
        let last = self.step_count;
        self.rewind();
        while self.step_count < last {
            self.start_if_needed();
            let time = self.time();
            let (before, histories) = (self.suspect.insert(self.state.clone()).clone(), self.mechanics.histories());
            self.fixed_step();
            self.mechanics.accept(self.state.at(self.time()));
            let now = self.energy_terms();
            if now.total().is_finite() {
                if let Some(fault) = self.certain_fault(&now) {
                    return Some(fault);
                }
                continue;
            }
            self.mechanics.restore_histories(&histories);
            if let Some((k, node, size)) = self.largest_force(before.at(time), 0..before.positions.nrows()) {
                let place =
                    format!("node {}, on which that law acts with {size:.3e} N", self.numbering.to_external(node));
                return Some(self.described(
                    "a position or velocity is no longer finite".to_owned(),
                    place,
                    Some(k),
                    &now,
                ));
            }
        }
        None
    }

    /// The law with the largest finite force on any of `nodes`, the node, and the force [N].
    pub(super) fn largest_force(&mut self, point: PhasePoint<'_>, nodes: Range<usize>) -> Option<(usize, usize, f64)> {
        let mut largest: Option<(usize, usize, f64)> = None;
        let at = self.mechanics.instant(point);
        for k in 0..self.mechanics.laws.len() {
            let mut forces = NodeVectors::zeros(at.positions.nrows());
            self.mechanics.add_forces_of(k, at, &mut forces);
            for node in nodes.clone() {
                let size = forces.row(node).norm();
                if size.is_finite() && largest.is_none_or(|(.., largest)| size > largest) {
                    largest = Some((k, node, size));
                }
            }
        }
        largest
    }

    /// Restores the state of the last good check, for a method of constant step.
    fn rewind(&mut self) {
        let good = &self.good;
        (self.output, self.origin, self.origin_step) = (None, good.origin, good.origin_step);
        (self.step_count, self.state, self.ledger.work) = (good.step_count, good.state.clone(), good.work.clone());
        self.integrator.restore_history(good.history.clone());
        self.mechanics.restore_histories(&good.law_histories);
        self.find_interval();
    }

    /// Restores the state of the last good check, and returns the error that describes the fault.
    pub(super) fn roll_back(&mut self, fault: Fault) -> Error {
        let Fault { what, place, law, remedy, .. } = fault;
        let (time, step) = (self.time(), self.step_count);
        self.rewind();
        self.suspect = None;
        let good_time = self.good.time;
        self.roll_back_adaptive(good_time);
        Error::Unstable { time, step, good_time, what, place, law, remedy }
    }

    /// Records the present state as the last good one.
    pub(super) fn record_good(&mut self, energy_terms: EnergyTerms) {
        (self.good.time, self.good.origin) = (self.time(), self.origin);
        (self.good.origin_step, self.good.step_count) = (self.origin_step, self.step_count);
        self.good.state.positions.copy_from(&self.state.positions);
        self.good.state.velocities.copy_from(&self.state.velocities);
        self.good.work.copy_from_slice(&self.ledger.work);
        (self.good.energy_terms, self.good.history) = (energy_terms, self.integrator.history());
        self.good.law_histories = self.mechanics.histories();
    }
}
