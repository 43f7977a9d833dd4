//! Triangles that are apart beyond all rounding, found without exact arithmetic.
//!
//! A number in doubles decides only where it is larger than its own error; else the pair is left to exact signs.

use super::box_tree::Bounds;
use super::orientation::Points;
use crate::model::mesh::{cross, dot, sub};

/// Times the magnitudes of the factors, at least twice the error of what is computed here: of a product of differences
/// of coordinates with a direction, and of the difference of two such. With u = 2^-53, a difference has the relative
/// error u, a product with it 2 u, the sum of three of these 4 u; components of a normal have 4 u of their own.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// A triangle with what the tests need of it.
pub(super) struct Facet {
    pub(super) nodes: [u32; 3],
    /// Twice the area, in its direction.
    normal: [f64; 3],
    /// Error of a height above its plane times the length of the normal, for each unit of length from the triangle.
    rounding: f64,
    /// The longest side of its bounding box.
    extent: f64,
}

impl Facet {
    /// A triangle of some points.
    pub(super) fn new(points: &Points, nodes: [u32; 3]) -> Self {
        let [a, b, c] = nodes.map(|node| points.scaled(node));
        let (b, c) = (sub(b, a), sub(c, a));
        let terms = [[1, 2], [2, 0], [0, 1]].map(|[i, j]| [b[i] * c[j], b[j] * c[i]]);
        let magnitude: f64 = terms.iter().flatten().map(|term| term.abs()).sum();
        let Bounds { low, high } = Bounds::of(&nodes.map(|node| points.scaled(node)));
        // Products of coordinates that are too small underflow: nothing is then decided here.
        let is_exact = !nodes.iter().any(|&node| points.is_small(node));
        let extent =
            if is_exact { (0..3).map(|axis| high[axis] - low[axis]).fold(0.0, f64::max) } else { f64::INFINITY };
        Self { nodes, normal: terms.map(|[plus, minus]| plus - minus), rounding: ROUNDING * magnitude, extent }
    }

    /// Whether this triangle has no point in common with another one whose box meets its own, or only common nodes and
    /// what lies between them. `false` leaves it open.
    #[inline]
    pub(super) fn is_apart(&self, other: &Self, points: &Points) -> bool {
        let reach = self.extent + other.extent;
        let above = self.heights(points, other);
        is_on_one_side(above, [false; 3], self.rounding * reach) || self.is_apart_beside(other, points, above)
    }

    /// Heights of the nodes of another triangle above the plane of this one, times the length of the normal.
    #[inline]
    fn heights(&self, points: &Points, other: &Self) -> [f64; 3] {
        let [p, q, r] = other.nodes;
        let origin = points.scaled(self.nodes[0]);
        let height = |node| dot(self.normal, sub(points.scaled(node), origin));
        [height(p), height(q), height(r)]
    }

    /// The same where the other triangle is not wholly above or below the plane of this one.
    #[inline(never)]
    fn is_apart_beside(&self, other: &Self, points: &Points, above: [f64; 3]) -> bool {
        let reach = self.extent + other.extent;
        let below = other.heights(points, self);
        let [margin, other_margin] = [self.rounding * reach, other.rounding * reach];
        if is_on_one_side(below, [false; 3], other_margin) {
            return true;
        }
        let is_shared = self.nodes.map(|node| other.nodes.contains(&node));
        let is_others_shared = other.nodes.map(|node| self.nodes.contains(&node));
        let count = |shared: [bool; 3]| shared.iter().filter(|&&is_shared| is_shared).count();
        let common = count(is_shared);
        if common == 3 || count(is_others_shared) != common {
            return false;
        }
        if common > 0
            && (is_on_one_side(above, is_others_shared, margin) || is_on_one_side(below, is_shared, other_margin))
        {
            return true;
        }
        let corners = odd_first(self.nodes.map(|node| points.scaled(node)), is_shared, common);
        let others = odd_first(other.nodes.map(|node| points.scaled(node)), is_others_shared, common);
        match common {
            0 => self.is_beside(&corners, &others, reach) || other.is_beside(&others, &corners, reach),
            1 => are_opposite(&corners, &others, reach),
            _ => reach.is_finite() && self.is_across(&corners, others[0]),
        }
    }

    /// Whether a plane along a side and the normal separates the triangle from other points.
    fn is_beside(&self, corners: &[[f64; 3]; 3], others: &[[f64; 3]; 3], reach: f64) -> bool {
        (0..3).any(|k| {
            let outward = cross(sub(corners[(k + 1) % 3], corners[k]), self.normal);
            let along = |point: &[f64; 3]| dot(outward, sub(*point, corners[k]));
            let own = corners.iter().map(along).fold(f64::NEG_INFINITY, f64::max);
            let least = others.iter().map(along).fold(f64::INFINITY, f64::min);
            least - own > error(outward, reach)
        })
    }

    /// Whether the first corner and another point lie on two sides of the line through the other two corners, seen
    /// along the axis that is nearest to the normal. No product of coordinates underflows.
    fn is_across(&self, &[own, start, end]: &[[f64; 3]; 3], other: [f64; 3]) -> bool {
        let size = self.normal.map(f64::abs);
        let [i, j] = if size[0] >= size[1] && size[0] >= size[2] {
            [1, 2]
        } else if size[1] >= size[2] {
            [2, 0]
        } else {
            [0, 1]
        };
        let side = sub(end, start);
        let turn = |point| {
            let to = sub(point, start);
            let [plus, minus] = [side[i] * to[j], side[j] * to[i]];
            let (turn, margin) = (plus - minus, ROUNDING * (plus.abs() + minus.abs()));
            i8::from(turn > margin) - i8::from(turn < -margin)
        };
        turn(own) * turn(other) < 0
    }
}

