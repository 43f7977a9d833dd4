//! The Jacobian of the forces of a film, taut, wrinkled or slack: a material part, by the derivative of the stress by
//! the strain, and a geometric part.
//!
//! The change of the stress by wrinkles is an isotropic function of T = S + P. With the mean m of T, its half
//! difference (x, y) = ((T11 - T22)/2, T12) and spread r = |(x, y)|, it is h 1 + g/r (x, y; y, -x), where h and g are
//! half the sum and half the difference of (c - 1) d1 and (c - 1) d2, which are functions of m and r.

use nalgebra::Matrix3;

use super::Triangles;
use super::wrinkles::Wrinkles;
use crate::arrays::jacobian::{JacobianBlocks, at, of_differences};
use crate::laws::Instant;
use crate::simd::lanes::{F64x8, SimdF64};

impl Triangles {
    pub(super) fn jacobian(&self, instant: Instant<'_>, jacobian: &mut dyn JacobianBlocks) {
        for (batch, lane, nodes) in self.flat.elements.each() {
            let single = self.flat.single(batch, lane, nodes.map(|node| at(instant.positions, node)));
            let [f1, f2] = single.gradient;
            let strain = [0.5 * (f1.dot(&f1) - 1.0), 0.5 * (f2.dot(&f2) - 1.0), 0.5 * f1.dot(&f2)].map(F64x8::all);
            let stress = self.stress(batch, strain).map(|lanes| lanes.0[lane]);
            let by_gradient = self.material_tangent(batch, lane, strain) * single.strain_derivative();
            let square = single.material(&by_gradient) + single.geometric(stress);
            of_differences(nodes, &single.by_sides(&square), |i, j, block| jacobian.by_position(i, j, block));
        }
    }

    /// dS/dE over E_Y; rows and columns 11, 22, 12.
    fn material_tangent(&self, batch: usize, lane: usize, strain: [F64x8; 3]) -> Matrix3<f64> {
        let taut = self.flat.taut(batch, lane);
        let Wrinkles { second, first, stress, spread } = self.wrinkles(batch, self.flat.stress(batch, strain));
        let [second, first, spread] = [second, first, spread].map(|lanes| lanes.0[lane]);
        if second >= 0.0 {
            return taut;
        }
        let (nu, share) = (self.flat.nu, 0.5 * (self.compression - 1.0));
        let r = spread.max(f64::MIN_POSITIVE);
        // Derivatives of second and first by (m, r).
        let of_second = [1.0, -1.0];
        let of_first = if first < 0.0 { [1.0 - nu, 1.0 + nu] } else { [0.0; 2] };
        let ratio = share * (nu * second + first - second) / r;
        let h = [0, 1].map(|k| share * (nu * of_second[k] + of_first[k] + of_second[k]));
        let g = [0, 1].map(|k| share * (nu * of_second[k] + of_first[k] - of_second[k]));
        let [t11, t22, t12] = stress.map(|lanes| lanes.0[lane]);
        let (x, y) = (0.5 * (t11 - t22) / r, t12 / r);
        // Derivatives of m, of x r and of y r by T11, T22, T12; then that of r.
        let (of_m, of_x, of_y) = ([0.5, 0.5, 0.0], [0.5, -0.5, 0.0], [0.0, 0.0, 1.0]);
        let by_stress = Matrix3::from_fn(|row, column| {
            let (dm, dx, dy) = (of_m[column], of_x[column], of_y[column]);
            let dr = x * dx + y * dy;
            let (dh, dg) = (h[0] * dm + h[1] * dr, g[0] * dm + g[1] * dr);
            let along_x = ratio * dx + x * (dg - ratio * dr);
            let along_y = ratio * dy + y * (dg - ratio * dr);
            [dh + along_x, dh - along_x, along_y][row]
        });
        taut + by_stress * taut
    }
}
