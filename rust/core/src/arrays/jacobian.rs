//! The Jacobian of the forces: derivatives of the force on one node by position and velocity of another.
//!
//! Laws pass it block by block to a receiver, such as the sparse tangent, or the dense matrix of a test.

use nalgebra::{Matrix3, SMatrix, Vector3};

use crate::arrays::state::NodeVectors;

/// Row: component of the force; column: component of the position or velocity.
pub type Block = Matrix3<f64>;

/// A receiver of blocks. Node numbers are internal.
pub trait JacobianBlocks {
    /// Adds to dF_on / dx_of \[N/m\].
    fn by_position(&mut self, on: u32, of: u32, block: &Block);
    /// Adds to dF_on / dv_of \[N s/m\].
    fn by_velocity(&mut self, on: u32, of: u32, block: &Block);
}

/// The vector of a node.
pub(crate) fn at(vectors: &NodeVectors, node: u32) -> Vector3<f64> {
    vectors.row(node as usize).transpose()
}

/// The derivative of a x v by v: [a]x.
pub(crate) fn cross_matrix(a: &Vector3<f64>) -> Block {
    a.cross_matrix()
}

/// Blocks of the forces on the ends of a link, a function of (second - first) on the first and its opposite on the
/// second; `derivative` is that of the function.
pub(crate) fn of_link([i, j]: [u32; 2], derivative: &Block, mut add: impl FnMut(u32, u32, &Block)) {
    let opposite = -derivative;
    add(i, j, derivative);
    add(j, i, derivative);
    add(i, i, &opposite);
    add(j, j, &opposite);
}

/// Blocks of the forces on N nodes with an energy that depends on the N - 1 differences from node 0. `hessian` is that
/// of the energy by the differences, three rows each; forces are the negative gradient.
pub(crate) fn of_differences<const N: usize, const D: usize>(
    nodes: [u32; N],
    hessian: &SMatrix<f64, D, D>,
    mut add: impl FnMut(u32, u32, &Block),
) {
    let block = |i: usize, j: usize| -> Block { hessian.fixed_view::<3, 3>(3 * i, 3 * j).into_owned() };
    let mut corner = Block::zeros();
    for i in 0..N - 1 {
        let (mut row, mut column) = (Block::zeros(), Block::zeros());
        for j in 0..N - 1 {
            add(nodes[i + 1], nodes[j + 1], &-block(i, j));
            row += block(i, j);
            column += block(j, i);
        }
        add(nodes[i + 1], nodes[0], &row);
        add(nodes[0], nodes[i + 1], &column);
        corner += row;
    }
    add(nodes[0], nodes[0], &-corner);
}
