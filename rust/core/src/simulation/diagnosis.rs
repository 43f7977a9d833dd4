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

/// Energy error by rounding, relative to the largest energy term.
const ROUNDING: f64 = 1e-9;
/// Residual that is allowed at any reference energy, relative to the largest energy term: a disc in steady rotation
/// exchanges no energy, but the work of its dashpots is of the order of (Omega dt)^2 of its energy in each revolution.
const RESIDUAL_FLOOR: f64 = 1e-5;

/// Vibration of nodes by rounding, in units in the last place of the largest coordinate.
const VIBRATION_ULPS: f64 = 64.0;
/// Speed of nodes of an adaptive run in a scene at rest, relative to the allowed error of a step: there the steps grow
/// beyond the limit until the error reaches the tolerance.
const REST_SPEED_FACTOR: f64 = 10.0;

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

    /// Row and work \[J\] of each law that may dissipate: all but external loads independent of velocity.
    fn damping_work(&self) -> impl Iterator<Item = (usize, f64)> {
        let rows = self.mechanics.laws.iter().zip(&self.ledger.work).enumerate();
        let is_load = |law: &dyn Law| {
            let Properties { work_class, depends_on_velocity, .. } = law.properties();
            work_class == WorkClass::External && !depends_on_velocity
        };
        rows.filter(move |(_, (law, _))| !is_load(law.as_ref())).map(|(row, (_, work))| (row, *work))
    }

    /// Energy error by rounding [J]: relative to the largest energy term, and, for a scene at rest whose energy terms
    /// are themselves within rounding, the energy of nodes that vibrate by some last digits of their coordinates.
    fn rounding(&self, largest: f64) -> f64 {
        let digit = VIBRATION_ULPS * f64::EPSILON * self.state.positions.amax();
        let vibration = self.kinetic_at(digit * self.start_limit.largest_frequency);
        // A vibration that is not finite allows no error.
        ROUNDING * largest + if vibration.is_finite() { vibration } else { 0.0 }
    }

    /// Whether the reference energy of an adaptive run is within the errors allowed for its steps.
    fn is_within_tolerance(&self, reference_energy: f64) -> bool {
        let allowed =
            self.kinetic_at(REST_SPEED_FACTOR * self.settings.tolerance.relative * self.settings.tolerance.speed);
        self.adaptive.is_some() && reference_energy <= self.step_count as f64 * allowed
    }

    /// Kinetic energy of all nodes at one speed [J].
    fn kinetic_at(&self, speed: f64) -> f64 {
        0.5 * self.mechanics.masses.iter().sum::<f64>() * speed * speed
    }

    /// Residual, reference energy and largest energy term [J].
    ///
    /// The energy of a method that conserves energy oscillates about its modified energy: below the limit of the step
    /// by less than the reference energy, above it by more. The modified energy does not oscillate. The smaller of both
    /// residuals counts, and none where their signs differ.
    fn balance(&self, now: &EnergyTerms) -> (f64, f64, f64) {
        let (residual, reference_energy) = (self.ledger.residual(now), self.ledger.reference_energy(now));
        let largest = now.stored.iter().fold(now.kinetic, |most, stored| most.max(stored.abs()));
        if !self.properties().conserves_energy
            || residual.abs() > reference_energy + self.rounding(largest)
            || residual.is_nan()
        {
            return (residual, reference_energy, largest);
        }
        let modified = residual + self.energy_shift(self.dt) - self.ledger.start_shift;
        let smaller = if residual > 0.0 { residual.min(modified).max(0.0) } else { residual.max(modified).min(0.0) };
        (smaller, reference_energy, largest)
    }

    /// A spurious gain: a positive residual that exceeds the total work of damping.
    fn spurious_gain(&self, now: &EnergyTerms) -> Option<Fault> {
        let (residual, reference_energy, largest) = self.balance(now);
        let dissipated: f64 = self.damping_work().map(|(_, work)| work.min(0.0)).sum();
        let gain = residual + dissipated;
        if self.is_within_tolerance(reference_energy) {
            return None;
        }
        let Settings { energy_tolerance, loss_tolerance, .. } = self.settings;
        // A long step of an implicit method has an error in the energy of unresolved vibrations, of either sign, before
        // it damps them: the larger tolerance applies.
        let allowed =
            if self.properties().is_implicit { energy_tolerance.max(loss_tolerance) } else { energy_tolerance };
        if !residual.is_nan() && gain <= allowed * reference_energy + self.rounding(largest) {
            return None;
        }
        let what = format!(
            "a spurious gain of {gain:.3e} J, {:.3} % of the reference energy (the largest exchange so far)",
            100.0 * gain / reference_energy
        );
        if self.properties().is_implicit {
            return Some(self.hardly_resolved(what, self.most_changed(now), "so that its energy is inaccurate"));
        }
        Some(self.described(what, self.fastest(), self.most_changed(now), now))
    }

    /// A residual of the energy balance beyond its tolerance: the method damps vibrations that the step hardly
    /// resolves, or the step hardly resolves the damping, whose work is then inaccurate.
    fn out_of_balance(&self, now: &EnergyTerms) -> Option<Fault> {
        let (residual, reference_energy, largest) = self.balance(now);
        if self.is_within_tolerance(reference_energy) {
            return None;
        }
        let percent = |energy: f64| 100.0 * energy.abs() / reference_energy;
        let allowed =
            self.settings.loss_tolerance * reference_energy + RESIDUAL_FLOOR * largest + self.rounding(largest);
        if residual > allowed {
            let law = self.damping_work().min_by(|(_, a), (_, b)| a.total_cmp(b)).map(|(row, _)| row);
            let what = format!(
                "the work of damping exceeds the energy lost by {residual:.3e} J, {:.3} % of the reference energy \
                 (the largest exchange so far)",
                percent(residual)
            );
            return Some(self.hardly_resolved(what, law, "so that the work of damping is inaccurate"));
        }
        if residual < -allowed {
            let what = format!(
                "a loss of {:.3e} J that is no law's work, {:.3} % of the reference energy (the largest exchange \
                 so far)",
                -residual,
                percent(residual)
            );
            let law = self.mechanics.laws.iter().position(|law| law.name() == self.start_limit.law);
            return Some(self.hardly_resolved(what, law, "so that the method damps it"));
        }
        None
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
        let recent: Vec<f64> = (0..good_work.len())
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
