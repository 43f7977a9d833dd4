//! The crossings of a mesh.

use std::ops::ControlFlow;

use super::box_tree::BoxTree;
use super::orientation::Points;
use super::triangle_pair::{Relation, relation};
use crate::error::Result;
use crate::model::mesh::{check_finite, check_indices};

/// Candidates between two calls of `pause`.
const CANDIDATES_PER_PAUSE: u64 = 1024;

/// Pairs of triangles by what they have in common.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Crossings {
    /// The first pairs that cross, the lower index first, in lexicographic order.
    pub pairs: Vec<[u32; 2]>,
    /// Pairs with inner points in common, in two planes.
    pub count: u64,
    /// Pairs with inner points in common, in one plane.
    pub overlapping: u64,
    /// Pairs without a common node and with common points, which are inner points of one at most.
    pub touching: u64,
    /// Pairs whose bounding boxes have a point in common.
    pub candidates: u64,
}

/// Crossings of triangles at positions \[m\]: all counted, the first `limit` listed. `pause` is called now and then,
/// and may end the search.
///
/// Every number is exact, whatever the finite positions: no distance counts as zero. Memory is that of the triangles
/// and of `limit` pairs, and time that of the candidates, at most all pairs.
///
/// # Errors
/// `IndexOutOfRange` for a triangle with an unknown node; `NotFinite` for a coordinate.
pub fn crossings<B>(
    positions: &[[f64; 3]],
    triangles: &[[u32; 3]],
    limit: usize,
    mut pause: impl FnMut() -> ControlFlow<B>,
) -> Result<ControlFlow<B, Crossings>> {
    check_indices("triangle", triangles, positions.len())?;
    check_finite("the position", positions)?;
    let points = Points::new(positions);
    let tree = BoxTree::new(triangles.iter().map(|nodes| nodes.map(|node| points.scaled(node))));
    let mut found = Crossings::default();
    let mut crossed = Vec::new();
    for (index, &nodes) in triangles.iter().enumerate() {
        crossed.clear();
        let visited = tree.visit_neighbours(index, |other| {
            if other as usize <= index {
                return ControlFlow::Continue(());
            }
            found.candidates += 1;
            match relation(&points, nodes, triangles[other as usize]) {
                Relation::Apart => {}
                Relation::Touching => found.touching += 1,
                Relation::Overlapping => found.overlapping += 1,
                Relation::Crossing => {
                    found.count += 1;
                    if found.pairs.len() < limit {
                        crossed.push(other);
                    }
                }
            }
            if found.candidates.is_multiple_of(CANDIDATES_PER_PAUSE) { pause() } else { ControlFlow::Continue(()) }
        });
        if let ControlFlow::Break(reason) = visited {
            return Ok(ControlFlow::Break(reason));
        }
        crossed.sort_unstable();
        let left = limit - found.pairs.len();
        found.pairs.extend(crossed.iter().take(left).map(|&other| [index as u32, other]));
    }
    Ok(ControlFlow::Continue(found))
}
