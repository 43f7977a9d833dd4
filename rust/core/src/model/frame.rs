//! The frame that turns with the hub about z: its prescribed motion, and its state at an instant.

/// Prescribed rotation of the hub: Omega(t) = rate + acceleration t.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Spin {
    /// Omega at t = 0 \[rad/s\].
    pub rate: f64,
    /// Omega' \[rad/s2\].
    pub acceleration: f64,
}

/// State of the frame at an instant.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Frame {
    /// Angle of rotation since t = 0 \[rad\].
    pub angle: f64,
    /// Omega \[rad/s\].
    pub rate: f64,
    /// Omega' \[rad/s2\].
    pub acceleration: f64,
}

impl Spin {
    /// The frame at `time` \[s\].
    #[inline]
    pub fn at(&self, time: f64) -> Frame {
        Frame {
            angle: (self.rate + 0.5 * self.acceleration * time) * time,
            rate: self.rate + self.acceleration * time,
            acceleration: self.acceleration,
        }
    }
}
