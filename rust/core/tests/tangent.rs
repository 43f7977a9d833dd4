//! The Jacobian of every law against central differences of its forces, and the tangent against a dense matrix.
#![allow(missing_docs, clippy::unwrap_used)]

mod common;

use std::collections::BTreeSet;

use common::{Bench, every_law_with, every_law_with_hinges, films, law_sets, sheet};
use membrane_core::arrays::jacobian::{Block, JacobianBlocks};
use membrane_core::arrays::state::{NodeVectors, State};
use membrane_core::laws::{Instant, Law, Linearisation, WorkClass};
use membrane_core::linear::tangent::{Tangent, Weights};
use nalgebra::{DMatrix, DVector};

/// dF/dx and dF/dv as dense matrices; row and column 3 node + axis.
struct Dense {
    by_position: DMatrix<f64>,
    by_velocity: DMatrix<f64>,
    coupled: BTreeSet<(u32, u32)>,
}

impl JacobianBlocks for Dense {
    fn by_position(&mut self, on: u32, of: u32, block: &Block) {
        let mut place = self.by_position.fixed_view_mut::<3, 3>(3 * on as usize, 3 * of as usize);
        place += block;
        self.coupled.insert((on.min(of), on.max(of)));
    }

    fn by_velocity(&mut self, on: u32, of: u32, block: &Block) {
        let mut place = self.by_velocity.fixed_view_mut::<3, 3>(3 * on as usize, 3 * of as usize);
        place += block;
        self.coupled.insert((on.min(of), on.max(of)));
    }
}

impl Dense {
    fn of(law: &dyn Linearisation, at: Instant<'_>) -> Self {
        let size = 3 * at.positions.nrows();
        let zeros = || DMatrix::zeros(size, size);
        let mut dense = Self { by_position: zeros(), by_velocity: zeros(), coupled: BTreeSet::new() };
        law.add_jacobian(at, &mut dense);
        dense
    }
}

/// The column of the Jacobian for one coordinate, by central differences of fourth order.
fn difference(
    bench: &mut Bench,
    row: usize,
    (node, axis): (usize, usize),
    step: f64,
    is_position: bool,
) -> DVector<f64> {
    let (time, start) = (bench.time, bench.state.clone());
    let mut forces = |by: f64| {
        let State { mut positions, mut velocities } = start.clone();
        let changed = if is_position { &mut positions } else { &mut velocities };
        changed[(node, axis)] += by;
        let found = bench.evaluate(row, time, &State { positions, velocities }).0;
        DVector::from_fn(3 * found.nrows(), |row, _| found[(row / 3, row % 3)])
    };
    ((forces(step) - forces(-step)) * 8.0 - (forces(2.0 * step) - forces(-2.0 * step))) / (12.0 * step)
}

/// The pairs of nodes that a law couples, and each node with itself.
fn couplings(law: &dyn Linearisation, nodes: usize) -> BTreeSet<(u32, u32)> {
    let mut coupled: BTreeSet<(u32, u32)> = (0..nodes as u32).map(|node| (node, node)).collect();
    law.visit_couplings(&mut |nodes| {
        coupled.extend(nodes.iter().flat_map(|&i| nodes.iter().map(move |&j| (i.min(j), i.max(j)))));
    });
    coupled
}

