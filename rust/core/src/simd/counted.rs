//! Eight numbers with counted operations: the operation counts of a kernel, taken from the kernel itself.
//!
//! Values and results are those of `F64x8`. `InstructionSet::Counted` runs kernels with this type, and `count` returns
//! the counts. Work outside the trait `SimdF64` (gathers and scatters of gathered batches, indices) is not counted.

use std::cell::Cell;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

use super::lanes::{F64x8, HALF, LANES, SimdF64};

/// Operations on eight numbers, by kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Sums and differences.
    pub additions: u64,
    /// Products.
    pub multiplications: u64,
    /// Quotients.
    pub divisions: u64,
    /// Square roots.
    pub roots: u64,
    /// Maxima and minima of two.
    pub extremes: u64,
    /// Comparisons, each with the selection by its result.
    pub choices: u64,
    /// Absolute values, negations, copied signs.
    pub signs: u64,
    /// Reads.
    pub loads: u64,
    /// Writes.
    pub stores: u64,
}

thread_local! {
    static COUNTS: Cell<Counts> = const { Cell::new(Counts {
        additions: 0,
        multiplications: 0,
        divisions: 0,
        roots: 0,
        extremes: 0,
        choices: 0,
        signs: 0,
        loads: 0,
        stores: 0,
    }) };
}

/// Operations of `work` on this thread with `InstructionSet::Counted`.
pub fn count(work: impl FnOnce()) -> Counts {
    COUNTS.set(Counts::default());
    work();
    COUNTS.take()
}

fn increment(kind: impl FnOnce(&mut Counts) -> &mut u64) {
    let mut counts = COUNTS.get();
    *kind(&mut counts) += 1;
    COUNTS.set(counts);
}

/// Eight numbers with counted operations.
#[derive(Clone, Copy)]
pub(crate) struct Counted(F64x8);

macro_rules! operator {
    ($trait:ident, $method:ident, $op:tt, $kind:ident) => {
        impl $trait for Counted {
            type Output = Self;
            fn $method(self, other: Self) -> Self {
                increment(|counts| &mut counts.$kind);
                Self(self.0 $op other.0)
            }
        }
    };
}
operator!(Add, add, +, additions);
operator!(Sub, sub, -, additions);
operator!(Mul, mul, *, multiplications);
operator!(Div, div, /, divisions);

impl Neg for Counted {
    type Output = Self;
    fn neg(self) -> Self {
        increment(|counts| &mut counts.signs);
        Self(-self.0)
    }
}

impl AddAssign for Counted {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl SubAssign for Counted {
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl SimdF64 for Counted {
    fn load_from(numbers: &[f64; LANES]) -> Self {
        increment(|counts| &mut counts.loads);
        Self(F64x8(*numbers))
    }

    fn load_split(low: &[f64; HALF], high: &[f64; HALF]) -> Self {
        increment(|counts| &mut counts.loads);
        Self(F64x8::load_split(low, high))
    }

    /// Eight rows are as many reads.
    fn of_rows(rows: [&[f64; HALF]; LANES]) -> [Self; HALF] {
        (0..LANES).for_each(|_| increment(|counts| &mut counts.loads));
        F64x8::of_rows(rows).map(Self)
    }

    /// Counted here for both halves.
    fn add_low_to(self, place: &mut [f64; HALF]) {
        increment(|counts| &mut counts.loads);
        increment(|counts| &mut counts.additions);
        increment(|counts| &mut counts.stores);
        self.0.add_low_to(place);
    }

    fn add_high_to(self, place: &mut [f64; HALF]) {
        self.0.add_high_to(place);
    }

    fn lanes(self) -> F64x8 {
        increment(|counts| &mut counts.stores);
        self.0
    }

    /// A constant in a register is no read.
    fn all(value: f64) -> Self {
        Self(F64x8::all(value))
    }

    fn sqrt(self) -> Self {
        increment(|counts| &mut counts.roots);
        Self(self.0.sqrt())
    }

    fn abs(self) -> Self {
        increment(|counts| &mut counts.signs);
        Self(self.0.abs())
    }

    fn max(self, other: Self) -> Self {
        increment(|counts| &mut counts.extremes);
        Self(self.0.max(other.0))
    }

    fn min(self, other: Self) -> Self {
        increment(|counts| &mut counts.extremes);
        Self(self.0.min(other.0))
    }

    fn below(self, bound: Self, yes: Self, no: Self) -> Self {
        increment(|counts| &mut counts.choices);
        Self(self.0.below(bound.0, yes.0, no.0))
    }

    fn copysign(self, sign: Self) -> Self {
        increment(|counts| &mut counts.signs);
        Self(self.0.copysign(sign.0))
    }
}
