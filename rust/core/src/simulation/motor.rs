//! The work of the motor that turns the hub at its prescribed rate.
//!
//! tau is the torque about the axis that the hub and all that turns with it exert on the nodes: holds, moved nodes,
//! spool, bodies, friction relative to the frame. By the theorem of angular momentum tau = L' - tau_out, with L that of
//! all nodes in inertial space and tau_out the torque of loads from outside. Integrated by parts, the work is
//!
//!     W = integral of Omega tau dt = [Omega L] - integral of Omega' L dt - integral of Omega tau_out dt      \[J\]
//!
//! The first term is one of the state. -Omega' L is the power of the law of the frame; the other inertial laws have
//! the power -Omega tau_out, by which their potential changes as it turns in the frame. The stages of the method
//! integrate both as works in the ledger, and behind them Omega times the torque (`Law::outside_load`) of the other
//! loads from outside, among them gravity with a factor, which has no potential. So the work is of the order of the
//! method and needs no torque of contact, which is large and quick; and K in inertial space, U, and the works of all
//! laws in inertial space have the residual of the balance in the turning frame. The motor of a free hub has the work
//! of its torque, which is that of the law of the frame.

use super::Simulation;
use crate::laws::{Law, WorkClass};

impl Simulation {
    /// The work of the motor since the start \[J\]; `None` where a state of an earlier version lacks its start.
    pub fn motor_work(&self) -> Option<f64> {
        let (mechanics, ledger) = (&self.mechanics, &self.ledger);
        if let Some(row) = mechanics.hub_row {
            return Some(ledger.work[row]);
        }
        let start = ledger.start_turning?;
        let is_by_turning = |law: &dyn Law| law.is_inertial() && law.properties().work_class == WorkClass::Conservative;
        let inertial = mechanics.laws.iter().zip(&ledger.work).filter(|(law, _)| is_by_turning(law.as_ref()));
        let of_frame: f64 = inertial.map(|(_, work)| work).sum();
        let of_outside = ledger.work[mechanics.laws.len()];
        Some(mechanics.turning_energy(self.state.at(self.time())) - start + of_frame - of_outside)
    }
}
