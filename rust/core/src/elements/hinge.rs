//! Kinematics of a hinge and its transpose: two facets ABC and ABD with the common edge AB.
//!
//! With e = B - A, c = C - A, d = D - A the facets have the normals n_C = e x c and n_D = d x e, twice their vector
//! areas. The hinge angle theta is pi for flat facets, 0 for a shut hinge, and negative where the facets
//! interpenetrate. The fold pattern gives its sign, not the geometry. Positions give it up to whole turns. The fold
//! angle phi = pi - theta, positive for a valley, is 0 for flat facets and +-pi for a shut hinge.
//!
//! A function u of the angle acts with the weights of both facets, U = w_C w_D u,
//!
//!     w = (1 + c^2) A^2 / (A^2 + (c A0)^2)
//!
//! A is the present and A0 the reference area of a facet, at which w = 1. Without the weights the force on an apex,
//! u'/height, is singular as a facet collapses, and a run gains energy there. With |AB|/(4 A^2 + 4 (c A0)^2) the
//! weighted force has no singularity.

use std::f64::consts::TAU;

use crate::simd::lanes::{F64x8, SimdF64, Vec3, cross, dot, negate, scale, sub, sum};

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

    /// The fold angle, from -pi to pi: its cut is where the hinge is shut, from either side \[rad\].
    #[inline(always)]
    pub(crate) fn fold_angle(&self) -> V {
        let [sine, cosine] = self.unscaled_direction();
        V::atan2(sine, cosine)
    }

    /// The fold angle less a natural one, given by its sine and cosine, from -pi to pi: its cut is half a turn from the
    /// natural angle \[rad\].
    #[inline(always)]
    pub(crate) fn fold_beyond(&self, natural: [V; 2]) -> V {
        let [sine, cosine] = turned_back(self.unscaled_direction(), natural);
        V::atan2(sine, cosine)
    }

    /// The sine and the cosine of the fold angle; 0 where a facet has no area.
    #[inline(always)]
    pub(crate) fn fold_direction(&self) -> [V; 2] {
        let [square_c, square_d] = self.squares();
        let inverse = V::all(1.0) / (square_c.sqrt() * square_d.sqrt()).max(V::all(f64::MIN_POSITIVE));
        let [sine, cosine] = self.unscaled_direction();
        [sine * inverse, cosine * inverse]
    }

    /// The sine and the cosine of the fold angle, times the product of the lengths of both normals.
    #[inline(always)]
    fn unscaled_direction(&self) -> [V; 2] {
        [self.length * dot(self.normal_d, self.c), dot(self.normal_c, self.normal_d)]
    }

    /// The squares of the lengths of both normals.
    #[inline(always)]
    pub(crate) fn squares(&self) -> [V; 2] {
        [dot(self.normal_c, self.normal_c), dot(self.normal_d, self.normal_d)]
    }

    /// w_C w_D, up to the factor (1 + c^2)^2; `softening` is 4 (c A0)^2 of each facet.
    #[inline(always)]
    pub(crate) fn weight(&self, [soft_c, soft_d]: [V; 2]) -> V {
        let [square_c, square_d] = self.squares();
        square_c / (square_c + soft_c) * square_d / (square_d + soft_d)
    }

    /// The gradients of the fold angle at A, B, C and D, the part of each facet with its weight.
    #[inline(always)]
    pub(crate) fn weighted_gradients(&self, [soft_c, soft_d]: [V; 2]) -> [Vec3<V>; 4] {
        let [square_c, square_d] = self.squares();
        let at_c = scale(self.length / (square_c + soft_c), self.normal_c);
        let at_d = scale(self.length / (square_d + soft_d), self.normal_d);
        let [of_c, of_d] = self.shares_at_b();
        let at_b = sum(scale(of_c, at_c), scale(of_d, at_d));
        [negate(sum(at_b, sum(at_c, at_d))), at_b, at_c, at_d]
    }

    /// The shares of forces at C and at D that B bears, normal to the facets; A bears the rest, without torque.
    #[inline(always)]
    pub(crate) fn shares_at_b(&self) -> [V; 2] {
        let inverse = V::all(-1.0) / self.length_square;
        [dot(self.c, self.e) * inverse, dot(self.d, self.e) * inverse]
    }
}

/// The sine and the cosine of an angle less another one.
#[inline(always)]
pub(crate) fn turned_back<V: SimdF64>([sine, cosine]: [V; 2], [other_sine, other_cosine]: [V; 2]) -> [V; 2] {
    [sine * other_cosine - cosine * other_sine, cosine * other_cosine + sine * other_sine]
}

/// Factors of the normals of facets C and D in the forces -dU/dx of a batch, with U = w_C w_D u.
#[derive(Clone, Copy)]
pub(crate) struct HingeForces<V> {
    /// Of the moment, for forces normal to the facets.
    normal: [V; 2],
    /// Of the weights w, for forces in the planes of the facets.
    in_plane: [V; 2],
    /// Shares of the normal forces that B bears.
    at_b: [V; 2],
}

impl<V: SimdF64> HingeForces<V> {
    /// No forces.
    #[inline(always)]
    pub(crate) fn zero() -> Self {
        let zeros = [V::zero(); 2];
        Self { normal: zeros, in_plane: zeros, at_b: zeros }
    }

    /// From u \[J\] and -du/dphi \[N m\], both with the constant factor (1 + c^2)^2 of the weights; `softening` is
    /// 4 (c A0)^2 of each facet.
    #[inline(always)]
    pub(crate) fn new(facets: &Facets<V>, [soft_c, soft_d]: [V; 2], energy: V, moment: V) -> Self {
        let [square_c, square_d] = facets.squares();
        // 1/(q + s) of each facet, with q the square of its normal, by one division: w = q/(q + s), up to the factor
        // 1 + c^2.
        let (root_c, root_d) = (square_c + soft_c, square_d + soft_d);
        let both = V::all(1.0) / (root_c * root_d);
        let (share_c, share_d) = (root_d * both, root_c * both);
        let (weight_c, weight_d) = (square_c * share_c, square_d * share_d);
        // The gradient of the fold angle at C, times w_C, is |AB| n_C / (q_C + s_C).
        let normal = moment * facets.length;
        // -u dw/dx: dw/dq = s/(q + s)^2 and dq/dP = 2 n x (opposite side, directed around the facet).
        let in_plane = V::all(-2.0) * energy;
        Self {
            normal: [normal * weight_d * share_c, normal * weight_c * share_d],
            in_plane: [
                in_plane * weight_d * soft_c * share_c * share_c,
                in_plane * weight_c * soft_d * share_d * share_d,
            ],
            at_b: facets.shares_at_b(),
        }
    }

    /// The forces on A, B, C and D.
    #[inline(always)]
    pub(crate) fn on_nodes(&self, facets: &Facets<V>) -> [Vec3<V>; 4] {
        let (normal_c, normal_d) = (scale(self.normal[0], facets.normal_c), scale(self.normal[1], facets.normal_d));
        let (in_plane_c, in_plane_d) =
            (scale(self.in_plane[0], facets.normal_c), scale(self.in_plane[1], facets.normal_d));
        let at_c = sum(normal_c, cross(in_plane_c, facets.e));
        let at_d = sum(normal_d, cross(facets.e, in_plane_d));
        let normal_b = sum(scale(self.at_b[0], normal_c), scale(self.at_b[1], normal_d));
        let at_b = sum(normal_b, sum(cross(facets.c, in_plane_c), cross(in_plane_d, facets.d)));
        [negate(sum(at_b, sum(at_c, at_d))), at_b, at_c, at_d]
    }
}
