//! The diagnosis: what is wrong with a run, where, by which law, and what to do about it.
//!
//! A run is wrong where a value is not finite, where an element is beyond the bound that its user set, where energy
//! is gained spuriously, and where the method itself loses more of it than its user allows. The cause that is named is, in this
//! order: a step above the limit; a limit that fell below the step as the shape changed; the law that failed, and the law that
//! gave it energy.

use super::{Settings, Simulation};
use crate::arrays::columns::total;
use crate::arrays::state::State;
use crate::evaluation::ledger::EnergyTerms;
use crate::laws::{Law, Properties, WorkClass};

/// Share of the largest energy term that rounding may make.
const ROUNDING: f64 = 1e-9;
/// Share of the largest energy term by which the balance may be off, whatever the reference energy: a disc that merely spins
/// exchanges nothing, but its dashpots' work is of the order of (Omega dt)^2 of its energy in each turn.
const FLOOR: f64 = 1e-5;

/// By how many times the last digit of the largest coordinate all nodes may be off by rounding.
const DIGITS: f64 = 64.0;
/// By how many times the error that is allowed in a step the speeds of an adaptive run are off in a scene at rest: there
/// its steps grow past the limit until that error shows.
const ERRORS: f64 = 10.0;

/// The description of a fault.
pub(super) struct Fault {
    pub(super) what: String,
    pub(super) place: String,
    pub(super) law: String,
    pub(super) remedy: String,
    /// False for a balance that does not close, which may be the step's coarseness alone.
    pub(super) is_certain: bool,
}

impl Simulation {
    /// What is wrong now.
    pub(super) fn fault(&self, now: &EnergyTerms) -> Option<Fault> {
        self.certain_fault(now).or_else(|| self.out_of_balance(now))
    }

    /// What is wrong for certain: no number, beyond a bound, or spurious gain.
    pub(super) fn certain_fault(&self, now: &EnergyTerms) -> Option<Fault> {
        self.not_finite(now).or_else(|| self.beyond_bound(now)).or_else(|| self.created(now))
    }

    fn not_finite(&self, now: &EnergyTerms) -> Option<Fault> {
        let State { positions, velocities } = &self.state;
        if (total(positions.as_slice()) + total(velocities.as_slice())).is_finite() {
            return None;
        }
        let row = (0..positions.nrows()).find(|&i| !(positions.row(i).sum() + velocities.row(i).sum()).is_finite())?;
        let what = "a position or velocity is no longer finite".to_owned();
        Some(self.described(what, self.node(row), self.most_changed(now), now))
    }

    fn beyond_bound(&self, now: &EnergyTerms) -> Option<Fault> {
        let (k, excess) = self
            .mechanics
            .laws
            .iter()
            .enumerate()
            .find_map(|(k, law)| law.inspection()?.first_excess(self.instant()).map(|excess| (k, excess)))?;
        let [i, j] = excess.nodes.map(|node| self.numbering.to_external(node as usize));
        Some(self.described(excess.what, format!("between nodes {i} and {j}"), Some(k), now))
    }

    /// The work so far of each law whose work may be damping, and its row: of all but loads on positions alone \[J\].
    fn damping_work(&self) -> impl Iterator<Item = (usize, f64)> {
        let rows = self.mechanics.laws.iter().zip(&self.ledger.work).enumerate();
        let is_load = |law: &dyn Law| {
            let Properties { work_class, depends_on_velocity, .. } = law.properties();
            work_class == WorkClass::External && !depends_on_velocity
        };
        rows.filter(move |(_, (law, _))| !is_load(law.as_ref())).map(|(row, (_, work))| (row, *work))
    }

    /// Energy that rounding may make [J]: a share of the largest energy term, and, for a scene at rest whose energy_terms
    /// are rounding themselves, that of nodes which vibrate by some last digits of their coordinates.
    fn rounding(&self, largest: f64) -> f64 {
        let digit = DIGITS * f64::EPSILON * self.state.positions.amax();
        let vibration = self.kinetic_at(digit * self.start_limit.largest_frequency);
        // What is not finite excuses nothing.
        ROUNDING * largest + if vibration.is_finite() { vibration } else { 0.0 }
    }

