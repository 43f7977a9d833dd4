//! Blocks of rows of node vectors that fit the caches: tiles, on which all laws act before the next, and row blocks.

use std::ops::Range;

/// Rows of a row block: several passes node by node act on one while it is in the first cache.
pub const ROW_BLOCK: usize = 256;

/// The row blocks of some rows.
pub fn row_blocks(rows: Range<usize>) -> impl Iterator<Item = Range<usize>> {
    rows.clone().step_by(ROW_BLOCK).map(move |start| start..rows.end.min(start + ROW_BLOCK))
}

/// Rows of a tile: the data of so many nodes fit the cache of one core. A multiple of `ROW_BLOCK`.
pub const TILE: usize = 2048;

/// The tiles of `count` rows, at least one.
pub fn tiles(count: usize) -> Range<usize> {
    0..count.div_ceil(TILE).max(1)
}

/// The rows of a tile.
pub fn rows_of(tile: usize, count: usize) -> Range<usize> {
    tile * TILE..count.min((tile + 1) * TILE)
}
