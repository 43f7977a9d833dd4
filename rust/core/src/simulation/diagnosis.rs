//! Diagnosis of a fault: the violated condition, its place, its law, and the remedy.
//!
//! The conditions: values are finite; elements are within their bounds; no energy is gained spuriously; the residual of
//! the energy balance is within the tolerance. The description names as cause, in this order: a step above the limit; a
//! limit that fell below the step as the shape changed; the law at fault, and the law that supplied its energy.

use super::{Settings, Simulation};
use crate::arrays::columns::total;
use crate::arrays::state::State;
use crate::evaluation::ledger::EnergyTerms;
use crate::laws::{Law, Properties, WorkClass};

/// The description of a fault.
pub(super) struct Fault {
    pub(super) what: String,
    pub(super) place: String,
    pub(super) law: String,
    pub(super) remedy: String,
    /// False for a residual of the balance, which a coarse step alone may cause.
    pub(super) is_certain: bool,
}

impl Simulation {
    /// The fault at present, if any.
    pub(super) fn fault(&self, now: &EnergyTerms) -> Option<Fault> {
        self.certain_fault(now).or_else(|| self.out_of_balance(now))
    }

    /// A certain fault: a value not finite, an element beyond its bound, or a spurious gain.
    pub(super) fn certain_fault(&self, now: &EnergyTerms) -> Option<Fault> {
        self.fault_of_state(now).or_else(|| self.spurious_gain(now))
    }

    /// A fault of positions and velocities: a value not finite, or an element beyond its bound.
    pub(super) fn fault_of_state(&self, now: &EnergyTerms) -> Option<Fault> {
        self.not_finite(now).or_else(|| self.beyond_bound(now))
    }

    /// Whether all positions and velocities are finite.
    pub(super) fn is_finite(&self) -> bool {
        let State { positions, velocities } = &self.state;
        (total(positions.as_slice()) + total(velocities.as_slice())).is_finite()
    }

    fn not_finite(&self, now: &EnergyTerms) -> Option<Fault> {
        if self.is_finite() {
            return None;
        }
        let State { positions, velocities } = &self.state;
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
        let place = match *excess.nodes.as_slice() {
            [i, j] => {
                let [i, j] = [i, j].map(|node| self.numbering.to_external(node as usize));
                format!("between nodes {i} and {j}")
            }
            ref nodes => nodes.iter().map(|&node| self.node(node as usize)).collect::<Vec<_>>().join(" and "),
        };
        Some(self.described(excess.what, place, Some(k), now))
    }

    /// Row and work \[J\] of each law whose work a step may hardly resolve: those that dissipate, and loads that depend
    /// on velocity.
    pub(super) fn resisting_work(&self) -> impl Iterator<Item = (usize, f64)> {
        let resists = |law: &dyn Law| {
            let Properties { work_class, depends_on_velocity, .. } = law.properties();
            work_class == WorkClass::Dissipative || (work_class == WorkClass::External && depends_on_velocity)
        };
        let rows = self.mechanics.laws.iter().zip(&self.ledger.work).enumerate();
        rows.filter(move |(_, (law, _))| resists(law.as_ref())).map(|(row, (_, work))| (row, *work))
    }

    /// Residual and reference energy [J].
    ///
    /// The energy of a method that conserves energy oscillates about its modified energy: below the limit of the step
    /// by less than the reference energy, above it by more. The modified energy does not oscillate. The smaller of both
    /// residuals counts, and none where their signs differ.
    fn balance(&self, now: &EnergyTerms) -> (f64, f64) {
        let (residual, reference_energy) = (self.ledger.residual(now), self.ledger.reference_energy(now));
        if !self.properties().conserves_energy
            || residual.abs() > reference_energy + self.rounding(now)
            || residual.is_nan()
        {
            return (residual, reference_energy);
        }
        let modified = residual + self.energy_shift(self.dt) - self.ledger.start_shift;
        let smaller = if residual > 0.0 { residual.min(modified).max(0.0) } else { residual.max(modified).min(0.0) };
        (smaller, reference_energy)
    }

