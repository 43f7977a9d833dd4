//! What contact between layers refuses, what stops a run, and shapes at the limits of geometry.
#![allow(missing_docs, clippy::unwrap_used, clippy::panic)]

mod common;
#[path = "common/sheets.rs"]
mod sheets;

use common::{Dice, springs};
use membrane_core::error::Error;
use membrane_core::laws::{LawSpec, Scheme, SelfContactParameters, SpinParameters};
use membrane_core::model::input::{Bridges, Motion};
use membrane_core::model::schedule::Schedule;
use membrane_core::simulation::Simulation;
use sheets::{PLAIN, Scene, momenta, placed, square, triangle, work};

const GAP: f64 = 0.505e-3;
const LEAN: f64 = 1.0;

/// Two ribbons that cross at a right angle, 0.505 mm apart, of two triangles each: their edges alone meet. The upper
/// one leans on an edge, and moves at -1 m/s.
fn ribbons(has_edges: bool) -> Scene {
    let mut scene = Scene::new();
    let points = [[-0.02, -0.002, 0.0], [0.02, -0.002, 0.0], [0.02, 0.002, 0.0], [-0.02, 0.002, 0.0]];
    let triangles = [[0, 1, 2], [0, 2, 3]];
    let height = GAP + 0.002 * LEAN.sin();
    let upper = placed(&points, LEAN, std::f64::consts::FRAC_PI_2, [0.0, 0.0, height]);
    scene.add(&points, &triangles, [0.0; 3]);
    scene.add(&upper, &triangles, [0.0, 0.0, -1.0]);
    scene.dt = Some(1e-5);
    scene.contact.scheme = Scheme { has_edges, ..Scheme::default() };
    scene
}

#[test]
fn edges_stop_what_nodes_and_triangles_let_pass() {
    let run = |has_edges| {
        let scene = ribbons(has_edges);
        let mut simulation = scene.started();
        simulation.step(100).unwrap();
        (scene.crossings(&simulation), work(&simulation))
    };
    let (crossed, none) = run(false);
    assert!(crossed > 0 && none == 0.0, "{crossed} {none}");
    let (crossed, work) = run(true);
    assert!(crossed == 0 && work < 0.0, "{crossed} {work}");
}

#[test]
fn a_crossing_stops_the_run_at_the_next_check_with_both_triangles() {
    let mut scene = ribbons(false);
    scene.contact.crossing_interval = 10.0;
    let mut simulation = scene.started();
    let Error::Unstable { time, step, good_time, what, law, .. } = simulation.step(100).unwrap_err() else { panic!() };
    // They meet within step 51; regular checks are those of every 32nd step.
    assert_eq!((step, law.as_str()), (60, "self_contact"));
    assert!((time - 60e-5).abs() < 1e-12 && (good_time - 32e-5).abs() < 1e-12, "{time} {good_time}");
    assert!(what.contains("triangles 0 and 2 of the film cross, 2 pairs"), "{what}");
    assert_eq!((simulation.time(), simulation.step_count()), (good_time, 32));
    assert!((simulation.positions()[4][2] - (GAP - 32e-5)).abs() < 1e-12);
    // It goes on from there, to the same fault.
    simulation.step(20).unwrap();
    assert!(simulation.step(8).is_err());
}

#[test]
fn layers_that_nothing_keeps_apart_stop_a_run_at_once() {
    let mut scene = Scene::new();
    let (points, triangles) = square(2, 2, 0.011);
    let lower = scene.add(&placed(&points, 0.0, 0.3, [0.0; 3]), &triangles, [0.0; 3]);
    let upper = scene.add(&placed(&points, 0.0, 0.0, [0.001, 0.002, 1e-4]), &triangles, [0.0; 3]);
    scene.hold(lower);
    let down = Schedule::new(vec![0.0, 1e-3], vec![0.0, -1e-3], 0.0).unwrap();
    let nodes = upper.clone().map(|node| node as u32).collect();
    scene.model.motions = vec![Motion { nodes, displacement: [None, None, Some(down)], turn: None }];
    let Error::Unstable { what, place, time, .. } = scene.started().step(1000).unwrap_err() else { panic!() };
    assert!(what.contains("two layers pass through each other, which impulses cannot stop"), "{what}");
    assert!(time > 0.99e-4 && time < 1.02e-4, "{time}");
    let nodes: Vec<usize> = place.split(' ').filter_map(|word| word.parse().ok()).collect();
    assert!(matches!(nodes[..], [a, b] if upper.contains(&a) != upper.contains(&b)), "{place}");
}