    /// Whether an adaptive run has turned over no more than the errors that its user allowed in each step.
    fn is_within_tolerance(&self, reference_energy: f64) -> bool {
        let allowed = self.kinetic_at(ERRORS * self.settings.tolerance.relative * self.settings.tolerance.speed);
        self.adaptive.is_some() && reference_energy <= self.step_count as f64 * allowed
    }

    /// Kinetic energy where every node has this speed [J].
    fn kinetic_at(&self, speed: f64) -> f64 {
        0.5 * self.mechanics.masses.iter().sum::<f64>() * speed * speed
    }

    /// Surplus of energy, the energy turned over, and the largest energy term [J].
    ///
    /// A method that keeps energy keeps it but for a swing, which stays below what is turned over as long as the step is
    /// below its limit, and grows beyond it above. What it conserves instead has no such swing: what both show counts.
    fn balance(&self, now: &EnergyTerms) -> (f64, f64, f64) {
        let (residual, reference_energy) = (self.ledger.residual(now), self.ledger.reference_energy(now));
        let largest = now.stored.iter().fold(now.kinetic, |most, stored| most.max(stored.abs()));
        if !self.properties().conserves_energy
            || residual.abs() > reference_energy + self.rounding(largest)
            || residual.is_nan()
        {
            return (residual, reference_energy, largest);
        }
        let kept = residual + self.energy_shift(self.dt) - self.ledger.start_shift;
        let both = if residual > 0.0 { residual.min(kept).max(0.0) } else { residual.max(kept).min(0.0) };
        (both, reference_energy, largest)
    }

    /// Spurious gain: more energy than there was at the start and has come in.
    fn created(&self, now: &EnergyTerms) -> Option<Fault> {
        let (residual, reference_energy, largest) = self.balance(now);
        let taken: f64 = self.damping_work().map(|(_, work)| work.min(0.0)).sum();
        let created = residual + taken;
        if self.is_within_tolerance(reference_energy) {
            return None;
        }
        let Settings { energy_tolerance, loss_tolerance, .. } = self.settings;
        // A long step of an implicit method also misjudges what it does not resolve, and then removes it: its user says how
        // far the balance may be off, either way.
        let allowed =
            if self.properties().is_implicit { energy_tolerance.max(loss_tolerance) } else { energy_tolerance };
        if !residual.is_nan() && created <= allowed * reference_energy + self.rounding(largest) {
            return None;
        }
        let what = format!(
            "a spurious gain of {created:.3e} J, {:.3} % of the reference energy (the largest exchange so far)",
            100.0 * created / reference_energy
        );
        if self.properties().is_implicit {
            return Some(self.hardly_resolved(what, self.most_changed(now), "so the method misjudges it"));
        }
        Some(self.described(what, self.fastest(), self.most_changed(now), now))
    }

    /// A balance that does not close, because the method damps the vibrations that its step hardly resolves, or because it
    /// misjudges work of damping that it hardly resolves.
    fn out_of_balance(&self, now: &EnergyTerms) -> Option<Fault> {
        let (residual, reference_energy, largest) = self.balance(now);
        if self.is_within_tolerance(reference_energy) {
            return None;
        }
        let percent = |energy: f64| 100.0 * energy.abs() / reference_energy;
        let loose = self.settings.loss_tolerance * reference_energy + FLOOR * largest + self.rounding(largest);
        if residual > loose {
            let law = self.damping_work().min_by(|(_, a), (_, b)| a.total_cmp(b)).map(|(row, _)| row);
            let what = format!(
                "the work of damping exceeds the energy lost by {residual:.3e} J, {:.3} % of the reference energy (the largest exchange so far)",
                percent(residual)
            );
            return Some(self.hardly_resolved(what, law, "so their work is misjudged"));
        }
        if residual < -loose {
            let what = format!(
                "a loss of {:.3e} J that is no law's work, {:.3} % of the reference energy (the largest exchange so far)",
                -residual,
                percent(residual)
            );
            let law = self.mechanics.laws.iter().position(|law| law.name() == self.start_limit.law);
            return Some(self.hardly_resolved(what, law, "so the method damps it"));
        }
        None
    }

