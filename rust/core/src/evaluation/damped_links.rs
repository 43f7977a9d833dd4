//! Springs and the dashpots along them in one pass.
//!
//! Both laws need the span and the length of each link, so that one pass costs half as much as two. The equations are
//! those of `laws::springs` and `laws::spring_damping`.

use crate::arrays::columns::{Columns, ColumnsMut};
use crate::elements::link::{Links, Span};
use crate::laws::spring_damping::{self, Dashpots};
use crate::laws::springs;
use crate::layout::Coded;
use crate::simd::dispatch::BatchKernel;
use crate::simd::lanes::{F64x8, SimdF64, negate, scale};

/// Adds the forces of the springs and dashpots of one tile; the result is the power of the dashpots.
pub(super) struct DampedLinks<'a> {
    pub(super) links: &'a Links,
    pub(super) springs: &'a Coded<springs::Parameters>,
    pub(super) dashpots: &'a Dashpots,
    pub(super) tile: usize,
    pub(super) positions: Columns<'a>,
    pub(super) velocities: Columns<'a>,
    pub(super) forces: ColumnsMut<'a>,
}

impl DampedLinks<'_> {
    /// Runs the kernel; the resistance per length of each dashpot is stored in `cache`.
    pub(super) fn run(self, cache: Option<&mut [F64x8]>) -> f64 {
        let instructions = self.links.instructions;
        match (self.dashpots.limit.is_some(), cache) {
            (false, None) => instructions.run_batches(Kernel::<false>(self)),
            (true, None) => instructions.run_batches(Kernel::<true>(self)),
            (false, Some(cache)) => instructions.run_batches(CachedKernel::<false>(self, cache)),
            (true, Some(cache)) => instructions.run_batches(CachedKernel::<true>(self, cache)),
        }
    }

    #[inline(always)]
    fn add_forces<V: SimdF64, const KIND: usize, const LIMITED: bool>(&mut self, mut cache: Option<&mut [F64x8]>) -> V {
        let pass = self.links.elements.pass::<KIND>(self.tile, self.positions.rows());
        let positions = pass.reader(self.positions);
        let velocities = pass.reader(self.velocities);
        let mut sums = pass.adder(&mut self.forces);
        let (parameters, coefficient) = (self.springs.of(&pass), self.dashpots.coefficient.of(&pass));
        let limit = if LIMITED { self.dashpots.limit.as_ref().map(|springs| springs.of(&pass)) } else { None };
        let mut power = V::zero();
        for batch in 0..pass.len() {
            let span = Span::between(positions.read::<V>(batch));
            let rate = span.opening(velocities.read::<V>(batch));
            let length = span.length();
            let (tension, inverse) = parameters[batch].tension_per_length(length);
            let mut resistance = spring_damping::resistance_per_length(&coefficient[batch], rate, inverse * inverse);
            if let Some(springs) = &limit {
                resistance = spring_damping::limited(resistance, springs[batch].excess(length) * inverse);
            }
            power -= resistance * rate;
            let force = scale(tension + resistance, span.d);
            sums.add(batch, [force, negate(force)]);
            if let Some(cache) = &mut cache {
                cache[pass.place(batch)] = resistance.lanes();
            }
        }
        power
    }
}

/// The kernel of a tile, with limited dashpots or without.
struct Kernel<'a, const LIMITED: bool>(DampedLinks<'a>);

/// The same, with the resistance per length of each dashpot stored.
struct CachedKernel<'a, const LIMITED: bool>(DampedLinks<'a>, &'a mut [F64x8]);

impl<const LIMITED: bool> BatchKernel for Kernel<'_, LIMITED> {
    #[inline(always)]
    fn sweep_kind<V: SimdF64, const KIND: usize>(&mut self) -> V {
        self.0.add_forces::<V, KIND, LIMITED>(None)
    }
}

impl<const LIMITED: bool> BatchKernel for CachedKernel<'_, LIMITED> {
    #[inline(always)]
    fn sweep_kind<V: SimdF64, const KIND: usize>(&mut self) -> V {
        self.0.add_forces::<V, KIND, LIMITED>(Some(self.1))
    }
}
