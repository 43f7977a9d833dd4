//! Contact at borders: over edges within a layer, beside free edges, off the edge of a fold, and of edges that swing.
#![allow(missing_docs, clippy::unwrap_used)]

mod common;
#[path = "common/sheets.rs"]
mod sheets;

use common::gravity;
use nalgebra::Vector3;
use sheets::{Points, Scene, mean_velocity, placed, square, triangle, work};

const GRAVITY: f64 = 9.81;
/// The distance at which layers touch, and that which they keep [m].
const TOUCHING: f64 = 7.5e-6;
const KEPT: f64 = 0.5 * TOUCHING;

/// A held layer, and a corner of a free triangle, whose others are 50 mm above it, with a velocity and a step.
fn corner_at(layer: &Points, triangles: &[[u32; 3]], at: [f64; 3], velocity: [f64; 3], dt: f64) -> (Scene, usize) {
    let mut scene = Scene::new();
    let held = scene.add(layer, triangles, [0.0; 3]);
    scene.hold(held);
    let [x, y, z] = at;
    let points = [at, [x - 1e-4, y + 1e-4, z + 0.05], [x + 1e-4, y + 2e-4, z + 0.05]];
    let node = scene.add(&points, &[[0, 1, 2]], velocity).start;
    (scene.dt, scene.contact.crossing_interval) = (Some(dt), 1.0);
    (scene, node)
}

#[test]
fn a_piece_of_film_keeps_its_speed_over_the_edges_of_a_flat_layer() {
    let turned = |point: [f64; 3]| Vector3::from(placed(&[point], 0.3, 0.0, [0.0; 3])[0]);
    // It sinks onto the layer, or is pressed on it.
    for (sink, gravity_of) in [(0.1, 0.0), (0.0, GRAVITY), (0.0, 100.0 * GRAVITY)] {
        for ways in [0.02, 0.1, 0.3, 1.0, 2.0, 5.0, 10.0] {
            let mut scene = Scene::new();
            let (points, triangles) = square(14, 8, 1e-3);
            let floor = scene.add(&placed(&points, 0.3, 0.0, [0.0; 3]), &triangles, [0.0; 3]);
            scene.hold(floor);
            let (points, triangles) = triangle(3.7e-3);
            let points = placed(&points, 0.0, 0.1, [-3.5e-3, -7e-4, 1.1 * TOUCHING]);
            let velocity = turned([1.0, 0.2, -sink]).into();
            let upper = scene.add(&placed(&points, 0.3, 0.0, [0.0; 3]), &triangles, velocity);
            scene.specs = vec![gravity(turned([0.0, 0.0, -gravity_of]).into())];
            let dt = ways * TOUCHING;
            (scene.dt, scene.contact.crossing_interval) = (Some(dt), 100.0);
            let mut simulation = scene.started();
            simulation.step((5e-3 / dt) as u64).unwrap();
            let share = mean_velocity(&simulation, upper.clone()).dot(&turned([1.0, 0.2, 0.0])) / 1.04;
            assert!((share - 1.0).abs() < 1e-4, "{sink}, {gravity_of}, {ways}: {share}");
            let normal = turned([0.0, 0.0, 1.0]);
            let is_above = |x: &[f64; 3]| Vector3::from(*x).dot(&normal) > 0.9 * KEPT;
            assert!(simulation.positions()[upper].iter().all(is_above), "{sink}, {gravity_of}, {ways}");
        }
    }
}

#[test]
fn a_node_that_falls_beside_a_free_edge_has_no_impulse() {
    let (points, triangles) = square(4, 4, 1e-3);
    for (ways, beside) in [(0.5, 1.2), (1.0, 1.5), (5.0, 4.0), (10.0, 8.0)] {
        for restitution in [0.0, 1.0] {
            let at = [-2e-3 - beside * KEPT, 3.7e-4, 8.0 * ways * KEPT];
            let (mut scene, node) = corner_at(&points, &triangles, at, [0.0, 0.0, -1.0], ways * TOUCHING);
            scene.contact.restitution = restitution;
            let mut simulation = scene.started();
            simulation.step(12).unwrap();
            assert!(work(&simulation) == 0.0 && simulation.positions()[node][2] < 0.0, "{ways}, {restitution}");
        }
    }
}