/// A sheet that rests at a height above one that moves by a schedule, with or without substeps.
fn on_a_plate(height: f64, times: Vec<f64>, heights: Vec<f64>, substeps: u32) -> Scene {
    let mut scene = Scene::new();
    let (points, triangles) = square(2, 2, 0.011);
    let plate = scene.add(&placed(&points, 0.0, 0.3, [0.0; 3]), &triangles, [0.0; 3]);
    scene.add(&placed(&points, 0.0, 0.0, [0.001, 0.002, height]), &triangles, [0.0; 3]);
    let schedule = Schedule::new(times, heights, 0.0).unwrap();
    let nodes = plate.map(|node| node as u32).collect();
    scene.model.motions = vec![Motion { nodes, displacement: [None, None, Some(schedule)], turn: None }];
    (scene.settings.substeps, scene.dt) = (substeps, Some(2e-6 * f64::from(substeps)));
    scene
}

#[test]
fn a_plate_that_starts_or_stops_at_once_carries_a_sheet_and_ends_below_it() {
    for substeps in [1, 3] {
        for speed in [0.5, 2.0, 5.0, 20.0] {
            let scene = on_a_plate(2.3e-6, vec![0.0, 1e-3, 2e-3], vec![0.0, 0.0, 1e-3 * speed], substeps);
            let mut simulation = scene.started();
            simulation.step(990 / u64::from(substeps)).unwrap();
            let positions = simulation.positions();
            let (plate, sheet) = positions.split_at(9);
            assert!(plate[0][2] > 0.9e-3 * speed && sheet.iter().all(|x| x[2] > plate[0][2]), "{substeps} {speed}");
        }
        // It comes as near as 0.2 d0 to a held sheet, and stays there.
        let mut scene = on_a_plate(1e-3, vec![0.0, 1e-3, 2e-3], vec![0.0, 1e-3 - 1.5e-6, 1e-3 - 1.5e-6], substeps);
        scene.hold(9..18);
        let mut simulation = scene.started();
        simulation.step(990 / u64::from(substeps)).unwrap();
        assert!(work(&simulation) == 0.0 && simulation.positions()[0][2] > 0.9e-3);
    }
}

#[test]
fn layers_of_a_motion_that_goes_on_keep_their_distances() {
    let mut scene = Scene::new();
    let (points, triangles) = square(2, 2, 0.011);
    let lower = scene.add(&points, &triangles, [0.0; 3]);
    let upper = scene.add(&placed(&points, 0.0, 0.0, [0.0, 0.0, 2e-5]), &triangles, [0.0, 0.0, -1.0]);
    scene.hold(lower);
    let mut simulation = scene.started();
    simulation.step(50).unwrap();
    let height = |simulation: &Simulation| simulation.positions()[upper.start][2];
    let down: Vec<_> = scene.model.velocities.clone();
    let pressed = height(&simulation);
    assert!((pressed - 3.75e-6).abs() < 1e-9, "{pressed:e}");
    let shapes = simulation.layer_shapes();
    assert_eq!(shapes, [scene.model.positions.clone()]);
    // Set with another velocity, and in another simulation: it would go down to half of this, from new distances.
    let positions = simulation.positions();
    simulation.set_motion(&positions, &down).unwrap();
    simulation.step(50).unwrap();
    assert!((height(&simulation) - pressed).abs() < 1e-9, "{:e}", height(&simulation));
    for (shapes, expected) in [(shapes.as_slice(), pressed), (&[], 0.5 * pressed)] {
        let mut next = scene.started();
        next.start_from(0.1, &[0.0; 14], &positions, &down, None, shapes).unwrap();
        next.step(50).unwrap();
        assert!((height(&next) - expected).abs() < 1e-9, "{:e} {expected:e}", height(&next));
    }
    // Motions that are set again and again have no more shapes than a long run.
    for _ in 0..5 {
        simulation.set_motion(&simulation.positions(), &simulation.velocities()).unwrap();
        simulation.step(1000).unwrap();
    }
    assert_eq!(simulation.layer_shapes().len(), 3);
    // Moved, layers begin anew.
    let mut moved = positions;
    moved[upper.start][2] += 1e-12;
    simulation.set_motion(&moved, &down).unwrap();
    simulation.step(50).unwrap();
    assert!((height(&simulation) - 0.5 * pressed).abs() < 1e-9, "{:e}", height(&simulation));
    let few = [vec![[0.0; 3]; 3]];
    let wrong = simulation.start_from(0.1, &[0.0; 14], &moved, &down, None, &few);
    assert!(matches!(wrong, Err(Error::LengthMismatch { found: 3, .. })));
    let infinite = [vec![[f64::INFINITY; 3]; moved.len()]];
    assert!(simulation.start_from(0.1, &[0.0; 14], &moved, &down, None, &infinite).is_err());
}

