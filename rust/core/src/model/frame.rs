//! The frame that turns with the hub: its motion, prescribed about z or that of a free hub, and its state at an
//! instant.

use std::f64::consts::TAU;
use std::sync::Arc;

use nalgebra::Vector3;

use super::hub::{BodyFrame, Hub, HubFrame};
use super::schedule::Schedule;

/// Prescribed rotation of the hub: Omega(t) = rate + acceleration t, or 2 pi times a schedule of the frequency; or a
/// free hub.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Spin {
    /// Omega at t = 0 \[rad/s\].
    pub rate: f64,
    /// Omega' \[rad/s2\].
    pub acceleration: f64,
    /// The frequency \[Hz\] as a function of time, in place of rate and acceleration.
    pub schedule: Option<Arc<Schedule>>,
    /// The time at which everything that depends on time is frozen \[s\]; `None`: time passes.
    pub frozen_at: Option<f64>,
    /// The first and the last time of the present interval between two jumps \[s\]; `None`: nothing jumps.
    pub interval: Option<[f64; 2]>,
    /// Angle at t = 0 \[rad\]: not 0 where the hub has turned at another rate before.
    pub phase: f64,
    /// A hub that nothing drives, in place of the prescribed rotation.
    pub hub: Option<Box<Hub>>,
}

/// State of the frame at an instant.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Frame {
    /// Angle of rotation since the hub began to turn \[rad\].
    pub angle: f64,
    /// Omega \[rad/s\].
    pub rate: f64,
    /// Omega' \[rad/s2\].
    pub acceleration: f64,
    /// Whether angle and Omega stay as they are, although Omega and Omega' are not zero.
    pub is_frozen: bool,
    /// What else there is to know of the frame of a free hub.
    pub hub: Option<HubFrame>,
}

impl Frame {
    /// d(angle)/dt \[rad/s\], by which directions fixed in inertial space turn in this frame.
    #[inline]
    pub fn angle_rate(&self) -> f64 {
        if self.is_frozen { 0.0 } else { self.rate }
    }

    /// How the hub stands in space, in six degrees of freedom.
    #[inline]
    pub fn body(&self) -> Option<&BodyFrame> {
        self.hub.as_ref().and_then(|hub| hub.body.as_ref())
    }

    /// Rates of this frame \[rad/s\], and the velocity of its origin in space \[m/s\].
    #[inline]
    pub fn carried(&self) -> (Vector3<f64>, Vector3<f64>) {
        let about_axis = (Vector3::new(0.0, 0.0, self.rate), Vector3::zeros());
        self.hub.as_ref().map_or(about_axis, |hub| (hub.rates, hub.velocity))
    }

    /// The components in this frame of a vector that is fixed in inertial space.
    #[inline]
    pub fn components_of(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        if let Some(body) = self.body() {
            return body.attitude.inverse_transform_vector(&Vector3::new(x, y, z)).into();
        }
        let (sine, cosine) = self.angle.sin_cos();
        [cosine * x + sine * y, cosine * y - sine * x, z]
    }
}

impl Spin {
    /// The time of the frame, and of all that depends on time, at `time` of the motion \[s\]: within the present
    /// interval between two jumps, so that no step sees what lies beyond them.
    #[inline]
    pub fn time_of(&self, time: f64) -> f64 {
        let time = self.frozen_at.unwrap_or(time);
        self.interval.map_or(time, |[first, last]| time.max(first).min(last))
    }

    /// The angle by which the hub turns from t = 0 to `time` \[rad\].
    #[inline]
    fn turned(&self, time: f64) -> f64 {
        if let Some(schedule) = &self.schedule {
            return TAU * (schedule.integral(time) - schedule.integral(0.0));
        }
        (self.rate + 0.5 * self.acceleration * time) * time
    }

    /// The same motion, at `angle` \[rad\] at `time` \[s\].
    #[must_use]
    pub fn through(self, time: f64, angle: f64) -> Self {
        Self { phase: angle - self.turned(time), ..self }
    }

    /// The frame at `time` \[s\].
    #[inline]
    pub fn at(&self, time: f64) -> Frame {
        if let Some(hub) = &self.hub {
            let (angle, frame) = (hub.motion.angle, hub.frame());
            return Frame { angle, rate: frame.rates.z, hub: Some(frame), ..Frame::default() };
        }
        let time = self.time_of(time);
        let (rate, acceleration) = match &self.schedule {
            Some(schedule) => (TAU * schedule.value(time), TAU * schedule.rate(time)),
            None => (self.rate + self.acceleration * time, self.acceleration),
        };
        Frame {
            angle: if self.phase == 0.0 { self.turned(time) } else { self.phase + self.turned(time) },
            rate,
            acceleration,
            is_frozen: self.frozen_at.is_some(),
            hub: None,
        }
    }

    /// A frame with the largest rate that the hub has by its schedule, for bounds; without one, or frozen, the same.
    #[must_use]
    pub fn fastest(&self, frame: Frame) -> Frame {
        match &self.schedule {
            Some(schedule) if !frame.is_frozen => Frame { rate: TAU * schedule.largest(), ..frame },
            _ => frame,
        }
    }
}
