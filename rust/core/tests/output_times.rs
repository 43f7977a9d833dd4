//! Output times between two steps: they change nothing of a run, and their states are those of the motion.
#![allow(missing_docs, clippy::unwrap_used)]

mod common;

use common::toys::WearingFriction;
use common::{Dice, methods, sheet, simulation_of};
use membrane_core::assembly::Assembly;
use membrane_core::integrators::{METHODS, Method, Options};
use membrane_core::laws::Law;
use membrane_core::model::input::{Cord, Model};
use membrane_core::simulation::{Settings, Simulation};

const DT: f64 = 1e-6;

fn friction(assembly: &Assembly) -> Vec<Box<dyn Law>> {
    vec![Box::new(WearingFriction::new(assembly))]
}

/// A stretched sheet in motion, turning, with springs, dashpots and friction that has a history.
fn moving(method: Method, dt: Option<f64>, substeps: u32) -> Simulation {
    let mut model = sheet(4, 3, 0.01);
    model.positions.iter_mut().for_each(|p| *p = [1.002 * p[0] + 0.04, 1.002 * p[1], 0.1 * p[0]]);
    model.velocities = Dice(3).vectors(model.positions.len(), 0.05);
    let laws = [common::springs(), common::spin(20.0, 0.0), common::gravity([0.0, -9.81, 0.0])];
    let settings = Settings { check_interval: 7, substeps, loss_tolerance: 0.5, ..Settings::default() };
    simulation_of(model, &laws, method, dt, settings, friction)
}

fn every_run() -> impl Iterator<Item = (Method, Option<f64>, u32)> {
    let named = |name| METHODS.iter().find(|method| method.name == name).copied().unwrap();
    let fixed = methods().map(|method| (method, Some(DT), 1));
    fixed.chain([(named("dopri5"), None, 1), (named("leapfrog"), Some(4.0 * DT), 4)])
}

#[test]
fn output_times_change_no_bit_of_a_run_whole_or_resumed_within_a_step() {
    for (method, dt, substeps) in every_run() {
        let new = || moving(method, dt, substeps);
        let (mut whole, mut cut) = (new(), new());
        assert!(whole.reach(50.3 * DT, u64::MAX).unwrap());
        for time in [0.0, 0.4, 0.41, 1.0, 2.3, 2.7, 11.111, 13.999, 14.0, 33.3, 50.3].map(|steps| steps * DT) {
            assert!(cut.reach(time, u64::MAX).unwrap());
            assert_eq!(cut.time(), time, "{}", method.name);
            let before = cut.progress();
            cut.forces(None).unwrap();
            cut.check(true).unwrap();
            let shown = (cut.positions(), cut.velocities(), cut.energy_terms());
            cut = new();
            cut.resume(&before).unwrap();
            assert_eq!(cut.progress(), before, "{}", method.name);
            assert_eq!((cut.positions(), cut.velocities(), cut.energy_terms()), shown, "{}", method.name);
        }
        assert_eq!(whole.progress(), cut.progress(), "{}", method.name);
        assert_eq!(whole.positions(), cut.positions(), "{}", method.name);
        // Steps continue from the last one, not from the output time.
        let mut stepped = new();
        stepped.step(cut.step_count() + 3).unwrap();
        cut.step(3).unwrap();
        assert_eq!((cut.time(), cut.progress()), (stepped.time(), stepped.progress()), "{}", method.name);
    }
}

/// One mass between two held nodes: a linear oscillator along x with omega = 1.
fn oscillator_model() -> Model {
    let cord = |nodes| Cord { nodes, stiffness: 0.5, rest_length: 1.0, strain_limit: 10.0, ..Default::default() };
    Model {
        positions: vec![[0.0; 3], [2.3, 0.0, 0.0], [4.0, 0.0, 0.0]],
        velocities: vec![[0.0; 3]; 3],
        extra_masses: vec![1.0; 3],
        fixed: vec![0, 2],
        cords: vec![cord([0, 1]), cord([1, 2])],
        ..Model::default()
    }
}

fn oscillator(method: Method, dt: f64) -> Simulation {
    // A method of order 1 loses energy at once.
    let most = if (method.make)(&Options::default()).properties().order == 1 { 1.0 } else { 1e-3 };
    let settings = Settings { check_interval: 1, loss_tolerance: most, energy_tolerance: most, ..Settings::default() };
    simulation_of(oscillator_model(), &[], method, Some(dt), settings, |_| Vec::new())
}

#[test]
fn the_state_between_two_steps_is_that_of_the_motion() {
    for method in methods() {
        let dt = 1e-2;
        let mut simulation = oscillator(method, dt);
        for steps in [0.5, 1.25, 200.7, 201.01, 900.5] {
            let time: f64 = steps * dt;
            simulation.reach(time, u64::MAX).unwrap();
            // First-order methods are out by omega dt/2 of the offset in phase.
            let error = simulation.positions()[1][0] - 2.0 - 0.3 * time.cos();
            assert!(error.abs() < 3e-3, "{}: {error:e} at {steps} steps", method.name);
        }
    }
}

