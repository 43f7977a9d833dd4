//! A start from the motion of another simulation: of the same nodes, under other laws or parameters.

use super::Simulation;
use crate::error::Result;
use crate::evaluation::ledger::Ledger;
use crate::model::checks::finite;

impl Simulation {
    /// Starts from positions \[m\] and velocities \[m/s\], in external order, at a time \[s\] and with a hub that has
    /// turned by `hub_angle` \[rad\], which goes on from there at the rate of this scene. Steps are counted from there,
    /// and the ledger is opened anew.
    ///
    /// # Errors
    /// `OutOfRange`, `LengthMismatch`, `NotFinite`; the simulation is then unchanged.
    pub fn start_from(
        &mut self,
        time: f64,
        hub_angle: f64,
        positions: &[[f64; 3]],
        velocities: &[[f64; 3]],
    ) -> Result<()> {
        finite("time at the start [s]", time)?;
        finite("angle of the hub at the start [rad]", hub_angle)?;
        self.set_motion(positions, velocities)?;
        (self.output, self.origin, self.step_count) = (None, time, 0);
        self.roll_back_adaptive(time);
        self.mechanics.spin = self.mechanics.spin.through(time, hub_angle);
        self.open_ledger();
        Ok(())
    }

    /// Opens the ledger anew, with the present motion as its start and as the last good state.
    pub(super) fn open_ledger(&mut self) {
        self.ledger = Ledger::open(self.mechanics.scope(), self.energy_terms());
        self.record_good(self.ledger.start.clone());
    }
}
