//! What a method or a law keeps from step to step beside the motion: saved and restored with a run.

use super::state::NodeVectors;

/// Vectors and numbers to go on from; empty before the first step, and for what keeps nothing.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct History {
    /// One vector per node each, in the core's numbering.
    pub vectors: Vec<NodeVectors>,
    /// Whatever else.
    pub numbers: Vec<f64>,
}
