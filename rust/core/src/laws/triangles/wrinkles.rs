//! The stress of a film with wrinkles, and its energy; see `triangles` for the equations.

use super::Triangles;
use crate::elements::triangle::Tensor;
use crate::simd::lanes::{F64x8, SimdF64};

/// Mean of the principal values of a tensor, and half their difference.
#[inline(always)]
pub(super) fn principal<V: SimdF64>(t: Tensor<V>) -> (V, V) {
    let half = V::all(0.5);
    let difference = half * (t[0] - t[1]);
    (half * (t[0] + t[1]), (difference * difference + t[2] * t[2]).sqrt())
}

/// The wrinkles of the triangles of a batch.
pub(super) struct Wrinkles<V> {
    /// min(s2, 0) and min(e1, 0) over E_Y.
    pub(super) second: V,
    pub(super) first: V,
    /// S + P over E_Y, and half the difference of its principal values.
    pub(super) stress: Tensor<V>,
    pub(super) spread: V,
}

impl Triangles {
    /// The wrinkles of a batch, from its taut stress over E_Y.
    #[inline(always)]
    pub(super) fn wrinkles<V: SimdF64>(&self, batch: usize, s: Tensor<V>) -> Wrinkles<V> {
        let critical = &self.critical_strain[batch];
        let stress = [s[0] + V::load(&critical[0]), s[1] + V::load(&critical[1]), s[2] + V::load(&critical[2])];
        let (mean, spread) = principal(stress);
        let (s1, s2) = (mean + spread, mean - spread);
        let first = s1 - V::all(self.flat.nu) * s2;
        Wrinkles { second: s2.min(V::zero()), first: first.min(V::zero()), stress, spread }
    }

    /// Stress over E_Y, with wrinkles.
    #[inline(always)]
    pub(super) fn stress<V: SimdF64>(&self, batch: usize, e: Tensor<V>) -> Tensor<V> {
        let s = self.flat.stress(batch, e);
        let Wrinkles { second, first, stress, spread } = self.wrinkles(batch, s);
        // The change of the principal stresses by wrinkles: half its sum, and half its difference.
        let half = V::all(0.5 * (self.compression - 1.0));
        let (d1, d2) = (V::all(self.flat.nu) * second + first, second);
        let mean = half * (d1 + d2);
        let ratio = half * (d1 - d2) / spread.max(V::all(f64::MIN_POSITIVE));
        let difference = V::all(0.5) * ratio * (stress[0] - stress[1]);
        [s[0] + mean + difference, s[1] + mean - difference, s[2] + ratio * stress[2]]
    }

    /// Energy of a batch over E_Y h A0.
    pub(super) fn density(&self, batch: usize, e: Tensor) -> F64x8 {
        let s = self.flat.stress(batch, e);
        let Wrinkles { second, first, .. } = self.wrinkles(batch, s);
        let [one, half, nu] = [1.0, 0.5, self.flat.nu].map(F64x8::all);
        let taut = half * (s[0] * e[0] + s[1] * e[1]) + s[2] * e[2];
        let released = half * ((one - nu * nu) * second * second + first * first);
        taut - F64x8::all(1.0 - self.compression) * released
    }
}

#[cfg(test)]
mod tests {
    use super::super::TriangleParameters;
    use super::*;
    use crate::assembly::Assembly;
    use crate::model::input::{Film as Material, Model};
    use crate::simd::dispatch::InstructionSet;

    const NU: f64 = 0.3;

