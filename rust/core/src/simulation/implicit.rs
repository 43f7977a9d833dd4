//! What a run by an implicit method has beside: the step where none is given, and what is told where none can be taken.

use super::Simulation;
use crate::error::Result;
use crate::integrators::Implicit;

/// The step where none is given, over the explicit limit 2/omega of the highest frequency: long enough to be worth its
/// factorisation. What is slower than about six such steps per radian is resolved.
pub(super) const LONG_STEP: f64 = 50.0;

impl Simulation {
    /// Stops a run whose last step could not be taken.
    ///
    /// # Errors
    /// `Unstable`; the state is then that of the last good check.
    pub(super) fn refuse_stall(&mut self) -> Result<()> {
        let Some(stall) = self.integrator.implicit().and_then(|method: &dyn Implicit| method.stalled()) else {
            return Ok(());
        };
        let (state, time) = (self.state.clone(), self.time());
        let largest = self.largest_force(state.at(time), stall.node..stall.node + 1);
        let what =
            format!("Newton's method finds no step from t = {:.6e} s, not even one of {:.3e} s", stall.time, stall.dt);
        let place = format!("node {} is corrected most", self.numbering.to_external(stall.node));
        let now = self.energy_terms();
        let mut fault = self.described(what, place, largest.map(|(law, ..)| law), &now);
        fault.remedy += "; or use an explicit integrator";
        Err(self.set_back(fault))
    }
}
