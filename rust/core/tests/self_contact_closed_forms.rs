//! Contact between layers against closed forms: impacts with restitution, and Coulomb's friction, slow and fast.
#![allow(missing_docs, clippy::unwrap_used)]

mod common;
#[path = "common/sheets.rs"]
mod sheets;

use common::{Dice, gravity, spin};
use membrane_core::simulation::Simulation;
use nalgebra::Vector3;
use sheets::{Scene, mean_velocity, momenta, placed, square, triangle, work};

const SIDE: f64 = 0.011;
const GRAVITY: f64 = 9.81;
/// The distance at which layers touch [m], and fast pairs: how often they move by it in a step.
const TOUCHING: f64 = 7.5e-6;
const FAST: [f64; 3] = [2.0, 5.0, 10.0];

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

/// A node at a slant onto the middle of a triangle, at -1 m/s along its normal and this speed along it; both ways.
/// They meet in the third step, of which this share has gone then.
fn at_a_slant(along: f64, ways: f64, share: f64) -> (Scene, Vector3<f64>, Vector3<f64>) {
    let mut scene = node_on_triangle(1.0, 0.0);
    let [tangent, normal] =
        [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]].map(|axis| Vector3::from(placed(&[axis], 0.3, 0.2, [0.0; 3])[0]));
    let dt = ways * TOUCHING / along.hypot(1.0);
    let velocity = tangent * along - normal;
    scene.model.positions[3] = (0.5 * TOUCHING * normal - velocity * dt * (2.0 + share)).into();
    scene.model.velocities[3] = velocity.into();
    scene.dt = Some(dt);
    (scene, tangent, normal)
}

/// Speeds along a held layer, restitutions, frictions, thicknesses a step, and when in the step they meet.
fn slants() -> impl Iterator<Item = [f64; 5]> {
    let shares = [0.02, 0.3, 0.5, 0.7, 0.98];
    let cases = FAST.into_iter().flat_map(move |ways| shares.map(|share| [ways, share]));
    let coefficients = [0.0, 0.5, 1.0].into_iter().flat_map(|restitution| [0.0, 0.3].map(|mu| [restitution, mu]));
    let all = coefficients.flat_map(move |[restitution, mu]| cases.clone().map(move |[w, s]| [restitution, mu, w, s]));
    all.flat_map(|[restitution, mu, ways, share]| [0.0, 0.5, 1.0, 4.0].map(|v| [v, restitution, mu, ways, share]))
}

#[test]
fn a_fast_node_leaves_a_held_layer_by_newtons_restitution_and_coulombs_friction() {
    for [along, restitution, friction, ways, share] in slants() {
        let (mut scene, tangent, normal) = at_a_slant(along, ways, share);
        scene.hold(0..3);
        (scene.contact.restitution, scene.contact.friction) = (restitution, friction);
        let mut simulation = scene.started();
        for _ in 0..8 {
            simulation.step(1).unwrap();
            assert!(Vector3::from(simulation.positions()[3]).dot(&normal) > 0.0);
        }
        let slower = (along - friction * (1.0 + restitution)).max(0.0);
        let off = Vector3::from(simulation.velocities()[3]) - normal * restitution - tangent * slower;
        assert!(off.norm() < 1e-10, "{along} {restitution} {friction} {ways} {share}: {off:?}");
    }
}

#[test]
fn a_fast_node_gives_a_free_triangle_its_impulse() {
    for [along, restitution, friction, ways, share] in slants().filter(|[_, restitution, ..]| *restitution > 0.0) {
        let (mut scene, tangent, normal) = at_a_slant(along, ways, share);
        (scene.contact.restitution, scene.contact.friction) = (restitution, friction);
        let mut simulation = scene.started();
        let (start, before) = (simulation.energy_terms().kinetic, momenta(&simulation)[0]);
        simulation.step(8).unwrap();
        // The reduced mass is three quarters of that of a node: to second order in the way beside the centroid.
        let pressed = 0.75 * (1.0 + restitution);
        let slower = along - (friction * pressed).min(0.75 * along);
        let off = Vector3::from(simulation.velocities()[3]) - normal * (pressed - 1.0) - tangent * slower;
        assert!(off.norm() < 2e-3, "{along} {restitution} {friction} {ways} {share}: {off:?}");
        assert!((momenta(&simulation)[0] - before).norm() < 1e-14 * before.norm());
        assert!(simulation.energy_terms().kinetic < start * (1.0 + 1e-14));
    }
}

