//! Times of one evaluation of each law, of all laws, and of a step, on a sheet the size of model 1, for each set of
//! vector instructions that the machine has.
//!
//! The sheet stands in for the sail, so that this crate alone can be measured: 48 rows of 36 squares give the sail's 3456
//! triangles and 756 creases, and springs and nodes to within 2 % (the counts are printed). It is folded to a zigzag and
//! crumpled a little, so that creases turn, springs pull and buckle, and air drags. `benchmarks/model_1.py` times the
//! sail itself.
#![allow(missing_docs, clippy::unwrap_used, clippy::print_stdout)]

use std::f64::consts::TAU;
use std::hint::black_box;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use membrane_core::forces::{
    self, AirDragParameters, AirMotion, CreaseParameters, LawSpec, Spin, SpoolContactParameters, SpringParameters,
};
use membrane_core::integrators;
use membrane_core::model::{Assembly, Cord, Film, Model};
use membrane_core::simulation::{Settings, Simulation};
use membrane_core::state::{Instant, Vectors};
use membrane_core::width::Width;

const COLUMNS: usize = 36;
const ROWS: usize = 48;
/// Side of the squares \[m\]; a crease runs along every second row.
const SIDE: f64 = 0.011;
const CREASES: usize = 21;
/// How far a strip leans from the flat sheet \[rad\].
const LEAN: f64 = 0.5;
/// Tethers, and segments in each.
const TETHERS: usize = 4;
const SEGMENTS: usize = 19;
/// Step \[s\], that of model 1.
const STEP: f64 = 4e-6;

/// The fractional part of multiples of the golden ratio, in -0.5 .. 0.5: numbers that repeat from run to run.
fn noise(k: usize) -> f64 {
    (k as f64 * 0.618_033_988_749_894_9).fract() - 0.5
}

fn shake(k: usize, size: f64) -> [f64; 3] {
    [0, 1, 2].map(|axis| size * noise(3 * k + axis + 1))
}

fn sheet() -> Model {
    let node = |i: usize, j: usize| (j * (COLUMNS + 1) + i) as u32;
    let (mut reference, mut positions) = (Vec::new(), Vec::new());
    for j in 0..=ROWS {
        // Two rows up, two rows down.
        let height = SIDE * (2 - (j % 4).abs_diff(2)) as f64 * LEAN.sin();
        for i in 0..=COLUMNS {
            let [dx, dy, dz] = shake(reference.len(), 1e-5);
            reference.push([i as f64 * SIDE, j as f64 * SIDE, 0.0]);
            positions.push([0.05 + i as f64 * SIDE + dx, j as f64 * SIDE * LEAN.cos() + dy, height + dz]);
        }
    }
    let mut triangles = Vec::new();
    for j in 0..ROWS {
        for i in 0..COLUMNS {
            let [a, b, c, d] = [node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)];
            triangles.extend(if (i + j) % 2 == 0 { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] });
        }
    }
    let lines = (1..=CREASES).map(|line| 2 * line);
    let creases: Vec<[u32; 2]> =
        lines.flat_map(|j| (0..COLUMNS).map(move |i| (i, j))).map(|(i, j)| [node(i, j), node(i + 1, j)]).collect();
    let fold_signs = (0..creases.len()).map(|row| if (row / COLUMNS).is_multiple_of(2) { -1.0 } else { 1.0 }).collect();

    let mut cords = Vec::new();
    let (mut fixed, mut contact_nodes) = (Vec::new(), Vec::new());
    for tether in 0..TETHERS {
        let mut last = node(0, tether * ROWS / TETHERS);
        let end = positions[last as usize];
        for segment in 1..=SEGMENTS {
            let next = positions.len() as u32;
            positions.push([end[0] - 2.5e-3 * segment as f64, end[1], end[2]]);
            cords.push(Cord { nodes: [last, next], stiffness: 6.8e3, rest_length: 2.516e-3, strain_limit: 1.0 });
            contact_nodes.push(next);
            last = next;
        }
        fixed.push(last);
    }
    let mut extra_masses = vec![0.0; positions.len()];
    extra_masses[reference.len()..].fill(2.5e-7);
    Model {
        velocities: (0..positions.len()).map(|k| shake(k + 7, 0.2)).collect(),
        positions,
        reference,
        triangles,
        film: Some(Film { youngs_modulus: 3.2e9, poisson_ratio: 0.34, density: 1420.0, thickness: 7.5e-6 }),
        creases,
        fold_signs,
        extra_masses,
        fixed,
        cords,
        contact_nodes,
        ..Model::default()
    }
}

