//! The watch: what is wrong with a run, where, by which law, and what to do; and the way back to the last good state.

use super::Simulation;
use crate::error::{Error, Result};
use crate::ledger::Accounts;
use crate::stability;
use crate::state::{Instant, Vectors};

impl Simulation {
    /// Looks for values that are not finite, springs over their bound, and energy from nowhere, between two regular
    /// checks: it leaves no trace in the ledger, so that looking on changes nothing.
    ///
    /// # Errors
    /// `Unstable`; the state is then that of the last good regular check.
    pub fn check(&mut self) -> Result<()> {
        let now = self.accounts();
        self.refuse_fault(&now)
    }

    pub(super) fn regular_check(&mut self) -> Result<()> {
        let now = self.accounts();
        self.refuse_fault(&now)?;
        self.ledger.swing = self.ledger.turned_over(&now);
        self.keep(now);
        Ok(())
    }

    fn refuse_fault(&mut self, now: &Accounts) -> Result<()> {
        let Some(mut fault) = self.fault(now) else {
            return Ok(());
        };
        if self.adaptive.is_none() {
            fault = self.first_fault().unwrap_or(fault);
        }
        let (what, place, law, cure) = fault;
        Err(self.set_back([what, place, law, cure]))
    }

    /// Takes the steps since the last good check once more, with a check after each, and stops at the first fault. By the
    /// regular check what went wrong has often spread; here it is still where it began.
    fn first_fault(&mut self) -> Option<(String, String, String, String)> {
        let last = self.step_count;
        self.rewind();
        while self.step_count < last {
            let (time, before) = (self.time(), self.state.clone());
            self.integrator.step(&mut self.mechanics, time, self.dt, &mut self.state, &mut self.ledger.work);
            self.step_count += 1;
            let now = self.accounts();
            if now.total().is_finite() {
                if let Some(fault) = self.fault(&now) {
                    return Some(fault);
                }
            } else if let Some((k, node, size)) =
                self.largest_force(Instant { time, positions: &before.positions, velocities: &before.velocities })
            {
                let (law, cure) = self.explain(Some(k));
                let place = format!("node {}, on which that law acts with {size:.3e} N", self.layout.outward(node));
                return Some(("a position or velocity is no longer finite".to_owned(), place, law, cure));
            }
        }
        None
    }

    /// The law with the largest finite force at `at`, the node it acts on, and the force [N].
    fn largest_force(&self, at: Instant<'_>) -> Option<(usize, usize, f64)> {
        let mut largest: Option<(usize, usize, f64)> = None;
        for (k, law) in self.mechanics.laws.iter().enumerate() {
            let mut forces = Vectors::zeros(at.positions.nrows());
            law.add_forces(at, &mut forces);
            for (node, force) in forces.row_iter().enumerate() {
                let size = force.norm();
                if size.is_finite() && largest.is_none_or(|(.., most)| size > most) {
                    largest = Some((k, node, size));
                }
            }
        }
        largest
    }

    /// Back to the last good check, with a method of fixed steps.
    fn rewind(&mut self) {
        let good = &self.good;
        (self.step_count, self.state, self.ledger.work) = (good.step_count, good.state.clone(), good.work.clone());
        self.integrator.recall(good.memory.clone());
    }

    /// Sets the state back to that of the last good check, and says why.
    pub(super) fn set_back(&mut self, [what, place, law, cure]: [String; 4]) -> Error {
        let (time, step) = (self.time(), self.step_count);
        self.rewind();
        let good_time = self.good.time;
        self.set_back_adaptive(good_time);
        Error::Unstable { time, step, good_time, what, place, law, cure }
    }

    pub(super) fn keep(&mut self, accounts: Accounts) {
        (self.good.time, self.good.step_count) = (self.time(), self.step_count);
        self.good.state.positions.copy_from(&self.state.positions);
        self.good.state.velocities.copy_from(&self.state.velocities);
        self.good.work.copy_from_slice(&self.ledger.work);
        (self.good.accounts, self.good.memory) = (accounts, self.integrator.memory());
    }

