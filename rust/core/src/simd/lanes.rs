//! Eight numbers at a time, in portable Rust.
//!
//! `F64x8` is eight numbers in memory, portable: every operation is a plain loop that the compiler vectorises where it
//! can. `sse2` and `x86` hold the numbers in registers of SSE2, AVX2 and AVX-512. No operation fuses a product with a
//! sum, and `sum` alone adds across lanes. Results therefore have the same bits with every vector type.

use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// Lanes of a vector.
pub const LANES: usize = 8;

/// Half the lanes.
pub const HALF: usize = LANES / 2;

/// Eight numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C, align(64))]
pub struct F64x8(pub [f64; LANES]);

/// A 3-vector in each lane.
pub type Vec3<V = F64x8> = [V; 3];

macro_rules! lanewise {
    ($trait:ident, $method:ident, $op:tt) => {
        impl $trait for F64x8 {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                let mut out = [0.0; LANES];
                for i in 0..LANES {
                    out[i] = self.0[i] $op other.0[i];
                }
                Self(out)
            }
        }
    };
}
lanewise!(Add, add, +);
lanewise!(Sub, sub, -);
lanewise!(Mul, mul, *);
lanewise!(Div, div, /);

impl Neg for F64x8 {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        let mut out = [0.0; LANES];
        for i in 0..LANES {
            out[i] = -self.0[i];
        }
        Self(out)
    }
}

impl AddAssign for F64x8 {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl SubAssign for F64x8 {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl F64x8 {
    /// Zero in every lane.
    pub const ZERO: Self = Self([0.0; LANES]);

    /// The sum over the lanes, in a fixed order.
    #[inline(always)]
    pub fn sum(self) -> f64 {
        let [a, b, c, d, e, f, g, h] = self.0;
        ((a + e) + (c + g)) + ((b + f) + (d + h))
    }
}

/// Eight numbers as the operand of one instruction set. Kernels are generic over it.
pub trait SimdF64:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
{
    /// Eight numbers from memory.
    fn load_from(numbers: &[f64; LANES]) -> Self;
    /// The same from aligned memory.
    #[inline(always)]
    fn load(lanes: &F64x8) -> Self {
        Self::load_from(&lanes.0)
    }
    /// Four numbers from one array and four from another.
    fn load_split(low: &[f64; HALF], high: &[f64; HALF]) -> Self;
    /// The columns of a matrix by its eight rows: the first numbers of all rows, the second ones, and so on.
    fn of_rows(rows: [&[f64; HALF]; LANES]) -> [Self; HALF];
    /// Adds the first four numbers to an array.
    fn add_low_to(self, place: &mut [f64; HALF]);
    /// Adds the last four numbers to an array.
    fn add_high_to(self, place: &mut [f64; HALF]);
    /// The eight numbers.
    fn lanes(self) -> F64x8;
    /// The same number in every lane.
    fn all(value: f64) -> Self;
    /// Square root.
    fn sqrt(self) -> Self;
    /// Magnitude.
    fn abs(self) -> Self;
    /// The larger; `other` where one is not a number.
    fn max(self, other: Self) -> Self;
    /// The smaller; `other` where one is not a number.
    fn min(self, other: Self) -> Self;
    /// `yes` where self < bound, else `no`.
    fn below(self, bound: Self, yes: Self, no: Self) -> Self;
    /// Self with the sign of `sign`.
    fn copysign(self, sign: Self) -> Self;
    /// Zero in every lane.
    #[inline(always)]
    fn zero() -> Self {
        Self::all(0.0)
    }

    /// The angle of the point (x, y) in -pi .. pi, with an error below 5e-16 rad (two units in the last place).
    ///
    /// The smaller over the larger coordinate is reduced to |t| <= tan(pi/8) for the rational approximation of Cephes
    /// (Moshier 1984, atan.c). The angle of (0, 0) is that of (1, 0).
    #[inline(always)]
    fn atan2(y: Self, x: Self) -> Self {
        use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};
        const TAN_PI_8: f64 = 0.414_213_562_373_095_03;
        const P: [f64; 5] = [
            -8.750_608_600_031_904e-1,
            -1.615_753_718_733_365e1,
            -7.500_855_792_314_705e1,
            -1.228_866_684_490_136e2,
            -6.485_021_904_942_025e1,
        ];
        const Q: [f64; 5] = [
            2.485_846_490_142_306_3e1,
            1.650_270_098_316_988_5e2,
            4.328_810_604_912_902_7e2,
            4.853_903_996_359_137e2,
            1.945_506_571_482_614e2,
        ];
        let (ax, ay) = (x.abs(), y.abs());
        let (small, large) = (ax.min(ay), ax.max(ay).max(Self::all(f64::MIN_POSITIVE)));
        let bound = Self::all(TAN_PI_8) * large;
        let over = bound.below(small, small - large, small);
        let under = bound.below(small, small + large, large);
        let shift = bound.below(small, Self::all(FRAC_PI_4), Self::zero());
        let t = over / under;
        let z = t * t;
        let mut p = Self::all(P[0]);
        let mut q = z + Self::all(Q[0]);
        for k in 1..5 {
            p = p * z + Self::all(P[k]);
            q = q * z + Self::all(Q[k]);
        }
        let angle = shift + (t + t * (z * p / q));
        let angle = ax.below(ay, Self::all(FRAC_PI_2) - angle, angle);
        let angle = x.below(Self::zero(), Self::all(PI) - angle, angle);
        angle.copysign(y)
    }
}

impl SimdF64 for F64x8 {
    #[inline(always)]
    fn load_from(numbers: &[f64; LANES]) -> Self {
        Self(*numbers)
    }

