//! Contact with the spool: no node comes out on another side, at any speed, step and interval of the checks.
#![allow(missing_docs, clippy::unwrap_used)]

mod common;

use common::{methods, simulation_of};
use membrane_core::error::Error;
use membrane_core::integrators::{METHODS, Method};
use membrane_core::laws::{LawSpec, SpoolContactParameters};
use membrane_core::model::input::{ContactSet, Model};
use membrane_core::simulation::{Settings, Simulation};

const RADIUS: f64 = 0.05;

fn spool(stiffness: f64, half_height: Option<f64>) -> LawSpec {
    SpoolContactParameters { radius: RADIUS, stiffness, half_height, membrane: false }.into()
}

/// Masses of 10 g that fly freely.
fn flight(positions: &[[f64; 3]], velocities: &[[f64; 3]]) -> Model {
    let nodes = 0..positions.len() as u32;
    Model {
        positions: positions.to_vec(),
        velocities: velocities.to_vec(),
        extra_masses: vec![0.01; positions.len()],
        contacts: ContactSet { nodes: nodes.collect() },
        ..Model::default()
    }
}

fn every(check_interval: u64) -> Settings {
    Settings { check_interval, ..Settings::default() }
}

fn run(model: Model, law: LawSpec, method: Method, dt: f64, settings: Settings, until: f64) -> (Simulation, String) {
    let mut simulation = simulation_of(model, &[law], method, Some(dt), settings, |_| Vec::new());
    let result = simulation.step((until / dt).ceil() as u64).and_then(|()| simulation.check(true));
    (simulation, result.err().map_or_else(String::new, |error| error.to_string()))
}

#[test]
fn a_fast_node_never_passes_unnoticed() {
    for method in METHODS.iter().copied() {
        for speed in [1.0, 5.0, 10.0, 100.0, 1000.0] {
            for (dt, interval) in [(1e-5, 1), (1e-4, 32), (1e-3, 100), (7e-3, 1000)] {
                let model = flight(&[[0.3, 0.3, 0.0], [0.2, 0.001, 0.0]], &[[0.0; 3], [-speed, 0.0, 0.0]]);
                let until = 0.5 / speed;
                let (simulation, error) = run(model, spool(200.0, None), method, dt, every(interval), until.max(dt));
                let x = simulation.positions()[1][0];
                let words = ["node 1", "deep into the spool", "spool_contact", "stiffer spool", "smaller dt"];
                let is_named = words.iter().all(|word| error.contains(word));
                let case = format!("{} at {speed} m/s, dt {dt}, {interval}: x = {x}, {error}", method.name);
                assert!(x > 0.0, "{case}");
                assert!(error.is_empty() || is_named || dt >= 1e-3, "{case}");
                assert!(speed < 10.0 || !error.is_empty(), "{case}");
                assert!(speed > 1.0 || dt > 1e-4 || error.is_empty(), "{case}");
            }
        }
    }
}

#[test]
fn a_step_that_dips_in_and_comes_out_without_feeling_the_contact_is_a_fault() {
    // A path that passes 5 mm below the surface, twice a twentieth of the radius, and one 1 mm below it.
    for (height, dt, is_found) in [(0.045, 5e-3, true), (0.045, 1e-5, false), (0.049, 5e-3, false)] {
        let model = flight(&[[0.2, height, 0.0]], &[[-100.0, 0.0, 0.0]]);
        let method = methods().next().unwrap();
        let (simulation, error) = run(model, spool(200.0, None), method, dt, every(1), 5e-3);
        let case = format!("{height} {dt}: {error}");
        assert_eq!(error.contains("deep into the spool"), is_found, "{case}");
        assert_eq!(simulation.positions()[0][0] < -0.2, !is_found, "{case}");
    }
}

#[test]
fn the_fault_is_that_of_the_first_step_beyond_the_bound() {
    let new = |interval| {
        let model = flight(&[[0.2, 0.0, 0.0]], &[[-10.0, 0.0, 0.0]]);
        let laws = [spool(200.0, None)];
        let method = methods().next().unwrap();
        let mut simulation = simulation_of(model, &laws, method, Some(1e-4), every(interval), |_| Vec::new());
        simulation.step(2000).unwrap_err()
    };
    let [Error::Unstable { time, step, what, .. }, Error::Unstable { time: later, step: later_step, .. }] =
        [new(1), new(500)]
    else {
        panic!("not unstable")
    };
    assert_eq!((time, step), (later, later_step));
    // 15 cm of free flight, then 2.5 cm of a half-period of the contact, which hardly brakes.
    assert!((0.0175..0.019).contains(&time), "{time}");
    assert!(what.contains("2.5"), "{what}");
}

