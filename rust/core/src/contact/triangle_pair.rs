//! How two triangles lie to each other.
//!
//! Two planes that are not parallel meet in a line; each triangle cuts an interval out of it. Which ends of the two
//! intervals come first follows from orientations alone: Guigue and Devillers, Fast and robust triangle-triangle
//! overlap test using orientation predicates, Journal of Graphics Tools 8 (2003). Nothing is constructed, so that
//! exact orientations give exact answers.

use super::orientation::Points;

/// What two triangles have in common.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Relation {
    /// Nothing, or a node and what follows from it.
    Apart,
    /// Points of their sides alone, without a common node.
    Touching,
    /// Inner points, in one plane.
    Overlapping,
    /// Inner points, in two planes.
    Crossing,
}

/// The relation of two triangles by their nodes. A triangle without area is apart from all, or touches.
pub(super) fn relation(points: &Points, first: [u32; 3], second: [u32; 3]) -> Relation {
    let common = first.iter().filter(|&node| second.contains(node)).count();
    let of_first = sides(points, second, first);
    // With a common side, the triangles are in one plane or have no other point in common.
    if is_on_one_side(of_first) || (common == 2 && of_first != [0; 3]) {
        return Relation::Apart;
    }
    let of_second = sides(points, first, second);
    if is_on_one_side(of_second) {
        return Relation::Apart;
    }
    if of_first == [0; 3] && of_second == [0; 3] {
        return in_one_plane(points, first, second, common);
    }
    if of_first == [0; 3] || of_second == [0; 3] {
        return Relation::Apart;
    }
    let (first, is_first_above) = alone_first(first, of_first);
    let (second, is_second_above) = alone_first(second, of_second);
    let [p1, q1, r1] = if is_second_above { first } else { reversed(first) };
    let [p2, q2, r2] = if is_first_above { second } else { reversed(second) };
    // 1 where an interval begins before the other one ends, 0 where it begins at that end.
    let order = [points.side_of_plane([p1, q1, q2], p2), points.side_of_plane([p1, r1, p2], r2)];
    let is_proper = [of_first, of_second].iter().all(|sides| sides.contains(&1) && sides.contains(&-1));
    if is_proper && order == [1, 1] {
        Relation::Crossing
    } else if common == 0 && order[0] >= 0 && order[1] >= 0 {
        Relation::Touching
    } else {
        Relation::Apart
    }
}

/// The side of a triangle's plane on which each of some nodes lies; 0 for those of its own.
fn sides(points: &Points, plane: [u32; 3], nodes: [u32; 3]) -> [i8; 3] {
    nodes.map(|node| if plane.contains(&node) { 0 } else { points.side_of_plane(plane, node) })
}

fn is_on_one_side(sides: [i8; 3]) -> bool {
    sides == [1; 3] || sides == [-1; 3]
}

/// The nodes in their sense of rotation, first the one that is alone on its side of a plane, and whether this is above
/// it; sides that are neither all alike nor all 0.
fn alone_first(nodes: [u32; 3], sides: [i8; 3]) -> ([u32; 3], bool) {
    // A side of 0 counts as the one opposite to that of the node, or of the others.
    for k in 0..3 {
        let (own, others) = (sides[k], [sides[(k + 1) % 3], sides[(k + 2) % 3]]);
        for side in [1, -1] {
            let is_alone = own * side >= 0 && others.iter().all(|other| other * side <= 0);
            if is_alone && (own != 0 || !others.contains(&0)) {
                return ([nodes[k], nodes[(k + 1) % 3], nodes[(k + 2) % 3]], side == 1);
            }
        }
    }
    (nodes, true)
}

fn reversed([p, q, r]: [u32; 3]) -> [u32; 3] {
    [p, r, q]
}

/// The relation of two triangles in one plane, by the lines along their sides: two convex shapes are apart if one of
/// these separates them.
fn in_one_plane(points: &Points, first: [u32; 3], second: [u32; 3], common: usize) -> Relation {
    let all = [[0, 1], [1, 2], [2, 0]];
    let Some(axes) = all.into_iter().find(|&axes| points.turn(first, axes) != 0) else { return Relation::Apart };
    if points.turn(second, axes) == 0 {
        return Relation::Apart;
    }
    let mut is_touching = false;
    for (own, other) in [(first, second), (second, first)] {
        let sense = points.turn(own, axes);
        for k in 0..3 {
            let [p, q] = [own[k], own[(k + 1) % 3]];
            let turns =
                other.map(|node| if node == p || node == q { 0 } else { sense * points.turn([p, q, node], axes) });
            if turns == [-1; 3] {
                return Relation::Apart;
            }
            is_touching |= turns.iter().all(|&turn| turn <= 0);
        }
    }
    match (is_touching, common) {
        (false, _) => Relation::Overlapping,
        (true, 0) => Relation::Touching,
        (true, _) => Relation::Apart,
    }
}
