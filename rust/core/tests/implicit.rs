//! Methods without a limit of the step: steps far beyond the explicit limit, counts, and failure of Newton's method.
#![allow(missing_docs, clippy::unwrap_used)]

mod common;

use common::{Dice, every_law_with, films, sheet};
use membrane_core::integrators::{Integrator, Options, SPECTRAL_RADIUS, Statistics, by_name};
use membrane_core::laws::LawSpec;
use membrane_core::model::input::{Cord, Model};
use membrane_core::simulation::{Settings, Simulation};

const NAME: &str = "generalized_alpha";

fn without_monitor() -> Settings {
    Settings { check_interval: u64::MAX, ..Settings::default() }
}

fn method(spectral_radius: f64) -> Box<dyn Integrator> {
    (by_name(NAME).unwrap().make)(&Options { spectral_radius, ..Options::default() })
}

/// A mass of 1 kg between two stretched cords, omega = 1 rad/s along them, `offset` \[m\] from equilibrium.
fn oscillator(offset: f64) -> Model {
    let cord = |nodes| Cord { nodes, stiffness: 0.5, rest_length: 1.0, strain_limit: 10.0, ..Default::default() };
    Model {
        positions: vec![[0.0; 3], [2.0 + offset, 0.0, 0.0], [4.0, 0.0, 0.0]],
        velocities: vec![[0.0; 3]; 3],
        extra_masses: vec![1.0; 3],
        fixed: vec![0, 2],
        cords: vec![cord([0, 1]), cord([1, 2])],
        ..Model::default()
    }
}

#[test]
fn amplification_is_at_most_one_and_tends_to_the_spectral_radius() {
    for radius in [0.0, 0.3, SPECTRAL_RADIUS, 1.0] {
        let method = method(radius);
        for k in -20..=16 {
            let omega = 10.0_f64.powf(0.25 * f64::from(k));
            for ratio in [0.0, 0.02, 1.0, 50.0] {
                let amplification = method.amplification(omega, 2.0 * ratio * omega, 1.0);
                // A triple root has the cube root of the rounding error.
                assert!(amplification <= 1.0 + 1e-5, "radius {radius}, omega {omega}, ratio {ratio}: {amplification}");
            }
        }
        let last = method.amplification(1e4, 0.0, 1.0);
        assert!((last - radius).abs() < 1e-2, "{last} {radius}");
    }
}

#[test]
fn a_step_amplifies_an_oscillation_by_the_stated_factor() {
    let settings = |spectral_radius| Settings { spectral_radius, ..without_monitor() };
    for (radius, dt, steps) in [(0.8, 0.5, 200), (0.3, 0.5, 100), (0.8, 30.0, 60), (1.0, 30.0, 60)] {
        let mut simulation = Simulation::new(oscillator(0.3), &[], NAME, Some(dt), settings(radius)).unwrap();
        let method = method(radius);
        let energy = |simulation: &Simulation| simulation.energy_terms().total() - 0.5;
        simulation.step(20).unwrap();
        let before = energy(&simulation);
        simulation.step(steps).unwrap();
        let per_step = (energy(&simulation) / before).powf(0.5 / steps as f64);
        let expected = method.amplification(1.0, 0.0, dt);
        assert!((per_step - expected).abs() < 0.02 * (1.0 - expected) + 2e-3, "{radius} {dt}: {per_step} {expected}");
    }
    for radius in [-0.1, 1.1, f64::NAN] {
        let error = Simulation::new(oscillator(0.3), &[], NAME, Some(0.1), settings(radius)).map(|_| ()).unwrap_err();
        assert!(error.to_string().contains("spectral radius"), "{error}");
    }
}