/// Whether a plane through the first corner, which is common, has the other two on one side of it, and those of another
/// triangle on the other side: the plane halfway between the directions of the two.
fn are_opposite(corners: &[[f64; 3]; 3], others: &[[f64; 3]; 3], reach: f64) -> bool {
    let [ahead, behind] = [corners, others].map(|[common, p, q]| [p, q].map(|&point| sub(point, *common)));
    let axis: [f64; 3] = std::array::from_fn(|k| (ahead[0][k] + ahead[1][k]) - (behind[0][k] + behind[1][k]));
    let margin = error(axis, reach);
    ahead.iter().all(|&to| dot(axis, to) > margin) && behind.iter().all(|&to| dot(axis, to) < -margin)
}

/// Whether all heights but those of shared nodes, which are 0, are above a margin, or all below it.
#[inline]
fn is_on_one_side(heights: [f64; 3], is_shared: [bool; 3], margin: f64) -> bool {
    let ([p, q, r], [a, b, c]) = (heights, is_shared);
    let is_above = (a | (p > margin)) & (b | (q > margin)) & (c | (r > margin));
    let is_below = (a | (p < -margin)) & (b | (q < -margin)) & (c | (r < -margin));
    is_above | is_below
}

/// Corners in their sense of rotation, the only shared one first, or the only one that is not.
fn odd_first(corners: [[f64; 3]; 3], is_shared: [bool; 3], common: usize) -> [[f64; 3]; 3] {
    let first = is_shared.iter().position(|&is_shared| is_shared == (common == 1)).unwrap_or(0);
    [corners[first], corners[(first + 1) % 3], corners[(first + 2) % 3]]
}

/// Bound on the error of the difference of two heights along a direction, of points so near to the origin.
fn error(direction: [f64; 3], reach: f64) -> f64 {
    ROUNDING * direction.iter().map(|part| part.abs()).sum::<f64>() * reach
}

#[cfg(test)]
mod tests {
    use super::super::triangle_pair::{Relation, relation};
    use super::*;

    /// Pairs of triangles of some nodes whose boxes meet: how many there are, and how many are found to be apart.
    fn decided(given: &[[f64; 3]], triangles: &[[u32; 3]]) -> (usize, usize) {
        let points = Points::new(given);
        let facets: Vec<_> = triangles.iter().map(|&nodes| Facet::new(&points, nodes)).collect();
        let bounds = |nodes: [u32; 3]| Bounds::of(&nodes.map(|node| points.scaled(node)));
        let (mut pairs, mut apart) = (0, 0);
        for (k, first) in facets.iter().enumerate() {
            for second in &facets[k + 1..] {
                if !bounds(first.nodes).meets(&bounds(second.nodes)) {
                    continue;
                }
                pairs += 1;
                for (first, second) in [(first, second), (second, first)] {
                    if first.is_apart(second, &points) {
                        let found = relation(&points, first.nodes, second.nodes);
                        assert_eq!(found, Relation::Apart, "{:?} {:?} of {given:?}", first.nodes, second.nodes);
                    }
                }
                apart += usize::from(first.is_apart(second, &points));
            }
        }
        (pairs, apart)
    }

    /// Whole numbers below a bound, by a linear congruential generator.
    fn numbers() -> impl FnMut(u64) -> u64 {
        let mut seed = 1_u64;
        move |below| {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 33) % below
        }
    }

    #[test]
    fn what_is_found_to_be_apart_is_apart() {
        let mut number = numbers();
        // Coordinates on a coarse grid, in a plane or near one, moved by a few units of the last place, or tiny.
        for round in 0..3000 {
            let scale = [1.0, 0.1, 1e-130, 1e300, f64::MIN_POSITIVE][round % 5];
            let flat = round % 3;
            let given: Vec<[f64; 3]> = (0..7)
                .map(|_| {
                    let [x, y, z] = [0; 3].map(|_: u8| (number(7) as f64 - 3.0) * scale);
                    let z = [z, 0.3 * x - 0.7 * y, 0.0][flat];
                    [x, y, z].map(|value| value * (1.0 + (number(5) as f64 - 2.0) * f64::EPSILON))
                })
                .collect();
            let triangles: Vec<[u32; 3]> = (0..6)
                .map(|_| [0; 3].map(|_: u8| number(7) as u32))
                .filter(|[a, b, c]| a != b && b != c && a != c)
                .collect();
            decided(&given, &triangles);
        }
    }

    #[test]
    fn neighbours_in_a_sheet_and_in_the_next_layer_need_no_exact_arithmetic() {
        let side = 8_u32;
        let node = |layer: u32, i: u32, j: u32| (layer * side + i) * side + j;
        let mut given = Vec::new();
        let mut triangles = Vec::new();
        for layer in 0..2 {
            for i in 0..side {
                // Turned by 30 degrees, and folded along the middle.
                let (u, v) = (0.1 * f64::from(i), 0.01 * f64::from(layer));
                let height = 0.4 * (u - 0.35).abs();
                for j in 0..side {
                    let w = 0.1 * f64::from(j) + 0.05 * f64::from(i);
                    given.push([0.8 * u - 0.6 * w, 0.6 * u + 0.8 * w, v + height]);
                    if i + 1 < side && j + 1 < side {
                        let [a, b] = [node(layer, i, j), node(layer, i + 1, j)];
                        triangles.extend([[a, b, a + 1], [b, b + 1, a + 1]]);
                    }
                }
            }
        }
        let (pairs, apart) = decided(&given, &triangles);
        assert!(pairs > 1000 && 100 * apart > 99 * pairs, "{apart} of {pairs}");
    }
}