#[test]
fn the_jacobian_of_every_law_is_that_of_its_forces() {
    let mut seen = BTreeSet::new();
    for (seed, laws) in (0..8).flat_map(|seed| law_sets().map(move |laws| (seed, laws))) {
        // From small deformations of taut films to collapsed facets and slack triangles.
        let of_kind = if seed < 4 { Bench::crumpled } else { Bench::patched };
        let mut bench = of_kind(&laws, seed, 0.004 * 0.3_f64.powi(seed as i32 % 4));
        let nodes = bench.state.positions.nrows();
        for row in 0..bench.laws.len() {
            let name = bench.laws[row].name();
            // A law with state changes it once at an instant.
            let (time, state) = (bench.time, bench.state.clone());
            bench.evaluate(row, time, &state);
            let zeros = || DMatrix::zeros(3 * nodes, 3 * nodes);
            let [by_position, by_velocity] = match bench.laws[row].linearisation() {
                None => [zeros(), zeros()],
                Some(law) => {
                    let Dense { by_position, by_velocity, coupled } = Dense::of(law, bench.instant());
                    assert!(
                        coupled.is_subset(&couplings(law, nodes)),
                        "{name} couples nodes that visit_couplings leaves out"
                    );
                    [by_position, by_velocity]
                }
            };
            for (jacobian, step, is_position) in [(&by_position, 2e-9, true), (&by_velocity, 1e-6, false)] {
                let size = jacobian.amax();
                for column in 0..jacobian.ncols() {
                    let found = difference(&mut bench, row, (column / 3, column % 3), step, is_position);
                    let difference = (&found - jacobian.column(column)).amax();
                    let allowed = 2e-6 * size.max(found.amax()) + 1e-12;
                    assert!(difference <= allowed, "{name}, seed {seed}, column {column}: {difference:e} of {size:e}");
                }
                if size > 0.0 {
                    seen.insert(name);
                }
            }
            // Only a constant force may be without linearisation.
            assert!(bench.laws[row].linearisation().is_none() || seen.contains(name) || seed == 0, "{name}");
        }
    }
}

#[test]
fn the_damping_matrix_of_every_law_is_the_symmetric_part_of_its_jacobian() {
    for film in films() {
        let bench = Bench::crumpled(&every_law_with(film), 5, 0.001);
        let [p, q] = [11, 12].map(|seed| bench.vectors(seed, 1.0));
        let product = |law: &dyn Linearisation, p: &NodeVectors| {
            let mut out = NodeVectors::zeros(p.nrows());
            law.add_damping_product(1.0, bench.instant(), p, &mut out);
            out
        };
        let flat = |v: &NodeVectors| DVector::from_fn(3 * v.nrows(), |row, _| v[(row / 3, row % 3)]);
        for law in &bench.laws {
            let Some(linear) = law.linearisation() else { continue };
            let jacobian = Dense::of(linear, bench.instant()).by_velocity;
            let symmetric = -0.5 * (&jacobian + jacobian.transpose());
            let (found, exact) = (flat(&q).dot(&flat(&product(linear, &p))), flat(&q).dot(&(&symmetric * flat(&p))));
            let scale = symmetric.amax() * flat(&p).norm() * flat(&q).norm();
            // The matrix of drag is not symmetric: the mean of both products is exact.
            let other = flat(&p).dot(&flat(&product(linear, &q)));
            assert!((0.5 * (found + other) - exact).abs() <= 1e-12 * scale, "{}: {found:e} {exact:e}", law.name());
        }
    }
}

#[test]
fn the_stiffness_of_every_law_is_symmetric_and_bounds_its_jacobian() {
    for film in films() {
        // Slightly stretched, so that nothing buckles; pairs of random vectors.
        let mut model = sheet(4, 3, 0.01);
        model.positions.iter_mut().for_each(|p| *p = [1.001 * p[0] + 0.01, 1.001 * p[1], 0.0]);
        let bench = Bench::new(model, &every_law_with(film));
        let product = |law: &dyn Linearisation, p: &NodeVectors| {
            let mut out = NodeVectors::zeros(p.nrows());
            law.add_stiffness_product(bench.instant(), p, &mut out);
            out
        };
        let laws = bench.laws.iter().filter(|law| law.properties().work_class == WorkClass::Conservative);
        for (law, seed) in laws.flat_map(|law| (0..6).map(move |seed| (law, seed))) {
            let Some(linear) = law.linearisation() else { continue };
            let [p, q] = [2 * seed, 2 * seed + 1].map(|seed| bench.vectors(seed, 1.0));
            let (kp, kq) = (product(linear, &p), product(linear, &q));
            let scale = kp.norm() * q.norm();
            assert!((q.dot(&kp) - p.dot(&kq)).abs() <= 1e-12 * scale, "{} is not symmetric", law.name());
            let jacobian = Dense::of(linear, bench.instant()).by_position;
            let flat = DVector::from_fn(3 * p.nrows(), |row, _| p[(row / 3, row % 3)]);
            let quotient = -flat.dot(&(&jacobian * &flat));
            // Without the geometric part, of the order of the strain; the frame has no positive stiffness.
            assert!(quotient <= p.dot(&kp) * 1.01 + 1e-12, "{}: {quotient:e} over {:e}", law.name(), p.dot(&kp));
        }
    }
}

