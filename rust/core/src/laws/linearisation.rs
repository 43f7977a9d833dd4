//! A law linearised at an instant: what stability limits, implicit steps and methods that take Coriolis apart ask for.

use super::Instant;
use crate::arrays::jacobian::JacobianBlocks;
use crate::arrays::state::NodeVectors;
use crate::model::frame::Frame;

/// A law that changes with what moves, or with how it moves.
pub trait Linearisation {
    /// Adds K p, with K the stiffest linearisation that the law can show at these positions \[N\].
    fn add_stiffness_product(&self, _at: Instant<'_>, _p: &NodeVectors, _out: &mut NodeVectors) {}

    /// Adds C p, with C the damping matrix \[N\] for velocities p \[m/s\].
    fn add_damping_product(&self, _at: Instant<'_>, _p: &NodeVectors, _out: &mut NodeVectors) {}

    /// Visits the nodes of each element through which its nodes can act on each other.
    fn visit_couplings(&self, _visit: &mut dyn FnMut(&[u32])) {}

    /// Adds the derivatives of the forces by positions and velocities, exactly, as the law is at this instant.
    fn add_jacobian(&self, at: Instant<'_>, jacobian: &mut dyn JacobianBlocks);

    /// The rate w \[1/s\] where the law's forces hold m w (v_y, -v_x, 0), which does no work; methods may treat it apart.
    fn coriolis_rate(&self, _frame: Frame) -> f64 {
        0.0
    }
}
