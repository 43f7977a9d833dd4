//! Internal order of nodes and elements: the renumbering of nodes, and elements in batches.

mod batches;
mod element_set;
mod renumbering;

pub use element_set::{CHUNK, ElementSet, Pass};
pub use renumbering::Renumbering;