#[test]
fn an_impact_that_follows_from_another_in_the_step_has_its_restitution() {
    for restitution in [0.5, 1.0] {
        // The middle sheet meets the floor within the first step, and only then the upper one, at the same step's end.
        let (points, triangles) = square(3, 3, SIDE);
        let mut scene = Scene::new();
        let floor = scene.add(&points, &triangles, [0.0; 3]);
        scene.hold(floor);
        let [middle, upper] = [[5e-6, -1.0], [25e-6, -2.0]].map(|[height, speed]| {
            scene.add(&placed(&points, 0.0, 0.0, [0.0, 0.0, height]), &triangles, [0.0, 0.0, speed])
        });
        (scene.dt, scene.contact.restitution) = (Some(1e-5), restitution);
        let mut simulation = scene.started();
        simulation.step(1).unwrap();
        let all = simulation.velocities();
        for (nodes, expected) in [(middle, restitution), (upper, 2.0 * restitution)] {
            assert!(all[nodes].iter().all(|v| (v[2] - expected).abs() < 5e-3), "{restitution}: {all:?}");
        }
    }
}

#[test]
fn fast_sheets_gain_no_energy_where_nothing_is_lost() {
    let mut dice = Dice(7);
    for ways in [2.0, 3.0, 5.0, 7.0, 10.0, 15.0] {
        for tilt in [0.0_f64, 0.0, 0.0, 0.01, 0.1, 0.5, 1.0, 1.4] {
            let mut scene = Scene::new();
            let (points, triangles) = if dice.roll() < 0.0 { square(8, 1, SIDE) } else { square(4, 4, SIDE) };
            scene.add(&points, &triangles, [0.0; 3]);
            let half = points.iter().map(|point| point[1]).fold(0.0, f64::max) * tilt.sin();
            let [x, y] = [0.5 * SIDE * dice.roll(), 0.5 * SIDE * dice.roll()];
            let velocity = Vector3::new(3.5 * dice.roll(), 3.5 * dice.roll(), -5.0);
            let thrown = placed(&points, tilt, 3.0 * dice.roll(), [x, y, half + 16.0 * TOUCHING]);
            let upper = scene.add(&thrown, &triangles, velocity.into());
            (scene.dt, scene.contact.restitution) = (Some(ways * TOUCHING / velocity.norm()), 1.0);
            scene.contact.crossing_interval = 1.0;
            let mut simulation = scene.started();
            let (start, mut most) = (simulation.energy_terms().kinetic, f64::NEG_INFINITY);
            let steps = (2.0 * half + 48.0 * TOUCHING) / (5.0 * simulation.dt());
            for _ in 0..steps.min(400.0) as u64 + 8 {
                simulation.step(1).unwrap();
                most = most.max(work(&simulation) / start);
            }
            let change = mean_velocity(&simulation, upper) - velocity;
            assert!(most < 1e-4 && change.norm() > 1e-3, "{ways}, {tilt}: {most:e} {change:?}");
        }
    }
}

/// A triangle on a held layer, in contact from the start, both tilted; the direction of the steepest descent.
fn slope(tilt: f64, friction: f64, speed: f64, dt: f64) -> (Simulation, Vector3<f64>) {
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
    (scene.contact.friction, scene.dt) = (friction, Some(dt));
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
    let fast = FAST.map(|ways| (0.5, 0.9, ways * TOUCHING / 0.9));
    for (friction, speed, dt) in [(0.2, 0.1, 2e-5), (0.5, 0.2, 2e-5)].into_iter().chain(fast) {
        let (time, way) = (speed / (friction * GRAVITY), speed * speed / (2.0 * friction * GRAVITY));
        let run = |time| {
            let (simulation, direction) = slope(0.0, friction, speed, dt);
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
        let (simulation, descent) = slope(tilt, friction, 0.0, 2e-5);
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
