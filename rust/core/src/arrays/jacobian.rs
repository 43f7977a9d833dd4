//! The jacobian of forces: how much the force on one node changes as another moves, or moves faster.
//!
//! Laws give them block by block; what becomes of the blocks (a sparse matrix, a test's dense one) is the taker's business.

use nalgebra::{Matrix3, SMatrix, Vector3};

use crate::arrays::state::NodeVectors;

/// Row: component of the force; column: component of what changes.
pub type Block = Matrix3<f64>;

/// Takes jacobian. Node numbers are the core's.
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

/// The block of a x v for a change of v: [a]x.
pub(crate) fn crossing(a: &Vector3<f64>) -> Block {
    a.cross_matrix()
}

/// JacobianBlocks of the forces on the ends of a link, where that on the first is `pull` of (second - first), and the other its
/// opposite; `slope` is the slope of `pull`.
pub(crate) fn of_link([i, j]: [u32; 2], slope: &Block, mut add: impl FnMut(u32, u32, &Block)) {
    let opposite = -slope;
    add(i, j, slope);
    add(j, i, slope);
    add(i, i, &opposite);
    add(j, j, &opposite);
}

/// JacobianBlocks of the forces on nodes whose energy depends on M differences from node 0, with M = N - 1: `hessian` is that of
/// the energy by the differences, three rows each; forces are the negative gradient.
pub(crate) fn of_differences<const N: usize, const D: usize>(
    nodes: [u32; N],
    hessian: &SMatrix<f64, D, D>,
    mut add: impl FnMut(u32, u32, &Block),
) {
    let part = |i: usize, j: usize| -> Block { hessian.fixed_view::<3, 3>(3 * i, 3 * j).into_owned() };
    let mut corner = Block::zeros();
    for i in 0..N - 1 {
        let (mut row, mut column) = (Block::zeros(), Block::zeros());
        for j in 0..N - 1 {
            add(nodes[i + 1], nodes[j + 1], &-part(i, j));
            row += part(i, j);
            column += part(j, i);
        }
        add(nodes[i + 1], nodes[0], &row);
        add(nodes[0], nodes[i + 1], &column);
        corner += row;
    }
    add(nodes[0], nodes[0], &-corner);
}