#[test]
fn the_monitor_judges_the_balance_of_steps_and_any_state_that_is_shown() {
    // At omega dt = 1.5 the energy of leapfrog oscillates by half, and its modified energy depends on the step.
    let leapfrog = METHODS.iter().find(|method| method.name == "leapfrog").copied().unwrap();
    let mut simulation = oscillator(leapfrog, 1.5);
    for k in 1..300 {
        simulation.reach(0.4321 * f64::from(k), u64::MAX).unwrap();
        let before = (simulation.progress(), simulation.positions());
        simulation.check(simulation.step_count() > 0).unwrap();
        assert_eq!((simulation.progress(), simulation.positions()), before);
    }
    // A cord that is beyond its bound only between two steps.
    let mut model = oscillator_model();
    model.velocities[1] = [1.0, 0.0, 0.0];
    model.cords.iter_mut().for_each(|cord| cord.strain_limit = 1.5);
    let settings = Settings { check_interval: 1_000, ..Settings::default() };
    let mut fast = simulation_of(model, &[], leapfrog, Some(1.9), settings, |_| Vec::new());
    fast.check(true).unwrap();
    fast.reach(0.9, u64::MAX).unwrap();
    let text = fast.check(true).unwrap_err().to_string();
    assert!(text.contains("over its bound") && fast.time() == 0.0, "{text}");
    fast.step(2).unwrap();
}

#[test]
fn a_run_that_ends_within_its_first_step_is_judged() {
    // The whole step is beyond the limit of 2.83; the part of it up to the end gains a tenth of the energy.
    let rk4 = METHODS.iter().find(|method| method.name == "rk4").copied().unwrap();
    let mut simulation = oscillator(rk4, 5.0);
    simulation.reach(3.0, u64::MAX).unwrap();
    assert_eq!(simulation.step_count(), 0);
    simulation.check(false).unwrap();
    let text = simulation.check(true).unwrap_err().to_string();
    assert!(text.contains("a spurious gain") && simulation.time() == 0.0, "{text}");
}

#[test]
fn a_motion_or_a_step_set_between_two_steps_continues_from_there() {
    for method in methods() {
        let time = 20.3 * DT;
        let (mut set, mut new_step) = (moving(method, Some(DT), 1), moving(method, Some(DT), 1));
        for simulation in [&mut set, &mut new_step] {
            simulation.reach(time, u64::MAX).unwrap();
        }
        let shown = (set.positions(), set.velocities());
        set.set_motion(&shown.0, &shown.1).unwrap();
        new_step.set_dt(0.5 * DT).unwrap();
        for (simulation, dt) in [(&mut set, DT), (&mut new_step, 0.5 * DT)] {
            assert_eq!(
                (simulation.time(), simulation.positions(), simulation.velocities()),
                (time, shown.0.clone(), shown.1.clone())
            );
            simulation.step(2).unwrap();
            assert_eq!(simulation.time(), time + 2.0 * dt, "{}", method.name);
        }
        new_step.step(2).unwrap();
        let distance = |a: &Simulation, b: &Simulation| {
            let (a, b) = (a.positions(), b.positions());
            a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
        };
        // Two steps of 1 us at 0.1 m/s: both went on from the same state.
        let most = if new_step.integrator().properties().order == 1 { 1e-6 } else { 1e-9 };
        assert!(distance(&set, &new_step) < most, "{}: {:e}", method.name, distance(&set, &new_step));
        let progress = new_step.progress();
        assert_eq!((progress.origin, progress.step_count), (time, 4));
    }
}

#[test]
fn times_in_the_past_without_end_or_beyond_all_steps_are_refused() {
    let mut simulation = moving(METHODS[0], Some(DT), 1);
    simulation.reach(5.5 * DT, u64::MAX).unwrap();
    let before = simulation.progress();
    for (time, reason) in [
        (5.4 * DT, "not before the present time"),
        (f64::NAN, "finite"),
        (f64::INFINITY, "finite"),
        (1e308, "10^15 steps"),
        (1e15, "10^15 steps"),
    ] {
        let text = simulation.reach(time, 10).unwrap_err().to_string();
        assert!(text.contains(reason), "{text}");
    }
    assert_eq!(simulation.progress(), before);
    for output_time in [Some(6.6 * DT), Some(f64::NAN), Some(-DT)] {
        let saved = membrane_core::simulation::Progress { output_time, ..before.clone() };
        assert!(simulation.resume(&saved).is_err());
        assert_eq!(simulation.progress(), before);
    }
}

#[test]
fn a_multiple_of_the_step_is_the_end_of_a_step_however_it_was_computed() {
    let mut simulation = moving(METHODS[0], Some(1e-4 / 282.0), 1);
    for k in 1..=20 {
        simulation.reach(f64::from(k) * 1e-4, u64::MAX).unwrap();
        assert_eq!(simulation.step_count(), 282 * u64::from(k as u32));
        let shown = (simulation.positions(), simulation.velocities());
        simulation.step(0).unwrap();
        let mut stepped = moving(METHODS[0], Some(1e-4 / 282.0), 1);
        if k == 20 {
            stepped.step(simulation.step_count()).unwrap();
            assert_eq!(shown, (stepped.positions(), stepped.velocities()));
        }
    }
}
