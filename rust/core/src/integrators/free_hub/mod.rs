//! Methods that move a free hub with the nodes.
//!
//! States have velocities v relative to the frame of the hub, with the rates omega and the velocity V of the origin:
//!
//!     u = v + omega x r + V        in space, with components along the axes of the hub      \[m/s\]

pub(super) mod leapfrog;
pub(super) mod rk4;

use nalgebra::{Matrix3, Vector3};

use crate::simd::lanes::SimdF64;

/// r -> W r + w, for numbers of eight nodes.
#[derive(Clone, Copy)]
struct Affine {
    matrix: Matrix3<f64>,
    offset: Vector3<f64>,
}

impl Affine {
    /// The velocity of a frame, as a function of r.
    fn carried(rates: &Vector3<f64>, velocity: &Vector3<f64>) -> Self {
        Self { matrix: rates.cross_matrix(), offset: *velocity }
    }

    /// The value, in a loop: a closure given to `map` is not inlined in the kernels of an instruction set, and each of
    /// its operations becomes a call.
    #[inline(always)]
    fn of<V: SimdF64>(&self, [x, y, z]: [V; 3]) -> [V; 3] {
        let (m, w) = (&self.matrix, &self.offset);
        let mut value = [V::zero(); 3];
        for k in 0..3 {
            value[k] = V::all(m[(k, 0)]) * x + V::all(m[(k, 1)]) * y + V::all(m[(k, 2)]) * z + V::all(w[k]);
        }
        value
    }
}
