//! The kernels against plain scalar loops: equal forces within rounding, in batches of all kinds, at every width.
#![allow(missing_docs, clippy::unwrap_used)]

mod common;
mod oracle;

use common::{Dice, sail, sheet};
use membrane_core::arrays::blocks::TILE;
use membrane_core::assembly::Assembly;
use membrane_core::laws::{DampingParameters, DashpotMass, LawSpec, Limited, RectangleParameters};
use membrane_core::model::input::{Creases, Model};
use membrane_core::simd::dispatch::InstructionSet;
use membrane_core::simulation::{Settings, Simulation};
use oracle::steps::{METHODS, Stepper};
use oracle::{Motion, Oracle};

/// A sheet with random numbers of its nodes, random diagonals, and without a tenth of its triangles.
fn unstructured() -> Model {
    let (columns, rows) = (23, 17);
    let mut dice = Dice(11);
    let mut model = sheet(columns, rows, 0.01);
    let nodes = model.reference.len();
    for cell in model.triangles.chunks_mut(2) {
        if dice.roll() < 0.0 {
            let ([a, b, c], d) = (cell[0], *cell[1].iter().find(|node| !cell[0].contains(node)).unwrap());
            // The other diagonal of the corners a, b, c, d of a square.
            let corners = if cell[1].contains(&a) && cell[1].contains(&c) { [a, b, c, d] } else { [b, d, c, a] };
            let [a, b, c, d] = corners;
            cell.copy_from_slice(&[[a, b, d], [b, c, d]]);
        }
    }
    model.triangles.retain(|_| dice.roll() < 0.8);
    for (point, reference) in model.positions.iter_mut().zip(&mut model.reference) {
        for axis in 0..3 {
            reference[axis] += if axis < 2 { 1e-3 * dice.roll() } else { 0.0 };
            point[axis] = reference[axis] + 5e-4 * dice.roll();
        }
    }
    let mut renumbered: Vec<u32> = (0..nodes as u32).collect();
    (1..nodes).rev().for_each(|k| renumbered.swap(k, ((dice.roll() + 1.0) / 2.0 * (k + 1) as f64) as usize));
    let renamed = |node: u32| *renumbered.get(node as usize).unwrap_or(&node);
    let (reference, positions) = (model.reference.clone(), model.positions.clone());
    for (old, &new) in renumbered.iter().enumerate() {
        model.reference[new as usize] = reference[old];
        model.positions[new as usize] = positions[old];
    }
    model.triangles.iter_mut().for_each(|nodes| *nodes = nodes.map(renamed));
    model.cords.iter_mut().for_each(|cord| cord.nodes = cord.nodes.map(renamed));
    // Creases on the inner edges of rows that still have two triangles.
    let mut creases: Vec<[u32; 2]> = model.creases.nodes.iter().map(|pair| pair.map(renamed)).collect();
    creases
        .retain(|pair| model.triangles.iter().filter(|nodes| pair.iter().all(|end| nodes.contains(end))).count() == 2);
    let fold_signs = (0..creases.len()).map(|row| if row % 3 == 0 { 1.0 } else { -1.0 }).collect();
    model.creases = Creases { nodes: creases, fold_signs, ..Creases::default() };
    model.bridges.nodes.clear();
    // Nodes without triangles have no mass of film.
    model.extra_masses.fill(1e-6);
    model.velocities = dice.vectors(model.positions.len(), 0.3);
    model
}

fn agree(model: Model, instructions: InstructionSet) {
    agree_with(&sail::laws(), model, instructions);
}

fn agree_with(laws: &[LawSpec], model: Model, instructions: InstructionSet) {
    let settings = Settings { instructions, ..Settings::default() };
    let mut simulation = Simulation::new(model.clone(), laws, "rk4", Some(1e-7), settings).unwrap();
    let assembly = Assembly::new(model, instructions).unwrap();
    let oracle = Oracle::new(laws, &assembly);
    let forces = vec![[0.0; 3]; simulation.positions().len()];
    let mut motion = Motion { positions: simulation.positions(), velocities: simulation.velocities(), forces };
    let mut compare = |what: &str, found: Vec<[f64; 3]>, evaluate: &dyn Fn(&mut Motion)| {
        motion.forces.fill([0.0; 3]);
        evaluate(&mut motion);
        let largest = motion.forces.iter().flatten().fold(0.0, |most: f64, force| most.max(force.abs()));
        let differences = found.iter().flatten().zip(motion.forces.iter().flatten()).map(|(a, b)| (a - b).abs());
        let worst = differences.fold(0.0, f64::max);
        assert!(worst <= 1e-12 * largest, "{what}, {}: {worst:e} N of {largest:e} N", instructions.name());
        assert!(largest > 0.0 || what == "spool", "{what}");
    };
    let film = laws.iter().find(|law| law.film().is_some()).unwrap().kind();
    for (part, laws, evaluate) in Oracle::PARTS {
        let mut found = vec![[0.0; 3]; simulation.positions().len()];
        for &law in laws {
            let forces = simulation.forces(Some(if law == "springs" { film } else { law })).unwrap();
            found.iter_mut().zip(forces).for_each(|(sum, force)| (0..3).for_each(|axis| sum[axis] += force[axis]));
        }
        compare(part, found, &|motion| {
            evaluate(&oracle, motion);
        });
    }
    compare("all", simulation.forces(None).unwrap(), &|motion| {
        oracle.evaluate(motion);
    });
}

