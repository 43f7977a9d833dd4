//! Eight numbers in vector registers of x86-64.
//!
//! These types need instructions that not every machine has. Only `dispatch` names them, in functions that it calls
//! where the machine has those instructions; kernels are generic over the trait `SimdF64`. All `unsafe` relies on this.
#![allow(unsafe_code)]

use std::arch::x86_64::*;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

use super::lanes::{F64x8, HALF, LANES, SimdF64};

/// Two registers of AVX2.
#[derive(Clone, Copy)]
pub(crate) struct Avx2(__m256d, __m256d);

/// One register of AVX-512.
#[derive(Clone, Copy)]
pub(crate) struct Avx512(__m512d);

macro_rules! operator {
    ($trait:ident, $method:ident, $of_256:ident, $of_512:ident) => {
        impl $trait for Avx2 {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                // SAFETY: the machine has AVX2, see above.
                unsafe { Self($of_256(self.0, other.0), $of_256(self.1, other.1)) }
            }
        }

        impl $trait for Avx512 {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                // SAFETY: the machine has AVX-512, see above.
                unsafe { Self($of_512(self.0, other.0)) }
            }
        }
    };
}
operator!(Add, add, _mm256_add_pd, _mm512_add_pd);
operator!(Sub, sub, _mm256_sub_pd, _mm512_sub_pd);
operator!(Mul, mul, _mm256_mul_pd, _mm512_mul_pd);
operator!(Div, div, _mm256_div_pd, _mm512_div_pd);

macro_rules! derived {
    ($type:ident, $xor:ident) => {
        impl Neg for $type {
            type Output = Self;
            #[inline(always)]
            fn neg(self) -> Self {
                self.$xor(Self::all(-0.0))
            }
        }

        impl AddAssign for $type {
            #[inline(always)]
            fn add_assign(&mut self, other: Self) {
                *self = *self + other;
            }
        }

        impl SubAssign for $type {
            #[inline(always)]
            fn sub_assign(&mut self, other: Self) {
                *self = *self - other;
            }
        }
    };
}
derived!(Avx2, flipped);
derived!(Avx512, flipped);

impl Avx2 {
    /// The signs flipped where `sign` has the sign bit alone.
    #[inline(always)]
    fn flipped(self, sign: Self) -> Self {
        // SAFETY: the machine has AVX2, see above.
        unsafe { Self(_mm256_xor_pd(self.0, sign.0), _mm256_xor_pd(self.1, sign.1)) }
    }
}

impl Avx512 {
    /// The signs flipped where `sign` has the sign bit alone.
    #[inline(always)]
    fn flipped(self, sign: Self) -> Self {
        // SAFETY: the machine has AVX-512, see above.
        unsafe { Self(_mm512_xor_pd(self.0, sign.0)) }
    }
}

/// Adds four numbers to an array.
#[inline(always)]
fn add_to(place: &mut [f64; HALF], numbers: __m256d) {
    // SAFETY: four numbers lie behind the pointer; the machine has AVX2, or AVX-512, which includes it, see above.
    unsafe { _mm256_storeu_pd(place.as_mut_ptr(), _mm256_add_pd(_mm256_loadu_pd(place.as_ptr()), numbers)) }
}

/// The columns of a matrix of four rows.
#[inline(always)]
fn of_four_rows([p, q, r, s]: [&[f64; HALF]; HALF]) -> [__m256d; HALF] {
    // SAFETY: four numbers lie behind each pointer; the machine has AVX2, see above.
    unsafe {
        let (p, q) = (_mm256_loadu_pd(p.as_ptr()), _mm256_loadu_pd(q.as_ptr()));
        let (r, s) = (_mm256_loadu_pd(r.as_ptr()), _mm256_loadu_pd(s.as_ptr()));
        let (even, odd) = (_mm256_unpacklo_pd(p, q), _mm256_unpackhi_pd(p, q));
        let (next_even, next_odd) = (_mm256_unpacklo_pd(r, s), _mm256_unpackhi_pd(r, s));
        [
            _mm256_permute2f128_pd::<0x20>(even, next_even),
            _mm256_permute2f128_pd::<0x20>(odd, next_odd),
            _mm256_permute2f128_pd::<0x31>(even, next_even),
            _mm256_permute2f128_pd::<0x31>(odd, next_odd),
        ]
    }
}

