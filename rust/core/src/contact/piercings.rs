//! Segments that pierce triangles, exactly.

use super::box_tree::Bounds;
use super::orientation::Points;
use crate::error::Result;
use crate::model::mesh::{check_finite, check_indices};

/// The first segment whose inner points go through the inner points of a triangle, and the first such triangle, of
/// those that have no node in common. Time is that of all segments times all triangles, of which most are apart by
/// their boxes.
///
/// # Errors
/// `IndexOutOfRange` for a triangle or a segment with an unknown node; `NotFinite` for a coordinate.
pub fn first_piercing(
    positions: &[[f64; 3]],
    triangles: &[[u32; 3]],
    segments: &[[u32; 2]],
) -> Result<Option<[usize; 2]>> {
    check_indices("triangle", triangles, positions.len())?;
    check_indices("segment", segments, positions.len())?;
    check_finite("the position", positions)?;
    if segments.is_empty() || triangles.is_empty() {
        return Ok(None);
    }
    let points = Points::new(positions);
    let boxes: Vec<_> = triangles.iter().map(|nodes| Bounds::of(&nodes.map(|node| points.scaled(node)))).collect();
    for (row, segment) in segments.iter().enumerate() {
        let own = Bounds::of(&segment.map(|node| points.scaled(node)));
        let near = boxes.iter().enumerate().filter(|(_, other)| own.meets(other)).map(|(triangle, _)| triangle);
        for triangle in near {
            if pierces(&points, *segment, triangles[triangle]) {
                return Ok(Some([row, triangle]));
            }
        }
    }
    Ok(None)
}

fn pierces(points: &Points, [p, q]: [u32; 2], [a, b, c]: [u32; 3]) -> bool {
    if [a, b, c].contains(&p) || [a, b, c].contains(&q) {
        return false;
    }
    let ends = [p, q].map(|end| points.side_of_plane([a, b, c], end));
    if ends[0] * ends[1] >= 0 {
        return false;
    }
    let around = [[a, b], [b, c], [c, a]].map(|[from, to]| points.side_of_plane([p, q, from], to));
    around == [1; 3] || around == [-1; 3]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_segment_pierces_what_it_goes_through_alone() {
        let triangle = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let found = |ends: [[f64; 3]; 2]| {
            let positions = [&triangle[..], &ends].concat();
            first_piercing(&positions, &[[0, 1, 2]], &[[0, 1], [3, 4]])
        };
        let through = |x: f64, y: f64| [[x, y, -1.0], [x + 1e-3, y, 2.0]];
        assert_eq!(found(through(0.2, 0.3)), Ok(Some([1, 0])));
        assert_eq!(found(through(0.7, 0.7)), Ok(None));
        assert_eq!(found([[0.2, 0.3, 1e-300], [0.2, 0.3, 1.0]]), Ok(None));
        assert_eq!(found([[0.2, 0.3, -1e-300], [0.2, 0.3, 1.0]]), Ok(Some([1, 0])));
    }
}