    /// One triangle of unit stiffness and area, with a critical strain by `buckling`.
    fn triangle(compression: f64, buckling: f64) -> Triangles {
        let points = vec![[0.0; 3], [2.0, 0.0, 0.0], [0.7, 1.0, 0.0]];
        let film = Material { youngs_modulus: 1.0, poisson_ratio: NU, density: 1.0, thickness: 1.0 };
        let model = Model {
            positions: points.clone(),
            velocities: vec![[0.0; 3]; 3],
            reference: points,
            triangles: vec![[0, 1, 2]],
            film: Some(film),
            extra_masses: vec![0.0; 3],
            ..Model::default()
        };
        let assembly = Assembly::new(model, InstructionSet::Baseline).unwrap();
        let parameters = TriangleParameters {
            compression,
            buckling,
            buckling_on_creases: buckling,
            buckling_length: Some(1.0),
            crease_length: None,
            strain_limit: 0.1,
        };
        Triangles::new(parameters, &assembly).unwrap()
    }

    fn tensor(e: [f64; 3]) -> Tensor {
        e.map(F64x8::all)
    }

    fn stress(law: &Triangles, e: [f64; 3]) -> [f64; 3] {
        law.stress(0, tensor(e)).map(|lanes| lanes.0[0])
    }

    #[test]
    fn a_taut_film_obeys_hookes_law_and_a_wrinkled_one_bears_uniaxial_tension() {
        let law = triangle(0.0, 0.0);
        let taut = stress(&law, [0.02, 0.01, 0.0]);
        let factor = 1.0 / (1.0 - NU * NU);
        assert!((taut[0] - factor * (0.02 + NU * 0.01)).abs() < 1e-16);
        assert!((taut[1] - factor * (0.01 + NU * 0.02)).abs() < 1e-16);
        // Beyond the lateral contraction of -nu e the film wrinkles.
        let wrinkled = stress(&law, [0.02, -0.015, 0.0]);
        assert!((wrinkled[0] - 0.02).abs() < 1e-16 && wrinkled[1].abs() < 1e-16, "{wrinkled:?}");
        assert!(stress(&law, [-0.02, -0.01, 0.003]).iter().all(|s| s.abs() < 1e-16));
    }

    #[test]
    fn uniaxial_compression_is_that_of_equation_2() {
        let critical = std::f64::consts::PI.powi(2) / 12.0 * 1e-2;
        let law = triangle(0.0, 1e-2);
        for (strain, expected) in [(-0.5 * critical, -0.5 * critical), (-3.0 * critical, -critical)] {
            // With free lateral expansion.
            let found = stress(&law, [strain, -NU * expected, 0.0]);
            assert!((found[0] - expected).abs() < 1e-15 && found[1].abs() < 1e-15, "{found:?}");
        }
    }

    #[test]
    fn stress_is_the_derivative_of_the_energy_and_continuous_between_all_states() {
        for (compression, buckling) in [(0.0, 0.0), (0.0, 0.01), (0.3, 0.01), (1.0, 0.0)] {
            let law = triangle(compression, buckling);
            let mut seen = [false; 3];
            for k in 0..400 {
                let angle = 0.05 * f64::from(k);
                let (mean, spread) = (0.02 * (0.37 * angle).sin(), 0.02 * (0.61 * angle).cos());
                let e = [mean + spread * angle.cos(), mean - spread * angle.cos(), spread * angle.sin()];
                let s = stress(&law, e);
                for i in 0..3 {
                    let step = 1e-6;
                    let mut sides = [e, e];
                    sides[0][i] += step;
                    sides[1][i] -= step;
                    let [above, below] = sides.map(|e| law.density(0, tensor(e)).0[0]);
                    let derivative = (above - below) / (2.0 * step);
                    // The off-diagonal term counts twice.
                    let expected = if i == 2 { 2.0 * s[2] } else { s[i] };
                    // At a discontinuity of the second derivative the error is of the order of the step.
                    assert!((derivative - expected).abs() < 2.0 * step, "{e:?}: {derivative} {expected}");
                }
                let wrinkles = law.wrinkles(0, law.flat.stress(0, tensor(e)));
                let [second, first] = [wrinkles.second, wrinkles.first].map(|lanes| usize::from(lanes.0[0] < 0.0));
                seen[second + first] = true;
            }
            assert_eq!(seen, [true; 3]);
        }
    }
}
