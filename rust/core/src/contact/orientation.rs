//! On which side of a plane, or of a line in a plane, a node lies: the exact sign of a determinant.
//!
//! The sign is that of the real number that the coordinates give, doubles being rational, never that of a rounded one:
//! Shewchuk, Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates, Discrete and
//! Computational Geometry 18 (1997), in the crate `robust`. His arithmetic neither overflows nor underflows where
//! coordinates are 0 or from 2^-142 to 2^201 in magnitude. So all are scaled by one power of two, the largest to about
//! 2^200; determinants with a coordinate that is then too small, 1e103 times below the largest, are whole numbers of
//! any length.

use num_bigint::{BigInt, Sign};
use robust::{Coord, Coord3D, orient2d, orient3d};

/// Binary exponent of the largest coordinate, and the least of any other, in Shewchuk's range.
const LARGEST_EXPONENT: i32 = 200;
const LEAST_EXPONENT: i32 = -142;

/// Points whose orientation is asked for.
pub(super) struct Points {
    /// Times a power of two; coordinates that underflow are not exact.
    scaled: Vec<[f64; 3]>,
    /// As given.
    given: Vec<[f64; 3]>,
    /// Whether a coordinate is too small for the predicates in doubles.
    is_small: Vec<bool>,
}

impl Points {
    /// Points with finite coordinates.
    pub(super) fn new(given: &[[f64; 3]]) -> Self {
        let largest = given.iter().flatten().fold(0.0, |largest: f64, value| largest.max(value.abs()));
        let shift = LARGEST_EXPONENT - exponent(largest);
        let scaled: Vec<[f64; 3]> = given.iter().map(|point| point.map(|value| times_power(value, shift))).collect();
        let is_small =
            |point: &[f64; 3]| point.iter().any(|&value| value != 0.0 && exponent(value) + shift < LEAST_EXPONENT);
        Self { scaled, is_small: given.iter().map(is_small).collect(), given: given.to_vec() }
    }

    /// How many there are.
    pub(super) fn len(&self) -> usize {
        self.given.len()
    }

    /// The points in another order.
    pub(super) fn reordered(&self, order: &[u32]) -> Self {
        let order = order.iter().map(|&node| node as usize);
        Self {
            scaled: order.clone().map(|node| self.scaled[node]).collect(),
            given: order.clone().map(|node| self.given[node]).collect(),
            is_small: order.map(|node| self.is_small[node]).collect(),
        }
    }

    /// Coordinates times a power of two, which keeps their order.
    pub(super) fn scaled(&self, node: u32) -> [f64; 3] {
        self.scaled[node as usize]
    }

    /// Whether the orientation of a point is asked of whole numbers.
    pub(super) fn is_small(&self, node: u32) -> bool {
        self.is_small[node as usize]
    }

    /// Sign of the determinant of a - d, b - d, c - d: 1 where a, b, c run clockwise seen from d, 0 where the four lie
    /// in one plane.
    pub(super) fn side_of_plane(&self, [a, b, c]: [u32; 3], d: u32) -> i8 {
        if [a, b, c, d].into_iter().any(|node| self.is_small(node)) {
            let [a, b, c, d] = [a, b, c, d].map(|node| self.given[node as usize].map(whole));
            let [a, b, c] = [a, b, c].map(|point| difference(&point, &d));
            let cofactor = |i: usize, j: usize| &b[i] * &c[j] - &b[j] * &c[i];
            return sign_of(&(&a[0] * cofactor(1, 2) + &a[1] * cofactor(2, 0) + &a[2] * cofactor(0, 1)));
        }
        let [a, b, c, d] = [a, b, c, d].map(|node| {
            let [x, y, z] = self.scaled(node);
            Coord3D { x, y, z }
        });
        sign(orient3d(a, b, c, d))
    }

    /// Sign of the area of a, b, c along two of the axes: 1 where they run counter-clockwise.
    pub(super) fn turn(&self, [a, b, c]: [u32; 3], axes: [usize; 2]) -> i8 {
        if [a, b, c].into_iter().any(|node| self.is_small(node)) {
            let [a, b, c] = [a, b, c].map(|node| axes.map(|axis| whole(self.given[node as usize][axis])));
            let [a, b] = [a, b].map(|point| difference(&point, &c));
            return sign_of(&(&a[0] * &b[1] - &a[1] * &b[0]));
        }
        let [a, b, c] = [a, b, c].map(|node| {
            let [x, y] = axes.map(|axis| self.scaled(node)[axis]);
            Coord { x, y }
        });
        sign(orient2d(a, b, c))
    }
}

fn sign(value: f64) -> i8 {
    i8::from(value > 0.0) - i8::from(value < 0.0)
}

fn sign_of(value: &BigInt) -> i8 {
    match value.sign() {
        Sign::Minus => -1,
        Sign::NoSign => 0,
        Sign::Plus => 1,
    }
}

fn difference<const N: usize>(point: &[BigInt; N], origin: &[BigInt; N]) -> [BigInt; N] {
    std::array::from_fn(|k| &point[k] - &origin[k])
}

/// The mantissa and the exponent of 2 of a finite number, whose product it is; the exponent is at least -1074.
fn parts(value: f64) -> (i64, i32) {
    let bits = value.to_bits();
    let biased = ((bits >> 52) & 0x7ff) as i32;
    let fraction = (bits & ((1 << 52) - 1)) as i64;
    let mantissa = if biased == 0 { fraction } else { fraction | (1 << 52) };
    (if value.is_sign_negative() { -mantissa } else { mantissa }, biased.max(1) - 1075)
}

/// The whole number that is a finite number times 2^1074.
fn whole(value: f64) -> BigInt {
    let (mantissa, power) = parts(value);
    BigInt::from(mantissa) << (power + 1074) as u32
}

/// k for a magnitude from 2^k to 2^(k+1); 0 for 0.
fn exponent(value: f64) -> i32 {
    match parts(value) {
        (0, _) => 0,
        (mantissa, power) => power + mantissa.unsigned_abs().ilog2() as i32,
    }
}

/// A number times 2^shift, in steps that are doubles.
fn times_power(value: f64, shift: i32) -> f64 {
    let half = shift / 2;
    value * 2.0_f64.powi(half) * 2.0_f64.powi(shift - half)
}
