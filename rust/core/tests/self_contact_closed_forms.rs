//! Contact between layers against closed forms: impacts with restitution, and Coulomb's friction.
#![allow(missing_docs, clippy::unwrap_used)]

mod common;
#[path = "common/sheets.rs"]
mod sheets;

use common::{gravity, spin};
use membrane_core::simulation::Simulation;
use nalgebra::Vector3;
use sheets::{Scene, mean_velocity, placed, square, triangle, work};

const SIDE: f64 = 0.011;
const GRAVITY: f64 = 9.81;

/// A free triangle, and a node at -V above its centroid: a corner of a triangle whose others are held far above.
fn node_on_triangle(speed: f64, restitution: f64) -> Scene {
    let mut scene = Scene::new();
    let (points, triangles) = triangle(SIDE);
    scene.add(&placed(&points, 0.3, 0.2, [0.0; 3]), &triangles, [0.0; 3]);
    scene.add(&points, &triangles, [0.0; 3]);
    let normal = Vector3::from(placed(&[[0.0, 0.0, 1.0]], 0.3, 0.2, [0.0; 3])[0]);
    for (node, [along, across]) in [(3, [1e-4, 0.0]), (4, [0.03, 0.004]), (5, [0.03, -0.004])] {
        scene.model.positions[node] = (normal * along + Vector3::new(across, 0.0, 0.0)).into();
    }
    scene.model.velocities[3] = (-speed * normal).into();
    scene.hold(4..6);
    scene.contact.restitution = restitution;
    scene
}

#[test]
fn a_node_on_the_centroid_of_a_triangle_moves_with_it_at_a_quarter_of_its_velocity() {
    let normal = Vector3::from(placed(&[[0.0, 0.0, 1.0]], 0.3, 0.2, [0.0; 3])[0]);
    for speed in [0.1, 1.0, 20.0] {
        for restitution in [0.0, 0.5, 1.0] {
            let mut simulation = node_on_triangle(speed, restitution).started();
            let start = simulation.energy_terms().kinetic;
            simulation.step((1.5e-4 / speed / 1e-6) as u64).unwrap();
            let after = simulation.velocities().into_iter().map(Vector3::from).collect::<Vec<_>>();
            // m v + 3 m w = -m V with v - w = e V.
            let (node, others) = (-0.25 + 0.75 * restitution, -0.25 - 0.25 * restitution);
            assert!((after[3] - speed * node * normal).norm() < 1e-12 * speed, "{restitution}: {:?}", after[3]);
            for other in &after[..3] {
                assert!((other - speed * others * normal).norm() < 1e-12 * speed, "{restitution}: {other:?}");
            }
            let lost = 0.75 * (1.0 - restitution * restitution);
            assert!((work(&simulation) / start + lost).abs() < 1e-12, "{restitution}");
            assert!((simulation.energy_terms().kinetic / start - 1.0 + lost).abs() < 1e-12, "{restitution}");
        }
    }
}

#[test]
fn impulses_stop_the_drift_with_what_coriolis_adds_to_them() {
    let normal = Vector3::from(placed(&[[0.0, 0.0, 1.0]], 0.3, 0.2, [0.0; 3])[0]);
    for rate in [0.0, 1e3, 1e4] {
        let mut scene = node_on_triangle(1.0, 0.0);
        let distance = 6e-6;
        scene.model.positions[3] = (distance * normal).into();
        (scene.specs, scene.dt) = (vec![spin(rate, 0.0)], Some(1e-5));
        let mut simulation = scene.started();
        simulation.step(1).unwrap();
        // By the weights at the centroid and the direction of the contact, which keeps half of the distance at first.
        let x: Vec<_> = simulation.positions().into_iter().map(Vector3::from).collect();
        let after = (x[3] - (x[0] + x[1] + x[2]) / 3.0).dot(&normal);
        assert!(work(&simulation) < 0.0 && (after / (0.5 * distance) - 1.0).abs() < 1e-9, "{rate}: {after:e}");
    }
}

