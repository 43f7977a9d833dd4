//! Positions and velocities, each component a contiguous column.

use std::ops::Range;

use nalgebra::MatrixXx3;

/// One 3-vector per node: x, y and z are three contiguous columns.
pub type Vectors = MatrixXx3<f64>;

/// Where every node is and how it moves, in the frame that turns with the hub.
#[derive(Debug, Clone, PartialEq)]
pub struct State {
    /// Positions \[m\].
    pub positions: Vectors,
    /// Velocities relative to the turning frame \[m/s\].
    pub velocities: Vectors,
}

/// The instant at which laws are evaluated.
#[derive(Debug, Clone, Copy)]
pub struct Instant<'a> {
    /// Time \[s\].
    pub time: f64,
    /// Positions \[m\].
    pub positions: &'a Vectors,
    /// Velocities relative to the turning frame \[m/s\].
    pub velocities: &'a Vectors,
}

/// The three columns of `vectors`.
#[inline]
pub fn columns(vectors: &Vectors) -> [&[f64]; 3] {
    let n = vectors.nrows();
    let (x, rest) = vectors.as_slice().split_at(n);
    let (y, z) = rest.split_at(n);
    [x, y, z]
}

/// The three columns of `vectors`, to be written.
#[inline]
pub fn columns_mut(vectors: &mut Vectors) -> [&mut [f64]; 3] {
    let n = vectors.nrows();
    let (x, rest) = vectors.as_mut_slice().split_at_mut(n);
    let (y, z) = rest.split_at_mut(n);
    [x, y, z]
}

/// `rows` of the three columns of `vectors`.
#[inline]
pub fn rows(vectors: &Vectors, rows: Range<usize>) -> [&[f64]; 3] {
    columns(vectors).map(|column| &column[rows.clone()])
}

/// `rows` of the three columns of `vectors`, to be written.
#[inline]
pub fn rows_mut(vectors: &mut Vectors, rows: Range<usize>) -> [&mut [f64]; 3] {
    columns_mut(vectors).map(|column| &mut column[rows.clone()])
}

/// Columns that are only read after all.
#[inline]
pub fn shared<'a>(columns: &'a [&mut [f64]; 3]) -> [&'a [f64]; 3] {
    columns.each_ref().map(|column| &**column)
}

/// Rows that are gone over together, by one pass after the other while they are in the nearest cache.
pub const STRETCH: usize = 256;

/// The stretches of some rows.
pub fn stretches(rows: Range<usize>) -> impl Iterator<Item = Range<usize>> {
    rows.clone().step_by(STRETCH).map(move |start| start..rows.end.min(start + STRETCH))
}

/// Rows of a tile: what belongs to so many fits the cache of one processor. A multiple of `STRETCH`.
pub const TILE: usize = 2048;

/// The tiles of `count` rows, at least one.
pub fn tiles(count: usize) -> Range<usize> {
    0..count.div_ceil(TILE).max(1)
}

/// The rows of a tile.
pub fn rows_of(tile: usize, count: usize) -> Range<usize> {
    tile * TILE..count.min((tile + 1) * TILE)
}
