//! Kinematics of a hinge: two facets ABC and ABD that share the edge AB.
//!
//! With e = B - A, c = C - A, d = D - A the facets have the normals n_C = e x c and n_D = d x e, twice their vector areas. The
//! hinge angle theta is pi where the facets are flat, 0 where they lie on each other, negative where they interpenetrate; its
//! sign is the fold's, never the geometry's.

use std::f64::consts::{FRAC_PI_2, TAU};

use crate::layout::Renumbering;
use crate::simd::lanes::{F64x8, SimdF64, Vec3, cross, dot, sub};

/// A hinge's nodes in the core's numbering, taken from the lower node of its edge: turned by half a turn, it is the same hinge.
/// And whether the two facets have changed places.
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

    /// The hinge angle [rad]; its cut lies at -pi/2 (or 3 pi/2), as far from shut as from flat. The sine times both normals' lengths is |AB| n_D . c, since n_D x n_C = e (n_D . c).
    #[inline(always)]
    pub(crate) fn angle(&self, sign: V) -> V {
        let sine = sign * self.length * dot(self.normal_d, self.c);
        let cosine = -dot(self.normal_c, self.normal_d);
        let angle = V::atan2(sine, cosine);
        angle.below(V::all(-FRAC_PI_2), angle + V::all(TAU), angle)
    }

    /// The shares of vectors at C and at D that act at B, the rest at A, so that no torque is left of them.
    #[inline(always)]
    pub(crate) fn shares_at_b(&self) -> [V; 2] {
        let inverse = V::all(-1.0) / self.length_square;
        [dot(self.c, self.e) * inverse, dot(self.d, self.e) * inverse]
    }
}
