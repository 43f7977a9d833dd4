//! The closest points of a node and a triangle, and of two edges, eight pairs at a time.
//!
//! Both are four nodes q with weights w_q, so that the gap is g = sum of w_q x_q: of a node and a triangle
//! (1, -u, -v, -w) with the barycentric coordinates of the triangle's point, of two edges (1 - s, s, -(1 - t), -t).
//! All cases of sides and corners are covered: Ericson, Real-Time Collision Detection (2005), chapter 5.

use crate::simd::lanes::{SimdF64, Vec3, dot, scale, sub, sum};

/// Weights of the four nodes, and the gap \[m\].
#[derive(Clone, Copy)]
pub(crate) struct Closest<V> {
    pub(crate) weights: [V; 4],
    pub(crate) gap: Vec3<V>,
    /// Of two edges the squared sine of their angle; of a node and a triangle 1.
    pub(crate) square_sine: V,
}

/// A number between 0 and 1; 0 where it is none.
#[inline(always)]
fn clamped<V: SimdF64>(value: V) -> V {
    value.max(V::zero()).min(V::all(1.0))
}

/// The first of four points, and the triangle of the others.
#[inline(always)]
pub(crate) fn node_triangle<V: SimdF64>([p, a, b, c]: [Vec3<V>; 4]) -> Closest<V> {
    let (zero, one) = (V::zero(), V::all(1.0));
    let (ab, ac, bc) = (sub(b, a), sub(c, a), sub(c, b));
    let (ap, bp) = (sub(p, a), sub(p, b));
    let (g00, g01, g11) = (dot(ab, ab), dot(ab, ac), dot(ac, ac));
    let (p0, p1) = (dot(ap, ab), dot(ap, ac));
    let scale_of = one / (g00 * g11 - g01 * g01);
    let (v, w) = ((g11 * p0 - g01 * p1) * scale_of, (g00 * p1 - g01 * p0) * scale_of);
    let u = one - v - w;
    // The closest point of each side, by its place along it, and the squared distance.
    let (s0, s1) = (clamped(p0 / g00), clamped(p1 / g11));
    let s2 = clamped(dot(bp, bc) / dot(bc, bc));
    let far = [sub(ap, scale(s0, ab)), sub(ap, scale(s1, ac)), sub(bp, scale(s2, bc))];
    let far = [dot(far[0], far[0]), dot(far[1], far[1]), dot(far[2], far[2])];
    let (mut least, mut of_b, mut of_c) = (far[0], s0, zero);
    of_b = far[1].below(least, zero, of_b);
    of_c = far[1].below(least, s1, of_c);
    least = far[1].below(least, far[1], least);
    of_b = far[2].below(least, one - s2, of_b);
    of_c = far[2].below(least, s2, of_c);
    // Inside all three sides; a triangle without area has numbers that are none, and is left to its sides.
    let inner = zero.below(u, zero.below(v, zero.below(w, one, zero), zero), zero);
    let of_b = zero.below(inner, v, of_b);
    let of_c = zero.below(inner, w, of_c);
    let gap = sub(ap, sum(scale(of_b, ab), scale(of_c, ac)));
    Closest { weights: [one, of_b + of_c - one, -of_b, -of_c], gap, square_sine: one }
}

