//! Bounds of the machine: the time of each operation on eight numbers in registers and from the first cache, and the
//! least time of counted operations.
//!
//! Every operation is timed at each width through the trait of the kernels, in independent chains. The time of a unit
//! is its count times its time per operation. That of the busiest unit bounds the time from below, as if all other
//! units worked at the same time and none waited.
#![allow(unreachable_pub)]

use std::hint::black_box;
use std::marker::PhantomData;
use std::time::Instant;

use membrane_core::simd::counted::Counts;
use membrane_core::simd::dispatch::{InstructionSet, Kernel};
use membrane_core::simd::lanes::{F64x8, LANES, SimdF64};

/// Rounds in one timing, and number of timings.
const ROUNDS: usize = 10_000;
const TIMINGS: usize = 20;
/// Vectors of eight for reads and writes: less than 4 KiB, well within the first cache.
const PLACES: usize = 48;

/// Time of each operation on eight numbers [ns].
#[derive(Debug, Clone, Copy)]
pub struct OperationTimes {
    addition: f64,
    multiplication: f64,
    /// An independent pair of an addition and a multiplication.
    pair: f64,
    division: f64,
    root: f64,
    extreme: f64,
    choice: f64,
    load: f64,
    store: f64,
}

impl OperationTimes {
    /// Number of operations.
    pub const ROWS: usize = 9;

    /// Measures the times of all operations.
    pub fn of(instructions: InstructionSet) -> Self {
        Self {
            addition: chained::<Addition>(instructions),
            multiplication: chained::<Multiplication>(instructions),
            pair: 2.0 * chained::<Both>(instructions),
            division: chained::<Division>(instructions),
            root: chained::<Root>(instructions),
            extreme: chained::<Extreme>(instructions),
            choice: chained::<Choice>(instructions),
            load: [loads::<2>(instructions), loads::<3>(instructions), loads::<4>(instructions)]
                .into_iter()
                .fold(f64::INFINITY, f64::min),
            store: fastest(PLACES, || instructions.dispatch(Stores)),
        }
    }