    #[inline(always)]
    fn load_split(low: &[f64; HALF], high: &[f64; HALF]) -> Self {
        let mut out = [0.0; LANES];
        out[..HALF].copy_from_slice(low);
        out[HALF..].copy_from_slice(high);
        Self(out)
    }

    #[inline(always)]
    fn of_rows(rows: [&[f64; HALF]; LANES]) -> [Self; HALF] {
        let mut columns = [Self::ZERO; HALF];
        for lane in 0..LANES {
            for k in 0..HALF {
                columns[k].0[lane] = rows[lane][k];
            }
        }
        columns
    }

    #[inline(always)]
    fn add_low_to(self, place: &mut [f64; HALF]) {
        for i in 0..HALF {
            place[i] += self.0[i];
        }
    }

    #[inline(always)]
    fn add_high_to(self, place: &mut [f64; HALF]) {
        for i in 0..HALF {
            place[i] += self.0[i + HALF];
        }
    }

    #[inline(always)]
    fn lanes(self) -> F64x8 {
        self
    }

    #[inline(always)]
    fn all(value: f64) -> Self {
        Self([value; LANES])
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        let mut out = [0.0; LANES];
        for i in 0..LANES {
            out[i] = self.0[i].sqrt();
        }
        Self(out)
    }

    #[inline(always)]
    fn abs(self) -> Self {
        let mut out = [0.0; LANES];
        for i in 0..LANES {
            out[i] = self.0[i].abs();
        }
        Self(out)
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        let mut out = [0.0; LANES];
        for i in 0..LANES {
            out[i] = if self.0[i] > other.0[i] { self.0[i] } else { other.0[i] };
        }
        Self(out)
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        let mut out = [0.0; LANES];
        for i in 0..LANES {
            out[i] = if self.0[i] < other.0[i] { self.0[i] } else { other.0[i] };
        }
        Self(out)
    }

    #[inline(always)]
    fn below(self, bound: Self, yes: Self, no: Self) -> Self {
        let mut out = [0.0; LANES];
        for i in 0..LANES {
            out[i] = if self.0[i] < bound.0[i] { yes.0[i] } else { no.0[i] };
        }
        Self(out)
    }

    #[inline(always)]
    fn copysign(self, sign: Self) -> Self {
        let mut out = [0.0; LANES];
        for i in 0..LANES {
            out[i] = self.0[i].copysign(sign.0[i]);
        }
        Self(out)
    }
}

/// a - b
#[inline(always)]
pub fn sub<V: SimdF64>(a: Vec3<V>, b: Vec3<V>) -> Vec3<V> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// a + b
#[inline(always)]
pub fn sum<V: SimdF64>(a: Vec3<V>, b: Vec3<V>) -> Vec3<V> {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// a . b
#[inline(always)]
pub fn dot<V: SimdF64>(a: Vec3<V>, b: Vec3<V>) -> V {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// a x b
#[inline(always)]
pub fn cross<V: SimdF64>(a: Vec3<V>, b: Vec3<V>) -> Vec3<V> {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// s a
#[inline(always)]
pub fn scale<V: SimdF64>(s: V, a: Vec3<V>) -> Vec3<V> {
    [s * a[0], s * a[1], s * a[2]]
}

/// -a
#[inline(always)]
pub fn negate<V: SimdF64>(a: Vec3<V>) -> Vec3<V> {
    [-a[0], -a[1], -a[2]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::dispatch::{InstructionSet, Kernel};

    #[test]
    fn atan2_agrees_with_the_standard_library_at_every_angle() {
        let mut worst = 0.0_f64;
        for k in 0..20_000 {
            let angle = (k as f64 / 20_000.0 - 0.5) * std::f64::consts::TAU;
            let radius = 10.0_f64.powi(k % 21 - 10);
            let (y, x) = (radius * angle.sin(), radius * angle.cos());
            let ours = F64x8::atan2(F64x8::all(y), F64x8::all(x)).0[k as usize % 8];
            worst = worst.max((ours - y.atan2(x)).abs());
        }
        assert!(worst < 5e-16, "{worst:e}");
    }

    /// Lanes of the columns of eight rows.
    struct Columns([[f64; HALF]; LANES]);

    impl Kernel for Columns {
        type Output = [[f64; LANES]; HALF];

        #[inline(always)]
        fn sweep<V: SimdF64>(self) -> Self::Output {
            let [a, b, c, d] = V::of_rows(self.0.each_ref());
            [a.lanes().0, b.lanes().0, c.lanes().0, d.lanes().0]
        }
    }

    #[test]
    fn columns_are_those_of_their_rows_at_every_width() {
        let rows = std::array::from_fn(|lane| std::array::from_fn(|k| (10 * lane + k) as f64));
        let columns = std::array::from_fn(|k| std::array::from_fn(|lane| (10 * lane + k) as f64));
        for instructions in InstructionSet::ALL {
            assert_eq!(instructions.dispatch(Columns(rows)), columns, "{instructions:?}");
        }
    }

    #[test]
    fn atan2_holds_on_the_axes_and_at_the_origin() {
        for (y, x) in [(0.0, 1.0), (0.0, -1.0), (1.0, 0.0), (-1.0, 0.0), (0.0, 0.0), (1e-300, -1e-300)] {
            let ours = F64x8::atan2(F64x8::all(y), F64x8::all(x)).0[0];
            assert!((ours - f64::atan2(y, x)).abs() < 5e-16, "atan2({y}, {x}) = {ours}");
        }
    }
}