    /// The step is too long for what is fastest in the scene; above its limit that is the cause.
    fn hardly_resolved(&self, what: String, law: Option<usize>, so: &str) -> Fault {
        let own = law.map_or("no law", |k| self.mechanics.laws[k].name());
        let share = if self.start_limit.dt.is_finite() {
            format!(", {:.2} of the stability limit,", self.dt() / self.start_limit.dt)
        } else {
            String::new()
        };
        let remedy = self.step_above_limit(law).unwrap_or_else(|| {
            format!(
                "its step of {:.3e} s{share} hardly resolves what is fastest here, {so}: use a smaller dt, or allow a larger energy_loss",
                self.dt(),
            )
        });
        Fault {
            what,
            place: self.fastest(),
            law: own.to_owned(),
            remedy: format!("{}: {remedy}", self.name()),
            is_certain: false,
        }
    }

    fn fastest(&self) -> String {
        let speeds: Vec<f64> = self.state.velocities.row_iter().map(|row| row.norm_squared()).collect();
        let fastest = (0..speeds.len()).max_by(|&i, &j| speeds[i].total_cmp(&speeds[j])).unwrap_or(0);
        format!(
            "{} is fastest at {:.3e} m/s",
            self.node(fastest),
            speeds.get(fastest).map_or(0.0, |speed| speed.sqrt())
        )
    }

    pub(super) fn described(&self, what: String, place: String, law: Option<usize>, now: &EnergyTerms) -> Fault {
        let remedy = self.remedy(law, now);
        Fault {
            what,
            place,
            law: law.map_or("no law", |k| self.mechanics.laws[k].name()).to_owned(),
            remedy,
            is_certain: true,
        }
    }

    fn node(&self, row: usize) -> String {
        format!("node {}", self.numbering.to_external(row))
    }

    /// The law whose energy or work changed most since the last good check; since the start, where that is not finite.
    pub(super) fn most_changed(&self, now: &EnergyTerms) -> Option<usize> {
        let (good_work, good) = (&self.good.work, &self.good.energy_terms);
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
    fn source(&self, now: &EnergyTerms) -> Option<usize> {
        (0..now.stored.len())
            .filter(|&k| self.given(k, now).is_finite() && self.given(k, now) > 0.0)
            .max_by(|&a, &b| self.given(a, now).total_cmp(&self.given(b, now)))
    }

    /// What a law has given to the others since the start [J].
    fn given(&self, law: usize, now: &EnergyTerms) -> f64 {
        self.ledger.start.stored[law] - now.stored[law] + self.ledger.work[law]
    }

    fn remedy(&self, law: Option<usize>, now: &EnergyTerms) -> String {
        if let Some(words) = self.step_above_limit(law) {
            return words;
        }
        let laws = &self.mechanics.laws;
        let own = law.map_or("check the scene", |k| laws[k].remedy());
        let source = self.source(now);
        if self.ledger.start.kinetic - now.kinetic > source.map_or(0.0, |k| self.given(k, now)) {
            return format!("the energy came from the velocities at the start: start slower; or {own}");
        }
        match source.filter(|source| Some(*source) != law) {
            Some(source) => {
                format!("the energy came from {}: {}; or {own}", laws[source].name(), laws[source].remedy())
            }
            None => own.to_owned(),
        }
    }

    /// In words, where the step was above its limit at the start, or has come to be.
    fn step_above_limit(&self, law: Option<usize>) -> Option<String> {
        let (laws, start) = (&self.mechanics.laws, &self.start_limit);
        let remedy_of = |name: &str| {
            let found = laws.iter().find(|law| law.name() == name).or(law.map(|k| &laws[k]));
            found.map_or("", |law| law.remedy())
        };
        if self.dt > start.dt {
            let remedy = remedy_of(start.law);
            return Some(format!(
                "dt = {:.3e} s is above the stability limit of {:.3e} s that {} sets: use a smaller dt, or leave it out; or {}",
                self.dt,
                start.dt,
                self.part(start),
                remedy
                    .strip_prefix("use a smaller dt, ")
                    .or(remedy.strip_prefix("use a smaller dt or "))
                    .unwrap_or(remedy)
            ));
        }
        let now = [Some(&self.good.state), self.suspect.as_ref()].into_iter().flatten().find_map(|state| {
            let at = self.mechanics.instant(state.at(self.good.time));
            self.limit_at(at).ok().filter(|now| self.dt > now.dt)
        })?;
        Some(format!(
            "as the shape changed, the stability limit fell from {:.3e} s to {:.3e} s, below dt = {:.3e} s, by {}: {}",
            start.dt,
            now.dt,
            self.dt,
            self.part(&now),
            remedy_of(now.law)
        ))
    }
}
