//! Two sheets that meet: they stay apart, and exchange momentum and energy as impulses do.
#![allow(missing_docs, clippy::unwrap_used, clippy::panic)]

mod common;
#[path = "common/sheets.rs"]
mod sheets;

use common::{FILM, spin, springs};
use membrane_core::error::Error;
use membrane_core::laws::{LawSpec, Scheme};
use membrane_core::model::input::Film;
use membrane_core::simulation::Simulation;
use sheets::{Scene, least_distance, mean_velocity, momenta, placed, square, work};

/// Cells of each sheet along a side, their size [m], and the gap [m].
const CELLS: usize = 10;
const SIZE: f64 = 0.011;
const GAP: f64 = 0.5e-3;
const NODES: usize = (CELLS + 1) * (CELLS + 1);
/// The distance at which layers touch, and the share of it that they keep [m].
const TOUCHING: f64 = 7.5e-6;
const KEPT: f64 = 0.5 * TOUCHING;
/// Without pairs of edges layers cross.
const NODES_ALONE: Scheme = Scheme { has_edges: false, ..Scheme::USUAL };
/// A sheet whose own step is long against its thickness.
const RUBBER: Film = Film { youngs_modulus: 1e6, poisson_ratio: 0.33, density: 1000.0, thickness: 2e-4 };

/// The lower sheet at rest, and the upper one, above it with its lowest point, at -V.
fn sheets(speed: f64, tilt: f64, turn: f64, shift: [f64; 2]) -> Scene {
    let mut scene = Scene::new();
    let (points, triangles) = square(CELLS, CELLS, SIZE);
    let height = GAP + 0.5 * CELLS as f64 * SIZE * tilt.sin().abs();
    scene.add(&points, &triangles, [0.0; 3]);
    scene.add(&placed(&points, tilt, turn, [shift[0], shift[1], height]), &triangles, [0.0, 0.0, -speed]);
    scene.specs = vec![springs(), LawSpec::SpringDamping(0.02.into())];
    scene.dt = None;
    scene
}

/// Takes steps, and looks at the layers between: none cross. Their smallest distance [m].
fn run(scene: &Scene, simulation: &mut Simulation, end: f64, every: u64, mut look: impl FnMut(&Simulation)) -> f64 {
    let (lower, upper) = scene.model.triangles.split_at(2 * CELLS * CELLS);
    let mut least = 1e-4;
    while simulation.time() < end {
        simulation.step(every).unwrap();
        assert_eq!(scene.crossings(simulation), 0, "{}", simulation.time());
        least = least_distance(&simulation.positions(), lower, upper, least);
        look(simulation);
    }
    least
}

#[test]
fn a_turned_sheet_is_stopped_at_any_speed() {
    for (speed, dt) in [(0.1, None), (1.0, None), (5.0, None), (20.0, None)] {
        let mut scene = sheets(speed, 0.0, 0.3, [0.5 * SIZE; 2]);
        scene.dt = dt;
        let mut simulation = scene.started();
        let (start, before) = (simulation.energy_terms(), momenta(&simulation));
        let mut first = None;
        let least = run(&scene, &mut simulation, 1.1 * GAP / speed + 3e-3, 10, |simulation| {
            let kinetic = simulation.energy_terms().kinetic / start.kinetic;
            let mean = [0..NODES, NODES..2 * NODES].map(|nodes| mean_velocity(simulation, nodes).z / speed);
            if kinetic < 1.0 {
                first.get_or_insert((kinetic, mean));
                // Corners beside the other sheet fly on at first, and then pull.
                assert!((0.5..0.57).contains(&kinetic), "{speed}: {kinetic}");
                assert!(mean.iter().all(|mean| (mean + 0.5).abs() < 0.09), "{speed}: {mean:?}");
            }
        });
        // The first blow: film has no bending stiffness, so that nodes alone have a part in it, at any speed alike.
        let (kinetic, [lower, upper]) = first.unwrap();
        assert!((kinetic - 0.533).abs() < 3e-3, "{speed}: {kinetic}");
        assert!((lower + 0.469).abs() < 3e-3 && (upper + 0.531).abs() < 3e-3, "{speed}: {lower} {upper}");
        // Fast pairs go on with the points of the end of a step, about which the impulses have a moment.
        let (share, moment) = if speed < 10.0 { (0.95, 1e-14) } else { (0.9, 1e-5) };
        assert!(least > share * KEPT && least < TOUCHING, "{speed}: {least:e}");
        let after = momenta(&simulation);
        assert!((after[0] - before[0]).norm() < 1e-14 * before[0].norm(), "{speed}");
        assert!((after[1] - before[1]).norm() < moment * before[0].norm() * CELLS as f64 * SIZE, "{speed}");
    }
}

