//! Velocities relative to the air, of nodes with velocities in a moving frame.

use crate::simd::lanes::{SimdF64, Vec3, cross, sum};
use crate::simd::map::Formula;

/// The velocity relative to the air, normal to the axis, of nodes at (x, y) with the velocity (u, v) in the frame.
#[inline(always)]
pub(super) fn about_axis<V: SimdF64>([x, y]: [V; 2], [u, v]: [V; 2], rate: V) -> [V; 2] {
    [u - rate * y, v + rate * x]
}

/// The velocities relative to the air in a frame that turns about the axis.
pub(super) struct AboutAxis {
    pub(super) rate: f64,
}

impl Formula<4, 2> for AboutAxis {
    #[inline(always)]
    fn row<V: SimdF64>(&self, [x, y, u, v]: [V; 4], _: [V; 2]) -> [V; 2] {
        about_axis([x, y], [u, v], V::all(self.rate))
    }
}

/// A frame with these rates [rad/s] and the velocity of its origin [m/s], and the velocities relative to the air in it.
pub(super) struct Carried {
    pub(super) rates: [f64; 3],
    pub(super) velocity: [f64; 3],
}

impl Carried {
    /// v + omega x r + V_0.
    #[inline(always)]
    pub(super) fn wind<V: SimdF64>(&self, r: Vec3<V>, v: Vec3<V>) -> Vec3<V> {
        sum(v, sum(cross(self.rates.map(V::all), r), self.velocity.map(V::all)))
    }
}

impl Formula<6, 3> for Carried {
    #[inline(always)]
    fn row<V: SimdF64>(&self, [x, y, z, u, v, w]: [V; 6], _: [V; 3]) -> [V; 3] {
        self.wind([x, y, z], [u, v, w])
    }
}
