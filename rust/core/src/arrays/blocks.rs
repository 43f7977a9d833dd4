//! Rows of node vectors in pieces that fit the caches: tiles, which all laws go over before the next, and row blocks.

use std::ops::Range;

/// Rows that are gone over together, by one pass after the other while they are in the nearest cache.
pub const ROW_BLOCK: usize = 256;

/// The row_blocks of some rows.
pub fn row_blocks(rows: Range<usize>) -> impl Iterator<Item = Range<usize>> {
    rows.clone().step_by(ROW_BLOCK).map(move |start| start..rows.end.min(start + ROW_BLOCK))
}

/// Rows of a tile: what belongs to so many fits the cache of one processor. A multiple of `ROW_BLOCK`.
pub const TILE: usize = 2048;

/// The tiles of `count` rows, at least one.
pub fn tiles(count: usize) -> Range<usize> {
    0..count.div_ceil(TILE).max(1)
}

/// The rows of a tile.
pub fn rows_of(tile: usize, count: usize) -> Range<usize> {
    tile * TILE..count.min((tile + 1) * TILE)
}
