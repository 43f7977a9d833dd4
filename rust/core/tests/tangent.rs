//! The jacobian of every law against central differences of its forces, and the factorised tangent against a dense one.
#![allow(missing_docs, clippy::unwrap_used)]

mod common;

use std::collections::BTreeSet;

use common::{Dice, every_law_with, films, sheet};
use membrane_core::arrays::jacobian::{Block, JacobianBlocks};
use membrane_core::arrays::state::{Instant, NodeVectors};
use membrane_core::assembly::Assembly;
use membrane_core::laws::{self, Law};
use membrane_core::linear::tangent::{Tangent, Weights};
use membrane_core::simd::dispatch::InstructionSet;
use nalgebra::{DMatrix, DVector};

/// dF/dx and dF/dv as dense matrices; row and column 3 node + axis.
struct Dense {
    by_position: DMatrix<f64>,
    by_velocity: DMatrix<f64>,
    touched: BTreeSet<(u32, u32)>,
}

impl JacobianBlocks for Dense {
    fn by_position(&mut self, on: u32, of: u32, block: &Block) {
        let mut place = self.by_position.fixed_view_mut::<3, 3>(3 * on as usize, 3 * of as usize);
        place += block;
        self.touched.insert((on.min(of), on.max(of)));
    }

    fn by_velocity(&mut self, on: u32, of: u32, block: &Block) {
        let mut place = self.by_velocity.fixed_view_mut::<3, 3>(3 * on as usize, 3 * of as usize);
        place += block;
        self.touched.insert((on.min(of), on.max(of)));
    }
}

fn slopes_of(law: &dyn Law, at: Instant<'_>) -> Dense {
    let size = 3 * at.positions.nrows();
    let zeros = || DMatrix::zeros(size, size);
    let mut dense = Dense { by_position: zeros(), by_velocity: zeros(), touched: BTreeSet::new() };
    law.add_jacobian(at, &mut dense);
    dense
}

/// The column of differences of the forces as one coordinate changes, of fourth order.
fn difference(law: &dyn Law, at: Instant<'_>, node: usize, axis: usize, step: f64, is_position: bool) -> DVector<f64> {
    let forces = |by: f64| {
        let (mut x, mut v) = (at.positions.clone(), at.velocities.clone());
        if is_position {
            x[(node, axis)] += by
        } else {
            v[(node, axis)] += by
        };
        let mut out = NodeVectors::zeros(x.nrows());
        law.add_forces(Instant { time: at.time, positions: &x, velocities: &v }, &mut out);
        DVector::from_fn(3 * x.nrows(), |row, _| out[(row / 3, row % 3)])
    };
    ((forces(step) - forces(-step)) * 8.0 - (forces(2.0 * step) - forces(-2.0 * step))) / (12.0 * step)
}

/// A crumpled sheet that moves, in the core's numbering.
fn crumpled(seed: u64, size: f64) -> (Assembly, NodeVectors, NodeVectors) {
    let mut dice = Dice(seed);
    let mut model = sheet(3, 3, 0.01);
    for (point, kick) in model.positions.iter_mut().zip(dice.vectors(100, size)) {
        (0..3).for_each(|axis| point[axis] += kick[axis]);
    }
    let velocities = dice.vectors(model.positions.len(), 1.0);
    let assembly = Assembly::new(model, InstructionSet::widest()).unwrap();
    let x = assembly.layout.internal_vectors(&assembly.model.positions);
    let v = assembly.layout.internal_vectors(&velocities);
    (assembly, x, v)
}

