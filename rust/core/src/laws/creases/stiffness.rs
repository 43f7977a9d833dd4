//! The stiffest linearisation of creases.

use super::Creases;
use crate::arrays::columns::{Columns, ColumnsMut};
use crate::elements::hinge::Facets;
use crate::simd::dispatch::BatchKernel;
use crate::simd::lanes::{SimdF64, dot, negate, scale, sum};

/// Adds K p of the creases of one tile, with every crease in contact.
pub(super) struct StiffnessKernel<'a> {
    pub(super) creases: &'a Creases,
    pub(super) tile: usize,
    pub(super) positions: Columns<'a>,
    pub(super) p: Columns<'a>,
    pub(super) out: ColumnsMut<'a>,
}

impl BatchKernel for StiffnessKernel<'_> {
    #[inline(always)]
    fn sweep_kind<V: SimdF64, const KIND: usize>(&mut self) -> V {
        let pass = self.creases.elements.pass::<KIND>(self.tile, self.positions.rows());
        let positions = pass.reader(self.positions);
        let p = pass.reader(self.p);
        let mut sums = pass.adder(&mut self.out);
        let parameters = self.creases.parameters.of(&pass);
        let contact = V::all(self.creases.contact_penalty.max(1.0));
        for batch in 0..pass.len() {
            let facets = Facets::new(positions.read::<V>(batch));
            let [soft_c, soft_d] = &parameters[batch].softening;
            let (square_c, square_d) = (dot(facets.normal_c, facets.normal_c), dot(facets.normal_d, facets.normal_d));
            let at_c = scale(facets.length / (square_c + V::load(soft_c)), facets.normal_c);
            let at_d = scale(facets.length / (square_d + V::load(soft_d)), facets.normal_d);
            let [of_c, of_d] = facets.shares_at_b();
            let at_b = sum(scale(of_c, at_c), scale(of_d, at_d));
            let at_a = negate(sum(at_b, sum(at_c, at_d)));
            let [a, b, c, d] = p.read::<V>(batch);
            let rotation = dot(at_a, a) + dot(at_b, b) + dot(at_c, c) + dot(at_d, d);
            let moment = V::load(&parameters[batch].stiffness) * contact * rotation;
            let product = [scale(moment, at_a), scale(moment, at_b), scale(moment, at_c), scale(moment, at_d)];
            sums.add(batch, product);
        }
        V::zero()
    }
}