    /// Each with its name [ns].
    pub fn rows(&self) -> [(&'static str, f64); Self::ROWS] {
        [
            ("addition", self.addition),
            ("multiplication", self.multiplication),
            ("one of each, side by side", self.pair),
            ("division", self.division),
            ("square root", self.root),
            ("larger or smaller of two", self.extreme),
            ("comparison and choice", self.choice),
            ("read", self.load),
            ("write", self.store),
        ]
    }

    /// Time of the busiest unit for these operations [us], and its name.
    pub fn bound(&self, counts: &Counts) -> (f64, &'static str) {
        let sums = counts.additions as f64 * self.addition;
        let products = counts.multiplications as f64 * self.multiplication;
        // Additions and multiplications have separate units where a pair takes clearly less than both in turn. Even
        // then a pair may take longer than either: the registers are too few to keep both units busy.
        let are_separate = self.pair < 0.75 * (self.addition + self.multiplication);
        let arithmetic = if are_separate { sums.max(products) } else { sums + products };
        let divider = counts.divisions as f64 * self.division + counts.roots as f64 * self.root;
        let choices = counts.extremes as f64 * self.extreme + counts.choices as f64 * self.choice;
        let units = [
            (arithmetic, "adders and multipliers"),
            (divider, "divider"),
            (choices, "comparisons"),
            (counts.loads as f64 * self.load, "reads"),
            (counts.stores as f64 * self.store, "writes"),
        ];
        let longest = units.into_iter().fold((0.0, "nothing"), |most, unit| if unit.0 > most.0 { unit } else { most });
        (longest.0 * 1e-3, longest.1)
    }
}

/// Time of each of the `operations` of a round [ns]: the tenth percentile of many timings of `ROUNDS` rounds.
fn fastest<T>(operations: usize, mut rounds: impl FnMut() -> T) -> f64 {
    let mut times = [0.0; TIMINGS];
    for time in &mut times {
        let began = Instant::now();
        black_box(rounds());
        *time = began.elapsed().as_secs_f64() * 1e9 / (ROUNDS * operations) as f64;
    }
    times.sort_by(f64::total_cmp);
    times[TIMINGS / 10]
}

/// An operation on the numbers of chain `k`, those of the next chain, and a constant.
trait Operation {
    fn on<V: SimdF64>(k: usize, x: V, next: V, c: V) -> V;
}

macro_rules! operation {
    ($name:ident, |$k:ident, $x:ident, $next:ident, $c:ident| $formula:expr) => {
        struct $name;
        impl Operation for $name {
            #[inline(always)]
            fn on<V: SimdF64>($k: usize, $x: V, $next: V, $c: V) -> V {
                $formula
            }
        }
    };
}
operation!(Addition, |_k, x, _next, c| x + c);
operation!(Multiplication, |_k, x, _next, c| x * c);
operation!(Both, |k, x, _next, c| if k.is_multiple_of(2) { x + c } else { x * c });
operation!(Division, |_k, x, _next, c| c / x);
operation!(Root, |_k, x, _next, _c| x.sqrt());
operation!(Extreme, |_k, x, next, _c| x.max(next));
operation!(Choice, |_k, x, next, c| c.below(x, next, x));

/// Time of an operation [ns], with the best number of chains: few have latencies, many exceed the registers.
fn chained<O: Operation>(instructions: InstructionSet) -> f64 {
    let few = chains::<O, 2>(instructions).min(chains::<O, 3>(instructions)).min(chains::<O, 4>(instructions));
    let more = chains::<O, 6>(instructions).min(chains::<O, 8>(instructions));
    few.min(more).min(chains::<O, 12>(instructions)).min(chains::<O, 16>(instructions))
}

fn chains<O: Operation, const COUNT: usize>(instructions: InstructionSet) -> f64 {
    fastest(COUNT, || instructions.dispatch(Chains::<O, COUNT>(PhantomData)))
}

struct Chains<O, const COUNT: usize>(PhantomData<O>);

impl<O: Operation, const COUNT: usize> Kernel for Chains<O, COUNT> {
    type Output = F64x8;

    #[inline(always)]
    fn sweep<V: SimdF64>(self) -> F64x8 {
        let c = V::all(black_box(1.000_000_1));
        let mut x = [V::all(black_box(1.5)); COUNT];
        for _ in 0..ROUNDS {
            for k in 0..COUNT {
                x[k] = O::on(k, x[k], x[(k + 1) % COUNT], c);
            }
        }
        let mut sum = V::zero();
        for k in 0..COUNT {
            sum += x[k];
        }
        sum.lanes()
    }
}

/// Reads, each into one of `COUNT` sums or `COUNT` products.
struct Loads<const COUNT: usize>;

fn loads<const COUNT: usize>(instructions: InstructionSet) -> f64 {
    fastest(PLACES, || instructions.dispatch(Loads::<COUNT>))
}

impl<const COUNT: usize> Kernel for Loads<COUNT> {
    type Output = F64x8;

    #[inline(always)]
    fn sweep<V: SimdF64>(self) -> F64x8 {
        let places = [F64x8([1.0; LANES]); PLACES];
        let (mut sums, mut products) = ([V::zero(); COUNT], [V::zero(); COUNT]);
        for _ in 0..ROUNDS {
            let places = black_box(&places);
            for pairs in places.chunks_exact(2 * COUNT) {
                for k in 0..COUNT {
                    sums[k] += V::load(&pairs[2 * k]);
                    products[k] = products[k] * V::load(&pairs[2 * k + 1]);
                }
            }
        }
        let mut sum = V::zero();
        for k in 0..COUNT {
            sum += sums[k] + products[k];
        }
        sum.lanes()
    }
}

/// Writes of one register.
struct Stores;

impl Kernel for Stores {
    type Output = ();

    #[inline(always)]
    fn sweep<V: SimdF64>(self) {
        let x = V::all(black_box(1.5));
        let mut places = [F64x8::ZERO; PLACES];
        for _ in 0..ROUNDS {
            for place in black_box(&mut places) {
                *place = x.lanes();
            }
        }
    }
}
