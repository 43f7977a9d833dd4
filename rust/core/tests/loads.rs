//! A load that depends on positions alone and has no potential: order of each method, its work, and its balance.
#![allow(missing_docs, clippy::unwrap_used)]

mod common;

use common::toys::Circulation;
use common::{methods, simulation_of};
use membrane_core::assembly::Assembly;
use membrane_core::integrators::{Method, Options};
use membrane_core::laws::Law;
use membrane_core::model::input::{Bridges, Model};
use membrane_core::simulation::{Settings, Simulation};

/// c of the load [1/s2].
const RATE: f64 = 0.2;

/// A mass of 1 kg on a linear spring of 1 N/m to the held origin, 1 m from it along x, with this velocity along y: with
/// the load, z = x + i y obeys z'' = (-1 + i c) z.
fn oscillator(speed: f64) -> Model {
    Model {
        positions: vec![[0.0; 3], [1.0, 0.0, 0.0]],
        velocities: vec![[0.0; 3], [0.0, speed, 0.0]],
        extra_masses: vec![1.0; 2],
        fixed: vec![0],
        bridges: Bridges { nodes: vec![[0, 1]], stiffness: 1.0 },
        ..Model::default()
    }
}

fn simulation(
    model: Model,
    method: Method,
    dt: f64,
    settings: Settings,
    load: fn(&Assembly) -> Vec<Box<dyn Law>>,
) -> Simulation {
    simulation_of(model, &[], method, Some(dt), settings, load)
}

fn driving(assembly: &Assembly) -> Vec<Box<dyn Law>> {
    vec![Box::new(Circulation::new(assembly, RATE, 1.0))]
}

fn braking(assembly: &Assembly) -> Vec<Box<dyn Law>> {
    vec![Box::new(Circulation::new(assembly, -0.1 * RATE, 1.0))]
}

/// The same, with 3 % too much negative work in the balance.
fn braking_at_fault(assembly: &Assembly) -> Vec<Box<dyn Law>> {
    vec![Box::new(Circulation::new(assembly, -0.1 * RATE, 1.03))]
}

/// The exact position from rest, cosh(w t) with w^2 = -1 + i c.
fn exact(time: f64) -> [f64; 2] {
    let size = RATE.hypot(1.0);
    let [re, im] = [((size - 1.0) / 2.0).sqrt() * time, ((size + 1.0) / 2.0).sqrt() * time];
    [re.cosh() * im.cos(), re.sinh() * im.sin()]
}

#[test]
fn each_method_has_its_order_and_its_evaluations() {
    for method in methods() {
        let error = |steps: u64| {
            let (dt, settings) = (10.0 / steps as f64, Settings { check_interval: u64::MAX, ..Settings::default() });
            let mut simulation = simulation(oscillator(0.0), method, dt, settings, driving);
            simulation.step(steps).unwrap();
            let properties = simulation.integrator().properties();
            let expected =
                steps * u64::from(properties.evaluations_per_step) + u64::from(properties.evaluations_at_start);
            // Newton's method of an implicit step takes the symmetric part of the Jacobian, and so more iterations.
            assert!(properties.is_implicit || simulation.evaluation_count() == expected, "{}", method.name);
            let ([x, y, _], [exact_x, exact_y]) = (simulation.positions()[1], exact(10.0));
            ((x - exact_x).hypot(y - exact_y), f64::from(properties.order))
        };
        let ((coarse, order), (fine, _)) = (error(200), error(400));
        let measured = (coarse / fine).log2();
        assert!((measured - order).abs() < 0.15, "{}: measured order {measured}", method.name);
    }
}

#[test]
fn its_work_closes_the_balance_at_the_order_of_each_method() {
    for method in methods() {
        // The work over the same time, and the error of the balance.
        let run = |steps: u64| {
            let mut simulation = simulation(oscillator(1.0), method, 10.0 / steps as f64, Settings::default(), driving);
            simulation.step(steps).unwrap();
            let error = simulation.ledger().error(&simulation.energy_terms()).abs();
            (simulation.ledger().work[1], error, simulation.integrator().properties().order)
        };
        let ((work, coarse, order), (_, fine, _)) = (run(1000), run(2000));
        assert!(work > 1.0, "{}: {work}", method.name);
        let converges = fine < 0.7 * 2.0_f64.powi(1 - order.min(2) as i32) * coarse || fine < 1e-9;
        assert!(fine < 5e-3 && converges, "{}: {coarse:e} {fine:e}", method.name);
    }
}

#[test]
fn its_negative_work_is_no_dissipation_that_hides_a_gain() {
    // Of an implicit method both tolerances bound a gain, and the first-order method of the tests errs by more.
    let settings = Settings { loss_tolerance: 1.0, ..Settings::default() };
    let is_bounded = |method: &Method| {
        let properties = (method.make)(&Options::default()).properties();
        !properties.is_implicit && properties.order > 1
    };
    for method in methods().filter(is_bounded) {
        let run = |load| {
            let mut simulation = simulation(oscillator(1.0), method, 0.01, settings, load);
            let result = simulation.step(6400);
            (result, simulation.ledger().work[1])
        };
        let (result, work) = run(braking);
        assert!(result.is_ok() && work < -0.5, "{}: {work} {result:?}", method.name);
        let text = run(braking_at_fault).0.unwrap_err().to_string();
        assert!(text.contains("a spurious gain of"), "{}: {text}", method.name);
    }
}
