//! Histories of laws: they change at the end of an accepted step, are saved with the run, and start anew with a motion.
#![allow(missing_docs, clippy::unwrap_used)]

mod common;

use common::toys::WearingFriction;
use common::{Dice, methods, sheet, simulation_of};
use membrane_core::assembly::Assembly;
use membrane_core::integrators::{METHODS, Method, Tolerance};
use membrane_core::laws::Law;
use membrane_core::model::input::{Cord, Model};
use membrane_core::simulation::{Settings, Simulation};

fn friction(assembly: &Assembly) -> Vec<Box<dyn Law>> {
    vec![Box::new(WearingFriction::new(assembly))]
}

/// A stretched sheet in motion, with springs and friction.
fn moving(method: Method, settings: Settings) -> Simulation {
    let mut model = sheet(4, 3, 0.01);
    model.positions.iter_mut().for_each(|p| *p = [1.002 * p[0] + 0.04, 1.002 * p[1], 0.1 * p[0]]);
    model.velocities = Dice(3).vectors(model.positions.len(), 0.05);
    simulation_of(model, &[common::springs()], method, Some(1e-7), settings, friction)
}

/// A mass with friction between two slack cords, which become taut at once: there an adaptive run rejects steps.
fn slack() -> Simulation {
    let cord = |nodes| Cord { nodes, stiffness: 1e3, rest_length: 2.5, strain_limit: 10.0, ..Default::default() };
    let model = Model {
        positions: (0..3).map(|i| [2.0 * f64::from(i), 0.0, 0.0]).collect(),
        velocities: vec![[0.0; 3], [0.0, 9.0, 0.0], [0.0; 3]],
        extra_masses: vec![1.0; 3],
        fixed: vec![0, 2],
        cords: vec![cord([0, 1]), cord([1, 2])],
        ..Model::default()
    };
    let dopri5 = METHODS.iter().find(|method| method.name == "dopri5").copied().unwrap();
    let tolerance = Tolerance { relative: 1e-7, length: 0.1, speed: 1.0 };
    let settings = Settings { tolerance, loss_tolerance: 1.0, energy_tolerance: 1.0, ..Settings::default() };
    simulation_of(model, &[], dopri5, None, settings, friction)
}

#[test]
fn rejected_steps_output_times_and_looks_at_forces_do_not_change_the_history() {
    let (mut whole, mut cut) = (slack(), slack());
    assert!(whole.is_adaptive() && whole.reach(1.0, u64::MAX).unwrap());
    assert!(whole.rejected_count() > 0);
    for k in 1..=100 {
        assert!(cut.reach(0.01 * f64::from(k), u64::MAX).unwrap());
        let before = cut.progress();
        cut.forces(None).unwrap();
        cut.check(true).unwrap();
        assert_eq!(cut.progress(), before);
        if k % 10 == 0 {
            cut = slack();
            cut.resume(&before).unwrap();
            assert_eq!(cut.progress(), before);
        }
    }
    assert_eq!(whole.progress(), cut.progress());
}

#[test]
fn the_history_is_that_of_the_accepted_states() {
    let mut simulation = slack();
    let (mut last, mut wear) = (None::<Vec<[f64; 3]>>, 0.0);
    while simulation.time() < 0.5 || simulation.rejected_count() == 0 {
        simulation.step(1).unwrap();
        let now = simulation.positions();
        if let Some(last) = last {
            let moved = now.iter().flatten().zip(last.iter().flatten()).map(|(a, b): (&f64, &f64)| (a - b).abs());
            wear += 10.0 * moved.fold(0.0, f64::max);
        }
        let (vectors, numbers) = simulation.progress().law_histories.pop().unwrap();
        assert_eq!((vectors, numbers), (vec![now.clone()], vec![wear]));
        last = Some(now);
    }
    assert!(wear > 1.0);
}

#[test]
fn looks_at_forces_change_no_method() {
    for method in methods() {
        let (mut whole, mut seen) = (moving(method, Settings::default()), moving(method, Settings::default()));
        whole.step(60).unwrap();
        for _ in 0..60 {
            seen.step(1).unwrap();
            seen.forces(None).unwrap();
        }
        assert_eq!(whole.progress(), seen.progress(), "{}", method.name);
    }
}

#[test]
fn a_new_motion_has_the_history_of_the_start() {
    for method in methods() {
        let mut simulation = moving(method, Settings::default());
        let start = simulation.progress();
        simulation.step(5).unwrap();
        assert_ne!(simulation.progress().law_histories, start.law_histories);
        simulation.set_motion(&start.positions, &start.velocities).unwrap();
        assert_eq!(simulation.progress().law_histories, start.law_histories, "{}", method.name);
    }
}

#[test]
fn the_history_of_a_law_is_restored_with_the_state_of_a_stopped_run() {
    let mut simulation = moving(METHODS[0], Settings { check_interval: 16, ..Settings::default() });
    simulation.step(32).unwrap();
    let good = simulation.progress();
    simulation.set_dt(1e-4).unwrap();
    assert!(simulation.step(1000).is_err());
    assert_eq!(simulation.progress().law_histories, good.law_histories);
    assert_eq!(simulation.positions(), good.positions);
}

#[test]
fn a_history_that_its_law_refuses_changes_nothing_and_the_error_names_the_law() {
    for method in methods() {
        let new = || moving(method, Settings::default());
        let (mut simulation, mut later) = (new(), new());
        simulation.step(7).unwrap();
        later.step(3).unwrap();
        let (before, later) = (simulation.progress(), later.progress());
        let mut refuse = |histories: &dyn Fn(&mut Vec<membrane_core::simulation::SavedHistory>), word: &str| {
            let mut unfit = later.clone();
            histories(&mut unfit.law_histories);
            let error = simulation.resume(&unfit).unwrap_err().to_string();
            assert!(error.contains(word), "{}: {error}", method.name);
            assert_eq!(simulation.progress(), before, "{}", method.name);
        };
        refuse(&|all| all.last_mut().unwrap().1.push(1.0), "wearing_friction");
        refuse(&|all| all[0].1.push(1.0), "springs");
        refuse(&|all| all.truncate(1), "history of the laws");
        simulation.step(2).unwrap();
        let mut whole = new();
        whole.step(9).unwrap();
        assert_eq!(simulation.progress(), whole.progress(), "{}", method.name);
    }
}
