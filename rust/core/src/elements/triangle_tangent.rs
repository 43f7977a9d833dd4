//! The Jacobian of the nodal forces of a stress.
//!
//! With the columns f1, f2 of the deformation gradient, the first Piola-Kirchhoff stress is P_1 = S11 f1 + S12 f2, P_2
//! = S12 f1 + S22 f2. Its derivative by the gradient has a part by the change of S, the material part, and a part at
//! constant S, the geometric part.

use nalgebra::{Matrix3, SMatrix, Vector3};

use super::triangle::FlatTriangles;

/// A 6 x 6 matrix over (f1, f2), and over the sides (u, v) from the first node.
pub(crate) type Square = SMatrix<f64, 6, 6>;

/// One triangle of a batch.
pub(crate) struct Single {
    pub(crate) gradient: [Vector3<f64>; 2],
    /// p, q, r of f1 = p u, f2 = q u + r v [1/m].
    coefficients: [f64; 3],
    /// E_Y h A0 [J].
    pub(crate) stiffness: f64,
}

impl FlatTriangles {
    /// One triangle with `corners`, which may be positions or velocities.
    pub(crate) fn single(&self, batch: usize, lane: usize, corners: [Vector3<f64>; 3]) -> Single {
        let [p, q, r] = [&self.p, &self.q, &self.r].map(|values| values[batch].0[lane]);
        let [u, v] = [corners[1] - corners[0], corners[2] - corners[0]];
        let gradient = [u * p, u * q + v * r];
        Single { gradient, coefficients: [p, q, r], stiffness: self.stiffness[batch].0[lane] }
    }

    /// dS/dE of a film without wrinkles, over E_Y; rows and columns 11, 22, 12.
    pub(crate) fn taut(&self, batch: usize, lane: usize) -> Matrix3<f64> {
        if let Some(moduli) = &self.moduli {
            let [p11, p22, p12, p1s, p2s, pss] = moduli[batch].map(|values| values.0[lane]);
            let (twice_1, twice_2) = (2.0 * p1s, 2.0 * p2s);
            return Matrix3::new(p11, p12, twice_1, p12, p22, twice_2, p1s, p2s, 2.0 * pss);
        }
        let nu = self.nu;
        let shear = 1.0 / (1.0 + nu);
        let factor = shear / (1.0 - nu);
        Matrix3::new(factor, factor * nu, 0.0, factor * nu, factor, 0.0, 0.0, 0.0, shear)
    }
}

impl Single {
    /// The derivative of Green's strain (rows 11, 22, 12) by f1 and f2; or of its rate, with the gradient of velocity.
    pub(crate) fn strain_derivative(&self) -> SMatrix<f64, 3, 6> {
        let [f1, f2] = self.gradient;
        let mut derivative = SMatrix::<f64, 3, 6>::zeros();
        for k in 0..3 {
            derivative[(0, k)] = f1[k];
            derivative[(1, k + 3)] = f2[k];
            (derivative[(2, k)], derivative[(2, k + 3)]) = (0.5 * f2[k], 0.5 * f1[k]);
        }
        derivative
    }

    /// The material part of dP/d(f1, f2), from the derivative of the stress by (f1, f2), times E_Y h A0.
    pub(crate) fn material(&self, stress_derivative: &SMatrix<f64, 3, 6>) -> Square {
        let [f1, f2] = self.gradient;
        let mut square = Square::zeros();
        let row = |i: usize| stress_derivative.fixed_rows::<1>(i).into_owned();
        let (s11, s22, s12) = (row(0), row(1), row(2));
        square.fixed_rows_mut::<3>(0).copy_from(&(f1 * s11 + f2 * s12));
        square.fixed_rows_mut::<3>(3).copy_from(&(f1 * s12 + f2 * s22));
        square * self.stiffness
    }

    /// The geometric part of dP/d(f1, f2), at constant stress, times E_Y h A0.
    pub(crate) fn geometric(&self, stress: [f64; 3]) -> Square {
        let mut square = Square::zeros();
        for k in 0..3 {
            (square[(k, k)], square[(k + 3, k + 3)]) = (stress[0], stress[1]);
            (square[(k, k + 3)], square[(k + 3, k)]) = (stress[2], stress[2]);
        }
        square * self.stiffness
    }

    /// The transformation of rows and columns from (f1, f2) to (u, v).
    pub(crate) fn by_sides(&self, square: &Square) -> Square {
        let [p, q, r] = self.coefficients;
        let mut map = Square::zeros();
        for k in 0..3 {
            (map[(k, k)], map[(k + 3, k)], map[(k + 3, k + 3)]) = (p, q, r);
        }
        map.transpose() * square * map
    }
}
