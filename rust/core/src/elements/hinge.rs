//! Kinematics of a hinge: two facets ABC and ABD with the common edge AB.
//!
//! With e = B - A, c = C - A, d = D - A the facets have the normals n_C = e x c and n_D = d x e, twice their vector
//! areas. The hinge angle theta is pi for flat facets, 0 for a shut hinge, and negative where the facets
//! interpenetrate. The fold pattern gives its sign, not the geometry. Positions give it up to whole turns.

use std::f64::consts::TAU;

use crate::layout::Renumbering;
use crate::simd::lanes::{F64x8, SimdF64, Vec3, cross, dot, sub};

/// The internal nodes of a hinge, with the lower node of its edge as A: a hinge has no direction. Second, whether this
/// exchanges the two facets.
pub(crate) fn oriented(nodes: [u32; 4], numbering: &Renumbering) -> ([u32; 4], bool) {
    let [a, b, c, d] = numbering.to_internal(nodes);
    if a < b { ([a, b, c, d], false) } else { ([b, a, d, c], true) }
}

/// The facets of a batch of hinges.
pub(crate) struct Facets<V = F64x8> {
    /// B - A, C - A, D - A [m].
    pub(crate) e: Vec3<V>,
    pub(crate) c: Vec3<V>,
    pub(crate) d: Vec3<V>,
    /// Twice the vector areas of the facets [m2].
    pub(crate) normal_c: Vec3<V>,
    pub(crate) normal_d: Vec3<V>,
    /// |AB| [m] and its square.
    pub(crate) length: V,
    length_square: V,
}

impl<V: SimdF64> Facets<V> {
    #[inline(always)]
    pub(crate) fn new([a, b, c, d]: [Vec3<V>; 4]) -> Self {
        let (e, c, d) = (sub(b, a), sub(c, a), sub(d, a));
        let length_square = dot(e, e).max(V::all(f64::MIN_POSITIVE));
        let length = length_square.sqrt();
        Self { e, c, d, normal_c: cross(e, c), normal_d: cross(d, e), length, length_square }
    }

    /// The sine of the hinge angle, times the product of the lengths of both normals over |AB|: n_D . c, since
    /// n_D x n_C = e (n_D . c).
    #[inline(always)]
    pub(crate) fn sine(&self, sign: V) -> V {
        sign * dot(self.normal_d, self.c)
    }

    /// The cosine, times the product of the lengths of both normals.
    #[inline(always)]
    pub(crate) fn cosine(&self) -> V {
        -dot(self.normal_c, self.normal_d)
    }

    /// The hinge angle, from `least` up to a turn more; `least` lies in \[-pi, pi\) \[rad\].
    #[inline(always)]
    pub(crate) fn angle(&self, sign: V, least: V) -> V {
        let angle = V::atan2(self.length * self.sine(sign), self.cosine());
        angle.below(least, angle + V::all(TAU), angle)
    }

    /// The shares of forces at C and at D that B bears, normal to the facets; A bears the rest, without torque.
    #[inline(always)]
    pub(crate) fn shares_at_b(&self) -> [V; 2] {
        let inverse = V::all(-1.0) / self.length_square;
        [dot(self.c, self.e) * inverse, dot(self.d, self.e) * inverse]
    }
}