    /// What is wrong now: in words, where, by which law, and the cure.
    fn fault(&self, now: &Accounts) -> Option<(String, String, String, String)> {
        let laws = &self.mechanics.laws;
        let node_of = |row: usize| format!("node {}", self.layout.outward(row));
        let bad = (0..self.state.positions.nrows())
            .find(|&i| !(self.state.positions.row(i).sum() + self.state.velocities.row(i).sum()).is_finite());
        if let Some(row) = bad {
            let (law, cure) = self.explain(self.blame(now));
            return Some(("a position or velocity is no longer finite".to_owned(), node_of(row), law, cure));
        }
        for (k, law) in laws.iter().enumerate() {
            if let Some(excess) = law.first_excess(self.instant()) {
                let [i, j] = excess.nodes.map(|node| self.layout.outward(node as usize));
                let (law, cure) = self.explain(Some(k));
                return Some((excess.what, format!("between nodes {i} and {j}"), law, cure));
            }
        }
        let (surplus, turned_over) = (self.ledger.surplus(now), self.ledger.turned_over(now));
        // Rounding: a fraction of the largest account.
        let rounding = 1e-9 * now.stored.iter().fold(now.kinetic, |most, stored| most.max(stored.abs()));
        let allowed = self.settings.energy_tolerance * turned_over + rounding;
        // A method that keeps energy keeps it but for a swing, which stays below what is turned over as long as the step
        // is below its limit, and grows beyond it above. What it conserves instead has no such swing: energy is created
        // where both are above what was there.
        let is_created = if self.integrator.keeps_energy() {
            let kept = surplus + self.energy_shift(self.dt) - self.ledger.start_shift;
            surplus.min(kept) > allowed || surplus > turned_over + rounding
        } else {
            surplus > allowed
        };
        if surplus.is_nan() || is_created {
            let speeds: Vec<f64> = self.state.velocities.row_iter().map(|row| row.norm_squared()).collect();
            let fastest = (0..speeds.len()).max_by(|&i, &j| speeds[i].total_cmp(&speeds[j])).unwrap_or(0);
            let what = format!(
                "{surplus:.3e} J appeared from nowhere, {:.3} % of the energy turned over so far",
                100.0 * surplus / turned_over
            );
            let (law, cure) = self.explain(self.blame(now));
            return Some((
                what,
                format!("{} is fastest at {:.3e} m/s", node_of(fastest), speeds[fastest].sqrt()),
                law,
                cure,
            ));
        }
        None
    }

    /// The law whose energy (or work) grew most since the last good check; what is not a number counts as most.
    pub(super) fn blame(&self, now: &Accounts) -> Option<usize> {
        let growth = |k: usize| {
            let of_energy = (now.stored[k] - self.good.accounts.stored[k]).abs();
            let grown = of_energy + (self.ledger.work[k] - self.good.work[k]).abs();
            if grown.is_nan() { f64::INFINITY } else { grown }
        };
        (0..self.mechanics.laws.len()).max_by(|&a, &b| growth(a).total_cmp(&growth(b)))
    }

    /// The law's name, and the cure.
    pub(super) fn explain(&self, law: Option<usize>) -> (String, String) {
        let laws = &self.mechanics.laws;
        let name = law.map_or("no law", |k| laws[k].name());
        let good = Instant {
            time: self.good.time,
            positions: &self.good.state.positions,
            velocities: &self.good.state.velocities,
        };
        let limit = stability::limit(self.integrator.as_ref(), laws, good, &self.mechanics.inverse_masses);
        let cure = match limit {
            Ok(limit) if self.dt > limit.dt => format!(
                "dt = {:.3e} s is above the stability limit of {:.3e} s that {} sets: use a smaller dt, or leave it out",
                self.dt,
                limit.dt,
                self.part(&limit)
            ),
            _ => law.map_or("check the scene", |k| laws[k].cure()).to_owned(),
        };
        (name.to_owned(), cure)
    }
}