#[test]
fn numbers_of_triangles_are_those_of_the_mesh() {
    let mut scene = ribbons(false);
    scene.contact.crossing_interval = 1.0;
    scene.model.layers = vec![2, 1];
    let Error::Unstable { what, .. } = scene.started().step(100).unwrap_err() else { panic!() };
    assert!(what.contains("triangles 2 and 1 of the film cross, 1 pair in all"), "{what}");
}

#[test]
fn triangles_that_are_left_out_pass() {
    let mut scene = ribbons(true);
    scene.model.layers = vec![0, 1];
    let mut simulation = scene.started();
    simulation.step(100).unwrap();
    assert!(scene.crossings(&simulation) > 0 && work(&simulation) == 0.0);
    assert!(simulation.velocities()[4..].iter().all(|v| *v == [0.0, 0.0, -1.0]));
    // None at all.
    scene.model.layers.clear();
    let mut simulation = scene.started();
    simulation.step(100).unwrap();
    assert!(scene.crossings(&simulation) > 0 && work(&simulation) == 0.0);
}

#[test]
fn methods_frozen_time_and_free_hubs_are_refused() {
    for method in ["rk4", "dopri5", "generalized_alpha"] {
        let mut scene = ribbons(true);
        scene.method = method;
        let error = scene.start().err();
        let Some(Error::Impulses { what, law, .. }) = &error else { panic!("{error:?}") };
        assert!(what.contains(method) && *law == "self_contact");
    }
    let mut frozen = ribbons(true);
    frozen.settings.frozen_at = Some(0.0);
    assert!(matches!(frozen.start().err(), Some(Error::Impulses { .. })));
    for mass in [None, Some(0.1)] {
        let mut free = ribbons(true);
        let spin = SpinParameters { frequency: 1.0, inertia: Some(1e-4), mass, ..SpinParameters::default() };
        free.specs = vec![SpinParameters { transverse_inertia: mass.map(|_| 1e-4), ..spin }.into()];
        let error = free.start().err();
        assert!(matches!(&error, Some(Error::FreeHub { what, .. }) if what.contains("self_contact")), "{error:?}");
    }
}

#[test]
fn a_start_with_crossings_is_refused() {
    let scene = ribbons(true);
    let mut crossed = scene.clone();
    crossed.model.positions[4..].iter_mut().for_each(|point| point[2] -= 1.1 * GAP);
    let Some(Error::StartsCrossed { what }) = crossed.start().err() else { panic!() };
    assert!(what.starts_with("triangles 0 and 2 of the film cross, "), "{what}");
    let mut simulation = scene.started();
    simulation.step(10).unwrap();
    let before = simulation.progress();
    let velocities = simulation.velocities();
    let error = simulation.set_motion(&crossed.model.positions, &velocities);
    assert!(matches!(error, Err(Error::StartsCrossed { .. })), "{error:?}");
    assert_eq!(simulation.progress(), before);
    // A motion that does not cross starts anew.
    simulation.set_motion(&scene.model.positions, &scene.model.velocities).unwrap();
    simulation.step(100).unwrap();
    assert_eq!(scene.crossings(&simulation), 0);
}

#[test]
fn parameters_out_of_range_are_refused() {
    let wrong = [
        SelfContactParameters { thickness: Some(0.0), ..PLAIN },
        SelfContactParameters { thickness: Some(f64::NAN), ..PLAIN },
        SelfContactParameters { thickness: Some(f64::INFINITY), ..PLAIN },
        SelfContactParameters { cord_thickness: -1e-6, ..PLAIN },
        SelfContactParameters { cord_thickness: f64::NAN, ..PLAIN },
        SelfContactParameters { friction: -0.1, ..PLAIN },
        SelfContactParameters { friction: f64::INFINITY, ..PLAIN },
        SelfContactParameters { restitution: 1.5, ..PLAIN },
        SelfContactParameters { restitution: -0.1, ..PLAIN },
        SelfContactParameters { restitution: f64::NAN, ..PLAIN },
        SelfContactParameters { crossing_interval: 0.0, ..PLAIN },
        SelfContactParameters { crossing_interval: f64::NAN, ..PLAIN },
    ];
    for contact in wrong {
        let scene = Scene { contact, ..ribbons(true) };
        assert!(matches!(scene.start().err(), Some(Error::OutOfRange { .. })), "{contact:?}");
    }
}

