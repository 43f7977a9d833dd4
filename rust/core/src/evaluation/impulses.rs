//! Impulses, and the power of loads on the velocities that they change.
//!
//! The power P = F . v of a load without potential is found with its forces. Impulses change v after that, and the next
//! half kick does work on what they leave.

use super::mechanics::Mechanics;
use crate::arrays::state::{NodeVectors, PhasePoint};
use crate::integrators::Kick;

impl Mechanics {
    /// Changes the velocities by the impulses that the next drift needs, and adds their work. Whether there were any.
    ///
    /// Nodes that move as prescribed are where they are to be at both ends of the drift, which their velocities at its
    /// start do not tell.
    pub(super) fn kick(&mut self, kick: Kick<'_>, work: &mut [f64]) -> bool {
        let Some(row) = self.impulsive else { return false };
        let Kick { time, dt, state, .. } = kick;
        let [now, then] = [time, time + dt].map(|time| self.moves_in(0..self.masses.len(), time));
        let (mut places, mut velocities) = (Vec::new(), Vec::new());
        for ((node, now), (_, then)) in now.into_iter().zip(then) {
            places.push((node, state.positions.row(node).into_owned()));
            velocities.push((node, (then.position - now.position) / dt));
            state.positions.set_row(node, &now.position.transpose());
        }
        let done = self.laws[row].impulses().and_then(|law| law.kick(Kick { state: &mut *state, ..kick }, &velocities));
        places.iter().for_each(|(node, place)| state.positions.set_row(*node, place));
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
