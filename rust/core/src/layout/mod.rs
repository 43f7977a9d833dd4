//! The order in which the core keeps nodes and elements: its own business, unseen by callers.

mod batches;
mod element_set;
mod renumbering;

pub use element_set::{CHUNK, ElementSet, Pass};
pub use renumbering::Renumbering;
