//! The same bits at every vector width, and the same forces with every numbering.
#![allow(missing_docs, clippy::unwrap_used)]

mod common;

use common::patches::patched;
use common::{Dice, every_law, every_law_with_limited_dashpots, law_sets, sheet};
use membrane_core::arrays::blocks::TILE;
use membrane_core::laws::{LawSpec, WorkClass};
use membrane_core::model::input::Model;
use membrane_core::simd::dispatch::InstructionSet;
use membrane_core::simulation::{Settings, Simulation};

fn disturbed(instructions: InstructionSet) -> Simulation {
    sheet_in_motion((19, 13), "rk4", Settings { instructions, ..Settings::default() })
}

fn sheet_in_motion(size: (usize, usize), method: &str, settings: Settings) -> Simulation {
    sheet_with(&every_law(), size, method, settings)
}

fn sheet_with(laws: &[LawSpec], (columns, rows): (usize, usize), method: &str, settings: Settings) -> Simulation {
    simulation_of(sheet(columns, rows, 0.01), laws, method, settings)
}

fn simulation_of(mut model: Model, laws: &[LawSpec], method: &str, settings: Settings) -> Simulation {
    let kicks = Dice(1).vectors(model.positions.len(), 2e-4);
    for (point, kick) in model.positions.iter_mut().zip(kicks) {
        (0..3).for_each(|axis| point[axis] += kick[axis]);
        // Above the middle of the spool, in which it would be too deep.
        point[2] += 0.015;
    }
    model.velocities = Dice(2).vectors(model.positions.len(), 0.1);
    Simulation::new(model, laws, method, Some(1e-6), settings).unwrap()
}

#[test]
fn limited_dashpots_have_the_same_bits_at_every_width_and_lose_energy_by_every_method() {
    for method in ["rk4", "leapfrog"] {
        let run = |instructions: InstructionSet| {
            // The ratio makes the dashpots stiff.
            let settings = Settings { instructions, loss_tolerance: 1.0, energy_tolerance: 1.0, ..Settings::default() };
            let mut simulation = sheet_with(&every_law_with_limited_dashpots(), (19, 13), method, settings);
            simulation.set_dt(1e-8).unwrap();
            simulation.step(200).unwrap();
            simulation
        };
        let baseline = run(InstructionSet::Baseline);
        let row = baseline.laws().iter().position(|law| law.name() == "spring_damping").unwrap();
        assert!(baseline.ledger().work[row] < 0.0);
        for instructions in InstructionSet::ALL.into_iter().filter(|instructions| instructions.is_available()) {
            assert_eq!(run(instructions).progress(), baseline.progress(), "{method}, {}", instructions.name());
        }
    }
}

#[test]
fn a_trajectory_has_the_same_bits_at_every_width() {
    let mut baseline = disturbed(InstructionSet::Baseline);
    baseline.step(500).unwrap();
    for instructions in InstructionSet::ALL.into_iter().filter(|instructions| instructions.is_available()) {
        let mut simulation = disturbed(instructions);
        simulation.step(500).unwrap();
        assert_eq!(simulation.progress(), baseline.progress(), "{}", instructions.name());
    }
}

#[test]
fn so_has_a_trajectory_with_regions_of_the_film() {
    for laws in law_sets().take(3) {
        let run = |instructions: InstructionSet| {
            let settings = Settings { instructions, energy_tolerance: 1.0, ..Settings::default() };
            let mut simulation = simulation_of(patched(sheet(19, 13, 0.01)), &laws, "rk4", settings);
            simulation.set_dt(1e-7).unwrap();
            simulation.step(50).unwrap();
            simulation.progress()
        };
        let baseline = run(InstructionSet::Baseline);
        for instructions in InstructionSet::ALL.into_iter().filter(|instructions| instructions.is_available()) {
            assert_eq!(run(instructions), baseline, "{}", instructions.name());
        }
    }
}

#[test]
fn so_has_a_trajectory_of_more_than_one_tile() {
    for (method, substeps) in [("rk4", 1), ("leapfrog", 1), ("leapfrog", 2)] {
        let run = |instructions: InstructionSet| {
            let settings = Settings { instructions, substeps, ..Settings::default() };
            let mut simulation = sheet_in_motion((69, 59), method, settings);
            assert!(simulation.positions().len() > TILE);
            simulation.step(10).unwrap();
            simulation.progress()
        };
        let baseline = run(InstructionSet::Baseline);
        for instructions in InstructionSet::ALL.into_iter().filter(|instructions| instructions.is_available()) {
            assert_eq!(run(instructions), baseline, "{method}, {}", instructions.name());
        }
    }
}

