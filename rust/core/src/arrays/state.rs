//! Positions and velocities, each component a contiguous column.

use std::ops::Range;

use nalgebra::MatrixXx3;

/// One 3-vector per node: x, y and z are three contiguous columns.
pub type NodeVectors = MatrixXx3<f64>;

/// Positions and velocities of all nodes, in the frame that turns with the hub.
#[derive(Debug, Clone, PartialEq)]
pub struct State {
    /// Positions \[m\].
    pub positions: NodeVectors,
    /// Velocities relative to the turning frame \[m/s\].
    pub velocities: NodeVectors,
}

/// A point (t, x, v) of an evaluation.
#[derive(Debug, Clone, Copy)]
pub struct PhasePoint<'a> {
    /// Time \[s\].
    pub time: f64,
    /// Positions \[m\].
    pub positions: &'a NodeVectors,
    /// Velocities relative to the turning frame \[m/s\].
    pub velocities: &'a NodeVectors,
}

impl State {
    /// The state as a point at `time`.
    pub fn at(&self, time: f64) -> PhasePoint<'_> {
        PhasePoint { time, positions: &self.positions, velocities: &self.velocities }
    }
}

/// The three columns of `vectors`.
#[inline]
pub fn columns(vectors: &NodeVectors) -> [&[f64]; 3] {
    let n = vectors.nrows();
    let (x, rest) = vectors.as_slice().split_at(n);
    let (y, z) = rest.split_at(n);
    [x, y, z]
}

/// The three columns of `vectors`, for writing.
#[inline]
pub fn columns_mut(vectors: &mut NodeVectors) -> [&mut [f64]; 3] {
    let n = vectors.nrows();
    let (x, rest) = vectors.as_mut_slice().split_at_mut(n);
    let (y, z) = rest.split_at_mut(n);
    [x, y, z]
}

/// `rows` of the three columns of `vectors`.
#[inline]
pub fn rows(vectors: &NodeVectors, rows: Range<usize>) -> [&[f64]; 3] {
    columns(vectors).map(|column| &column[rows.clone()])
}

/// `rows` of the three columns of `vectors`, for writing.
#[inline]
pub fn rows_mut(vectors: &mut NodeVectors, rows: Range<usize>) -> [&mut [f64]; 3] {
    columns_mut(vectors).map(|column| &mut column[rows.clone()])
}

/// Columns for writing, as columns for reading.
#[inline]
pub fn shared<'a>(columns: &'a [&mut [f64]; 3]) -> [&'a [f64]; 3] {
    columns.each_ref().map(|column| &**column)
}
