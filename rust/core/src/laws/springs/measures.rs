//! Kernels of springs beside their forces: energy, bounds, and the stiffest linearisation.

use super::Springs;
use crate::arrays::columns::{Columns, ColumnsMut};
use crate::elements::link::Span;
use crate::simd::dispatch::BatchKernel;
use crate::simd::lanes::{SimdF64, dot, negate, scale, sub, sum};

/// The energy stored in springs.
pub(super) struct EnergyKernel<'a> {
    pub(super) springs: &'a Springs,
    pub(super) tile: usize,
    pub(super) positions: Columns<'a>,
}

impl BatchKernel for EnergyKernel<'_> {
    #[inline(always)]
    fn sweep_kind<V: SimdF64, const KIND: usize>(&mut self) -> V {
        let pass = self.springs.links.elements.pass::<KIND>(self.tile, self.positions.rows());
        let positions = pass.reader(self.positions);
        let parameters = self.springs.parameters.of(&pass);
        let mut energy = V::zero();
        for batch in 0..pass.len() {
            let l = Span::between(positions.read::<V>(batch)).length();
            let parameters = &parameters[batch];
            let effective = l.max(V::load(&parameters.critical_length));
            let elongation = effective - V::load(&parameters.rest_length);
            energy += V::load(&parameters.stiffness) * elongation * (V::all(0.5) * elongation + (l - effective));
        }
        energy
    }
}

/// Counts the springs beyond their bound.
pub(super) struct ExcessKernel<'a> {
    pub(super) springs: &'a Springs,
    pub(super) tile: usize,
    pub(super) positions: Columns<'a>,
}

impl BatchKernel for ExcessKernel<'_> {
    #[inline(always)]
    fn sweep_kind<V: SimdF64, const KIND: usize>(&mut self) -> V {
        let pass = self.springs.links.elements.pass::<KIND>(self.tile, self.positions.rows());
        let positions = pass.reader(self.positions);
        let (parameters, limits) = (self.springs.parameters.of(&pass), self.springs.strain_limit.of(&pass));
        let mut count = V::zero();
        for batch in 0..pass.len() {
            let l = Span::between(positions.read::<V>(batch)).length();
            let bound = V::load(&parameters[batch].rest_length) * (V::all(1.0) + V::load(&limits[batch]));
            count += bound.below(l, V::all(1.0), V::zero());
        }
        count
    }
}

/// Adds K p, with every spring taut.
pub(super) struct StiffnessKernel<'a> {
    pub(super) springs: &'a Springs,
    pub(super) tile: usize,
    pub(super) positions: Columns<'a>,
    pub(super) p: Columns<'a>,
    pub(super) out: ColumnsMut<'a>,
}

impl BatchKernel for StiffnessKernel<'_> {
    #[inline(always)]
    fn sweep_kind<V: SimdF64, const KIND: usize>(&mut self) -> V {
        let pass = self.springs.links.elements.pass::<KIND>(self.tile, self.positions.rows());
        let positions = pass.reader(self.positions);
        let p = pass.reader(self.p);
        let mut sums = pass.adder(&mut self.out);
        let parameters = self.springs.parameters.of(&pass);
        let least = V::all(f64::MIN_POSITIVE);
        for batch in 0..pass.len() {
            let span = Span::between(positions.read::<V>(batch));
            let [u, v] = p.read::<V>(batch);
            let (d, l, difference) = (span.d, span.length(), sub(v, u));
            let k = V::load(&parameters[batch].stiffness);
            let strain = dot(d, difference) / (l * l).max(least);
            let elongation = (l - V::load(&parameters[batch].rest_length)).max(V::zero()) / l.max(least);
            let across = k * elongation;
            let product = sum(scale((k - across) * strain, d), scale(across, difference));
            sums.add(batch, [negate(product), product]);
        }
        V::zero()
    }
}
