//! A force and its torque.

use std::ops::AddAssign;

use nalgebra::Vector3;

/// Force \[N\] and torque about a point \[N m\].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Load {
    /// Force \[N\].
    pub force: Vector3<f64>,
    /// Torque about the point \[N m\].
    pub torque: Vector3<f64>,
}

impl Load {
    /// That of a force \[N\] at a place from the point \[m\].
    pub fn at(place: Vector3<f64>, force: Vector3<f64>) -> Self {
        Self { force, torque: place.cross(&force) }
    }

    /// The same about another point, which lies at `place` from the first one \[m\].
    pub fn about(&self, place: &Vector3<f64>) -> Self {
        Self { torque: self.torque - place.cross(&self.force), ..*self }
    }

    /// Its power on a body that turns at these rates \[rad/s\], with this velocity of the point \[m/s\].
    pub fn power(&self, rates: &Vector3<f64>, velocity: &Vector3<f64>) -> f64 {
        rates.dot(&self.torque) + velocity.dot(&self.force)
    }
}

impl AddAssign for Load {
    fn add_assign(&mut self, other: Self) {
        self.force += other.force;
        self.torque += other.torque;
    }
}
