//! The instruction set that kernels run with, chosen once per process from what the machine has.
//!
//! A kernel is written once, as a `Kernel` or a `BatchKernel`; `dispatch` and `run_batches` compile it for each width and call
//! the one that was chosen. Plain loops, which the compiler turns into vectors by itself, are a `Sweep`. Results have the same
//! bits at every width (see `lanes`).

#[cfg(target_arch = "x86_64")]
use std::marker::PhantomData;
use std::sync::OnceLock;

use crate::simd::counted::Counted;
use crate::simd::lanes::SimdF64;
#[cfg(target_arch = "x86_64")]
use crate::simd::x86;

/// Eight numbers in what every machine of this architecture has.
#[cfg(target_arch = "x86_64")]
type Baseline = crate::simd::sse2::Sse2;
#[cfg(not(target_arch = "x86_64"))]
type Baseline = crate::simd::lanes::F64x8;

/// A set of vector instructions.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum InstructionSet {
    /// What every machine of this architecture has: SSE2 on x86-64, Neon on 64-bit Arm.
    Baseline,
    /// 256-bit vectors of x86-64.
    Avx2,
    /// 512-bit vectors of x86-64.
    Avx512,
    /// What every machine has, slowly: every operation is counted, see `lanes::counted`.
    Counted,
}

/// The kinds of batches of elements, in the order in which kernels go over them: eight contiguous, two times four, gathered.
pub const CONTIGUOUS: usize = 0;
/// See `CONTIGUOUS`.
pub const SPLIT: usize = 1;
/// See `CONTIGUOUS`.
pub const GATHERED: usize = 2;

/// A pass over elements, to be compiled for every width. `sweep` and all that it calls must be `#[inline(always)]`.
pub trait Sweep {
    /// What the pass gives back.
    type Output;
    /// The pass.
    fn sweep(self) -> Self::Output;
}

/// A sweep over batches of eight, written for any form of them. As `Sweep`; closures are not inlined into it.
pub trait Kernel {
    /// What the pass gives back.
    type Output;
    /// The pass.
    fn sweep<V: SimdF64>(self) -> Self::Output;
}

/// A kernel over batches of elements: one kind of batch (see `layout`) after another, and the sum of what they give.
pub trait BatchKernel {
    /// Goes over the batches of one kind.
    fn part<V: SimdF64, const KIND: usize>(&mut self) -> V;
}

/// All kinds of batches.
struct Kinds<G>(G);

impl<G: BatchKernel> Kernel for Kinds<G> {
    type Output = f64;

    #[inline(always)]
    fn sweep<V: SimdF64>(mut self) -> f64 {
        (self.0.part::<V, CONTIGUOUS>() + self.0.part::<V, SPLIT>() + self.0.part::<V, GATHERED>()).lanes().sum()
    }
}

/// A kernel as a sweep with one form of eight numbers.
#[cfg(target_arch = "x86_64")]
struct With<K, V>(K, PhantomData<V>);

#[cfg(target_arch = "x86_64")]
impl<K: Kernel, V: SimdF64> Sweep for With<K, V> {
    type Output = K::Output;

    #[inline(always)]
    fn sweep(self) -> K::Output {
        self.0.sweep::<V>()
    }
}

impl InstructionSet {
    /// Every width that is there to be fast.
    pub const ALL: [Self; 3] = [Self::Baseline, Self::Avx2, Self::Avx512];

    /// The name that users and benchmarks use.
    pub fn name(self) -> &'static str {
        match self {
            Self::Baseline => "baseline",
            Self::Avx2 => "avx2",
            Self::Avx512 => "avx512",
            Self::Counted => "counted",
        }
    }

    /// Whether this machine has it.
    pub fn is_available(self) -> bool {
        match self {
            Self::Baseline | Self::Counted => true,
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => std::arch::is_x86_feature_detected!("avx2"),
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => {
                std::arch::is_x86_feature_detected!("avx512dq") && std::arch::is_x86_feature_detected!("avx512vl")
            }
            #[cfg(not(target_arch = "x86_64"))]
            _ => false,
        }
    }

    /// The widest that this machine has.
    pub fn widest() -> Self {
        static WIDEST: OnceLock<InstructionSet> = OnceLock::new();
        *WIDEST.get_or_init(|| {
            Self::ALL.into_iter().rev().find(|instructions| instructions.is_available()).unwrap_or(Self::Baseline)
        })
    }

    /// Runs `kernel` with this width over all kinds of batches, and gives the sum over lanes and kinds.
    #[inline]
    pub fn run_batches(self, kernel: impl BatchKernel) -> f64 {
        self.dispatch(Kinds(kernel))
    }

    /// Runs `kernel` with this width, or with the widest below it that the machine has.
    #[inline]
    #[allow(unsafe_code)]
    pub fn dispatch<K: Kernel>(self, kernel: K) -> K::Output {
        match self {
            #[cfg(target_arch = "x86_64")]
            // SAFETY: the machine has what `avx512` and the form of AVX-512 require, which is checked here.
            Self::Avx512 if self.is_available() => unsafe { avx512(With(kernel, PhantomData::<x86::Avx512>)) },
            #[cfg(target_arch = "x86_64")]
            // SAFETY: the machine has what `avx2` and the form of AVX2 require, which is checked here.
            Self::Avx2 | Self::Avx512 if Self::Avx2.is_available() => unsafe {
                avx2(With(kernel, PhantomData::<x86::Avx2>))
            },
            Self::Counted => counted(kernel),
            _ => kernel.sweep::<Baseline>(),
        }
    }

    /// Runs `sweep` with this width, or with the widest below it that the machine has.
    #[inline]
    #[allow(unsafe_code)]
    pub fn run<S: Sweep>(self, sweep: S) -> S::Output {
        match self {
            #[cfg(target_arch = "x86_64")]
            // SAFETY: the one requirement of `avx512` is that the machine has its features, which is checked here.
            Self::Avx512 if self.is_available() => unsafe { avx512(sweep) },
            #[cfg(target_arch = "x86_64")]
            // SAFETY: the one requirement of `avx2` is that the machine has that feature, which is checked here.
            Self::Avx2 | Self::Avx512 if Self::Avx2.is_available() => unsafe { avx2(sweep) },
            _ => sweep.sweep(),
        }
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn avx2<S: Sweep>(sweep: S) -> S::Output {
    sweep.sweep()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512dq,avx512vl")]
fn avx512<S: Sweep>(sweep: S) -> S::Output {
    sweep.sweep()
}

/// Apart from the others, so that the compiler has no more to see to in the function that runs those.
#[cold]
#[inline(never)]
fn counted<K: Kernel>(kernel: K) -> K::Output {
    kernel.sweep::<Counted>()
}
