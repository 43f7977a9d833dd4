//! The energy balance: its terms, its residual, and the reference energy.
//!
//!     error = (E(t) - E(0) - W(t)) / reference energy(t)
//!
//! E is the kinetic energy in the turning frame plus the potential energy of every law. W is the work of forces without
//! potential and of potentials that depend on time, integrated by the stages of the method. The reference energy is the
//! largest exchange so far: the largest change of any single term (kinetic energy, potential energy of a law, work of a
//! law) since the start. It counts no energy twice.

use crate::arrays::state::columns;
use crate::laws::Instant;
use crate::laws::Law;

/// Kinetic and potential energies at an instant \[J\].
#[derive(Debug, Clone, PartialEq)]
pub struct EnergyTerms {
    /// Kinetic energy in the turning frame.
    pub kinetic: f64,
    /// Potential energy of each law, in their order; 0 for a law without potential.
    pub stored: Vec<f64>,
}

impl EnergyTerms {
    /// The terms at an instant.
    pub fn of(laws: &[Box<dyn Law>], masses: &[f64], at: Instant<'_>) -> Self {
        let [u, v, w] = columns(at.velocities);
        let kinetic = (0..masses.len()).map(|i| 0.5 * masses[i] * (u[i] * u[i] + v[i] * v[i] + w[i] * w[i])).sum();
        Self { kinetic, stored: laws.iter().map(|law| law.energy(at)).collect() }
    }

    /// Kinetic plus potential energy.
    pub fn total(&self) -> f64 {
        self.kinetic + self.stored.iter().sum::<f64>()
    }
}

/// The ledger: the record of the energy balance since the start.
#[derive(Debug, Clone, PartialEq)]
pub struct Ledger {
    /// The terms at the start.
    pub start: EnergyTerms,
    /// Work of each law since the start \[J\].
    pub work: Vec<f64>,
    /// Largest change of any single term at the checks so far \[J\].
    pub largest_change: f64,
    /// The modified energy of the method minus the energy, at the first step \[J\].
    pub start_shift: f64,
}

impl Ledger {
    /// Opens a ledger.
    pub fn open(start: EnergyTerms) -> Self {
        let work = vec![0.0; start.stored.len()];
        Self { start, work, largest_change: 0.0, start_shift: 0.0 }
    }

    /// The reference energy, with the present terms \[J\].
    pub fn reference_energy(&self, now: &EnergyTerms) -> f64 {
        let stored = now.stored.iter().zip(&self.start.stored).map(|(now, start)| (now - start).abs());
        let changes = stored.chain(self.work.iter().map(|work| work.abs()));
        changes.fold(self.largest_change.max((now.kinetic - self.start.kinetic).abs()), f64::max)
    }

    /// The residual E(t) - E(0) - W(t) \[J\]: positive for a gain, negative for a loss by the method.
    pub fn residual(&self, now: &EnergyTerms) -> f64 {
        now.total() - self.start.total() - self.work.iter().sum::<f64>()
    }

    /// The residual relative to the reference energy.
    pub fn error(&self, now: &EnergyTerms) -> f64 {
        let reference_energy = self.reference_energy(now);
        if reference_energy > 0.0 { self.residual(now) / reference_energy } else { 0.0 }
    }
}
