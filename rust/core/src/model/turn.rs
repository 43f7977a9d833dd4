//! Rotations of a rigid body in a step.

use nalgebra::{Matrix3, Quaternion, Unit, Vector3};

/// A rotation D from components after a turn to those before, as D - 1: so that small turns, of which a run has many
/// alike, have no rounding of the size of 1.
#[derive(Debug, Clone, Copy)]
pub struct Turn {
    /// D - 1.
    pub excess: Matrix3<f64>,
    /// Its quaternion.
    pub quaternion: Quaternion<f64>,
}

impl Turn {
    /// No turn.
    pub fn none() -> Self {
        Self { excess: Matrix3::zeros(), quaternion: Quaternion::identity() }
    }

    /// By an angle \[rad\] about an axis: D - 1 = sin K + 2 sin^2(half) K^2, by Rodrigues.
    pub fn about(axis: Vector3<f64>, angle: f64) -> Self {
        let Some(axis) = Unit::try_new(axis, 0.0) else { return Self::none() };
        let (across, half) = (axis.cross_matrix(), (0.5 * angle).sin());
        Self {
            excess: across * angle.sin() + across * across * (2.0 * half * half),
            quaternion: Quaternion::from_parts((0.5 * angle).cos(), axis.into_inner() * half),
        }
    }

    /// This turn, then another one about axes that have turned.
    pub fn then(&self, other: &Self) -> Self {
        let excess = self.excess + other.excess + self.excess * other.excess;
        Self { excess, quaternion: self.quaternion * other.quaternion }
    }

    /// A vector in components after the turn.
    pub fn back(&self, vector: Vector3<f64>) -> Vector3<f64> {
        vector + self.excess.transpose() * vector
    }
}
