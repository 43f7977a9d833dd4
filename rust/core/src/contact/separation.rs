//! Whether some points and all between them keep a distance from the origin: the algorithm of Gilbert, Johnson and
//! Keerthi (IEEE Journal of Robotics and Automation 4, 1988), ended as soon as the answer is certain.

use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};

/// Most improvements; each takes the closest point of a simplex to the origin nearer to it.
const MOST_ROUNDS: usize = 64;

/// Whether the convex hull of points comes nearer to the origin than `distance`, above 0.
pub(crate) fn comes_near(points: &[Vector3<f64>], distance: f64) -> bool {
    let Some(&first) = points.first() else { return false };
    let mut simplex = [first; 4];
    let mut size = 1;
    let mut nearest = first;
    for _ in 0..MOST_ROUNDS {
        let length = nearest.norm();
        if length < distance {
            return true;
        }
        // The point furthest against the direction of the nearest one bounds the distance from below.
        let (mut support, mut least) = (first, f64::INFINITY);
        for point in points {
            let along = point.dot(&nearest);
            if along < least {
                (support, least) = (*point, along);
            }
        }
        if least >= distance * length {
            return false;
        }
        if simplex[..size].contains(&support) {
            // Nothing is nearer, up to rounding.
            return false;
        }
        simplex[size] = support;
        size += 1;
        (nearest, size) = closest(&mut simplex, size);
        if size == 4 {
            return true;
        }
    }
    true
}

/// The point of a simplex that is closest to the origin, and the corners it lies between, first in the simplex: the
/// best of all faces whose closest point is inside them. Four corners: the origin is inside.
fn closest(simplex: &mut [Vector3<f64>; 4], size: usize) -> (Vector3<f64>, usize) {
    let given = *simplex;
    let mut best: Option<(f64, Vector3<f64>, [usize; 4], usize)> = None;
    for mask in 1_u32..1 << size {
        let mut corners = [0; 4];
        let mut count = 0;
        for corner in 0..size {
            if mask >> corner & 1 == 1 {
                corners[count] = corner;
                count += 1;
            }
        }
        let Some(point) = inside(&given, &corners[..count]) else { continue };
        let square = point.norm_squared();
        if best.is_none_or(|(least, ..)| square < least) {
            best = Some((square, point, corners, count));
        }
    }
    match best {
        Some((_, point, corners, count)) => {
            for (place, corner) in corners[..count].iter().enumerate() {
                simplex[place] = given[*corner];
            }
            (point, count)
        }
        None => (given[0], 1),
    }
}

/// The point of a face that is closest to the origin, where all its barycentric coordinates are positive.
fn inside(simplex: &[Vector3<f64>; 4], corners: &[usize]) -> Option<Vector3<f64>> {
    let corner = |k: usize| simplex[corners[k]];
    let a = corner(0);
    match corners.len() {
        1 => Some(a),
        2 => {
            let side = corner(1) - a;
            let share = -a.dot(&side) / side.norm_squared();
            (share > 0.0 && share < 1.0).then(|| a + side * share)
        }
        3 => {
            let (b, c) = (corner(1) - a, corner(2) - a);
            let gram = Matrix2::new(b.dot(&b), b.dot(&c), b.dot(&c), c.dot(&c));
            let shares = gram.lu().solve(&Vector2::new(-a.dot(&b), -a.dot(&c)))?;
            (shares.x > 0.0 && shares.y > 0.0 && shares.x + shares.y < 1.0).then(|| a + b * shares.x + c * shares.y)
        }
        _ => {
            let (b, c, d) = (corner(1) - a, corner(2) - a, corner(3) - a);
            let shares = Matrix3::from_columns(&[b, c, d]).lu().solve(&-a)?;
            (shares.min() > 0.0 && shares.sum() < 1.0).then(Vector3::zeros)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_distance_of_a_hull_is_found_on_both_sides() {
        // A box of half-sides 1, 2 and 3 about a centre, whose distance from the origin is known.
        for (centre, expected) in
            [([4.0, 0.0, 0.0], 3.0), ([4.0, 6.0, 0.5], 5.0), ([4.0, 6.0, 15.0], 13.0), ([0.5, -2.5, 1.0], 0.5)]
        {
            let points: Vec<_> = (0..8)
                .map(|k| {
                    let sign = |bit: u32| if k >> bit & 1 == 0 { -1.0 } else { 1.0 };
                    Vector3::new(centre[0] + sign(0), centre[1] + 2.0 * sign(1), centre[2] + 3.0 * sign(2))
                })
                .collect();
            assert!(comes_near(&points, expected * (1.0 + 1e-12)), "{centre:?}");
            assert!(!comes_near(&points, expected * (1.0 - 1e-12)), "{centre:?}");
        }
    }

    #[test]
    fn a_hull_around_the_origin_is_near() {
        let points = [[1.0, 0.0, 0.0], [-1.0, 0.2, 0.0], [0.0, -1.0, 0.1], [0.0, 0.3, 1.0], [0.0, 0.2, -1.0]];
        assert!(comes_near(&points.map(Vector3::from), 1e-9));
    }

    #[test]
    fn far_and_flat_hulls_are_decided_to_rounding() {
        // Two parallel layers of 11 mm, 8 micrometres apart, that slide over each other.
        let square = [[0.0, 0.0], [0.011, 0.0], [0.0, 0.011], [0.011, 0.011]];
        let points: Vec<_> = square
            .iter()
            .flat_map(|[x, y]| [0.0, 4e-5].map(|way| Vector3::new(x - 0.004 + way, y - 0.003, 8e-6)))
            .collect();
        assert!(comes_near(&points, 8e-6 * (1.0 + 1e-9)) && !comes_near(&points, 8e-6 * (1.0 - 1e-9)));
    }
}