#[test]
fn too_fast_an_approach_is_refused() {
    let scene = sheets(60.0, 0.0, 0.3, [0.5 * SIZE; 2]);
    let mut simulation = scene.started();
    assert!(simulation.dt() * 60.0 > 16.0 * TOUCHING);
    let error = simulation.step(100).unwrap_err();
    let Error::Unstable { what, place, law, good_time, .. } = error else { panic!("{error}") };
    assert!(what.contains("two layers approach by ") && law == "self_contact", "{what}, {law}");
    let nodes: Vec<usize> = place.split(' ').filter_map(|word| word.parse().ok()).collect();
    assert!(matches!(nodes[..], [a, b] if (a < NODES) != (b < NODES)), "{place}");
    assert!(good_time < GAP / 60.0 && simulation.time() == good_time);
    assert_eq!(scene.crossings(&simulation), 0);
}

#[test]
fn sheets_node_on_node_halve_the_velocity() {
    let mut simulation = sheets(1.0, 0.0, 0.0, [0.0; 2]).started();
    let start = simulation.energy_terms().kinetic;
    simulation.step(300).unwrap();
    assert!(simulation.velocities().iter().all(|v| (v[2] + 0.5).abs() < 1e-12));
    assert!((simulation.energy_terms().kinetic / start - 0.5).abs() < 1e-12);
    assert!((work(&simulation) / start + 0.5).abs() < 1e-12);
    assert!(simulation.ledger().residual(&simulation.energy_terms()).abs() < 1e-12 * start);
}

#[test]
fn tilted_and_shifted_sheets_stay_apart() {
    let tilts = [0.2, 0.5, 0.9, 1.2, 1.5].map(|tilt| (tilt, 0.3, [0.5, 0.5]));
    let shifts = [[0.5, 0.0], [0.0, 0.5], [0.5, 0.5]].map(|shift| (0.0, 0.0, shift));
    for (tilt, turn, shift) in tilts.into_iter().chain(shifts) {
        let scene = sheets(1.0, tilt, turn, shift.map(|cells| cells * SIZE));
        let mut simulation = scene.started();
        let least = run(&scene, &mut simulation, 2.5e-3, 20, |_| ());
        assert!(least > 0.95 * KEPT && work(&simulation) < 0.0, "{tilt}, {shift:?}: {least:e}");
    }
}

#[test]
fn crossings_of_fast_layers_are_found_soon() {
    // With states between steps that are looked at, or without.
    let found = |interval: f64, between: Option<u64>| {
        let mut scene = sheets(15.0, 0.5, 0.7, [0.28 * SIZE, 0.15 * SIZE]);
        scene.contact.scheme = NODES_ALONE;
        scene.contact.crossing_interval = interval;
        scene.dt = Some(4.0 * TOUCHING / 15.0);
        let mut simulation = scene.started();
        let mut result = Ok(());
        while result.is_ok() && simulation.step_count() < 600 {
            result = simulation.step(between.unwrap_or(600));
            if let (Some(_), Ok(())) = (between, &result) {
                simulation.reach(simulation.time() + 0.3 * simulation.dt(), 1).unwrap();
            }
        }
        let Err(Error::Unstable { what, time, .. }) = result else { panic!("{between:?}: {result:?}") };
        assert!(what.contains("cross"), "{what}");
        time / scene.dt.unwrap()
    };
    let first = found(1.0, None);
    for between in [None, Some(1), Some(10)] {
        let soon = found(1e9, between);
        assert!((first..first + 16.5).contains(&soon), "{between:?}: {first} {soon}");
    }
}

