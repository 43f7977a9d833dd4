//! The side of flat on which each crease is folded.
//!
//! Positions give a crease angle up to whole turns. Within 90 degrees of flat there is no doubt: from pi/2 to pi a
//! crease is on the side of its fold, from pi to 3 pi/2 it is folded against it. A sharper crease is on the side on
//! which it was last that open:
//!
//!     on its own side        theta in [-pi/2, 3 pi/2)   shut at 0, facets that interpenetrate below
//!     on the other side      theta in [pi/2, 5 pi/2)    shut at 2 pi, facets that interpenetrate above
//!
//! The side only changes where both ranges overlap, so that neither angle nor energy jumps. By positions alone a crease
//! that is folded against its side beyond 3 pi/2 would be one with facets that interpenetrate by 90 degrees: a run
//! gains the energy of that contact.
//!
//! A collapsed facet makes no difference. Where it inverts, through a line, the angle changes by half a turn, but the
//! weights are zero there, and the energy does not jump. To put such a crease on its own side would change the energy
//! of one that still has a weight, and a run would gain energy.

use std::f64::consts::{FRAC_PI_2, PI};

use super::{Creases, HistoryDependent, Instant};
use crate::arrays::blocks::tiles;
use crate::arrays::columns::Columns;
use crate::arrays::history::History;
use crate::elements::hinge::Facets;
use crate::elements::hinge_set::{HingeParameters, HingeSet};
use crate::layout::ElementSet;
use crate::simd::dispatch::BatchKernel;
use crate::simd::lanes::{F64x8, SimdF64};

/// The least angle of a crease on its own side, and on the other one \[rad\].
const OWN: f64 = -FRAC_PI_2;
const OTHER: f64 = FRAC_PI_2;

/// The least angle of each crease, by batch \[rad\].
pub(super) struct Sides(Vec<F64x8>);

impl Sides {
    /// All creases on their own sides.
    pub(super) fn own(elements: &ElementSet<4>) -> Self {
        Self(vec![F64x8::all(OWN); elements.batch_count()])
    }

    /// The least angle of each crease, by batch \[rad\].
    pub(super) fn least_angles(&self) -> &[F64x8] {
        &self.0
    }

    /// 1 for each crease on the other side and 0 for others, in external order; nothing where all are on their own.
    fn history(&self, elements: &ElementSet<4>) -> History {
        let is_own = self.0.iter().all(|batch| batch.0 == [OWN; 8]);
        let flags = |batch: &F64x8| F64x8(batch.0.map(|least| f64::from(u8::from(least == OTHER))));
        let numbers = if is_own { Vec::new() } else { elements.unpack(self.0.iter().map(flags)) };
        History { vectors: Vec::new(), numbers }
    }

    /// The sides of a history; `None` where it is not one of these creases.
    fn of(history: &History, elements: &ElementSet<4>) -> Option<Self> {
        let History { vectors, numbers } = history;
        if numbers.is_empty() {
            return vectors.is_empty().then(|| Self::own(elements));
        }
        let fits = vectors.is_empty()
            && numbers.len() == elements.each().count()
            && numbers.iter().all(|&flag| flag == 0.0 || flag == 1.0);
        fits.then(|| Self::where_other(elements, |row| numbers[row] == 1.0))
    }

    /// On the other side where a function of the crease says so, by its place in external order.
    fn where_other(elements: &ElementSet<4>, is_other: impl Fn(usize) -> bool) -> Self {
        Self(elements.pack(OWN, |row| if is_other(row) { OTHER } else { OWN }))
    }
}

/// Finds the sides of the creases of one tile.
struct SideKernel<'a> {
    hinges: &'a HingeSet,
    least_angles: &'a mut [F64x8],
    tile: usize,
    positions: Columns<'a>,
}

impl BatchKernel for SideKernel<'_> {
    #[inline(always)]
    fn sweep_kind<V: SimdF64, const KIND: usize>(&mut self) -> V {
        let pass = self.hinges.elements.pass::<KIND>(self.tile, self.positions.rows());
        let positions = pass.reader(self.positions);
        let parameters = self.hinges.parameters.of(&pass);
        let (zero, own) = (V::zero(), V::all(OWN));
        for batch in 0..pass.len() {
            let HingeParameters { sign, .. } = &parameters[batch];
            let facets = Facets::new(positions.read::<V>(batch));
            let least = &mut self.least_angles[pass.place(batch)];
            let by_sine = facets.sine(V::load(sign)).below(zero, V::all(OTHER), own);
            *least = facets.cosine().below(zero, by_sine, V::load(least)).lanes();
        }
        zero
    }
}

impl HistoryDependent for Creases {
    fn accept(&mut self, at: Instant<'_>) {
        let positions = Columns::of(at.positions);
        let Self { hinges, sides: Sides(least_angles), instructions, .. } = self;
        for tile in tiles(positions.rows()) {
            instructions.run_batches(SideKernel { hinges, least_angles, tile, positions });
        }
    }

    fn set_crease_angles(&mut self, angles: &[f64]) {
        if angles.len() == self.hinges.elements.each().count() {
            self.sides = Sides::where_other(&self.hinges.elements, |row| angles[row] > PI);
        }
    }

    fn history(&self) -> History {
        self.sides.history(&self.hinges.elements)
    }

    fn restore_history(&mut self, history: History) -> bool {
        let found = Sides::of(&history, &self.hinges.elements);
        let fits = found.is_some();
        if let Some(sides) = found {
            self.sides = sides;
        }
        fits
    }
}
