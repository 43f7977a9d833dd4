//! The instruction set of the kernels, chosen once per process among those of the machine.
//!
//! A kernel is written once, as a `Kernel` or a `BatchKernel`. `dispatch` and `run_batches` compile it for each
//! instruction set and call the chosen version. Plain loops, vectorised by the compiler, are a `Sweep`. Results have
//! the same bits with every instruction set (see `lanes`).

#[cfg(target_arch = "x86_64")]
use std::marker::PhantomData;
use std::sync::OnceLock;

use crate::simd::counted::Counted;
use crate::simd::lanes::SimdF64;
#[cfg(target_arch = "x86_64")]
use crate::simd::x86;

/// Eight numbers in the registers that every machine of this architecture has.
#[cfg(target_arch = "x86_64")]
type Baseline = crate::simd::sse2::Sse2;
#[cfg(not(target_arch = "x86_64"))]
type Baseline = crate::simd::lanes::F64x8;

/// A set of vector instructions.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum InstructionSet {
    /// Available on every machine of this architecture: SSE2 on x86-64, Neon on 64-bit Arm.
    Baseline,
    /// 256-bit vectors of x86-64.
    Avx2,
    /// 512-bit vectors of x86-64.
    Avx512,
    /// Available on every machine, slow: counts every operation, see `counted`.
    Counted,
}

/// The kinds of batches of elements, in the order of the kernels: contiguous, split, gathered (see `layout`).
pub const CONTIGUOUS: usize = 0;
/// See `CONTIGUOUS`.
pub const SPLIT: usize = 1;
/// See `CONTIGUOUS`.
pub const GATHERED: usize = 2;

/// A pass over elements, compiled for every instruction set. `sweep` and everything it calls must be
/// `#[inline(always)]`.
pub trait Sweep {
    /// Result of the pass.
    type Output;
    /// The pass.
    fn sweep(self) -> Self::Output;
}

/// A sweep over batches of eight, generic over their vector type. As `Sweep`; closures are not inlined into it.
pub trait Kernel {
    /// Result of the pass.
    type Output;
    /// The pass.
    fn sweep<V: SimdF64>(self) -> Self::Output;
}

/// A kernel over batches of elements: one kind of batch (see `layout`) after another; the result is the sum over all.
pub trait BatchKernel {
    /// Sweeps the batches of one kind.
    fn sweep_kind<V: SimdF64, const KIND: usize>(&mut self) -> V;
}

/// A kernel over all kinds of batches.
struct AllKinds<K>(K);

impl<K: BatchKernel> Kernel for AllKinds<K> {
    type Output = f64;

    #[inline(always)]
    fn sweep<V: SimdF64>(mut self) -> f64 {
        let (contiguous, split) = (self.0.sweep_kind::<V, CONTIGUOUS>(), self.0.sweep_kind::<V, SPLIT>());
        (contiguous + split + self.0.sweep_kind::<V, GATHERED>()).lanes().sum()
    }
}

/// A kernel as a sweep with one vector type.
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
    /// Every instruction set for production, from the narrowest to the widest.
    pub const ALL: [Self; 3] = [Self::Baseline, Self::Avx2, Self::Avx512];

    /// The name for users and benchmarks.
    pub fn name(self) -> &'static str {
        match self {
            Self::Baseline => "baseline",
            Self::Avx2 => "avx2",
            Self::Avx512 => "avx512",
            Self::Counted => "counted",
        }
    }

    /// Whether this machine supports it.
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

    /// The widest that this machine supports.
    pub fn widest() -> Self {
        static WIDEST: OnceLock<InstructionSet> = OnceLock::new();
        *WIDEST.get_or_init(|| {
            Self::ALL.into_iter().rev().find(|instructions| instructions.is_available()).unwrap_or(Self::Baseline)
        })
    }

    /// Runs `kernel` over all kinds of batches, and returns the sum over lanes and kinds.
    #[inline]
    pub fn run_batches(self, kernel: impl BatchKernel) -> f64 {
        self.dispatch(AllKinds(kernel))
    }

    /// Runs `kernel` with this instruction set, or with the widest below it that the machine supports.
    #[inline]
    #[allow(unsafe_code)]
    pub fn dispatch<K: Kernel>(self, kernel: K) -> K::Output {
        match self {
            #[cfg(target_arch = "x86_64")]
            // SAFETY: `avx512` and the vector type require AVX-512, which is checked here.
            Self::Avx512 if self.is_available() => unsafe { avx512(With(kernel, PhantomData::<x86::Avx512>)) },
            #[cfg(target_arch = "x86_64")]
            // SAFETY: `avx2` and the vector type require AVX2, which is checked here.
            Self::Avx2 | Self::Avx512 if Self::Avx2.is_available() => unsafe {
                avx2(With(kernel, PhantomData::<x86::Avx2>))
            },
            Self::Counted => counted(kernel),
            _ => kernel.sweep::<Baseline>(),
        }
    }

    /// Runs `sweep` with this instruction set, or with the widest below it that the machine supports.
    #[inline]
    #[allow(unsafe_code)]
    pub fn run<S: Sweep>(self, sweep: S) -> S::Output {
        match self {
            #[cfg(target_arch = "x86_64")]
            // SAFETY: `avx512` requires its target features, which is checked here.
            Self::Avx512 if self.is_available() => unsafe { avx512(sweep) },
            #[cfg(target_arch = "x86_64")]
            // SAFETY: `avx2` requires its target feature, which is checked here.
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

/// Kept out of line, so that `dispatch` stays small for the other instruction sets.
#[cold]
#[inline(never)]
fn counted<K: Kernel>(kernel: K) -> K::Output {
    kernel.sweep::<Counted>()
}
