//! Positions and velocities, each component a contiguous column.

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