#[test]
fn methods_agree_on_the_work_of_each_law_with_any_number_of_tiles() {
    for size in [(19, 13), (69, 59)] {
        let run = |method: &str, substeps: u32, steps: u64| {
            let settings = Settings { substeps, energy_tolerance: 1.0, ..Settings::default() };
            let mut simulation = sheet_in_motion(size, method, settings);
            simulation.set_dt(2e-8 * f64::from(substeps)).unwrap();
            simulation.step(steps).unwrap();
            simulation
        };
        let known = run("rk4", 1, 20);
        for (method, substeps) in [("leapfrog", 1), ("leapfrog", 2)] {
            let found = run(method, substeps, 20 / u64::from(substeps));
            for (law, (found, known)) in known.laws().iter().zip(found.ledger().work.iter().zip(&known.ledger().work)) {
                let name = law.name();
                assert!((found - known).abs() <= 1e-2 * known.abs(), "{size:?}, {method}, {name}: {found:e} {known:e}");
                assert!(law.properties().work_class != WorkClass::Dissipative || *known < 0.0, "{name}");
            }
        }
    }
}

#[test]
fn a_sheet_in_rows_has_contiguous_batches() {
    // Wide enough for elements that reach beyond their neighbours: those at both ends of a row differ.
    for law in sheet_in_motion((63, 5), "rk4", Settings::default()).laws() {
        let least = if law.name() == "tethers" || law.name() == "bridges" { 0.0 } else { 0.9 };
        let share = law.inspection().and_then(|law| law.contiguous_share()).unwrap_or(1.0);
        assert!(share >= least, "{}: {share}", law.name());
    }
}

#[test]
fn a_law_of_elements_gives_a_share_between_none_and_all_where_its_batches_are_mixed() {
    // The batch that ends the last row, and the few beside the edges, are gathered.
    let simulation = disturbed(InstructionSet::Baseline);
    let shares = simulation.laws().iter().filter_map(|law| Some((law.name(), law.inspection()?.contiguous_share())));
    for (name, share) in shares.filter(|(name, _)| *name != "tethers" && *name != "bridges") {
        assert!(share.is_none_or(|share| share < 1.0), "{name}: {share:?}");
    }
}

#[test]
fn forces_do_not_depend_on_the_external_order() {
    // The same sheet with random numbers of its nodes: other batches, equal forces within rounding.
    let plain = {
        let mut model = sheet(9, 7, 0.01);
        model
            .positions
            .iter_mut()
            .zip(Dice(3).vectors(1000, 2e-4))
            .for_each(|(p, k)| (0..3).for_each(|a| p[a] += k[a]));
        model
    };
    let n = plain.reference.len();
    let mut shuffled: Vec<u32> = (0..n as u32).collect();
    let mut dice = Dice(4);
    (1..n).rev().for_each(|i| shuffled.swap(i, ((dice.roll() + 1.0) / 2.0 * (i + 1) as f64) as usize));
    let renamed = |node: u32| if (node as usize) < n { shuffled[node as usize] } else { node };
    let mut other = plain.clone();
    for (old, &new) in shuffled.iter().enumerate() {
        other.reference[new as usize] = plain.reference[old];
        other.positions[new as usize] = plain.positions[old];
    }
    other.triangles.iter_mut().for_each(|nodes| *nodes = nodes.map(renamed));
    other.creases.nodes.iter_mut().for_each(|nodes| *nodes = nodes.map(renamed));
    other.bridges.nodes.iter_mut().for_each(|nodes| *nodes = nodes.map(renamed));
    other.loaded.iter_mut().for_each(|node| *node = renamed(*node));
    other.cords.iter_mut().for_each(|cord| cord.nodes = cord.nodes.map(renamed));
    let new = |model| Simulation::new(model, &every_law(), "rk4", Some(1e-6), Settings::default()).unwrap();
    let (mut plain, mut other) = (new(plain), new(other));
    let names: Vec<&str> = plain.laws().iter().map(|law| law.name()).collect();
    for name in names {
        let (a, b) = (plain.forces(Some(name)).unwrap(), other.forces(Some(name)).unwrap());
        let size = a.iter().flatten().fold(0.0, |most: f64, f| most.max(f.abs()));
        for (old, force) in a.iter().enumerate() {
            let twin = b[renamed(old as u32) as usize];
            (0..3).for_each(|axis| assert!((force[axis] - twin[axis]).abs() <= 1e-12 * size, "{name}"));
        }
    }
}