impl SimdF64 for Avx2 {
    #[inline(always)]
    fn load_from(numbers: &[f64; LANES]) -> Self {
        // SAFETY: eight numbers lie behind the pointer; the machine has AVX2, see above.
        unsafe { Self(_mm256_loadu_pd(numbers.as_ptr()), _mm256_loadu_pd(numbers.as_ptr().add(4))) }
    }

    #[inline(always)]
    fn load_split(low: &[f64; HALF], high: &[f64; HALF]) -> Self {
        // SAFETY: four numbers lie behind each pointer; the machine has AVX2, see above.
        unsafe { Self(_mm256_loadu_pd(low.as_ptr()), _mm256_loadu_pd(high.as_ptr())) }
    }

    #[inline(always)]
    fn of_rows(rows: [&[f64; HALF]; LANES]) -> [Self; HALF] {
        let [p, q, r, s, t, u, v, w] = rows;
        let ([a, b, c, d], [e, f, g, h]) = (of_four_rows([p, q, r, s]), of_four_rows([t, u, v, w]));
        [Self(a, e), Self(b, f), Self(c, g), Self(d, h)]
    }

    #[inline(always)]
    fn add_low_to(self, place: &mut [f64; HALF]) {
        add_to(place, self.0);
    }

    #[inline(always)]
    fn add_high_to(self, place: &mut [f64; HALF]) {
        add_to(place, self.1);
    }

    #[inline(always)]
    fn lanes(self) -> F64x8 {
        let mut out = F64x8::ZERO;
        // SAFETY: eight numbers lie behind the pointer; the machine has AVX2, see above.
        unsafe {
            _mm256_storeu_pd(out.0.as_mut_ptr(), self.0);
            _mm256_storeu_pd(out.0.as_mut_ptr().add(4), self.1);
        }
        out
    }

    #[inline(always)]
    fn all(value: f64) -> Self {
        // SAFETY: the machine has AVX2, see above.
        unsafe { Self(_mm256_set1_pd(value), _mm256_set1_pd(value)) }
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        // SAFETY: the machine has AVX2, see above.
        unsafe { Self(_mm256_sqrt_pd(self.0), _mm256_sqrt_pd(self.1)) }
    }

    #[inline(always)]
    fn abs(self) -> Self {
        let sign = Self::all(-0.0);
        // SAFETY: the machine has AVX2, see above.
        unsafe { Self(_mm256_andnot_pd(sign.0, self.0), _mm256_andnot_pd(sign.1, self.1)) }
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        // SAFETY: the machine has AVX2, see above.
        unsafe { Self(_mm256_max_pd(self.0, other.0), _mm256_max_pd(self.1, other.1)) }
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        // SAFETY: the machine has AVX2, see above.
        unsafe { Self(_mm256_min_pd(self.0, other.0), _mm256_min_pd(self.1, other.1)) }
    }

    #[inline(always)]
    fn below(self, bound: Self, yes: Self, no: Self) -> Self {
        // SAFETY: the machine has AVX2, see above.
        unsafe {
            let low = _mm256_cmp_pd::<_CMP_LT_OQ>(self.0, bound.0);
            let high = _mm256_cmp_pd::<_CMP_LT_OQ>(self.1, bound.1);
            Self(_mm256_blendv_pd(no.0, yes.0, low), _mm256_blendv_pd(no.1, yes.1, high))
        }
    }

    #[inline(always)]
    fn copysign(self, sign: Self) -> Self {
        let (bit, size) = (Self::all(-0.0), self.abs());
        // SAFETY: the machine has AVX2, see above.
        unsafe {
            Self(_mm256_or_pd(_mm256_and_pd(bit.0, sign.0), size.0), _mm256_or_pd(_mm256_and_pd(bit.1, sign.1), size.1))
        }
    }
}

impl SimdF64 for Avx512 {
    #[inline(always)]
    fn load_from(numbers: &[f64; LANES]) -> Self {
        // SAFETY: eight numbers lie behind the pointer; the machine has AVX-512, see above.
        unsafe { Self(_mm512_loadu_pd(numbers.as_ptr())) }
    }