/// Two edges, each of two points.
#[inline(always)]
pub(crate) fn edge_edge<V: SimdF64>([a, b, c, d]: [Vec3<V>; 4]) -> Closest<V> {
    let (zero, one) = (V::zero(), V::all(1.0));
    let (first, second, apart) = (sub(b, a), sub(d, c), sub(a, c));
    let (ff, ss, fs) = (dot(first, first), dot(second, second), dot(first, second));
    let (fa, sa) = (dot(first, apart), dot(second, apart));
    let area = ff * ss - fs * fs;
    // The points of the two lines; those of parallel lines are any.
    let s = clamped(zero.below(area, (fs * sa - fa * ss) / area, zero));
    let t = (fs * s + sa) / ss;
    let beyond = clamped((fs - fa) / ff);
    let before = clamped(-fa / ff);
    let s = t.below(zero, before, one.below(t, beyond, s));
    let t = clamped(t);
    let gap = sub(sum(apart, scale(s, first)), scale(t, second));
    Closest { weights: [one - s, s, t - one, -t], gap, square_sine: area / (ff * ss) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::lanes::{F64x8, LANES};

    /// Numbers between -1 and 1 without an order.
    fn points(seed: u32) -> [Vec3<F64x8>; 4] {
        std::array::from_fn(|k| {
            std::array::from_fn(|axis| {
                F64x8(std::array::from_fn(|lane| {
                    (f64::from(seed) * 1.7 + 7.3 * k as f64 + 2.9 * axis as f64 + 5.1 * lane as f64).sin()
                }))
            })
        })
    }

    fn lane(points: &[Vec3<F64x8>; 4], lane: usize) -> [[f64; 3]; 4] {
        points.map(|point| point.map(|values| values.0[lane]))
    }

    fn distance(weights: [f64; 4], x: &[[f64; 3]; 4]) -> f64 {
        let gap: [f64; 3] = std::array::from_fn(|axis| (0..4).map(|k| weights[k] * x[k][axis]).sum());
        gap.iter().map(|g| g * g).sum::<f64>().sqrt()
    }

    /// No point of a fine grid of weights is nearer, and the gap is that of the weights.
    fn check(found: &Closest<F64x8>, x: &[Vec3<F64x8>; 4], grid: &[[f64; 4]]) {
        for k in 0..LANES {
            let (weights, x) = (found.weights.map(|weight| weight.0[k]), lane(x, k));
            let gap = found.gap.map(|gap| gap.0[k]);
            let size = gap.iter().map(|g| g * g).sum::<f64>().sqrt();
            assert!((distance(weights, &x) - size).abs() < 1e-14);
            assert!(weights[0] + weights[1] + weights[2] + weights[3] < 1e-15);
            let nearest = grid.iter().map(|weights| distance(*weights, &x)).fold(f64::INFINITY, f64::min);
            assert!(size <= nearest + 1e-12 && nearest < size + 0.06, "{size} {nearest}");
        }
    }

    #[test]
    fn no_point_of_a_triangle_is_nearer_to_a_node() {
        let mut grid = Vec::new();
        for i in 0..=40_u32 {
            for j in 0..=40 - i {
                let (v, w) = (f64::from(i) / 40.0, f64::from(j) / 40.0);
                grid.push([1.0, v + w - 1.0, -v, -w]);
            }
        }
        for seed in 0..60 {
            let x = points(seed);
            check(&node_triangle(x), &x, &grid);
        }
    }

    #[test]
    fn no_points_of_two_edges_are_nearer() {
        let mut grid = Vec::new();
        for i in 0..=50_u32 {
            for j in 0..=50_u32 {
                let (s, t) = (f64::from(i) / 50.0, f64::from(j) / 50.0);
                grid.push([1.0 - s, s, t - 1.0, -t]);
            }
        }
        for seed in 0..60 {
            let x = points(seed);
            check(&edge_edge(x), &x, &grid);
        }
    }

    #[test]
    fn parallel_edges_and_flat_triangles_have_a_distance() {
        let all = |x: [[f64; 3]; 4]| x.map(|point| point.map(F64x8::all));
        let side_by_side = all([[0.0; 3], [1.0, 0.0, 0.0], [0.5, 0.0, 0.3], [2.5, 0.0, 0.3]]);
        let one_after_the_other = all([[0.0; 3], [1.0, 0.0, 0.0], [4.0, 0.0, 0.0], [2.5, 0.0, 0.0]]);
        let collapsed = all([[0.5, 0.7, 0.0], [0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]]);
        let size = |found: Closest<F64x8>| dot(found.gap, found.gap).sqrt().0[0];
        assert!((size(edge_edge(side_by_side)) - 0.3).abs() < 1e-15);
        assert!((size(edge_edge(one_after_the_other)) - 1.5).abs() < 1e-15);
        assert!((size(node_triangle(collapsed)) - 0.7).abs() < 1e-15);
    }
}