/// The laws of model 1.
fn laws() -> Vec<LawSpec> {
    vec![
        LawSpec::Springs(SpringParameters {
            buckling: 100.0,
            buckling_on_creases: 1000.0,
            buckling_length: None,
            crease_length: None,
            strain_limit: 1.0,
        }),
        LawSpec::SpringDamping(0.02.into()),
        LawSpec::Creases(CreaseParameters {
            stiffness: 10.0,
            contact_penalty: 100.0,
            natural_angle: 0.0,
            length_scale: None,
            collapse: 0.05,
        }),
        LawSpec::AirDrag(AirDragParameters { pressure: 4.5, temperature: 293.0, air: AirMotion::Still }),
        LawSpec::Spin(Spin { rate: 3.0 * TAU, acceleration: 0.0 }),
        LawSpec::SpoolContact(SpoolContactParameters {
            radius: 0.025,
            stiffness: 200.0,
            half_height: None,
            membrane: false,
        }),
    ]
}

/// The instruction sets that this machine has.
fn widths() -> impl Iterator<Item = Width> {
    Width::ALL.into_iter().filter(|width| width.is_available())
}

fn evaluations(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("evaluation");
    for width in widths() {
        let assembly = Assembly::new(sheet(), width).unwrap();
        let laws = forces::build(&laws(), &assembly).unwrap();
        let positions = assembly.layout.gather_vectors(&assembly.model.positions);
        let velocities = assembly.layout.gather_vectors(&assembly.model.velocities);
        let at = Instant { time: 0.0, positions: &positions, velocities: &velocities };
        let mut forces = Vectors::zeros(assembly.masses.len());
        for law in &laws {
            let id = BenchmarkId::new(law.name(), width.name());
            group.bench_function(id, |bencher| bencher.iter(|| law.add_forces(black_box(at), &mut forces)));
            forces.fill(0.0);
        }
        group.bench_function(BenchmarkId::new("all", width.name()), |bencher| {
            bencher.iter(|| {
                forces.fill(0.0);
                laws.iter().map(|law| law.add_forces(black_box(at), &mut forces)).sum::<f64>()
            });
        });
    }
    group.finish();
}

fn steps(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("step");
    for (name, width) in integrators::names().flat_map(|name| widths().map(move |width| (name, width))) {
        let settings = Settings { watch_interval: u64::MAX, energy_tolerance: 1e9, width, ..Settings::default() };
        let mut simulation = Simulation::new(sheet(), &laws(), name, Some(STEP), settings).unwrap();
        let start = simulation.progress();
        group.bench_function(BenchmarkId::new(name, width.name()), |bencher| {
            bencher.iter_custom(|count| {
                // From the same start each time, a thousand steps at most, so that all samples do the same work.
                let (mut left, mut spent) = (count, Duration::ZERO);
                while left > 0 {
                    simulation.resume(&start).unwrap();
                    let batch = left.min(1000);
                    let began = std::time::Instant::now();
                    simulation.step(batch).unwrap();
                    spent += began.elapsed();
                    left -= batch;
                }
                spent
            });
        });
    }
    group.finish();
}

/// Says what is measured.
fn counts(_: &mut Criterion) {
    let assembly = Assembly::new(sheet(), Width::Baseline).unwrap();
    println!(
        "sheet: {} nodes, {} springs, {} creases, {} triangles (model 1: 1912, 5368, 756, 3456)",
        assembly.masses.len(),
        assembly.mesh.edges.len() + assembly.model.cords.len(),
        assembly.hinges.len(),
        assembly.mesh.triangles.len()
    );
}

criterion_group! {
    name = benches;
    config = Criterion::default().warm_up_time(Duration::from_millis(500)).measurement_time(Duration::from_secs(2));
    targets = counts, evaluations, steps
}
criterion_main!(benches);