/// All numbers are finite, and momentum is that of the start. Layers that start without a distance may cross, which
/// stops the run.
fn check_momentum(scene: &Scene, steps: u64) -> f64 {
    let mut simulation = scene.started();
    let before = momenta(&simulation)[0];
    let mut crossed = 0;
    for _ in 0..steps {
        if let Err(error) = simulation.step(1) {
            let what = error.to_string();
            assert!(crossed > 0, "{what}");
            assert!(
                what.contains("two layers pass through each other") || what.contains("of the film cross"),
                "{what}"
            );
            break;
        }
        crossed = scene.crossings(&simulation);
    }
    let size: f64 = simulation.masses().iter().zip(simulation.velocities()).map(|(m, v)| m * v[2].abs()).sum();
    assert!((momenta(&simulation)[0] - before).norm() <= 1e-13 * size.max(before.norm()));
    assert!(simulation.positions().iter().chain(&simulation.velocities()).flatten().all(|value| value.is_finite()));
    work(&simulation)
}

#[test]
fn bridged_nodes_at_one_place_feel_nothing() {
    let mut scene = Scene::new();
    let (points, triangles) = square(4, 1, 0.011);
    scene.add(&placed(&points, 0.0, 0.0, [0.0, 0.0055, 0.0]), &triangles, [0.0; 3]);
    scene.add(&placed(&points, 2.0, 0.0, [0.0, 0.0055 * 2.0_f64.cos(), 0.0055 * 2.0_f64.sin()]), &triangles, [0.0; 3]);
    // The first row of each is the line they have in common.
    for node in 0..5 {
        let [a, b] = [node, node + 10].map(|node| scene.model.positions[node]);
        assert!((0..3).all(|axis| (a[axis] - b[axis]).abs() < 1e-15));
        scene.model.positions[node + 10] = a;
    }
    scene.model.bridges = Bridges { nodes: (0..5).map(|node| [node, node + 10]).collect(), stiffness: 1e3 };
    scene.specs = vec![springs(), LawSpec::SpringDamping(0.02.into())];
    assert_eq!(check_momentum(&scene, 200), 0.0);
    // Without bridges, layers that touch in nodes and sides have no direction in which to part.
    scene.model.bridges = Bridges::default();
    check_momentum(&scene, 200);
    let shakes = Dice(3).vectors(20, 0.05);
    scene.model.velocities = shakes;
    check_momentum(&scene, 400);
}

#[test]
fn layers_in_one_plane_start_and_go_on() {
    let mut scene = Scene::new();
    let (points, triangles) = square(3, 3, 0.011);
    scene.add(&points, &triangles, [0.0; 3]);
    scene.add(&placed(&points, 0.0, 0.3, [0.003, 0.002, 0.0]), &triangles, [0.0, 0.0, 0.1]);
    assert_eq!(check_momentum(&scene, 300), 0.0);
    scene.model.velocities = Dice(5).vectors(32, 0.1);
    scene.specs = vec![springs(), LawSpec::SpringDamping(0.02.into())];
    check_momentum(&scene, 1200);
}

#[test]
fn collapsed_triangles_are_stopped() {
    for collapse in [0.0, 1e-12, 1e-6] {
        let mut scene = Scene::new();
        let (points, triangles) = square(3, 3, 0.011);
        let floor = scene.add(&placed(&points, 0.0, 0.2, [0.0; 3]), &triangles, [0.0; 3]);
        scene.hold(floor);
        let (points, triangles) = triangle(0.006);
        let nodes = scene.add(&placed(&points, 0.0, 0.1, [1e-3, 2e-3, 1e-4]), &triangles, [0.0, 0.0, -1.0]);
        for point in &mut scene.model.positions[nodes.clone()] {
            point[1] = 2e-3 + collapse * (point[1] - 2e-3);
        }
        let mut simulation = scene.started();
        simulation.step(300).unwrap();
        let heights: Vec<f64> = simulation.positions()[nodes].iter().map(|point| point[2]).collect();
        assert!(heights.iter().all(|height| (3e-6..7e-6).contains(height)), "{collapse}: {heights:?}");
    }
}