#[test]
fn equal_sheets_node_on_node_exchange_their_velocities_where_nothing_is_lost() {
    for restitution in [0.0, 0.5, 1.0] {
        let mut scene = Scene::new();
        let (points, triangles) = square(3, 3, SIDE);
        scene.add(&points, &triangles, [0.0; 3]);
        scene.add(&placed(&points, 0.0, 0.0, [0.0, 0.0, 1e-4]), &triangles, [0.0, 0.0, -1.0]);
        scene.contact.restitution = restitution;
        let mut simulation = scene.started();
        simulation.step(200).unwrap();
        let all = simulation.velocities();
        let (lower, upper) = all.split_at(points.len());
        for (nodes, expected) in [(lower, -0.5 - 0.5 * restitution), (upper, -0.5 + 0.5 * restitution)] {
            assert!(nodes.iter().all(|v| (v[2] - expected).abs() < 2e-3), "{restitution}: {nodes:?}");
        }
    }
}

/// A triangle on a held layer, in contact from the start, both tilted; the direction of the steepest descent.
fn slope(tilt: f64, friction: f64, speed: f64) -> (Simulation, Vector3<f64>) {
    let mut scene = Scene::new();
    let (points, triangles) = square(2, 1, 0.2);
    let floor = scene.add(&placed(&points, tilt, 0.4, [0.0; 3]), &triangles, [0.0; 3]);
    scene.hold(floor);
    let turn = |point: [f64; 3]| placed(&[point], tilt, 0.4, [0.0; 3])[0];
    let (normal, descent) = (turn([0.0, 0.0, 1e-7]), turn([0.0, -1.0, 0.0]));
    let (points, triangles) = triangle(SIDE);
    let points: Vec<_> = placed(&points, 0.0, 0.1, [0.003, 0.05, 0.0]);
    let velocity = (speed * Vector3::from(descent)).into();
    scene.add(&placed(&points, tilt, 0.4, normal), &triangles, velocity);
    scene.specs = vec![gravity([0.0, 0.0, -GRAVITY])];
    scene.contact.friction = friction;
    scene.dt = Some(2e-5);
    (scene.started(), descent.into())
}

/// Distance [m] and mean velocity [m/s] along a direction after some time.
fn along(mut simulation: Simulation, direction: Vector3<f64>, time: f64) -> [f64; 2] {
    let nodes = 6..9;
    let place = |simulation: &Simulation| {
        simulation.positions()[nodes.clone()].iter().map(|p| Vector3::from(*p)).sum::<Vector3<f64>>() / 3.0
    };
    let before = place(&simulation);
    simulation.step((time / simulation.dt()).round() as u64).unwrap();
    [(place(&simulation) - before).dot(&direction), mean_velocity(&simulation, nodes.clone()).dot(&direction)]
}

#[test]
fn a_piece_of_film_slides_to_a_stop_by_coulombs_law() {
    for (friction, speed) in [(0.2, 0.1), (0.5, 0.2)] {
        let (time, way) = (speed / (friction * GRAVITY), speed * speed / (2.0 * friction * GRAVITY));
        let run = |time| {
            let (simulation, direction) = slope(0.0, friction, speed);
            along(simulation, direction, time)
        };
        let [half, still_fast] = run(0.5 * time);
        assert!((half / (0.75 * way) - 1.0).abs() < 0.01, "{friction}: {half} {way}");
        assert!((still_fast / (0.5 * speed) - 1.0).abs() < 0.01, "{friction}: {still_fast}");
        let [whole, none] = run(1.05 * time);
        assert!((whole / way - 1.0).abs() < 0.01 && none.abs() < 1e-6 * speed, "{friction}: {whole} {way} {none}");
    }
}

#[test]
fn it_stays_on_a_slope_below_the_angle_of_friction_and_slides_above() {
    let (friction, time) = (0.3_f64, 0.02);
    for tilt in [0.9, 1.2, 2.0].map(|share| share * friction.atan()) {
        let (simulation, descent) = slope(tilt, friction, 0.0);
        let [way, speed] = along(simulation, descent, time);
        let acceleration = GRAVITY * (tilt.sin() - friction * tilt.cos());
        if acceleration < 0.0 {
            // At rest is the velocity of the drift, half a kick of the weight later.
            let kick = 0.5 * 2e-5 * GRAVITY * tilt.sin();
            assert!(way.abs() < 1e-7 && (speed + kick).abs() < 1e-6 * kick, "{tilt}: {way:e} {speed:e}");
        } else {
            assert!((speed / (acceleration * time) - 1.0).abs() < 0.02, "{tilt}: {speed} {acceleration}");
        }
    }
}
