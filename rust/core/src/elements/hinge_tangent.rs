//! Derivatives of a hinge's energy U = w_C w_D u(phi), in the differences e = B - A, c = C - A, d = D - A.
//!
//! The fold angle is phi = f(e, c) - f(e, d). For each facet, with n = e x p, q = n^2, L = |e|, m = n x e and
//! t = p . e / L^2,
//!
//!     f_p  = L n/q,      f_e  = -t f_p
//!     f_pp = -L (n m^T + m n^T)/q^2
//!     f_pe = n e^T/(L q) - L [p]x/q - 2 L n (p x n)^T/q^2
//!     f_ee = -f_p (p/L^2 - 2 (p . e) e/L^4)^T - t f_pe
//!
//! The weights w = q/(q + s), up to the constant factor 1 + c^2 that the stiffness holds,
//! are functions of q = L^2 p^2 - (e . p)^2. As a facet collapses f is singular, but w f_pp remains bounded. Tamstorf
//! and Grinspun, Graphical Models 75 (2013), give the same Hessian in terms of the angles of the triangles.

use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

use crate::arrays::jacobian::cross_matrix;

/// Over the components of e, c and d.
pub(crate) type Square = SMatrix<f64, 9, 9>;
/// The same.
type Column = SVector<f64, 9>;

/// Lower bound of squared lengths and areas: a smaller facet has no direction, and a weight of 0.
const LEAST: f64 = 1e-60;

/// A function of e and p with its first and second derivatives.
struct Jet {
    by_e: Vector3<f64>,
    by_p: Vector3<f64>,
    by_ee: Matrix3<f64>,
    /// Rows p, columns e.
    by_pe: Matrix3<f64>,
    by_pp: Matrix3<f64>,
}

impl Jet {
    /// The angle f of a facet.
    fn angle(e: &Vector3<f64>, p: &Vector3<f64>) -> Self {
        let (normal, square_length) = (e.cross(p), e.norm_squared().max(LEAST));
        let (length, q) = (square_length.sqrt(), normal.norm_squared().max(LEAST));
        let (m, t) = (normal.cross(e), p.dot(e) / square_length);
        let by_p = normal * (length / q);
        let by_pp = (normal * m.transpose() + m * normal.transpose()) * (-length / (q * q));
        let by_pe = normal * e.transpose() / (length * q)
            - cross_matrix(p) * (length / q)
            - normal * p.cross(&normal).transpose() * (2.0 * length / (q * q));
        let t_e = p / square_length - e * (2.0 * p.dot(e) / (square_length * square_length));
        let by_ee = -by_p * t_e.transpose() - by_pe * t;
        Self { by_e: by_p * -t, by_p, by_ee: 0.5 * (by_ee + by_ee.transpose()), by_pe, by_pp }
    }

    /// q.
    fn square(e: &Vector3<f64>, p: &Vector3<f64>) -> Self {
        let (ee, pp, ep) = (e.norm_squared(), p.norm_squared(), e.dot(p));
        let one = Matrix3::identity();
        Self {
            by_e: (e * pp - p * ep) * 2.0,
            by_p: (p * ee - e * ep) * 2.0,
            by_ee: (one * pp - p * p.transpose()) * 2.0,
            by_pe: (p * e.transpose() * 2.0 - one * ep - e * p.transpose()) * 2.0,
            by_pp: (one * ee - e * e.transpose()) * 2.0,
        }
    }

    /// Gradient and Hessian over (e, c, d), with p = c (facet 0) or d (facet 1).
    fn lift(&self, facet: usize) -> (Column, Square) {
        let (mut gradient, mut hessian, p) = (Column::zeros(), Square::zeros(), 3 + 3 * facet);
        gradient.fixed_rows_mut::<3>(0).copy_from(&self.by_e);
        gradient.fixed_rows_mut::<3>(p).copy_from(&self.by_p);
        hessian.fixed_view_mut::<3, 3>(0, 0).copy_from(&self.by_ee);
        hessian.fixed_view_mut::<3, 3>(p, 0).copy_from(&self.by_pe);
        hessian.fixed_view_mut::<3, 3>(0, p).copy_from(&self.by_pe.transpose());
        hessian.fixed_view_mut::<3, 3>(p, p).copy_from(&self.by_pp);
        (gradient, hessian)
    }
}

/// The fold angle of a hinge and the product w_C w_D of its weights, up to the factor (1 + c^2)^2, with their
/// derivatives.
pub(crate) struct WeightedAngle {
    /// dphi/dx and its derivative.
    angle: (Column, Square),
    weight: f64,
    weight_gradient: Column,
    weight_hessian: Square,
}

impl WeightedAngle {
    /// Of the corners A, B, C, D, with 4 (c A0)^2 of each facet.
    pub(crate) fn new([a, b, c, d]: [Vector3<f64>; 4], softening: [f64; 2]) -> Self {
        let e = b - a;
        let facets = [c - a, d - a];
        let [of_c, of_d] = [0, 1].map(|facet| Jet::angle(&e, &facets[facet]).lift(facet));
        let [weight_c, weight_d] = [0, 1].map(|facet| {
            let (gradient, hessian) = Jet::square(&e, &facets[facet]).lift(facet);
            let (q, s) = (e.cross(&facets[facet]).norm_squared(), softening[facet]);
            let share = 1.0 / (q + s).max(LEAST);
            let (first, second) = (s * share * share, -2.0 * s * share * share * share);
            (q * share, gradient * first, gradient * gradient.transpose() * second + hessian * first)
        });
        let across = weight_c.1 * weight_d.1.transpose();
        Self {
            angle: (of_c.0 - of_d.0, of_c.1 - of_d.1),
            weight: weight_c.0 * weight_d.0,
            weight_gradient: weight_c.1 * weight_d.0 + weight_d.1 * weight_c.0,
            weight_hessian: weight_c.2 * weight_d.0 + weight_d.2 * weight_c.0 + across + across.transpose(),
        }
    }

    /// The gradients of w_C w_D u at A, B, C and D, from u and du/dphi.
    pub(crate) fn gradients(&self, energy: f64, slope: f64) -> [Vector3<f64>; 4] {
        let gradient = self.weight_gradient * energy + self.angle.0 * (self.weight * slope);
        let [b, c, d] = [0, 3, 6].map(|row| gradient.fixed_rows::<3>(row).into_owned());
        [-(b + c + d), b, c, d]
    }

    /// The Hessian of w_C w_D u, from u and its first and second derivatives by phi.
    pub(crate) fn hessian(&self, energy: f64, slope: f64, curvature: f64) -> Square {
        let (gradient, hessian) = &self.angle;
        let mixed = gradient * self.weight_gradient.transpose();
        self.weight_hessian * energy
            + (mixed + mixed.transpose() + hessian * self.weight) * slope
            + gradient * gradient.transpose() * (self.weight * curvature)
    }
}