    /// Whether an error of the balance is beyond what is allowed: a `tolerance` of the reference energy, `more` \[J\],
    /// and the floor.
    fn exceeds(&self, error: f64, tolerance: f64, more: f64, now: &EnergyTerms) -> bool {
        let allowed = tolerance * self.ledger.reference_energy(now) + more + self.resting_floor(now);
        // The rigid motion is asked only where it decides. An error that is not a number exceeds.
        !(error <= allowed || error <= allowed + self.moving_floor(tolerance, now))
    }

    /// A spurious gain: a positive residual that exceeds the total work of damping.
    fn spurious_gain(&self, now: &EnergyTerms) -> Option<Fault> {
        let (residual, reference_energy) = self.balance(now);
        let dissipated: f64 = self.resisting_work().map(|(_, work)| work.min(0.0)).sum();
        let gain = residual + dissipated;
        if self.is_within_tolerance(reference_energy) {
            return None;
        }
        let Settings { energy_tolerance, loss_tolerance, .. } = self.settings;
        // A long step of an implicit method has an error in the energy of unresolved vibrations, of either sign, before
        // it damps them: the larger tolerance applies.
        let allowed =
            if self.properties().is_implicit { energy_tolerance.max(loss_tolerance) } else { energy_tolerance };
        if !self.exceeds(gain, allowed, 0.0, now) {
            return None;
        }
        let what = format!("a spurious gain of {gain:.3e} J, {}", share_of(gain, reference_energy));
        if self.properties().is_implicit {
            return Some(self.hardly_resolved(what, self.most_changed(now), "so that its energy is inaccurate"));
        }
        Some(self.described(what, self.fastest(), self.most_changed(now), now))
    }

    /// A residual of the energy balance beyond its tolerance: the method damps vibrations that the step hardly
    /// resolves, or the step hardly resolves the damping, whose work is then inaccurate.
    fn out_of_balance(&self, now: &EnergyTerms) -> Option<Fault> {
        let (residual, reference_energy) = self.balance(now);
        let tolerance = self.settings.loss_tolerance;
        if self.is_within_tolerance(reference_energy) || !self.exceeds(residual.abs(), tolerance, 0.0, now) {
            return None;
        }
        let of_reference = share_of(residual, reference_energy);
        if residual > 0.0 {
            let law = self.resisting_work().min_by(|(_, a), (_, b)| a.total_cmp(b)).map(|(row, _)| row);
            let is_damping = |row: usize| self.mechanics.laws[row].properties().work_class == WorkClass::Dissipative;
            let work = match law {
                Some(row) if !is_damping(row) => format!("the work against {}", self.mechanics.laws[row].name()),
                _ => "the work of damping".to_owned(),
            };
            let what = format!("{work} exceeds the energy lost by {residual:.3e} J, {of_reference}");
            return Some(self.hardly_resolved(what, law, "so that this work is inaccurate"));
        }
        let vibration = self.overshoot(reference_energy).max(self.damped_within_tolerance(reference_energy));
        if !self.exceeds(-residual, tolerance, vibration, now) {
            return None;
        }
        let what = format!("a loss of {:.3e} J that is no law's work, {of_reference}", -residual);
        let law = self.mechanics.laws.iter().position(|law| law.name() == self.start_limit.law);
        Some(self.hardly_resolved(what, law, "so that the method damps it"))
    }

