//! Free hubs, and the momentum of the whole.
#![allow(unreachable_pub)]

use std::f64::consts::TAU;

use membrane_core::laws::SpinParameters;
use membrane_core::simulation::Simulation;
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

/// A hub that turns about its axis.
pub fn on_axis(rate: f64, inertia: f64) -> SpinParameters {
    SpinParameters { frequency: rate / TAU, inertia: Some(inertia), ..SpinParameters::default() }
}

/// A hub in six degrees of freedom.
pub fn body(rate: f64, mass: f64, [across, along]: [f64; 2]) -> SpinParameters {
    SpinParameters { mass: Some(mass), transverse_inertia: Some(across), ..on_axis(rate, along) }
}

/// Angular momentum of the whole in space \[kg m2/s\].
pub fn momentum(simulation: &Simulation) -> Vector3<f64> {
    let [hub, sail] = simulation.momenta();
    let ([w, x, y, z], _) = simulation.hub_pose();
    UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z)) * (hub + sail)
}
