//! Runs by implicit methods: the default step, and the fault of a step in which Newton's method fails.

use super::Simulation;
use crate::error::{Error, Result};
use crate::integrators::{Implicit, Stall};

/// The default step, relative to the explicit limit 2/omega of the highest frequency: long enough to be worth a
/// factorisation. Motion slower than about six such steps per radian is resolved.
pub(super) const LONG_STEP: f64 = 50.0;

impl Simulation {
    /// Stops a run in whose last step Newton's method failed.
    ///
    /// # Errors
    /// `Unstable`; the state is then that of the last good check.
    pub(super) fn refuse_stall(&mut self) -> Result<()> {
        let stall = self.integrator.implicit().and_then(|method: &dyn Implicit| method.stalled());
        stall.map_or(Ok(()), |stall| Err(self.stalled(stall)))
    }

    /// The error of a step in which Newton's method failed; the state is then that of the last good check.
    pub(super) fn stalled(&mut self, stall: Stall) -> Error {
        let (state, time) = (self.state.clone(), self.time());
        let largest = self.largest_force(state.at(time), stall.node..stall.node + 1);
        let what =
            format!("Newton's method finds no step from t = {:.6e} s, not even one of {:.3e} s", stall.time, stall.dt);
        let place = format!("node {} has the largest correction", self.numbering.to_external(stall.node));
        let now = self.energy_terms();
        let mut fault = self.described(what, place, largest.map(|(law, ..)| law), &now);
        fault.remedy = format!(
            "neither Newton's method nor descent finds forces in balance there: use a dt below {:.1e} s or an explicit \
             integrator; or {}",
            stall.dt, fault.remedy
        );
        self.roll_back(fault)
    }
}
