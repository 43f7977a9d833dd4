//! What present contacts add to the bound of the stiffness, because the place of contact moves with the nodes.
//!
//! The energy k/2 d^2 of an edge has the second derivative k (w w^T) n n^T - k d dd/dx dx. The second term is positive
//! across an edge nearly parallel to the axis: its nearest point slides by 1/(L sin(angle)) for each unit by which its
//! ends move apart along n, and the shares of its ends change beside it. With the bound B of all elements, and K the
//! exact stiffness of an element in contact, B + c is a bound of K where
//!
//!     c = max(0, largest eigenvalue of K - B)   [N/m]
//!
//! Beyond the bound of the depth, which stops a run, nothing is added: on the axis there is no direction.

use nalgebra::DMatrix;

use super::path::DEPTH_BOUND;
use super::{BodyContact, Visitor, corners};
use crate::bodies::real::scaled;
use crate::bodies::rigid_body::Pose;

/// Below this share of the stiffness of the penalty an excess is rounding.
const ROUNDING: f64 = 1e-9;

/// Adds c p for each element in contact.
pub(super) struct Present<'a, 'b> {
    pub(super) law: &'a BodyContact,
    pub(super) poses: &'a [Pose],
    pub(super) p: [&'a [f64]; 3],
    pub(super) out: [&'b mut [f64]; 3],
}

impl Present<'_, '_> {
    /// c; N is 3 K.
    fn excess<const K: usize, const N: usize>(&self, pose: &Pose, x: &[[f64; 3]; K]) -> f64 {
        let BodyContact { contacts, stiffness, .. } = self.law;
        let Some(forces) = self.law.derived_forces::<K, N>(pose, x) else { return 0.0 };
        let most = if K == 2 { *stiffness } else { 2.0 * stiffness };
        let unit = |axis: usize| std::array::from_fn(|place| f64::from(u8::from(place == axis)));
        let bounds: [[f64; 3]; 3] =
            std::array::from_fn(|axis| scaled(most, contacts.shape.bound_of_product(self.poses, unit(axis))));
        let beyond = DMatrix::from_fn(N, N, |row, column| {
            let bound = if row / 3 == column / 3 { bounds[column % 3][row % 3] } else { 0.0 };
            -forces[row / 3][row % 3].slope[column] - bound
        });
        if !beyond.iter().all(|entry| entry.is_finite()) {
            return 0.0;
        }
        let largest = beyond.symmetric_eigenvalues().max();
        if largest > ROUNDING * stiffness { largest } else { 0.0 }
    }
}

impl Visitor for Present<'_, '_> {
    fn visit<const K: usize>(&mut self, nodes: [u32; K], x: &[[f64; 3]; K], copy: usize) {
        let (pose, shape) = (&self.poses[copy], &self.law.contacts.shape);
        let bound = shape.size().map_or(f64::INFINITY, |size| DEPTH_BOUND * size);
        let depth = shape.depth(pose, x);
        if K == 1 || depth <= 0.0 || depth > bound {
            return;
        }
        let excess = if K == 2 { self.excess::<K, 6>(pose, x) } else { self.excess::<K, 9>(pose, x) };
        if excess > 0.0 {
            for (node, direction) in nodes.into_iter().zip(corners(self.p, nodes)) {
                for (column, value) in self.out.iter_mut().zip(scaled(excess, direction)) {
                    column[node as usize] += value;
                }
            }
        }
    }
}