    #[inline(always)]
    fn load_split(low: &[f64; HALF], high: &[f64; HALF]) -> Self {
        // SAFETY: four numbers lie behind each pointer; the machine has AVX-512, see above.
        unsafe {
            let low = _mm512_castpd256_pd512(_mm256_loadu_pd(low.as_ptr()));
            Self(_mm512_insertf64x4::<1>(low, _mm256_loadu_pd(high.as_ptr())))
        }
    }

    #[inline(always)]
    fn of_rows(rows: [&[f64; HALF]; LANES]) -> [Self; HALF] {
        // Each half of a register has a matrix of four rows.
        let (p, q) = (Self::load_split(rows[0], rows[4]).0, Self::load_split(rows[1], rows[5]).0);
        let (r, s) = (Self::load_split(rows[2], rows[6]).0, Self::load_split(rows[3], rows[7]).0);
        // SAFETY: the machine has AVX-512, see above.
        unsafe {
            let (even, odd) = (_mm512_unpacklo_pd(p, q), _mm512_unpackhi_pd(p, q));
            let (next_even, next_odd) = (_mm512_unpacklo_pd(r, s), _mm512_unpackhi_pd(r, s));
            let first = _mm512_setr_epi64(0, 1, 8, 9, 4, 5, 12, 13);
            let second = _mm512_setr_epi64(2, 3, 10, 11, 6, 7, 14, 15);
            [
                Self(_mm512_permutex2var_pd(even, first, next_even)),
                Self(_mm512_permutex2var_pd(odd, first, next_odd)),
                Self(_mm512_permutex2var_pd(even, second, next_even)),
                Self(_mm512_permutex2var_pd(odd, second, next_odd)),
            ]
        }
    }

    #[inline(always)]
    fn add_low_to(self, place: &mut [f64; HALF]) {
        // SAFETY: the machine has AVX-512, see above.
        add_to(place, unsafe { _mm512_castpd512_pd256(self.0) });
    }

    #[inline(always)]
    fn add_high_to(self, place: &mut [f64; HALF]) {
        // SAFETY: the machine has AVX-512, see above.
        add_to(place, unsafe { _mm512_extractf64x4_pd::<1>(self.0) });
    }

    #[inline(always)]
    fn lanes(self) -> F64x8 {
        let mut out = F64x8::ZERO;
        // SAFETY: eight numbers lie behind the pointer; the machine has AVX-512, see above.
        unsafe { _mm512_storeu_pd(out.0.as_mut_ptr(), self.0) };
        out
    }

    #[inline(always)]
    fn all(value: f64) -> Self {
        // SAFETY: the machine has AVX-512, see above.
        unsafe { Self(_mm512_set1_pd(value)) }
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        // SAFETY: the machine has AVX-512, see above.
        unsafe { Self(_mm512_sqrt_pd(self.0)) }
    }

    #[inline(always)]
    fn abs(self) -> Self {
        // SAFETY: the machine has AVX-512, see above.
        unsafe { Self(_mm512_andnot_pd(_mm512_set1_pd(-0.0), self.0)) }
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        // SAFETY: the machine has AVX-512, see above.
        unsafe { Self(_mm512_max_pd(self.0, other.0)) }
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        // SAFETY: the machine has AVX-512, see above.
        unsafe { Self(_mm512_min_pd(self.0, other.0)) }
    }

    #[inline(always)]
    fn below(self, bound: Self, yes: Self, no: Self) -> Self {
        // SAFETY: the machine has AVX-512, see above.
        unsafe { Self(_mm512_mask_blend_pd(_mm512_cmp_pd_mask::<_CMP_LT_OQ>(self.0, bound.0), no.0, yes.0)) }
    }

    #[inline(always)]
    fn copysign(self, sign: Self) -> Self {
        // SAFETY: the machine has AVX-512, see above.
        unsafe { Self(_mm512_or_pd(_mm512_and_pd(_mm512_set1_pd(-0.0), sign.0), self.abs().0)) }
    }
}
