//! Internal order of nodes and elements: the renumbering of nodes, and elements in batches.

mod batches;
mod coded;
mod element_set;
mod pass;
mod radix;
mod renumbering;

pub(crate) use coded::merged;
pub use coded::{Coded, Entry};
pub use element_set::ElementSet;
pub use pass::{CHUNK, Pass};
pub use renumbering::Renumbering;
