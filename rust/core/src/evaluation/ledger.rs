//! The energy balance: its terms, its residual, and the reference energy.
//!
//!     error = (E(t) - E(0) - W(t)) / reference energy(t)
//!
//! E is the kinetic energy in the turning frame plus the potential energy of every law. W is the work of forces without
//! potential and of potentials that depend on time, integrated by the stages of the method. The reference energy is the
//! largest exchange so far: the largest change of any single term (kinetic energy, potential energy of a law, work of a
//! law) since the start. What jumps of schedules put in is part of E(0). It counts no energy twice, nor the translation
//! of free pieces (see `free_pieces`).
//!
//! In an isolated scene nothing acts on the free pieces but internal forces, uniform fields and the frame. There the
//! balance is that of the motion about each centre of mass in inertial space, K_int + U - W of the internal laws: the
//! same however fast the whole flies or turns, and without a difference of large numbers.

use super::free_pieces::FreePieces;
use crate::arrays::state::columns;
use crate::laws::{Instant, Law, Properties, WorkClass};

/// Kinetic and potential energies at an instant \[J\].
#[derive(Debug, Clone, PartialEq)]
pub struct EnergyTerms {
    /// Kinetic energy in the turning frame.
    pub kinetic: f64,
    /// Kinetic energy without the translation of free pieces, see `FreePieces::internal_kinetic`.
    pub internal_kinetic: f64,
    /// Potential energy of each law, in their order; 0 for a law without potential.
    pub stored: Vec<f64>,
}

impl EnergyTerms {
    /// The terms at an instant.
    pub fn of(laws: &[Box<dyn Law>], masses: &[f64], pieces: &FreePieces, at: Instant<'_>) -> Self {
        let [u, v, w] = columns(at.velocities);
        let kinetic = (0..masses.len()).map(|i| 0.5 * masses[i] * (u[i] * u[i] + v[i] * v[i] + w[i] * w[i])).sum();
        let internal_kinetic = if pieces.is_empty() { kinetic } else { pieces.internal_kinetic(masses, at) };
        Self { kinetic, internal_kinetic, stored: laws.iter().map(|law| law.energy(at)).collect() }
    }

    /// Kinetic plus potential energy.
    pub fn total(&self) -> f64 {
        self.kinetic + self.stored.iter().sum::<f64>()
    }
}

/// The terms of the balance, a property of the scene.
#[derive(Debug, Clone, Default, PartialEq)]
pub enum Scope {
    /// Kinetic energy in the turning frame, and all laws.
    #[default]
    Whole,
    /// The same, where a potential that is fixed in space acts on single nodes, such as that of contact: it exchanges
    /// energy with the translation of free pieces, which counts then.
    Obstructed,
    /// In an isolated scene: the motion about the centres of mass, and the laws that are internal.
    Isolated {
        /// Whether each law is internal.
        is_internal: Vec<bool>,
    },
}

impl Scope {
    /// The scope of a scene.
    pub fn of(laws: &[Box<dyn Law>], pieces: &FreePieces) -> Self {
        let is_internal: Vec<bool> = laws.iter().map(|law| law.properties().is_internal).collect();
        let is_isolated = laws.iter().all(|law| law.properties().is_internal || law.is_inertial());
        let is_obstacle = |law: &dyn Law| {
            let Properties { work_class, is_internal, .. } = law.properties();
            work_class == WorkClass::Conservative && !is_internal && !law.is_inertial()
        };
        match is_isolated && pieces.are_all() {
            true => Self::Isolated { is_internal },
            false if laws.iter().any(|law| is_obstacle(law.as_ref())) => Self::Obstructed,
            false => Self::Whole,
        }
    }

    /// Whether the balance is that about the centres of mass.
    pub fn is_isolated(&self) -> bool {
        matches!(self, Self::Isolated { .. })
    }

    /// The kinetic energy that may be exchanged \[J\].
    fn kinetic(&self, terms: &EnergyTerms) -> f64 {
        if *self == Self::Obstructed { terms.kinetic } else { terms.internal_kinetic }
    }

    /// Whether a law is part of the balance.
    pub fn includes(&self, law: usize) -> bool {
        match self {
            Self::Whole | Self::Obstructed => true,
            Self::Isolated { is_internal } => is_internal[law],
        }
    }
}

