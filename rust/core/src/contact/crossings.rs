//! The crossings of a mesh.

use std::ops::ControlFlow;

use super::box_tree::{Bounds, BoxTree};
use super::facet::Facet;
use super::first_pairs::FirstPairs;
use super::orientation::Points;
use super::triangle_pair::{Relation, relation};
use crate::error::Result;
use crate::model::mesh::{check_finite, check_indices};

/// Comparisons of a triangle with eight others between two calls of `pause`.
const COMPARISONS_PER_PAUSE: u64 = 256;

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
/// and of twice `limit` pairs, and time that of the candidates, at most all pairs. Most candidates are found to be
/// apart in doubles with bounds on their errors; the others need exact signs.
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
    let boxes: Vec<_> = triangles.iter().map(|nodes| Bounds::of(&nodes.map(|node| points.scaled(node)))).collect();
    let tree = BoxTree::new(&boxes);
    drop(boxes);
    let (points, facets) = in_order(points, triangles, tree.order());
    let mut found = Crossings::default();
    let mut crossed = FirstPairs::new(limit);
    let mut comparisons = 0_u64;
    let visited = tree.visit_pairs(&mut |slot, leaf, mut meeting| {
        found.candidates += u64::from(meeting.count_ones());
        while meeting != 0 {
            let other = leaf + meeting.trailing_zeros() as usize;
            meeting &= meeting - 1;
            let [first, second] = [&facets[slot], &facets[other]];
            if first.is_apart(second, &points) {
                continue;
            }
            match relation(&points, first.nodes, second.nodes) {
                Relation::Apart => {}
                Relation::Touching => found.touching += 1,
                Relation::Overlapping => found.overlapping += 1,
                Relation::Crossing => {
                    found.count += 1;
                    crossed.push(tree.order()[slot], tree.order()[other]);
                }
            }
        }
        comparisons += 1;
        if comparisons.is_multiple_of(COMPARISONS_PER_PAUSE) { pause() } else { ControlFlow::Continue(()) }
    });
    Ok(match visited {
        ControlFlow::Break(reason) => ControlFlow::Break(reason),
        ControlFlow::Continue(()) => ControlFlow::Continue(Crossings { pairs: crossed.sorted(), ..found }),
    })
}

/// Triangles in some order, and their points as these first use them, so that near triangles are near in memory.
fn in_order(points: Points, triangles: &[[u32; 3]], order: &[u32]) -> (Points, Vec<Facet>) {
    const UNUSED: u32 = u32::MAX;
    let mut renumbered = vec![UNUSED; points.len()];
    let mut used = Vec::new();
    let nodes: Vec<_> = order
        .iter()
        .map(|&index| {
            triangles[index as usize].map(|node| {
                let number = &mut renumbered[node as usize];
                if *number == UNUSED {
                    *number = used.len() as u32;
                    used.push(node);
                }
                *number
            })
        })
        .collect();
    let points = points.reordered(&used);
    let facets = nodes.into_iter().map(|nodes| Facet::new(&points, nodes)).collect();
    (points, facets)
}
