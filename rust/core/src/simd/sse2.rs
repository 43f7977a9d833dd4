//! Eight numbers in four registers of SSE2, which every x86-64 has.
#![allow(unsafe_code)]

use std::arch::x86_64::*;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

use super::lanes::{F64x8, HALF, LANES, SimdF64};

/// Four registers.
#[derive(Clone, Copy)]
pub(crate) struct Sse2(__m128d, __m128d, __m128d, __m128d);

/// One operation on the four registers of one or two operands.
macro_rules! on_each {
    ($operation:ident, $a:expr) => {{
        let a = $a;
        // SAFETY: every x86-64 has SSE2.
        unsafe { Sse2($operation(a.0), $operation(a.1), $operation(a.2), $operation(a.3)) }
    }};
    ($operation:ident, $a:expr, $b:expr) => {{
        let (a, b) = ($a, $b);
        // SAFETY: every x86-64 has SSE2.
        #[allow(unused_unsafe)]
        unsafe {
            Sse2($operation(a.0, b.0), $operation(a.1, b.1), $operation(a.2, b.2), $operation(a.3, b.3))
        }
    }};
}

macro_rules! operator {
    ($trait:ident, $method:ident, $operation:ident) => {
        impl $trait for Sse2 {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                on_each!($operation, self, other)
            }
        }
    };
}
operator!(Add, add, _mm_add_pd);
operator!(Sub, sub, _mm_sub_pd);
operator!(Mul, mul, _mm_mul_pd);
operator!(Div, div, _mm_div_pd);

impl Neg for Sse2 {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        on_each!(_mm_xor_pd, self, Self::all(-0.0))
    }
}

impl AddAssign for Sse2 {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl SubAssign for Sse2 {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

/// Loads two numbers.
#[inline(always)]
fn two(numbers: &[f64], at: usize) -> __m128d {
    let numbers = &numbers[at..at + 2];
    // SAFETY: two numbers lie behind the pointer; every x86-64 has SSE2.
    unsafe { _mm_loadu_pd(numbers.as_ptr()) }
}

/// Stores two numbers.
#[inline(always)]
fn put(place: &mut [f64], at: usize, numbers: __m128d) {
    let place = &mut place[at..at + 2];
    // SAFETY: two numbers lie behind the pointer; every x86-64 has SSE2.
    unsafe { _mm_storeu_pd(place.as_mut_ptr(), numbers) }
}

/// Adds four numbers to an array.
#[inline(always)]
fn add_to(place: &mut [f64; HALF], low: __m128d, high: __m128d) {
    // SAFETY: every x86-64 has SSE2.
    let (low, high) = unsafe { (_mm_add_pd(two(place, 0), low), _mm_add_pd(two(place, 2), high)) };
    put(place, 0, low);
    put(place, 2, high);
}

impl SimdF64 for Sse2 {
    #[inline(always)]
    fn load_from(numbers: &[f64; LANES]) -> Self {
        Self(two(numbers, 0), two(numbers, 2), two(numbers, 4), two(numbers, 6))
    }

    #[inline(always)]
    fn load_split(low: &[f64; HALF], high: &[f64; HALF]) -> Self {
        Self(two(low, 0), two(low, 2), two(high, 0), two(high, 2))
    }

    #[inline(always)]
    fn of_rows(rows: [&[f64; HALF]; LANES]) -> [Self; HALF] {
        let [mut a, mut b, mut c, mut d] = [Self::zero(); HALF];
        macro_rules! pair_of_rows {
            ($register:tt, $row:expr) => {
                let (first, second) = (two(rows[$row], 0), two(rows[$row + 1], 0));
                let (third, fourth) = (two(rows[$row], 2), two(rows[$row + 1], 2));
                // SAFETY: every x86-64 has SSE2.
                unsafe {
                    (a.$register, b.$register) = (_mm_unpacklo_pd(first, second), _mm_unpackhi_pd(first, second));
                    (c.$register, d.$register) = (_mm_unpacklo_pd(third, fourth), _mm_unpackhi_pd(third, fourth));
                }
            };
        }
        pair_of_rows!(0, 0);
        pair_of_rows!(1, 2);
        pair_of_rows!(2, 4);
        pair_of_rows!(3, 6);
        [a, b, c, d]
    }

    #[inline(always)]
    fn add_low_to(self, place: &mut [f64; HALF]) {
        add_to(place, self.0, self.1);
    }

    #[inline(always)]
    fn add_high_to(self, place: &mut [f64; HALF]) {
        add_to(place, self.2, self.3);
    }

    #[inline(always)]
    fn lanes(self) -> F64x8 {
        let mut out = F64x8::ZERO;
        put(&mut out.0, 0, self.0);
        put(&mut out.0, 2, self.1);
        put(&mut out.0, 4, self.2);
        put(&mut out.0, 6, self.3);
        out
    }

    #[inline(always)]
    fn all(value: f64) -> Self {
        // SAFETY: every x86-64 has SSE2.
        let both = unsafe { _mm_set1_pd(value) };
        Self(both, both, both, both)
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        on_each!(_mm_sqrt_pd, self)
    }

    #[inline(always)]
    fn abs(self) -> Self {
        on_each!(_mm_andnot_pd, Self::all(-0.0), self)
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        on_each!(_mm_max_pd, self, other)
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        on_each!(_mm_min_pd, self, other)
    }

    #[inline(always)]
    fn below(self, bound: Self, yes: Self, no: Self) -> Self {
        let is_below = on_each!(_mm_cmplt_pd, self, bound);
        on_each!(_mm_or_pd, on_each!(_mm_and_pd, is_below, yes), on_each!(_mm_andnot_pd, is_below, no))
    }

    #[inline(always)]
    fn copysign(self, sign: Self) -> Self {
        on_each!(_mm_or_pd, on_each!(_mm_and_pd, Self::all(-0.0), sign), self.abs())
    }
}
