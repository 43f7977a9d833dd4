//! Springs and the dashpots along them in one pass.
//!
//! Both laws need the span and the length of each link, so that one pass costs half of two. The equations stay where they
//! are, in `laws::springs` and `laws::spring_damping`: this pass composes them.

use crate::arrays::columns::{Columns, ColumnsMut};
use crate::elements::link::Links;
use crate::laws::{spring_damping, springs};
use crate::simd::dispatch::BatchKernel;
use crate::simd::lanes::{F64x8, SimdF64, dot, negate, scale, sub};

/// Adds what springs and dashpots of one tile pull with to the forces, and gives the dashpots' power.
pub(super) struct DampedKernel<'a> {
    pub(super) links: &'a Links,
    pub(super) springs: &'a [springs::Parameters],
    pub(super) coefficient: &'a [F64x8],
    pub(super) tile: usize,
    pub(super) positions: Columns<'a>,
    pub(super) velocities: Columns<'a>,
    pub(super) forces: ColumnsMut<'a>,
}

/// The same, and keeps what each dashpot pulls with.
pub(super) struct CachedKernel<'a>(pub(super) DampedKernel<'a>, pub(super) &'a mut [F64x8]);

impl DampedKernel<'_> {
    #[inline(always)]
    fn go<V: SimdF64, const KIND: usize>(&mut self, mut pulls: Option<&mut [F64x8]>) -> V {
        let pass = self.links.elements.pass::<KIND>(self.tile, self.positions.rows());
        let (parameters, coefficient) = (pass.of(self.springs), pass.of(self.coefficient));
        let mut power = V::zero();
        for batch in 0..pass.len() {
            let [a, b] = pass.read::<V, 3>(self.positions, batch);
            let [u, v] = pass.read::<V, 3>(self.velocities, batch);
            let d = sub(b, a);
            let opening = dot(d, sub(v, u));
            let (tension, inverse) = parameters[batch].pull(dot(d, d).sqrt());
            let resistance = spring_damping::pull(&coefficient[batch], opening, inverse * inverse);
            power -= resistance * opening;
            let pull = scale(tension + resistance, d);
            pass.add(&mut self.forces, batch, [pull, negate(pull)]);
            if let Some(pulls) = &mut pulls {
                pulls[pass.place(batch)] = resistance.lanes();
            }
        }
        power
    }
}

impl BatchKernel for DampedKernel<'_> {
    #[inline(always)]
    fn part<V: SimdF64, const KIND: usize>(&mut self) -> V {
        self.go::<V, KIND>(None)
    }
}

impl BatchKernel for CachedKernel<'_> {
    #[inline(always)]
    fn part<V: SimdF64, const KIND: usize>(&mut self) -> V {
        self.0.go::<V, KIND>(Some(self.1))
    }
}