/// The ledger: the record of the energy balance since the start.
#[derive(Debug, Clone, PartialEq)]
pub struct Ledger {
    /// The terms of the balance.
    pub scope: Scope,
    /// The terms at the start.
    pub start: EnergyTerms,
    /// Work of each law since the start, and behind them that of the loads from outside on the turning of the frame,
    /// by their torques (`Law::outside_load`) \[J\].
    pub work: Vec<f64>,
    /// The turning energy at the start, see `Mechanics::turning_energy`; `None` where a state of an earlier version
    /// lacks it \[J\].
    pub start_turning: Option<f64>,
    /// Largest change of any single term at the checks so far \[J\].
    pub largest_change: f64,
    /// The modified energy of the method minus the energy, at the first step \[J\].
    pub start_shift: f64,
    /// What jumps of schedules have put into the kinetic energy, then into the potential energy of each law \[J\].
    pub changes: Vec<f64>,
}

impl Ledger {
    /// Opens a ledger.
    pub fn open(scope: Scope, start: EnergyTerms, turning: f64) -> Self {
        let (work, changes) = (vec![0.0; start.stored.len() + 1], vec![0.0; start.stored.len() + 1]);
        Self { scope, start, work, start_turning: Some(turning), largest_change: 0.0, start_shift: 0.0, changes }
    }

    /// Work of each law since the start \[J\].
    pub fn of_laws(&self) -> &[f64] {
        &self.work[..self.start.stored.len()]
    }

    /// Records what a jump has changed, less `work` that the ledger has \[J\]. It is no exchange: the balance goes on
    /// as if it had been there from the start.
    pub fn record_jump(&mut self, before: &EnergyTerms, after: &EnergyTerms, work: f64) {
        let kinetic = after.kinetic - before.kinetic - work;
        self.start.kinetic += kinetic;
        self.start.internal_kinetic += after.internal_kinetic - before.internal_kinetic - work;
        self.changes[0] += kinetic;
        for (k, stored) in self.start.stored.iter_mut().enumerate() {
            let change = after.stored[k] - before.stored[k];
            *stored += change;
            self.changes[k + 1] += change;
        }
    }

    /// The reference energy, with the present terms \[J\].
    pub fn reference_energy(&self, now: &EnergyTerms) -> f64 {
        let kinetic = (self.scope.kinetic(now) - self.scope.kinetic(&self.start)).abs();
        let of_law = |k: usize| (now.stored[k] - self.start.stored[k]).abs().max(self.work[k].abs());
        let laws = (0..now.stored.len()).filter(|&k| self.scope.includes(k));
        laws.map(of_law).fold(self.largest_change.max(kinetic), f64::max)
    }

    /// The residual E(t) - E(0) - W(t) \[J\]: positive for a gain, negative for a loss by the method.
    pub fn residual(&self, now: &EnergyTerms) -> f64 {
        let Scope::Isolated { is_internal } = &self.scope else {
            return now.total() - self.start.total() - self.of_laws().iter().sum::<f64>();
        };
        let internal = (0..is_internal.len()).filter(|&k| is_internal[k]);
        let of_laws = internal.map(|k| now.stored[k] - self.start.stored[k] - self.work[k]);
        now.internal_kinetic - self.start.internal_kinetic + of_laws.sum::<f64>()
    }

    /// The largest energy that the motion has at present, without a translation of free pieces that does not count
    /// \[J\].
    pub fn largest_energy(&self, now: &EnergyTerms) -> f64 {
        let stored = (0..now.stored.len()).filter(|&k| self.scope.includes(k)).map(|k| now.stored[k].abs());
        stored.fold(self.scope.kinetic(now), f64::max)
    }

    /// The kinetic energy that may be exchanged \[J\].
    pub fn kinetic(&self, now: &EnergyTerms) -> f64 {
        self.scope.kinetic(now)
    }

    /// The residual relative to the reference energy.
    pub fn error(&self, now: &EnergyTerms) -> f64 {
        let reference_energy = self.reference_energy(now);
        if reference_energy > 0.0 { self.residual(now) / reference_energy } else { 0.0 }
    }
}
