//! The jacobian of what a stress pulls the nodes of a flat triangle by.
//!
//! With the gradient's columns f1, f2 the pull's energy-like derivative is P_1 = S11 f1 + S12 f2, P_2 = S12 f1 + S22 f2;
//! P changes with the stress and, at a given stress, with the gradient: the geometric part.

use nalgebra::{Matrix3, SMatrix, Vector3};

use super::triangle::FlatTriangles;

/// A 6 x 6 matrix over (f1, f2), and over the sides (u, v) from the first node.
pub(crate) type Square = SMatrix<f64, 6, 6>;

/// One triangle of a batch.
pub(crate) struct One {
    pub(crate) gradient: [Vector3<f64>; 2],
    /// f1 = p u, f2 = q u + r v [1/m].
    sides: [f64; 3],
    /// E_Y h A0 [J].
    pub(crate) stiffness: f64,
}

impl FlatTriangles {
    /// One triangle with `corners`, which may be positions or velocities.
    pub(crate) fn one(&self, batch: usize, lane: usize, corners: [Vector3<f64>; 3]) -> One {
        let sides = [&self.p, &self.q, &self.r].map(|values| values[batch].0[lane]);
        let [u, v] = [corners[1] - corners[0], corners[2] - corners[0]];
        let gradient = [u * sides[0], u * sides[1] + v * sides[2]];
        One { gradient, sides, stiffness: self.stiffness[batch].0[lane] }
    }

    /// dS/dE of a film that does not wrinkle, over E_Y; rows and columns 11, 22, 12.
    pub(crate) fn taut(&self) -> Matrix3<f64> {
        let nu = self.nu;
        let shear = 1.0 / (1.0 + nu);
        let factor = shear / (1.0 - nu);
        Matrix3::new(factor, factor * nu, 0.0, factor * nu, factor, 0.0, 0.0, 0.0, shear)
    }
}

impl One {
    /// Rows: the change of Green's strain 11, 22, 12 with f1 and f2; or of its rate, with the gradient of velocity.
    pub(crate) fn strain_slope(&self) -> SMatrix<f64, 3, 6> {
        let [f1, f2] = self.gradient;
        let mut slope = SMatrix::<f64, 3, 6>::zeros();
        for k in 0..3 {
            slope[(0, k)] = f1[k];
            slope[(1, k + 3)] = f2[k];
            (slope[(2, k)], slope[(2, k + 3)]) = (0.5 * f2[k], 0.5 * f1[k]);
        }
        slope
    }

    /// The change of P with the gradient where the stress changes by `stress_slope` with it, times E_Y h A0.
    pub(crate) fn by_stress(&self, stress_slope: &SMatrix<f64, 3, 6>) -> Square {
        let [f1, f2] = self.gradient;
        let mut square = Square::zeros();
        let row = |i: usize| stress_slope.fixed_rows::<1>(i).into_owned();
        let (s11, s22, s12) = (row(0), row(1), row(2));
        square.fixed_rows_mut::<3>(0).copy_from(&(f1 * s11 + f2 * s12));
        square.fixed_rows_mut::<3>(3).copy_from(&(f1 * s12 + f2 * s22));
        square * self.stiffness
    }

    /// The geometric part: the change of P with the gradient at a given stress, times E_Y h A0.
    pub(crate) fn geometric(&self, stress: [f64; 3]) -> Square {
        let mut square = Square::zeros();
        for k in 0..3 {
            (square[(k, k)], square[(k + 3, k + 3)]) = (stress[0], stress[1]);
            (square[(k, k + 3)], square[(k + 3, k)]) = (stress[2], stress[2]);
        }
        square * self.stiffness
    }

    /// From (f1, f2) to (u, v) on both sides.
    pub(crate) fn by_sides(&self, square: &Square) -> Square {
        let [p, q, r] = self.sides;
        let mut map = Square::zeros();
        for k in 0..3 {
            (map[(k, k)], map[(k + 3, k)], map[(k + 3, k + 3)]) = (p, q, r);
        }
        map.transpose() * square * map
    }
}
