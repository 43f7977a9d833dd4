//! Layers that are pressed on each other, and runs that are changed on their way.
#![allow(missing_docs, clippy::unwrap_used)]

mod common;
#[path = "common/sheets.rs"]
mod sheets;

use common::{Dice, gravity, springs};
use membrane_core::error::Error;
use membrane_core::laws::{LawSpec, PressureParameters};
use membrane_core::model::input::Motion;
use membrane_core::model::schedule::Schedule;
use sheets::{Scene, placed, row, square, triangle};

const SIZE: f64 = 0.011;

/// A held sheet, and a smaller one above it that moves.
fn above_a_floor(gap: f64, speed: f64) -> Scene {
    let mut scene = Scene::new();
    let (points, triangles) = square(4, 4, SIZE);
    let floor = scene.add(&placed(&points, 0.0, 0.3, [0.0; 3]), &triangles, [0.0; 3]);
    scene.hold(floor);
    let (points, triangles) = square(2, 2, SIZE);
    scene.add(&placed(&points, 0.0, 0.1, [0.001, 0.002, gap]), &triangles, [0.0, 0.0, -speed]);
    scene
}

#[test]
fn the_work_of_a_pressure_is_that_on_velocities_after_impulses() {
    for substeps in [1, 4] {
        let mut scene = above_a_floor(6e-6, 0.0);
        scene.specs = vec![springs(), LawSpec::SpringDamping(0.02.into())];
        scene.specs.push(PressureParameters { pressure: -2000.0, ..Default::default() }.into());
        (scene.settings.substeps, scene.dt) = (substeps, Some(1e-6 * f64::from(substeps)));
        let mut simulation = scene.started();
        simulation.step(1000).unwrap();
        let now = simulation.energy_terms();
        assert!(simulation.ledger().residual(&now).abs() < 1e-6 * now.kinetic, "{substeps}");
    }
}

#[test]
fn what_is_squeezed_beyond_its_thickness_ends() {
    let mut scene = above_a_floor(2e-5, 0.0);
    let (points, triangles) = square(2, 2, SIZE);
    let top = scene.add(&placed(&points, 0.0, 0.0, [0.002, 0.001, 4e-5]), &triangles, [0.0; 3]);
    let ramp = Schedule::new(vec![0.0, 1.0], vec![0.0, -1.0], 0.0).unwrap();
    let nodes = top.map(|node| node as u32).collect();
    scene.model.motions = vec![Motion { nodes, displacement: [None, None, Some(ramp)], turn: None }];
    scene.specs = vec![springs(), LawSpec::SpringDamping(0.02.into())];
    (scene.settings.loss_tolerance, scene.settings.energy_tolerance) = (1e9, 1e9);
    scene.contact.crossing_interval = 1.0;
    let error = scene.started().step(100).unwrap_err();
    assert!(matches!(&error, Error::Unstable { what, .. } if what.contains("pass through each other")), "{error}");
}

#[test]
fn speeds_without_bounds_stop_a_run() {
    for speed in [1e8, 1e17, 1e40, 1e160, 1e300] {
        let mut scene = Scene::new();
        let (points, triangles) = triangle(SIZE);
        for layer in 0..3 {
            let at = f64::from(layer);
            scene.add(&placed(&points, 0.0, 0.3 * at, [1e-3 * at, 1e-3, 4e-6 * at]), &triangles, [0.0; 3]);
        }
        scene.model.velocities = Dice(3).vectors(9, speed);
        assert!(matches!(scene.started().step(10), Err(Error::Unstable { .. })), "{speed:e}");
    }
}

#[test]
fn a_step_after_a_shorter_one_has_impulses_of_its_own() {
    for k in 0..30 {
        let mut scene = above_a_floor(1e-4 + 1e-6 * f64::from(k), 10.0);
        scene.dt = Some(2e-6);
        let mut simulation = scene.started();
        simulation.step(4).unwrap();
        simulation.reach(simulation.time() + 0.5 * simulation.dt(), 1).unwrap();
        simulation.set_dt(2e-6).unwrap();
        simulation.step(1).unwrap();
        assert!(simulation.positions()[25..].iter().all(|point| point[2] > 0.0), "{k}");
    }
}

#[test]
fn histories_without_bounds_are_refused() {
    let mut scene = above_a_floor(6e-6, 1.0);
    scene.specs = vec![gravity([0.0, 0.0, -9.81])];
    let mut simulation = scene.started();
    let row = row(&simulation);
    while simulation.progress().law_histories[row].1.len() < 6 {
        simulation.step(1).unwrap();
    }
    let saved = simulation.progress();
    let of_counts = [1e300, f64::INFINITY, -1.0, f64::NAN].map(|count| [(0, count), (1, count)]).concat();
    let wrong = of_counts.into_iter().chain([(3, 1e300), (4, -1.0), (4, f64::NAN)]);
    for (place, value) in wrong.chain([-1.0, f64::INFINITY, f64::NAN].map(|pressed| (5, pressed))) {
        let mut other = saved.clone();
        other.law_histories[row].1[place] = value;
        let error = simulation.resume(&other).unwrap_err();
        assert!(matches!(error, Error::HistoryMisfit { owner: "self_contact" }), "{place}, {value}: {error}");
        assert_eq!(simulation.progress(), saved);
    }
}