#[test]
fn the_slopes_of_every_law_are_those_of_its_forces() {
    let mut seen = BTreeSet::new();
    for (seed, film) in (0..8).flat_map(|seed| films().map(|(_, film)| (seed, film))) {
        // From hardly deformed, where films are taut, to collapsed facets and slack triangles.
        let (assembly, x, v) = crumpled(seed, 0.004 * 0.3_f64.powi(seed as i32 % 4));
        let at = Instant { time: 0.3, positions: &x, velocities: &v };
        for law in laws::build(&every_law_with(film), &assembly).unwrap() {
            let exact = slopes_of(law.as_ref(), at);
            let mut announced: BTreeSet<(u32, u32)> = (0..x.nrows() as u32).map(|node| (node, node)).collect();
            law.visit_couplings(&mut |nodes| {
                announced.extend(nodes.iter().flat_map(|&i| nodes.iter().map(move |&j| (i.min(j), i.max(j)))));
            });
            assert!(exact.touched.is_subset(&announced), "{}: nodes are coupled that it does not announce", law.name());
            for (jacobian, step, is_position) in [(&exact.by_position, 2e-9, true), (&exact.by_velocity, 1e-6, false)] {
                let size = jacobian.amax();
                for column in 0..jacobian.ncols() {
                    let found = difference(law.as_ref(), at, column / 3, column % 3, step, is_position);
                    let apart = (&found - jacobian.column(column)).amax();
                    let allowed = 2e-6 * size.max(found.amax()) + 1e-12;
                    assert!(apart <= allowed, "{}, seed {seed}, column {column}: {apart:e} of {size:e}", law.name());
                }
                if size > 0.0 {
                    seen.insert((law.name(), is_position));
                }
            }
        }
    }
    let both = ["spring_damping", "air_drag", "spin"];
    let by_position = ["springs", "triangles", "creases", "spool_contact", "tethers", "bridges"];
    let expected = both.into_iter().flat_map(|name| [(name, false), (name, true)]);
    let expected = expected.chain(by_position.map(|name| (name, true))).chain([("mass_damping", false)]);
    assert_eq!(seen, expected.collect());
}

#[test]
fn the_tangent_solves_as_the_dense_matrix_does() {
    for (_, film) in films() {
        let (assembly, x, v) = crumpled(3, 0.0003);
        let laws = laws::build(&every_law_with(film), &assembly).unwrap();
        let at = Instant { time: 0.3, positions: &x, velocities: &v };
        // Nodes 2 and 5 are held; a heavy mass makes the matrix positive definite.
        let mut inverse = assembly.inverse_masses.clone();
        (inverse[2], inverse[5]) = (0.0, 0.0);
        let weights = Weights { mass: 1e12, damping: 1e3, stiffness: 1.0 };
        let mut tangent = Tangent::new(&laws, &inverse).unwrap();
        tangent.assemble(&laws, &assembly.masses, at, weights);
        assert!(tangent.factorise());
        let size = 3 * x.nrows();
        let mut dense =
            DMatrix::from_fn(size, size, |i, j| if i == j { weights.mass * assembly.masses[i / 3] } else { 0.0 });
        for law in &laws {
            let jacobian = slopes_of(law.as_ref(), at);
            dense -= jacobian.by_position * weights.stiffness + jacobian.by_velocity * weights.damping;
        }
        dense = 0.5 * (&dense + dense.transpose());
        let mut right = NodeVectors::from_fn(x.nrows(), |i, axis| ((3 * i + axis) as f64).sin());
        let mut forces = DVector::from_fn(size, |i, _| assembly.masses[i / 3] * right[(i / 3, i % 3)]);
        for node in [2, 5] {
            for row in 3 * node..3 * node + 3 {
                dense.row_mut(row).fill(0.0);
                dense.column_mut(row).fill(0.0);
                (dense[(row, row)], forces[row]) = (1.0, 0.0);
            }
        }
        let expected = dense.cholesky().unwrap().solve(&forces);
        tangent.solve(&assembly.masses, &mut right);
        let found = DVector::from_fn(size, |i, _| right[(i / 3, i % 3)]);
        assert!((&found - &expected).amax() < 1e-10 * expected.amax());
        // With the mass of the other sign it has no factor, and says so.
        tangent.assemble(&laws, &assembly.masses, at, Weights { mass: -weights.mass, ..weights });
        assert!(!tangent.factorise());
    }
}

#[test]
fn eliminating_in_the_right_order_keeps_the_factor_sparse() {
    let numbers = |side: usize| {
        let assembly = Assembly::new(sheet(side, side, 0.01), InstructionSet::widest()).unwrap();
        let (_, film) = films()[0].clone();
        let laws = laws::build(&every_law_with(film), &assembly).unwrap();
        Tangent::new(&laws, &assembly.inverse_masses).unwrap().factor_size()
    };
    // A band would grow eightfold, n^(3/2) to n log n in the nodes' order of least degree; and hold 3 n^(3/2) blocks.
    let (small, large) = (numbers(12), numbers(24));
    assert!(large < 6 * small, "{small} {large}");
    assert!(large < 9 * 3 * 15_625, "{large}");
}
