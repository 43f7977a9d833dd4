//! The watch: what is wrong with a run, where, by which law, and what to do about it.
//!
//! A run is wrong where a value is not finite, where an element is beyond the bound that its user set, where energy
//! has appeared from nowhere, and where the method itself has eaten more of it than its user allows. The cause that is told is,
//! in this order: a step above the limit; a limit that fell below the step as the shape changed; the law
//! that failed, and the law that fed it.

use super::{Simulation, State};
use crate::ledger::Accounts;
use crate::stability;

/// What is told of a fault.
pub(super) struct Fault {
    pub(super) what: String,
    pub(super) place: String,
    pub(super) law: String,
    pub(super) cure: String,
}

impl Simulation {
    /// What is wrong now.
    pub(super) fn fault(&self, now: &Accounts) -> Option<Fault> {
        self.not_finite(now).or_else(|| self.beyond_bound(now)).or_else(|| self.out_of_balance(now))
    }

    fn not_finite(&self, now: &Accounts) -> Option<Fault> {
        let State { positions, velocities } = &self.state;
        let row = (0..positions.nrows()).find(|&i| !(positions.row(i).sum() + velocities.row(i).sum()).is_finite())?;
        let what = "a position or velocity is no longer finite".to_owned();
        Some(self.told(what, self.node(row), self.most_changed(now), now))
    }

    fn beyond_bound(&self, now: &Accounts) -> Option<Fault> {
        let (k, excess) = self
            .mechanics
            .laws
            .iter()
            .enumerate()
            .find_map(|(k, law)| law.first_excess(self.instant()).map(|excess| (k, excess)))?;
        let [i, j] = excess.nodes.map(|node| self.layout.outward(node as usize));
        Some(self.told(excess.what, format!("between nodes {i} and {j}"), Some(k), now))
    }

    fn out_of_balance(&self, now: &Accounts) -> Option<Fault> {
        let (surplus, turned_over) = (self.ledger.surplus(now), self.ledger.turned_over(now));
        // Rounding: a fraction of the largest account.
        let rounding = 1e-9 * now.stored.iter().fold(now.kinetic, |most, stored| most.max(stored.abs()));
        let percent = 100.0 * surplus.abs() / turned_over;
        if surplus < -(self.settings.loss_tolerance * turned_over + rounding) {
            let what = format!(
                "{:.3e} J are gone that no law took, {percent:.3} % of the energy turned over so far",
                -surplus
            );
            return Some(self.lost(what));
        }
        if surplus <= self.settings.energy_tolerance * turned_over + rounding {
            return None;
        }
        let speeds: Vec<f64> = self.state.velocities.row_iter().map(|row| row.norm_squared()).collect();
        let fastest = (0..speeds.len()).max_by(|&i, &j| speeds[i].total_cmp(&speeds[j])).unwrap_or(0);
        let what = format!("{surplus:.3e} J appeared from nowhere, {percent:.3} % of the energy turned over so far");
        let place = format!("{} is fastest at {:.3e} m/s", self.node(fastest), speeds[fastest].sqrt());
        Some(self.told(what, place, self.most_changed(now), now))
    }

    /// Every method eats the vibrations that its step hardly resolves: the law that makes the fastest ones is named.
    fn lost(&self, what: String) -> Fault {
        let limit = &self.start_limit;
        let cure = format!(
            "{} damps vibrations that its step of {:.3e} s hardly resolves ({:.2} of the stability limit): use a smaller dt, or allow a larger energy_loss",
            self.integrator.name(),
            self.dt,
            self.dt / limit.dt
        );
        Fault { what, place: self.node(limit.node), law: limit.law.to_owned(), cure }
    }

    fn told(&self, what: String, place: String, law: Option<usize>, now: &Accounts) -> Fault {
        let cure = self.cure(law, now);
        Fault { what, place, law: law.map_or("no law", |k| self.mechanics.laws[k].name()).to_owned(), cure }
    }

    fn node(&self, row: usize) -> String {
        format!("node {}", self.layout.outward(row))
    }

    /// The law whose energy or work changed most since the last good check; since the start, where that is not finite.
    fn most_changed(&self, now: &Accounts) -> Option<usize> {
        let (_, _, good_work, good) = &self.good;
        let recent: Vec<f64> = (0..good_work.len())
            .map(|k| (now.stored[k] - good.stored[k]).abs() + (self.ledger.work[k] - good_work[k]).abs())
            .collect();
        let all_finite = recent.iter().all(|change| change.is_finite());
        let start = &self.ledger.start;
        let before = |k: usize| (good.stored[k] - start.stored[k]).abs() + good_work[k].abs();
        let change = |k: usize| if all_finite { recent[k] } else { before(k) };
        (0..recent.len()).max_by(|&a, &b| change(a).total_cmp(&change(b)))
    }

    /// The law that has given most energy to the others since the start.
    fn source(&self, now: &Accounts) -> Option<usize> {
        let given = |k: usize| self.ledger.start.stored[k] - now.stored[k] + self.ledger.work[k];
        (0..now.stored.len())
            .filter(|&k| given(k).is_finite() && given(k) > 0.0)
            .max_by(|&a, &b| given(a).total_cmp(&given(b)))
    }

    fn cure(&self, law: Option<usize>, now: &Accounts) -> String {
        let laws = &self.mechanics.laws;
        let start = &self.start_limit;
        if self.dt > start.dt {
            return format!(
                "dt = {:.3e} s is above the stability limit of {:.3e} s that {} sets: use a smaller dt, or leave it out",
                self.dt,
                start.dt,
                self.part(start)
            );
        }
        let own = law.map_or("check the scene", |k| laws[k].cure());
        let limit =
            stability::limit(self.integrator.as_ref(), laws, self.good_instant(), &self.mechanics.inverse_masses);
        if let Ok(limit) = limit
            && self.dt > limit.dt
        {
            let stiff = laws.iter().find(|law| law.name() == limit.law).map_or(own, |law| law.cure());
            return format!(
                "as the shape changed, the stability limit fell from {:.3e} s to {:.3e} s, below dt = {:.3e} s, by {}: {stiff}",
                start.dt,
                limit.dt,
                self.dt,
                self.part(&limit)
            );
        }
        match self.source(now).filter(|source| Some(*source) != law) {
            Some(source) => format!("the energy came from {}: {}; or {own}", laws[source].name(), laws[source].cure()),
            None => own.to_owned(),
        }
    }
}
