//! A tree of the bounding boxes of triangles.

use std::ops::ControlFlow;

use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree, RTreeObject};

type Leaf = GeomWithData<Rectangle<[f64; 3]>, u32>;

/// Boxes, found by overlap. Coordinates are finite, and their squares do not overflow.
pub(super) struct BoxTree {
    boxes: Vec<Rectangle<[f64; 3]>>,
    tree: RTree<Leaf>,
}

impl BoxTree {
    /// The smallest boxes around the corners of triangles.
    pub(super) fn new(corners: impl Iterator<Item = [[f64; 3]; 3]>) -> Self {
        let boxes: Vec<_> = corners.map(|corners| Rectangle::from_aabb(AABB::from_points(&corners))).collect();
        let leaves = boxes.iter().zip(0..).map(|(&shape, index)| GeomWithData::new(shape, index)).collect();
        Self { boxes, tree: RTree::bulk_load(leaves) }
    }

    /// Calls `visit` with each box that has a point in common with that of triangle `index`, itself among them, in any
    /// order.
    pub(super) fn visit_neighbours<B>(
        &self,
        index: usize,
        mut visit: impl FnMut(u32) -> ControlFlow<B>,
    ) -> ControlFlow<B> {
        let envelope = self.boxes[index].envelope();
        self.tree.locate_in_envelope_intersecting_int(envelope, |leaf: &Leaf| visit(leaf.data))
    }
}
