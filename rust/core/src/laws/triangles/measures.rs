//! Readings of a film of triangles: its state and its stress, by the law itself.

use super::Triangles;
use super::wrinkles::{Wrinkles, principal};
use crate::arrays::columns::Columns;
use crate::elements::stress::TriangleStress;
use crate::elements::triangle::strain;
use crate::laws::{FilmStates, Instant};
use crate::simd::lanes::{F64x8, SimdF64, Vec3};

impl Triangles {
    /// The stress of each triangle, in external order.
    pub(super) fn triangle_stress(&self, at: Instant<'_>) -> Vec<TriangleStress> {
        let of_batch = |(batch, gradient): (usize, [Vec3; 2])| {
            let [s11, s22, s12] = self.stress(batch, strain(gradient));
            let [[x1, y1, z1], [x2, y2, z2]] = gradient;
            [s11, s22, s12, x1, y1, z1, x2, y2, z2]
        };
        let rows = self.flat.elements.unpack_rows(self.gradients(Columns::of(at.positions)).map(of_batch));
        let of_row = |([s11, s22, s12, x1, y1, z1, x2, y2, z2], &modulus): ([f64; 9], &f64)| TriangleStress {
            stress: [s11, s22, s12].map(|stress| modulus * stress),
            gradient: [[x1, y1, z1], [x2, y2, z2]],
        };
        rows.into_iter().zip(&self.moduli).map(of_row).collect()
    }

    /// Strain and state of each triangle, and the buckled edges, in external order. With a share of compression of 1
    /// the film never wrinkles.
    pub(super) fn states(&self, at: Instant<'_>) -> FilmStates {
        let x = Columns::of(at.positions);
        let (zero, one) = (F64x8::ZERO, F64x8::all(1.0));
        let wrinkles = if self.compression < 1.0 { one } else { zero };
        let of_batch = |(batch, gradient): (usize, [Vec3; 2])| {
            let e = strain(gradient);
            let (mean, spread) = principal(e);
            let Wrinkles { second, first, .. } = self.wrinkles(batch, self.flat.stress(e));
            let state = second.below(zero, wrinkles, zero) + first.below(zero, wrinkles, zero);
            let [side_0, side_1, side_2] = self.flat.side_strains(batch, e);
            [mean + spread, mean - spread, state, side_0, side_1, side_2]
        };
        let rows = self.flat.elements.unpack_rows(self.gradients(x).map(of_batch));
        let mut buckled = vec![false; self.edge_count];
        for (&[_, _, state, side_0, side_1, side_2], sides) in rows.iter().zip(&self.sides) {
            for (&side, strain) in sides.iter().zip([side_0, side_1, side_2]) {
                buckled[side as usize] |= state > 0.0 && strain < 0.0;
            }
        }
        FilmStates {
            strain: rows.iter().map(|&[larger, smaller, ..]| [larger, smaller]).collect(),
            state: rows.iter().map(|&[_, _, state, ..]| state as u8).collect(),
            buckled,
        }
    }
}
