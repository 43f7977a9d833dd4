//! The order in which the core keeps nodes and elements.

mod batches;
mod element_set;
mod renumbering;

pub use element_set::*;
pub use renumbering::*;
