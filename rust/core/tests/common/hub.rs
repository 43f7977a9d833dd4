//! Free hubs, and the momentum of the whole.
#![allow(dead_code, unreachable_pub)]

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

/// Momentum of the nodes and of a hub in six degrees of freedom in space \[kg m/s\].
pub fn linear(simulation: &Simulation, mass: f64) -> Vector3<f64> {
    let [_, w, x, y, z, _, _, _, wx, wy, wz, u, v, s] = simulation.hub_state();
    let (rates, origin) = (Vector3::new(wx, wy, wz), Vector3::new(u, v, s));
    let (masses, positions) = (simulation.masses(), simulation.positions());
    let of_node = |node: usize| {
        masses[node]
            * (Vector3::from(simulation.velocities()[node]) + rates.cross(&Vector3::from(positions[node])) + origin)
    };
    let sum = mass * origin + (0..masses.len()).map(of_node).sum::<Vector3<f64>>();
    UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z)) * sum
}
