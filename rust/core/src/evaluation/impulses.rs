//! Impulses, and the power of loads on the velocities that they change.
//!
//! The power P = F . v of a load without potential is found with its forces. Impulses change v after that, and the next
//! half kick does work on what they leave.

use super::mechanics::Mechanics;
use crate::arrays::state::{NodeVectors, PhasePoint};
use crate::integrators::Kick;

impl Mechanics {
    /// Changes the velocities by the impulses that the next drift needs, and adds their work. Whether there were any.
    pub(super) fn kick(&mut self, kick: Kick<'_>, work: &mut [f64]) -> bool {
        let Some(row) = self.impulsive else { return false };
        let done = self.laws[row].impulses().and_then(|law| law.kick(kick));
        work[row] += done.unwrap_or_default();
        done.is_some()
    }

    /// The power of each selected steady load.
    pub(super) fn find_load_power(&mut self, point: PhasePoint<'_>, powers: &mut [f64]) {
        let at = self.instant(point);
        for k in 0..self.steady_loads.len() {
            let row = self.steady_loads[k];
            if self.is_selected[row] {
                powers[row] = self.add_forces_of(row, at, &mut NodeVectors::zeros(point.positions.nrows()));
            }
        }
    }
}