fn tangent_of(laws: &[Box<dyn Law>], inverse_masses: &[f64]) -> Tangent {
    let couplings = |visit: &mut dyn FnMut(&[u32])| {
        laws.iter().filter_map(|law| law.linearisation()).for_each(|law| law.visit_couplings(visit));
    };
    Tangent::new(&couplings, inverse_masses).unwrap()
}

#[test]
fn the_tangent_solves_as_the_dense_matrix_does() {
    for film in films() {
        let bench = Bench::crumpled(&every_law_with(film), 3, 0.0003);
        let (at, masses) = (bench.instant(), &bench.assembly.masses);
        let linearised = || bench.laws.iter().filter_map(|law| law.linearisation());
        let blocks = |receiver: &mut dyn JacobianBlocks| linearised().for_each(|law| law.add_jacobian(at, receiver));
        // Nodes 2 and 5 are held; a large weight of the masses makes the matrix positive definite.
        let mut inverse = bench.assembly.inverse_masses.clone();
        (inverse[2], inverse[5]) = (0.0, 0.0);
        let weights = Weights { mass: 1e12, damping: 1e3, stiffness: 1.0 };
        let mut tangent = tangent_of(&bench.laws, &inverse);
        tangent.assemble(masses, weights, blocks);
        assert!(tangent.factorise());
        let nodes = masses.len();
        let size = 3 * nodes;
        let mut dense = DMatrix::from_fn(size, size, |i, j| if i == j { weights.mass * masses[i / 3] } else { 0.0 });
        for law in linearised() {
            let jacobian = Dense::of(law, at);
            dense -= jacobian.by_position * weights.stiffness + jacobian.by_velocity * weights.damping;
        }
        dense = 0.5 * (&dense + dense.transpose());
        let mut right = NodeVectors::from_fn(nodes, |i, axis| ((3 * i + axis) as f64).sin());
        let mut forces = DVector::from_fn(size, |i, _| masses[i / 3] * right[(i / 3, i % 3)]);
        for node in [2, 5] {
            for row in 3 * node..3 * node + 3 {
                dense.row_mut(row).fill(0.0);
                dense.column_mut(row).fill(0.0);
                (dense[(row, row)], forces[row]) = (1.0, 0.0);
            }
        }
        let expected = dense.cholesky().unwrap().solve(&forces);
        tangent.solve(masses, &mut right);
        let found = DVector::from_fn(size, |i, _| right[(i / 3, i % 3)]);
        assert!((&found - &expected).amax() < 1e-10 * expected.amax());
        // With a negative mass it has no factor.
        tangent.assemble(masses, Weights { mass: -weights.mass, ..weights }, blocks);
        assert!(!tangent.factorise());
    }
}

#[test]
fn the_order_of_elimination_keeps_the_factor_sparse() {
    let numbers = |side: usize| {
        let bench = Bench::new(sheet(side, side, 0.01), &every_law_with_hinges());
        tangent_of(&bench.laws, &bench.assembly.inverse_masses).factor_size()
    };
    // A banded factor would grow eightfold, by n^(3/2) against n log n, with 3 n^(3/2) blocks.
    let (small, large) = (numbers(12), numbers(24));
    assert!(large < 6 * small, "{small} {large}");
    assert!(large < 9 * 3 * 15_625, "{large}");
}
