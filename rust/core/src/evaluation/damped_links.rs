//! Springs and the dashpots along them in one pass.
//!
//! Both laws need the span and the length of each link, so that one pass costs half as much as two. The equations are
//! those of `laws::springs` and `laws::spring_damping`.

use crate::arrays::columns::{Columns, ColumnsMut};
use crate::elements::link::{Links, Span};
use crate::laws::{spring_damping, springs};
use crate::simd::dispatch::BatchKernel;
use crate::simd::lanes::{F64x8, SimdF64, negate, scale};

/// Adds the forces of the springs and dashpots of one tile; the result is the power of the dashpots.
pub(super) struct DampedKernel<'a> {
    pub(super) links: &'a Links,
    pub(super) springs: &'a [springs::Parameters],
    pub(super) coefficient: &'a [F64x8],
    pub(super) tile: usize,
    pub(super) positions: Columns<'a>,
    pub(super) velocities: Columns<'a>,
    pub(super) forces: ColumnsMut<'a>,
}

/// The same, with the resistance per length of each dashpot stored.
pub(super) struct CachedKernel<'a>(pub(super) DampedKernel<'a>, pub(super) &'a mut [F64x8]);

impl DampedKernel<'_> {
    #[inline(always)]
    fn add_forces<V: SimdF64, const KIND: usize>(&mut self, mut cache: Option<&mut [F64x8]>) -> V {
        let pass = self.links.elements.pass::<KIND>(self.tile, self.positions.rows());
        let (parameters, coefficient) = (pass.of(self.springs), pass.of(self.coefficient));
        let mut power = V::zero();
        for batch in 0..pass.len() {
            let span = Span::between(pass.read::<V, 3>(self.positions, batch));
            let rate = span.opening(pass.read::<V, 3>(self.velocities, batch));
            let (tension, inverse) = parameters[batch].tension_per_length(span.length());
            let resistance = spring_damping::resistance_per_length(&coefficient[batch], rate, inverse * inverse);
            power -= resistance * rate;
            let force = scale(tension + resistance, span.d);
            pass.add(&mut self.forces, batch, [force, negate(force)]);
            if let Some(cache) = &mut cache {
                cache[pass.place(batch)] = resistance.lanes();
            }
        }
        power
    }
}

impl BatchKernel for DampedKernel<'_> {
    #[inline(always)]
    fn sweep_kind<V: SimdF64, const KIND: usize>(&mut self) -> V {
        self.add_forces::<V, KIND>(None)
    }
}

impl BatchKernel for CachedKernel<'_> {
    #[inline(always)]
    fn sweep_kind<V: SimdF64, const KIND: usize>(&mut self) -> V {
        self.0.add_forces::<V, KIND>(Some(self.1))
    }
}
