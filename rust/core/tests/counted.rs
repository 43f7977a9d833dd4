//! Operation counts of kernels: operations on eight numbers per batch, at unchanged bits.
#![allow(missing_docs, clippy::unwrap_used)]

mod common;

use common::sail;
use membrane_core::arrays::state::{NodeVectors, State};
use membrane_core::assembly::Assembly;
use membrane_core::evaluation::plan::Plan;
use membrane_core::laws::{self, Instant, Law, LawSpec, spin_of};
use membrane_core::simd::counted::{Counts, count};
use membrane_core::simd::dispatch::InstructionSet;
use membrane_core::simd::lanes::LANES;

/// One evaluation of the selected laws of model 1 without tethers: laws, forces and operation counts.
fn evaluate(
    instructions: InstructionSet,
    is_selected: fn(&LawSpec) -> bool,
) -> (Vec<Box<dyn Law>>, NodeVectors, Counts) {
    let mut sail = sail::sail(1);
    sail.cords.clear();
    let assembly = Assembly::new(sail, instructions).unwrap();
    let chosen: Vec<LawSpec> = sail::laws().into_iter().filter(is_selected).collect();
    let mut laws = laws::build(&chosen, &assembly).unwrap();
    let positions = assembly.numbering.internal_vectors(&assembly.model.positions);
    let velocities = assembly.numbering.internal_vectors(&assembly.model.velocities);
    let state = State { positions, velocities };
    let at = Instant::new(state.at(0.0), &spin_of(&chosen));
    let plan = Plan::new(&mut laws);
    let mut forces = NodeVectors::zeros(assembly.masses.len());
    let mut powers = vec![0.0; laws.len()];
    let counts = count(|| plan.add_selected(&mut laws, |_| true, at, &mut forces, &mut powers));
    (laws, forces, counts)
}

#[test]
fn counting_changes_no_bit() {
    let (_, forces, counts) = evaluate(InstructionSet::Baseline, |_| true);
    assert_eq!(counts, Counts::default());
    let (_, counted, counts) = evaluate(InstructionSet::Counted, |_| true);
    assert_eq!(counted, forces);
    assert!(counts.additions > 0);
}

#[test]
fn a_batch_of_eight_costs_no_more_than_its_formula() {
    // Largest counts per batch: quotients, roots, reads, writes, sums, products. Those of drag are per batch of
    // triangles and include its nodes, one for two triangles. Operations once per pass are below a tenth.
    let springs: fn(&LawSpec) -> bool = |law| matches!(law, LawSpec::Springs(_) | LawSpec::SpringDamping(_));
    let creases: fn(&LawSpec) -> bool = |law| matches!(law, LawSpec::Creases(_));
    let drag: fn(&LawSpec) -> bool = |law| matches!(law, LawSpec::AirDrag(_));
    for (name, is_selected, most) in [
        ("springs and dashpots", springs, [1, 1, 22, 6, 19, 16]),
        ("creases", creases, [4, 2, 42, 12, 114, 132]),
        ("drag", drag, [0, 0, 31, 7, 23, 24]),
    ] {
        let (laws, _, counts) = evaluate(InstructionSet::Counted, is_selected);
        let lanes: usize = laws.iter().filter_map(|law| law.inspection()).map(|law| law.lanes()[1]).sum();
        let batches = (lanes / LANES) as f64;
        let found =
            [counts.divisions, counts.roots, counts.loads, counts.stores, counts.additions, counts.multiplications];
        let found = found.map(|count| count as f64 / batches);
        let is_less = found.iter().zip(most).all(|(found, most)| *found < f64::from(most) + 0.1);
        assert!(
            is_less,
            "{name}: quotients, roots, reads, writes, sums, products a batch {found:.1?}, at most {most:?}"
        );
    }
}

#[test]
fn padding_lanes_are_few() {
    let laws = evaluate(InstructionSet::Baseline, |_| true).0;
    for (name, most) in [("springs", 0.02), ("creases", 0.03), ("air_drag", 0.02)] {
        let [elements, lanes] = laws.iter().find(|law| law.name() == name).unwrap().inspection().unwrap().lanes();
        let share = 1.0 - elements as f64 / lanes as f64;
        assert!((0.0..=most).contains(&share), "{name}: {share}");
    }
}
