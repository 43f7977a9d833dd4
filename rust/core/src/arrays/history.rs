//! The history of a method or a law: data kept from step to step beside the motion, saved and restored with a run.

use super::state::NodeVectors;

/// Vectors and numbers; empty before the first step, and for methods and laws without history.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct History {
    /// Each with one vector per node, in internal order.
    pub vectors: Vec<NodeVectors>,
    /// Other data.
    pub numbers: Vec<f64>,
}