#[test]
fn a_short_spool_is_passed_neither_across_nor_along_its_axis() {
    let tall = Some(0.02);
    for (from, velocity) in [
        ([0.2, 0.0, 0.001], [-20.0, 0.0, 0.0]),
        ([0.03, 0.0, 0.2], [0.0, 0.0, -20.0]),
        ([0.2, 0.01, 0.1], [-20.0, 0.0, -10.0]),
    ] {
        for (dt, interval) in [(1e-5, 100), (3e-3, 100)] {
            let model = flight(&[from], &[velocity]);
            let method = methods().next().unwrap();
            let error = run(model, spool(200.0, tall), method, dt, every(interval), 0.03).1;
            assert!(error.contains("deep into the spool"), "{from:?} {dt}: {error}");
        }
    }
    // Beside it, and above it, a node passes.
    for (from, velocity) in [([0.2, 0.051, 0.0], [-20.0, 0.0, 0.0]), ([0.2, 0.0, 0.021], [-20.0, 0.0, 0.0])] {
        for dt in [1e-5, 3e-3] {
            let method = methods().next().unwrap();
            let (simulation, error) = run(flight(&[from], &[velocity]), spool(200.0, tall), method, dt, every(7), 0.03);
            assert!(error.is_empty() && simulation.positions()[0][0] < -0.3, "{from:?}: {error}");
        }
    }
}

#[test]
fn an_oblique_path_is_deep_only_where_it_is_between_the_ends() {
    // It crosses the core of the side from s = 1/6 to 5/6, and that of the ends from 1/8 to 3/8, or nowhere.
    for (low, is_found) in [(-0.02, true), (0.013, false)] {
        let model = flight(&[[0.06, 0.0, low]], &[[-120.0, 0.0, 80.0]]);
        let method = methods().find(|method| method.name == "rk4").unwrap();
        let error = run(model, spool(200.0, Some(0.02)), method, 1e-3, every(1), 1e-3).1;
        assert_eq!(error.contains("deep into the spool"), is_found, "{low}: {error}");
    }
}

#[test]
fn a_node_that_is_turned_back_keeps_its_energy() {
    let model = flight(&[[0.07, 0.0, 0.0]], &[[-2.0, 0.0, 0.0]]);
    for method in methods().filter(|method| method.name != "semi_implicit_euler") {
        let (simulation, error) = run(model.clone(), spool(200.0, None), method, 1e-5, every(10), 0.08);
        let velocity = simulation.velocities()[0][0];
        assert!(error.is_empty() && (velocity - 2.0).abs() < 2e-3, "{}: {velocity} {error}", method.name);
    }
}

#[test]
fn a_start_deep_inside_is_named_at_the_first_check_and_a_held_node_is_not() {
    let inside = |fixed: Vec<u32>, x: f64, half_height: Option<f64>| {
        let mut model = flight(&[[0.2, 0.0, 0.0], [x, 0.0, 0.0]], &[[0.0; 3]; 2]);
        model.fixed = fixed;
        let laws = [spool(200.0, half_height)];
        Simulation::new(model, &laws, "rk4", Some(1e-4), Settings::default()).unwrap().check(true).err()
    };
    let text = inside(vec![], 0.01, None).unwrap().to_string();
    assert!(text.contains("node 1") && text.contains("4.0000e-2 m deep"), "{text}");
    assert!(inside(vec![], 0.0, Some(0.01)).is_some());
    assert!(inside(vec![1], 0.01, None).is_none() && inside(vec![], 0.03, None).is_none());
}

#[test]
fn a_motion_that_is_set_is_no_step_and_one_that_is_set_inside_is_found() {
    let model = flight(&[[0.2, 0.0, 0.0]], &[[0.0; 3]]);
    let mut simulation = Simulation::new(model, &[spool(200.0, None)], "rk4", Some(1e-4), every(1)).unwrap();
    simulation.step(3).unwrap();
    simulation.set_motion(&[[-0.2, 0.0, 0.0]], &[[0.0; 3]]).unwrap();
    simulation.step(3).unwrap();
    simulation.set_motion(&[[0.01, 0.0, 0.0]], &[[0.0; 3]]).unwrap();
    assert!(simulation.step(1).unwrap_err().to_string().contains("deep into the spool"));
}

#[test]
fn a_passage_is_found_after_a_restart_too() {
    let new = || {
        let model = flight(&[[0.2, 0.0, 0.0]], &[[-100.0, 0.0, 0.0]]);
        Simulation::new(model, &[spool(200.0, None)], "rk4", Some(1e-3), every(1000)).unwrap()
    };
    // Before the passage, near and far.
    for steps in [0, 1] {
        let (mut first, mut second) = (new(), new());
        first.step(steps).unwrap();
        second.resume(&first.progress()).unwrap();
        assert_eq!(second.progress(), first.progress());
        let [found, expected] = [second.step(3), first.step(3)].map(|result| {
            let Err(Error::Unstable { what, place, .. }) = result else { panic!("not found after {steps}") };
            (what, place)
        });
        assert_eq!(found, expected);
    }
}
