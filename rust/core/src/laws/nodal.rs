//! Laws whose force on a node depends on that node alone, or on a sum over its neighbours that is worked out before.

use std::ops::Range;

use super::Instant;

/// A law that can be added row block by row block, in the pass of a method that has the nodes in the cache.
pub trait NodalLaw {
    /// Works out what depends on neighbours; once for each tile, in order, before `add_to_rows` goes over its nodes.
    fn prepare(&mut self, _tile: usize, _at: Instant<'_>) {}

    /// Adds the forces \[N\] on `rows` to three columns of as many, and returns the power as `Law::add_to_tile` does.
    fn add_to_rows(&mut self, rows: Range<usize>, at: Instant<'_>, forces: [&mut [f64]; 3]) -> f64;
}
