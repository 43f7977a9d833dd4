//! The default step: accurate for the slow motion and for the response to the loads, at any spin and with few elements.
#![allow(missing_docs, clippy::unwrap_used)]

mod common;

use std::f64::consts::PI;

use common::{methods, simulation_of};
use membrane_core::integrators::METHODS;
use membrane_core::laws::LawSpec;
use membrane_core::model::input::{Cord, Model};
use membrane_core::simulation::{Settings, Simulation};

/// Masses of 1 kg on a cord along x from a held node, at their lengths without load.
fn chain(masses: u32, stiffness: f64) -> Model {
    let count = masses as usize + 1;
    Model {
        positions: (0..count).map(|i| [1.0 + i as f64, 0.0, 0.0]).collect(),
        velocities: vec![[0.0; 3]; count],
        extra_masses: vec![1.0; count],
        fixed: vec![0],
        cords: (0..masses)
            .map(|i| Cord { nodes: [i, i + 1], stiffness, rest_length: 1.0, strain_limit: 1e9, ..Default::default() })
            .collect(),
        ..Model::default()
    }
}

#[test]
fn each_method_has_its_stated_frequency_error() {
    let (dt, steps) = (0.2, 10_000);
    for method in methods() {
        // One mass between two held nodes, omega = 1.
        let mut model = chain(2, 0.5);
        model.fixed.push(2);
        model.positions.iter_mut().for_each(|p| p[0] *= 2.0);
        model.positions[1][0] += 0.3;
        let settings = Settings { check_interval: u64::MAX, ..Settings::default() };
        let mut simulation = simulation_of(model, &[], method, Some(dt), settings, |_| Vec::new());
        simulation.step(steps).unwrap();
        let (c, exponent) = simulation.integrator().properties().frequency_error;
        let phase = (-simulation.velocities()[1][0]).atan2(simulation.positions()[1][0] - 4.0);
        let expected = c * dt.powi(i32::from(exponent)) * simulation.time();
        let turns = (simulation.time() - phase).abs() - expected;
        let difference = (turns + PI).rem_euclid(2.0 * PI) - PI;
        let other_sign = (simulation.time() - phase + expected + PI).rem_euclid(2.0 * PI) - PI;
        let apart = difference.abs().min(other_sign.abs());
        assert!(apart < 0.06 * expected, "{}: {apart:e} of {expected:e}", method.name);
    }
}

fn default_dt(model: Model, laws: &[LawSpec], name: &str) -> (f64, Simulation) {
    let simulation = Simulation::new(model, laws, name, None, Settings::default()).unwrap();
    (simulation.dt(), simulation)
}

#[test]
fn a_fast_spin_and_a_load_bound_the_step_of_a_stiff_scene_too() {
    for method in METHODS.iter().filter(|method| method.name != "dopri5") {
        let at = |rate: f64, gravity: f64, stiffness: f64| {
            let laws = [common::spin(rate, 0.0), common::gravity([0.0, 0.0, -gravity])];
            default_dt(chain(10, stiffness), &laws, method.name)
        };
        let (error, exponent) = at(1.0, 0.0, 1e6).1.integrator().properties().frequency_error;
        let allowed = if method.name == "generalized_alpha" { 1e-5 } else { 5e-7 };
        for (rate, gravity) in [(300.0, 0.0), (0.0, 3e5)] {
            // The load turns the cord at 173 rad/s, which is 3e5 m/s2 over 10 m, to the power 1/2.
            let slow = f64::max(2.0 * rate, (gravity / 10.0_f64).sqrt());
            let (dt, _) = at(rate, gravity, 1e6);
            let found = error * (slow * dt).powi(i32::from(exponent));
            assert!(found <= 1.001 * allowed, "{}: {found:e}", method.name);
        }
        // Slow, it is the limit that counts.
        assert!(at(1e-3, 0.0, 1e6).0 > 5.0 * at(300.0, 0.0, 1e6).0 || method.name == "rk4", "{}", method.name);
    }
}

#[test]
fn the_vibration_of_few_elements_is_resolved_where_it_is_the_motion() {
    // One mass on one cord that its spin stretches: it vibrates at sqrt(k/m) = 1000 rad/s, the largest frequency too.
    for method in METHODS.iter().filter(|method| method.name != "dopri5") {
        let (dt, simulation) = default_dt(chain(1, 1e6), &[common::spin(6.0, 0.0)], method.name);
        let (error, exponent) = simulation.integrator().properties().frequency_error;
        let allowed = if method.name == "generalized_alpha" { 1e-3 } else { 5e-5 };
        let found = error * (1e3 * dt).powi(i32::from(exponent));
        assert!(found <= 1.01 * allowed && found > 0.5 * allowed, "{}: {found:e}", method.name);
    }
}

#[test]
fn few_nodes_that_no_load_strains_are_resolved_at_their_largest_frequency() {
    for method in METHODS.iter().filter(|method| method.name != "dopri5") {
        let resolved = |model: Model, laws: &[LawSpec]| {
            let (dt, simulation) = default_dt(model, laws, method.name);
            let (error, exponent) = simulation.integrator().properties().frequency_error;
            let allowed = if method.name == "generalized_alpha" { 1e-3 } else { 5e-5 };
            let largest = simulation.limit().unwrap().largest_frequency;
            error * (largest * dt).powi(i32::from(exponent)) / allowed
        };
        let across = common::gravity([0.0, 0.0, -9.81]);
        // Long steps are what an implicit method is chosen for.
        let most = if method.name == "generalized_alpha" { 1 } else { 60 };
        for masses in [1, 5, 60].into_iter().filter(|masses| *masses <= most) {
            let loads = [&[][..], std::slice::from_ref(&across)];
            for laws in &loads[..if masses > 1 { 1 } else { 2 }] {
                let found = resolved(chain(masses, 1e6), laws);
                assert!(found <= 1.01 && found > 0.5, "{}, {masses} masses: {found:e}", method.name);
            }
        }
        // Many nodes: the motion is slower than their vibrations.
        assert!(resolved(chain(most + 1, 1e6), &[]) > 10.0, "{}", method.name);
    }
}