#[test]
fn a_node_slides_off_the_edge_of_a_fold() {
    let (flat, triangles) = square(8, 6, 1e-3);
    for fold in [45.0_f64, 90.0, 120.0, 150.0, 170.0].map(f64::to_radians) {
        let bent = |&[x, y, z]: &[f64; 3]| if x > 0.0 { [x * fold.cos(), y, z - x * fold.sin()] } else { [x, y, z] };
        let layer: Points = flat.iter().map(bent).collect();
        // It falls on the layer, and is pressed on it up to the edge.
        for (gravity_of, ways) in [(GRAVITY, [0.1, 0.3, 1.0, 10.0]), (100.0 * GRAVITY, [0.1, 0.3, 1.0, 3.0])] {
            for (ways, share) in ways.into_iter().flat_map(|ways| [0.0, 0.3, 0.7].map(|share| (ways, share))) {
                let at = [-1.5e-3 - share * ways * TOUCHING, 1.3e-4, 2.2 * KEPT];
                let (mut scene, node) = corner_at(&layer, &triangles, at, [1.0, 0.0, 0.0], ways * TOUCHING);
                scene.specs = vec![gravity([0.0, 0.0, -gravity_of])];
                let mut simulation = scene.started();
                simulation.step((1.5e-3 / (ways * TOUCHING)) as u64 + 8).unwrap();
                let [along, ..] = simulation.velocities()[node];
                let place = format!("{fold}, {gravity_of}, {ways}, {share}");
                assert!((along - 1.0).abs() < 1e-9 && work(&simulation) < 0.0, "{place}: {along}");
                assert!(simulation.positions()[node][0] > 0.0, "{place}");
            }
        }
    }
}

#[test]
fn a_node_on_an_edge_that_stands_upright_stays_there() {
    let (flat, triangles) = square(4, 4, 1e-3);
    let layer: Points = flat.iter().map(|&[x, y, _]| [x, 0.0, y]).collect();
    // Its gap is oblique: it keeps less, by twice the depth at which 2.5 mm/s is the push, or by a tenth.
    for (dt, kept) in [(1e-7, 1.0 - 2.0 * 2.5e-3 * 1e-7 / 0.02 / KEPT), (1e-5, 0.9)] {
        for speed in [1e-3, 0.01, 0.1] {
            let at = [3e-4, 0.0, 2e-3 + 2.5 * KEPT];
            let (scene, node) = corner_at(&layer, &triangles, at, [0.0, 0.0, -speed], dt);
            let mut simulation = scene.started();
            simulation.step((4.0 * KEPT / speed / dt) as u64 + 4).unwrap();
            let [.., up] = simulation.velocities()[node];
            let height = (simulation.positions()[node][2] - 2e-3) / KEPT;
            assert!(work(&simulation) < 0.0 && up.abs() < 1e-9 * speed, "{dt}, {speed}: {up:e}");
            assert!((height - kept).abs() < 1e-3, "{dt}, {speed}: {height}");
        }
    }
}

#[test]
fn an_edge_whose_other_end_swings_through_another_is_stopped() {
    let mut scene = Scene::new();
    // Its edge is along x.
    let held = scene.add(&[[-1e-3, 0.0, 0.0], [2e-3, 0.0, 0.0], [5e-4, -3e-3, 0.0]], &[[0, 1, 2]], [0.0; 3]);
    scene.hold(held);
    // An edge across it at 2.75 d_m, which turns about its middle by 8 d_m a step at both ends, and slides such that
    // the end that sinks comes above the other edge: the closest points of the start do not approach.
    let slide = 20.0 * KEPT;
    let ends = [[2e-4, -slide, 1.5 * KEPT], [6e-4, slide, 4.0 * KEPT], [4e-4, 0.0, 3.5e-4]];
    let upper = scene.add(&ends, &[[0, 1, 2]], [0.0; 3]);
    let dt = 1e-5;
    for (node, rise) in upper.clone().zip([8.0, -8.0, 0.0]) {
        scene.model.velocities[node] = [0.0, -0.8 * slide / dt, rise * KEPT / dt];
    }
    scene.dt = Some(dt);
    let mut simulation = scene.started();
    simulation.step(1).unwrap();
    let x = simulation.positions();
    let [first, second] = [x[upper.start], x[upper.start + 1]];
    let share = first[1] / (first[1] - second[1]);
    let height = first[2] + share * (second[2] - first[2]);
    assert!((0.0..1.0).contains(&share) && (0.9 * KEPT..1.1 * KEPT).contains(&height), "{share}: {}", height / KEPT);
    assert!(work(&simulation) < 0.0);
}
