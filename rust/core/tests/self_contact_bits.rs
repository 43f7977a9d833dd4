//! Contact between layers gives the same bits at every instruction set, whole or in pieces, and whatever the lists.
#![allow(missing_docs, clippy::unwrap_used, clippy::panic)]

mod common;
#[path = "common/sheets.rs"]
mod sheets;

use common::{Dice, gravity, spin, springs};
use membrane_core::laws::{LawSpec, Scheme};
use membrane_core::simd::dispatch::InstructionSet;
use membrane_core::simulation::{Progress, Simulation};
use sheets::{Scene, placed, row, square};

const LAYERS: usize = 4;
const STEPS: u64 = 2010;

/// Layers 2 um apart, turned and shifted against each other, that are shaken; a cord lies across the uppermost.
fn stack(substeps: u32) -> Scene {
    let mut scene = Scene::new();
    let (points, triangles) = square(2, 2, 0.011);
    for layer in 0..LAYERS {
        let at = layer as f64;
        let shift = [1.3e-3 * at, -0.7e-3 * at, 2e-6 * at];
        scene.add(&placed(&points, 0.0, 0.05 * at, shift), &triangles, [0.0; 3]);
    }
    let model = &mut scene.model;
    let first = model.positions.len() as u32;
    for k in 0..5 {
        model.positions.push([0.015 * (f64::from(k) - 2.0), 0.001, 8e-6 + 2e-6 * LAYERS as f64]);
        model.velocities.push([0.0; 3]);
        model.extra_masses.push(1e-6);
    }
    for nodes in (first..first + 4).map(|node| [node, node + 1]) {
        let cord = membrane_core::model::input::Cord {
            nodes,
            stiffness: 1e3,
            rest_length: 0.0149,
            strain_limit: 1e9,
            ..Default::default()
        };
        model.cords.push(cord);
    }
    let shakes = Dice(11).vectors(model.positions.len(), 0.4);
    model.velocities = shakes.iter().map(|[x, y, z]| [0.1 * x, 0.1 * y, *z]).collect();
    // A weight of 100 g presses them on the lowest one.
    scene.hold(0..9);
    scene.specs = vec![springs(), LawSpec::SpringDamping(0.05.into()), spin(20.0, 0.0), gravity([0.0, 0.0, -981.0])];
    scene.contact.friction = 0.2;
    scene.contact.restitution = 0.3;
    scene.dt = None;
    scene.settings.substeps = substeps;
    scene.settings.loss_tolerance = 1.0;
    scene.settings.energy_tolerance = 1.0;
    scene
}

fn ended(scene: &Scene, steps: u64) -> Simulation {
    let mut simulation = scene.started();
    simulation.step(steps).unwrap();
    assert_eq!(scene.crossings(&simulation), 0);
    simulation
}

/// How many pairs had an impulse in the last step.
fn pairs(progress: &Progress, row: usize) -> usize {
    (progress.law_histories[row].1.len() - 2) / 4
}

#[test]
fn a_stack_has_the_same_bits_at_every_instruction_set() {
    let run = |instructions: InstructionSet| {
        let mut scene = stack(1);
        scene.settings.instructions = instructions;
        ended(&scene, 700)
    };
    let known = run(InstructionSet::Baseline);
    assert!(pairs(&known.progress(), row(&known)) > 10, "{}", pairs(&known.progress(), row(&known)));
    for instructions in InstructionSet::ALL.into_iter().filter(|instructions| instructions.is_available()) {
        assert_eq!(run(instructions).progress(), known.progress(), "{}", instructions.name());
    }
}

#[test]
fn a_stack_goes_on_with_the_same_bits() {
    for substeps in [1, 3] {
        let scene = stack(substeps);
        let whole = ended(&scene, STEPS).progress();
        // The shapes at the start and after 1000 and 2000 steps.
        assert_eq!(whole.law_histories[4].0.len(), 3);
        let mut pieces = scene.started();
        let mut resumed = scene.started();
        for steps in [0, 1, 17, 982, 1, 1, 500, STEPS - 1502] {
            pieces.step(steps).unwrap();
            // A side step gives impulses of its own.
            pieces.reach(pieces.time() + 0.3 * pieces.dt(), 1).unwrap();
            let between = pieces.positions();
            // The lists are made anew.
            let mut next = scene.started();
            next.resume(&resumed.progress()).unwrap();
            resumed = next;
            resumed.step(steps).unwrap();
            assert!(resumed.positions() != between);
            resumed.reach(resumed.time() + 0.3 * resumed.dt(), 1).unwrap();
            assert_eq!(pieces.progress(), resumed.progress(), "{substeps}, {steps}");
        }
        assert_eq!(Progress { output_time: None, ..pieces.progress() }, whole, "{substeps}");
    }
}

#[test]
fn lists_do_not_change_a_bit() {
    let of = |skins, horizons| Scheme { skins, horizons, ..Scheme::default() };
    let schemes = [
        of([2000.0, 300.0, 20.0, 2.0], [64.0; 4]),
        of([0.5, 0.4, 0.3, 0.2], [1.0; 4]),
        of([5.0; 4], [8.0; 4]),
        of([50.0, 5.0, 0.5, 0.01], [1000.0, 100.0, 3.0, 2.0]),
    ];
    let known = ended(&stack(1), STEPS).progress();
    for scheme in schemes {
        let mut scene = stack(1);
        scene.contact.scheme = scheme;
        assert!(ended(&scene, STEPS).progress() == known, "{scheme:?}");
    }
}

#[test]
fn a_run_that_is_set_back_goes_on_with_the_same_bits() {
    let scene = stack(1);
    let mut simulation = ended(&scene, 300);
    let saved = simulation.progress();
    simulation.step(200).unwrap();
    let known = simulation.progress();
    // Back, and on from there with the lists of what came later.
    simulation.resume(&saved).unwrap();
    assert_eq!(simulation.progress(), saved);
    simulation.step(200).unwrap();
    assert_eq!(simulation.progress(), known);
}
