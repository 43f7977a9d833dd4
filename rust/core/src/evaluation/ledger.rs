//! The energy balance: what is stored and what moves, the work of laws, and the residual.
//!
//!     error = (E(t) - E(0) - W(t)) / reference energy(t)
//!
//! E is the kinetic energy in the turning frame plus every law's potential energy. W is the work of forces without a potential
//! and of whatever depends on time, integrated by the method's own stages. The reference energy is the largest single
//! exchange so far: the largest change that any one term (kinetic, each law's energy, each law's work) has shown since the
//! start. It is a strict measure, for it counts no energy twice.

use crate::arrays::state::columns;
use crate::laws::Instant;
use crate::laws::Law;

/// The energy terms at one instant \[J\].
#[derive(Debug, Clone, PartialEq)]
pub struct EnergyTerms {
    /// Kinetic energy in the turning frame.
    pub kinetic: f64,
    /// Potential energy of each law, in the laws' order; 0 for a law that has none.
    pub stored: Vec<f64>,
}

impl EnergyTerms {
    /// Those of an instant.
    pub fn of(laws: &[Box<dyn Law>], masses: &[f64], at: Instant<'_>) -> Self {
        let [u, v, w] = columns(at.velocities);
        let kinetic = (0..masses.len()).map(|i| 0.5 * masses[i] * (u[i] * u[i] + v[i] * v[i] + w[i] * w[i])).sum();
        Self { kinetic, stored: laws.iter().map(|law| law.energy(at)).collect() }
    }

    /// Kinetic plus stored.
    pub fn total(&self) -> f64 {
        self.kinetic + self.stored.iter().sum::<f64>()
    }
}

/// The running ledger of one simulation.
#[derive(Debug, Clone, PartialEq)]
pub struct Ledger {
    /// The terms when the ledger was opened.
    pub start: EnergyTerms,
    /// Work done by each law since then \[J\].
    pub work: Vec<f64>,
    /// Largest change of any energy term at the checks so far \[J\].
    pub swing: f64,
    /// What the method conserves in place of the energy, minus the energy, at the first step \[J\].
    pub start_shift: f64,
}

impl Ledger {
    /// Opens the ledger.
    pub fn open(start: EnergyTerms) -> Self {
        let work = vec![0.0; start.stored.len()];
        Self { start, work, swing: 0.0, start_shift: 0.0 }
    }

    /// The largest single exchange so far, with the terms as they are now \[J\].
    pub fn reference_energy(&self, now: &EnergyTerms) -> f64 {
        let stored = now.stored.iter().zip(&self.start.stored).map(|(now, start)| (now - start).abs());
        let changes = stored.chain(self.work.iter().map(|work| work.abs()));
        changes.fold(self.swing.max((now.kinetic - self.start.kinetic).abs()), f64::max)
    }

    /// Energy that has appeared since the start without work done on the system \[J\]; negative where it was lost.
    pub fn residual(&self, now: &EnergyTerms) -> f64 {
        now.total() - self.start.total() - self.work.iter().sum::<f64>()
    }

    /// The residual as a share of the reference energy.
    pub fn error(&self, now: &EnergyTerms) -> f64 {
        let reference_energy = self.reference_energy(now);
        if reference_energy > 0.0 { self.residual(now) / reference_energy } else { 0.0 }
    }
}
