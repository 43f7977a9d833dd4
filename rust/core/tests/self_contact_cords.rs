//! Cords and layers keep to their sides.
#![allow(missing_docs, clippy::unwrap_used, clippy::panic)]

mod common;
#[path = "common/sheets.rs"]
mod sheets;

use common::springs;
use membrane_core::error::Error;
use membrane_core::laws::LawSpec;
use membrane_core::model::input::{Cord, Motion};
use membrane_core::model::schedule::Schedule;
use sheets::{Scene, placed, square, work};

/// Adds a taut cord of equal segments between two points; its first node.
fn cord(scene: &mut Scene, [from, to]: [[f64; 3]; 2], segments: u32, velocity: [f64; 3]) -> usize {
    let model = &mut scene.model;
    let first = model.positions.len() as u32;
    let at = |k: u32| [0, 1, 2].map(|axis| from[axis] + (to[axis] - from[axis]) * f64::from(k) / f64::from(segments));
    for k in 0..=segments {
        model.positions.push(at(k));
        model.velocities.push(velocity);
        model.extra_masses.push(1e-6);
    }
    let length = (0..3).map(|axis| (to[axis] - from[axis]).powi(2)).sum::<f64>().sqrt() / f64::from(segments);
    model.cords.extend((first..first + segments).map(|node| Cord {
        nodes: [node, node + 1],
        stiffness: 100.0 / length,
        rest_length: 0.999 * length,
        strain_limit: 1e9,
        ..Default::default()
    }));
    first as usize
}

#[test]
fn a_thick_cord_does_not_let_layers_approach_faster() {
    let error = |diameter: f64| {
        let mut scene = Scene::new();
        let (points, triangles) = square(4, 4, 0.011);
        scene.add(&points, &triangles, [0.0; 3]);
        scene.add(&placed(&points, 0.0, 0.3, [2e-3, 1e-3, 1e-3]), &triangles, [0.0, 0.0, -200.0]);
        cord(&mut scene, [[0.0, 0.0, 1.0], [0.05, 0.0, 1.0]], 2, [0.0; 3]);
        scene.contact.cord_thickness = diameter;
        scene.started().step(20).unwrap_err().to_string()
    };
    let known = error(0.0);
    assert!(known.contains("two layers approach by 2.000e-4 m"), "{known}");
    assert!(known.contains("beyond 1.200e-4 m"), "{known}");
    assert_eq!(error(1e-3), known);
}

#[test]
fn a_cord_thrown_across_a_held_sheet_lies_on_it() {
    for (segments, turn) in [(1, 0.2), (1, 0.0), (7, 0.2), (8, 0.0)] {
        for cords in [true, false] {
            let mut scene = Scene::new();
            let (points, triangles) = square(4, 4, 0.011);
            let floor = scene.add(&placed(&points, 0.0, turn, [0.0; 3]), &triangles, [0.0; 3]);
            scene.hold(floor);
            let ends = [[-0.03, 0.001, 2e-4], [0.03, 0.001, 2e-4]];
            let first = cord(&mut scene, ends, segments, [0.0, 0.0, -1.0]);
            scene.contact.cords = cords;
            let mut simulation = scene.started();
            simulation.step(400).unwrap();
            let positions = simulation.positions();
            let middle = first + segments as usize / 2;
            let height = if segments == 1 {
                0.5 * (positions[first][2] + positions[first + 1][2])
            } else {
                positions[middle][2]
            };
            // The distance is that of half the sum of both thicknesses.
            let is_above = height > 0.5 * 0.5 * (7.5e-6 + 1e-5) * 0.99;
            assert!(is_above == cords && (work(&simulation) < 0.0) == cords, "{segments}, {turn}, {cords}: {height:e}");
        }
    }
}

