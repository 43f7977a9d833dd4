//! Linearisation of a law at an instant: for stability limits, implicit steps, and the force of Coriolis.

use super::Instant;
use crate::arrays::jacobian::JacobianBlocks;
use crate::arrays::state::NodeVectors;
use crate::model::frame::Frame;

/// A law whose forces depend on positions or velocities.
pub trait Linearisation {
    /// Adds K p, with K the stiffest linearisation of the law at these positions \[N\].
    fn add_stiffness_product(&self, _at: Instant<'_>, _p: &NodeVectors, _out: &mut NodeVectors) {}

    /// Adds `factor` C p, with C the damping matrix \[N\] for velocities p \[m/s\].
    fn add_damping_product(&self, _factor: f64, _at: Instant<'_>, _p: &NodeVectors, _out: &mut NodeVectors) {}

    /// Visits the nodes of each element that couples nodes.
    fn visit_couplings(&self, _visit: &mut dyn FnMut(&[u32])) {}

    /// Adds the exact derivatives of the forces by positions and velocities at this instant.
    fn add_jacobian(&self, at: Instant<'_>, jacobian: &mut dyn JacobianBlocks);

    /// The rate w \[1/s\] of a part m w (v_y, -v_x, 0) of the forces, which does no work; methods may treat it apart.
    fn coriolis_rate(&self, _frame: Frame) -> f64 {
        0.0
    }
}
