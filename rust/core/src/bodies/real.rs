//! Numbers with or without derivatives: a formula over `Real` gives its value with `f64`, and its exact derivatives
//! with `Jet` (forward differentiation).

use std::ops::{Add, Div, Mul, Neg, Sub};

/// A real number, or one with derivatives.
pub trait Real:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    /// A constant.
    fn of(value: f64) -> Self;
    /// The value without derivatives.
    fn value(self) -> f64;
    /// The square root.
    #[must_use]
    fn sqrt(self) -> Self;
}

impl Real for f64 {
    #[inline(always)]
    fn of(value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn value(self) -> f64 {
        self
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        self.sqrt()
    }
}

/// A number and its derivatives by N variables.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Jet<const N: usize> {
    /// The number.
    pub value: f64,
    /// Its derivatives.
    pub slope: [f64; N],
}

impl<const N: usize> Jet<N> {
    /// The variable of this number.
    pub fn variable(value: f64, number: usize) -> Self {
        Self { value, slope: std::array::from_fn(|k| f64::from(u8::from(k == number))) }
    }

    /// A function with this value and the derivatives `a` and `b` by its two arguments.
    #[inline(always)]
    fn chain(value: f64, a: f64, left: Self, b: f64, right: Self) -> Self {
        Self { value, slope: std::array::from_fn(|k| a * left.slope[k] + b * right.slope[k]) }
    }
}

impl<const N: usize> Add for Jet<N> {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self::chain(self.value + other.value, 1.0, self, 1.0, other)
    }
}

impl<const N: usize> Sub for Jet<N> {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self::chain(self.value - other.value, 1.0, self, -1.0, other)
    }
}

impl<const N: usize> Mul for Jet<N> {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        Self::chain(self.value * other.value, other.value, self, self.value, other)
    }
}

impl<const N: usize> Div for Jet<N> {
    type Output = Self;

    fn div(self, other: Self) -> Self {
        let value = self.value / other.value;
        Self::chain(value, 1.0 / other.value, self, -value / other.value, other)
    }
}

impl<const N: usize> Neg for Jet<N> {
    type Output = Self;

    fn neg(self) -> Self {
        Self { value: -self.value, slope: self.slope.map(|slope| -slope) }
    }
}

impl<const N: usize> Real for Jet<N> {
    fn of(value: f64) -> Self {
        Self { value, slope: [0.0; N] }
    }

    fn value(self) -> f64 {
        self.value
    }

    fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        // The derivative at 0, which has none, is left out: contacts there have no direction either.
        let slope = if root > 0.0 { 0.5 / root } else { 0.0 };
        Self { value: root, slope: self.slope.map(|own| slope * own) }
    }
}

/// A vector of three numbers.
pub type Vector<T> = [T; 3];

/// A constant vector.
#[inline(always)]
pub fn constant<T: Real>(a: [f64; 3]) -> Vector<T> {
    a.map(T::of)
}

/// a + b.
#[inline(always)]
pub fn sum<T: Real>(a: Vector<T>, b: Vector<T>) -> Vector<T> {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// a - b.
#[inline(always)]
pub fn difference<T: Real>(a: Vector<T>, b: Vector<T>) -> Vector<T> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// s a.
#[inline(always)]
pub fn scaled<T: Real>(s: T, a: Vector<T>) -> Vector<T> {
    a.map(|component| s * component)
}

/// a . b.
#[inline(always)]
pub fn product<T: Real>(a: Vector<T>, b: Vector<T>) -> T {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// a x b.
#[inline(always)]
pub fn cross<T: Real>(a: Vector<T>, b: Vector<T>) -> Vector<T> {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