    /// A step too long for the fastest motion of the scene; `effect` says what follows. Above the limit, that is why.
    fn hardly_resolved(&self, what: String, law: Option<usize>, effect: &str) -> Fault {
        let own = law.map_or("no law", |k| self.mechanics.laws[k].name());
        let share = if self.start_limit.dt.is_finite() {
            format!(", {:.2} of the stability limit,", self.dt() / self.start_limit.dt)
        } else {
            String::new()
        };
        let remedy = self.step_above_limit(law).unwrap_or_else(|| {
            format!(
                "its step of {:.3e} s{share} hardly resolves the fastest motion here, {effect}: use a smaller dt, or \
                 allow a larger energy_loss",
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

    /// The fastest node, in words.
    fn fastest(&self) -> String {
        let speeds: Vec<f64> = self.state.velocities.row_iter().map(|row| row.norm_squared()).collect();
        let fastest = (0..speeds.len()).max_by(|&i, &j| speeds[i].total_cmp(&speeds[j])).unwrap_or(0);
        format!(
            "{} is fastest at {:.3e} m/s",
            self.node(fastest),
            speeds.get(fastest).map_or(0.0, |speed| speed.sqrt())
        )
    }

    /// A certain fault, with its remedy.
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

    /// A node, in words.
    fn node(&self, row: usize) -> String {
        format!("node {}", self.numbering.to_external(row))
    }

    /// The law whose energy or work changed most since the last good check; before it, where a change is not finite.
    pub(super) fn most_changed(&self, now: &EnergyTerms) -> Option<usize> {
        let (good_work, good) = (&self.good.work, &self.good.energy_terms);
        let recent: Vec<f64> = (0..now.stored.len())
            .map(|k| (now.stored[k] - good.stored[k]).abs() + (self.ledger.work[k] - good_work[k]).abs())
            .collect();
        let all_finite = recent.iter().all(|change| change.is_finite());
        let start = &self.ledger.start;
        let before = |k: usize| (good.stored[k] - start.stored[k]).abs() + good_work[k].abs();
        let change = |k: usize| if all_finite { recent[k] } else { before(k) };
        (0..recent.len()).max_by(|&a, &b| change(a).total_cmp(&change(b)))
    }

    /// The law that has supplied most energy to the others since the start.
    fn source(&self, now: &EnergyTerms) -> Option<usize> {
        (0..now.stored.len())
            .filter(|&k| self.supplied(k, now).is_finite() && self.supplied(k, now) > 0.0)
            .max_by(|&a, &b| self.supplied(a, now).total_cmp(&self.supplied(b, now)))
    }

    /// Energy that a law has supplied to the others since the start [J].
    fn supplied(&self, law: usize, now: &EnergyTerms) -> f64 {
        self.ledger.start.stored[law] - now.stored[law] + self.ledger.work[law]
    }

    /// The remedy for a fault of a law, by its cause.
    fn remedy(&self, law: Option<usize>, now: &EnergyTerms) -> String {
        if let Some(remedy) = self.step_above_limit(law) {
            return remedy;
        }
        let laws = &self.mechanics.laws;
        let own = law.map_or("check the scene", |k| laws[k].remedy());
        let source = self.source(now);
        if self.ledger.start.kinetic - now.kinetic > source.map_or(0.0, |k| self.supplied(k, now)) {
            return format!("the energy came from the velocities at the start: start slower; or {own}");
        }
        match source.filter(|source| Some(*source) != law) {
            Some(source) => {
                format!("the energy came from {}: {}; or {own}", laws[source].name(), laws[source].remedy())
            }
            None => own.to_owned(),
        }
    }

    /// Cause and remedy, if the step was above the limit at the start, or is above it now.
    fn step_above_limit(&self, law: Option<usize>) -> Option<String> {
        let (laws, start) = (&self.mechanics.laws, &self.start_limit);
        let remedy_of = |name: &str| {
            let found = laws.iter().find(|law| law.name() == name).or(law.map(|k| &laws[k]));
            found.map_or("", |law| law.remedy())
        };
        if self.dt > start.dt {
            let remedy = remedy_of(start.law);
            return Some(format!(
                "dt = {:.3e} s is above the stability limit of {:.3e} s that {} sets: use a smaller dt, or leave it \
                 out; or {}",
                self.dt,
                start.dt,
                self.limiting_part(start),
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
            self.limiting_part(&now),
            remedy_of(now.law)
        ))
    }
}

/// An energy as a share of the reference energy, in words.
fn share_of(energy: f64, reference_energy: f64) -> String {
    format!("{:.3} % of the reference energy (the largest exchange so far)", 100.0 * energy.abs() / reference_energy)
}