fn widths() -> impl Iterator<Item = InstructionSet> {
    InstructionSet::ALL.into_iter().filter(|instructions| instructions.is_available())
}

#[test]
fn kernels_agree_on_the_sail_of_model_1() {
    let sail = sail::sail(1);
    let assembly = Assembly::new(sail.clone(), InstructionSet::Baseline).unwrap();
    let springs = assembly.mesh.edges.len() + sail.cords.len();
    let counts = [sail.positions.len(), springs, sail.creases.nodes.len(), sail.triangles.len()];
    assert_eq!(counts, [1912, 5368, 756, 3456]);
    widths().for_each(|instructions| agree(sail.clone(), instructions));
}

#[test]
fn kernels_agree_in_every_form_of_the_dashpots() {
    for (limited, mass) in [(Limited::None, DashpotMass::Mean), (Limited::All, DashpotMass::Reduced)] {
        let mut laws = sail::laws();
        for law in &mut laws {
            if let LawSpec::SpringDamping(parameters) = law {
                *parameters = DampingParameters { limited, mass, ..*parameters };
            }
        }
        widths().for_each(|instructions| agree_with(&laws, sail::sail(1), instructions));
    }
}

#[test]
fn kernels_agree_on_sails_of_rectangles() {
    for (limited, fineness) in [(Limited::Cords, 2), (Limited::All, 1)] {
        let mut laws = sail::laws();
        for law in &mut laws {
            match law {
                LawSpec::Springs(parameters) => *law = RectangleParameters(*parameters).into(),
                LawSpec::SpringDamping(parameters) => *parameters = DampingParameters { limited, ..*parameters },
                _ => {}
            }
        }
        widths().for_each(|instructions| agree_with(&laws, sail::sail(fineness), instructions));
    }
}

#[test]
fn kernels_agree_on_a_sail_of_several_tiles() {
    let sail = sail::sail(2);
    assert!(sail.positions.len() > 2 * TILE);
    widths().for_each(|instructions| agree(sail.clone(), instructions));
}

#[test]
fn kernels_agree_on_an_unstructured_mesh() {
    widths().for_each(|instructions| agree(unstructured(), instructions));
}

#[test]
fn steps_of_plain_loops_are_those_of_the_core() {
    for fineness in [1, 2] {
        agree_in_steps(sail::sail(fineness));
    }
}

fn agree_in_steps(model: Model) {
    let (laws, dt, steps) = (sail::laws(), 1e-6 / model.positions.len() as f64 * 1912.0, 20);
    let assembly = Assembly::new(model.clone(), InstructionSet::widest()).unwrap();
    for method in METHODS {
        let mut simulation = Simulation::new(model.clone(), &laws, method, Some(dt), Settings::default()).unwrap();
        simulation.step(steps).unwrap();
        // A simulation starts with held nodes at rest.
        let mut stepper = Stepper::new(Oracle::new(&laws, &assembly), &assembly);
        model.fixed.iter().for_each(|&node| stepper.motion.velocities[node as usize] = [0.0; 3]);
        stepper.step(method, dt, steps);
        let found = [simulation.positions(), simulation.velocities()];
        for (found, expected, start) in [
            (&found[0], &stepper.motion.positions, &model.positions),
            (&found[1], &stepper.motion.velocities, &model.velocities),
        ] {
            let moved = expected.iter().flatten().zip(start.iter().flatten()).map(|(a, b)| (a - b).abs());
            let distance = expected.iter().flatten().zip(found.iter().flatten()).map(|(a, b)| (a - b).abs());
            let (moved, distance) = (moved.fold(0.0, f64::max), distance.fold(0.0, f64::max));
            assert!(distance < 1e-9 * moved, "{method}: {distance:e} of {moved:e}");
        }
    }
}
