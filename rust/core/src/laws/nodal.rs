//! Nodal laws: the force on a node depends on that node alone, or on a sum over its neighbours prepared before.

use std::ops::Range;

use super::Instant;

/// A law that methods add row block by row block, while the nodes are in the cache.
pub trait NodalLaw {
    /// Prepares sums over neighbours, once for each tile, in order, before `add_to_rows` for its nodes.
    fn prepare(&mut self, _tile: usize, _at: Instant<'_>) {}

    /// Adds the forces \[N\] on `rows` to three columns of that length, and returns the power as in `Law::add_to_tile`.
    fn add_to_rows(&mut self, rows: Range<usize>, at: Instant<'_>, forces: [&mut [f64]; 3]) -> f64;
}