#[test]
fn a_linear_step_takes_one_correction_and_one_factor() {
    let mut simulation = Simulation::new(oscillator(0.3), &[], NAME, Some(0.1), without_monitor()).unwrap();
    assert_eq!(simulation.limit().unwrap().dt, f64::INFINITY);
    simulation.step(50).unwrap();
    let expected = Statistics { iterations: 50, factorisations: 50, fallbacks: 0 };
    assert_eq!(simulation.integrator().implicit().unwrap().statistics(), expected);
    assert_eq!(simulation.evaluation_count(), 101);
    // The default step resolves the vibration, which is all the motion, to 1e-3 of its frequency.
    let simulation = Simulation::new(oscillator(0.3), &[], NAME, None, without_monitor()).unwrap();
    let (error, exponent) = simulation.integrator().properties().frequency_error;
    let found = error * simulation.dt().powi(i32::from(exponent));
    assert!(found <= 1e-3 && found > 0.9e-3, "{found:e} at {} s", simulation.dt());
}

/// A sheet of this film with random displacements, every law, and one side held.
fn disturbed(film: LawSpec, seed: u64) -> (Model, Vec<LawSpec>) {
    let mut model = sheet(4, 3, 0.01);
    let mut dice = Dice(seed);
    for (point, kick) in model.positions.iter_mut().zip(dice.vectors(100, 2e-4)) {
        (0..3).for_each(|axis| point[axis] += kick[axis]);
        // Above the middle of the spool, in which it would be too deep.
        point[2] += 0.015;
    }
    model.fixed = vec![0, 1, 2, 3, 4];
    (model, every_law_with(film))
}

#[test]
fn every_law_at_once_converges_to_the_motion_of_an_explicit_method_at_order_two() {
    for film in films() {
        let name = film.kind();
        let (model, laws) = disturbed(film, 3);
        let end = |method: &str, steps: u64| {
            let dt = 4e-5 / steps as f64;
            let mut simulation = Simulation::new(model.clone(), &laws, method, Some(dt), without_monitor()).unwrap();
            simulation.step(steps).unwrap();
            (simulation.positions(), simulation.ledger().error(&simulation.energy_terms()))
        };
        let exact = end("rk4", 4000).0;
        let error = |steps: u64| {
            let found = end(NAME, steps);
            let squares = found.0.iter().flatten().zip(exact.iter().flatten()).map(|(a, b)| (a - b).powi(2));
            (squares.sum::<f64>().sqrt(), found.1.abs())
        };
        let [coarse, fine] = [250, 1000].map(error);
        // A step of a quarter; springs buckle during the motion.
        let order = 0.5 * (coarse.0 / fine.0).log2();
        assert!((1.7..2.3).contains(&order), "{name}: order {order}, {:e}", fine.0);
        assert!(fine.1 < 1e-3 && fine.1 < 0.2 * coarse.1 + 1e-6, "{name}: balance {:e} {:e}", coarse.1, fine.1);
    }
}

#[test]
fn runs_are_the_same_to_the_last_bit_whole_or_in_pieces_with_every_law() {
    for film in films() {
        let name = film.kind();
        let (model, laws) = disturbed(film, 5);
        let new = || Simulation::new(model.clone(), &laws, NAME, Some(2e-5), without_monitor()).unwrap();
        let (mut whole, mut first, mut second) = (new(), new(), new());
        whole.step(60).unwrap();
        first.step(23).unwrap();
        second.resume(&first.progress()).unwrap();
        second.step(37).unwrap();
        assert_eq!(whole.progress(), second.progress(), "{name}");
        assert!(whole.integrator().implicit().unwrap().statistics().iterations > 60, "{name}");
    }
}

#[test]
fn a_step_without_solution_is_described_with_time_place_law_and_remedy() {
    let mut model = oscillator(0.0);
    // Forces that overflow: no step is small enough.
    model.velocities[1] = [1e200, 0.0, 0.0];
    let mut hopeless = Simulation::new(model, &[], NAME, Some(0.05), without_monitor()).unwrap();
    let text = hopeless.step(1).unwrap_err().to_string();
    for word in ["t = ", "Newton's method finds no step", "node ", "tethers", "smaller dt"] {
        assert!(text.contains(word), "{text}");
    }
    assert!(hopeless.positions().iter().flatten().all(|value| value.is_finite()));
    assert_eq!(hopeless.integrator().implicit().unwrap().statistics().fallbacks, 10);
}
