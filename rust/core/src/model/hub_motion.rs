//! The motion of a hub, and its numbers for histories and stages.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};

/// Motion of the hub.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HubMotion {
    /// Integral of the rate about its axis since it began to turn \[rad\].
    pub angle: f64,
    /// From components of the hub to those in space; of a hub on its axis not kept, see `Hub::attitude`.
    pub attitude: Quaternion<f64>,
    /// Displacement of its centre of mass in space \[m\].
    pub centre: Vector3<f64>,
    /// Rates less those at the start, so that a heavy hub keeps small changes \[rad/s\].
    pub change: Vector3<f64>,
    /// Velocity of its centre of mass \[m/s\].
    pub velocity: Vector3<f64>,
}

impl Default for HubMotion {
    fn default() -> Self {
        let none = Vector3::zeros();
        Self { angle: 0.0, attitude: Quaternion::identity(), centre: none, change: none, velocity: none }
    }
}

/// Number of numbers of a motion.
pub const NUMBERS: usize = 14;

/// The motion of a driven hub at an angle \[rad\] and a rate \[rad/s\], with its rates as changes.
pub fn driven(angle: f64, rate: f64) -> HubMotion {
    let attitude = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle).into_inner();
    HubMotion { angle, attitude, change: Vector3::new(0.0, 0.0, rate), ..HubMotion::default() }
}

impl HubMotion {
    /// As numbers, for a history or the stages of a method.
    pub fn numbers(&self) -> [f64; NUMBERS] {
        let Self { angle, attitude: q, centre: c, change: w, velocity: v } = self;
        [*angle, q.w, q.i, q.j, q.k, c.x, c.y, c.z, w.x, w.y, w.z, v.x, v.y, v.z]
    }

    /// From such numbers; `None` where there are others, or one is not finite.
    pub fn from_numbers(numbers: &[f64]) -> Option<Self> {
        let &[angle, w, i, j, k, cx, cy, cz, wx, wy, wz, vx, vy, vz] = numbers else { return None };
        numbers.iter().all(|number| number.is_finite()).then(|| Self {
            angle,
            attitude: Quaternion::new(w, i, j, k),
            centre: Vector3::new(cx, cy, cz),
            change: Vector3::new(wx, wy, wz),
            velocity: Vector3::new(vx, vy, vz),
        })
    }
}