#[test]
fn the_edge_of_a_sheet_stays_on_a_cord() {
    for cords in [true, false] {
        let mut scene = Scene::new();
        let (points, triangles) = square(3, 2, 0.011);
        let upright = placed(&points, std::f64::consts::FRAC_PI_2, 0.0, [0.0, 0.0, 0.0111]);
        scene.add(&upright, &triangles, [0.0, 0.0, -1.0]);
        let first = cord(&mut scene, [[0.0, -0.02, 0.0], [0.0, 0.021, 0.0]], 1, [0.0; 3]);
        scene.hold(first..first + 2);
        scene.specs = vec![springs(), LawSpec::SpringDamping(0.02.into())];
        scene.contact.cords = cords;
        let mut simulation = scene.started();
        // The middle of the lower edge, between its second and third node.
        let mut lowest = f64::INFINITY;
        for _ in 0..60 {
            simulation.step(10).unwrap();
            let positions = simulation.positions();
            lowest = lowest.min(0.5 * (positions[1][2] + positions[2][2]));
        }
        assert_eq!(lowest > 4e-6, cords, "{lowest:e}");
        assert_eq!(work(&simulation) < 0.0, cords);
    }
}

#[test]
fn cords_pass_through_each_other() {
    let mut scene = Scene::new();
    let (points, triangles) = square(1, 1, 0.011);
    scene.add(&placed(&points, 0.0, 0.0, [0.0, 0.0, 0.5]), &triangles, [0.0; 3]);
    cord(&mut scene, [[-0.02, 0.0, 0.0], [0.02, 0.0, 0.0]], 1, [0.0; 3]);
    cord(&mut scene, [[0.0, -0.02, 1e-4], [0.0, 0.02, 1e-4]], 1, [0.0, 0.0, -1.0]);
    let mut simulation = scene.started();
    simulation.step(200).unwrap();
    assert_eq!(work(&simulation), 0.0);
}

#[test]
fn a_cord_through_a_sheet_is_refused_at_the_start_stopped_at_once_and_found_at_the_end() {
    let mut scene = Scene::new();
    let (points, triangles) = square(4, 4, 0.011);
    let floor = scene.add(&points, &triangles, [0.0; 3]);
    scene.hold(floor);
    let first = cord(&mut scene, [[0.001, 0.002, -0.01], [0.001, 0.002, 0.01]], 1, [0.0; 3]);
    let Some(Error::StartsCrossed { what }) = scene.start().err() else { panic!("{first} goes through") };
    assert!(
        what.contains(&format!("the cord between nodes {first} and {} goes through triangle", first + 1)),
        "{what}"
    );
    // What is held and what moves as prescribed feel no impulse.
    for node in [first, first + 1] {
        scene.model.positions[node][2] += 0.011;
    }
    let down = Schedule::new(vec![0.0, 1e-3], vec![0.0, -0.01], 0.0).unwrap();
    let nodes = vec![first as u32, first as u32 + 1];
    scene.model.motions = vec![Motion { nodes, displacement: [None, None, Some(down)], turn: None }];
    scene.dt = Some(1e-5);
    let Err(Error::Unstable { what, law, step, .. }) = scene.started().step(100) else { panic!("nothing is stopped") };
    assert!(what.contains("two layers pass through each other, which impulses cannot stop"), "{what}");
    assert!(law == "self_contact" && (8..=10).contains(&step), "{step}");
    // From the side, without pairs of edges.
    scene.contact.scheme.has_edges = false;
    let across = Schedule::new(vec![0.0, 1e-3], vec![0.0, -0.02], 0.0).unwrap();
    for node in [first, first + 1] {
        scene.model.positions[node][0] += 0.03;
        scene.model.positions[node][2] -= 0.011;
    }
    scene.model.motions[0].displacement = [Some(across), None, None];
    let mut simulation = scene.started();
    simulation.step(100).unwrap();
    let Err(Error::Unstable { what, law, .. }) = simulation.check(true) else { panic!("nothing is found") };
    assert!(what.contains("goes through triangle") && law == "self_contact", "{what}");
}