#[test]
fn layers_that_move_by_many_thicknesses_a_step_stay_apart() {
    let film = [(FILM, 5.0, 7.5), (FILM, 15.0, 22.5), (RUBBER, 4.0, 5.0), (RUBBER, 7.5, 5.0)];
    for (film, ways, speed) in film {
        for (tilt, turn) in [(0.0, 0.3), (0.05, 0.7), (0.5, 0.3), (0.9, 0.3), (0.9, 0.7), (1.3, 0.3), (1.3, 0.7)] {
            let mut scene = sheets(speed, tilt, turn, [0.28 * SIZE, 0.15 * SIZE]);
            scene.model.film = Some(film);
            for position in &mut scene.model.positions[NODES..] {
                position[2] += 20.0 * film.thickness;
            }
            // Steps of film below its own limit; that of rubber is longer.
            scene.dt = Some(ways * film.thickness / speed);
            scene.contact.crossing_interval = 1.0;
            let height = GAP + 20.0 * film.thickness + 0.6 * CELLS as f64 * SIZE * tilt.sin();
            let steps = (height / (ways * film.thickness)) as u64 + 50;
            let mut simulation = scene.started();
            simulation.step(steps).unwrap();
            assert!(work(&simulation) < 0.0, "{ways}, {tilt}, {turn}");
        }
    }
}

#[test]
fn the_energy_balance_is_that_of_leapfrog_in_any_frame_and_with_substeps() {
    for (rate, substeps) in [(0.0, 1), (0.0, 4), (30.0, 1), (30.0, 4)] {
        let residual = |dt: f64| {
            let mut scene = sheets(1.0, 0.1, 0.3, [0.5 * SIZE; 2]);
            (scene.dt, scene.settings.substeps) = (Some(dt * f64::from(substeps)), substeps);
            if rate > 0.0 {
                scene.specs.push(spin(rate, 0.0));
            }
            let mut simulation = scene.started();
            let start = simulation.energy_terms();
            simulation.step((4e-3 / simulation.dt()) as u64).unwrap();
            assert!(work(&simulation) < -0.1 * start.kinetic);
            simulation.ledger().residual(&simulation.energy_terms()).abs() / start.kinetic
        };
        let [coarse, fine] = [5e-6, 1.25e-6].map(residual);
        assert!(coarse < 1e-4 && fine < coarse / 8.0, "{rate}, {substeps}: {coarse:e} {fine:e}");
    }
}

#[test]
fn the_work_is_the_change_of_kinetic_energy_and_never_positive() {
    // In the turning frame the centrifugal potential takes part, with the error of leapfrog.
    for (rate, error) in [(0.0, 1e-14), (30.0, 1e-9)] {
        let mut scene = sheets(1.0, 0.01, 0.3, [0.5 * SIZE; 2]);
        (scene.specs, scene.dt) = (if rate > 0.0 { vec![spin(rate, 0.0)] } else { vec![] }, Some(4e-6));
        scene.contact.friction = 0.1;
        let mut simulation = scene.started();
        let start = simulation.energy_terms();
        let (mut last, mut meetings) = (0.0, 0);
        for _ in 0..700 {
            simulation.step(1).unwrap();
            let work = work(&simulation);
            assert!(work <= last + 1e-12 * start.kinetic, "{work:e} {last:e}");
            meetings += u32::from(work < last);
            last = work;
        }
        let residual = simulation.ledger().residual(&simulation.energy_terms());
        assert!(meetings > 50 && last < -0.05 * start.kinetic, "{meetings} {last:e}");
        assert!(residual.abs() < error * start.kinetic, "{rate}: {residual:e}");
    }
}

#[test]
fn a_run_is_set_back_to_a_state_without_crossings() {
    for steps in [7, 20, 1000] {
        let mut scene = sheets(15.0, 0.5, 0.7, [0.28 * SIZE, 0.15 * SIZE]);
        scene.contact.scheme = NODES_ALONE;
        scene.dt = Some(4.0 * TOUCHING / 15.0);
        // Between the crossing and the check.
        scene.settings.check_interval = 20;
        let mut simulation = scene.started();
        while simulation.step(steps).is_ok() {}
        assert_eq!(scene.crossings(&simulation), 0, "{steps}, step {}", simulation.step_count());
    }
}
