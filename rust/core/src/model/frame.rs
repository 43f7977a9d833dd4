//! The frame that turns with the hub about z: its motion as given, and where it is at an instant.

/// How the hub turns: Omega(t) = rate + acceleration t.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Spin {
    /// Omega at t = 0 \[rad/s\].
    pub rate: f64,
    /// Omega' \[rad/s2\].
    pub acceleration: f64,
}

/// The frame at one instant.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Frame {
    /// The angle that the hub has turned since t = 0 \[rad\].
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
