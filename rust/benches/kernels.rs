//! Times of an evaluation of each law, of all laws, and of a step, on the sail of model 1 and on finer ones: by plain
//! scalar loops (`tests/oracle`), and by the kernels with each instruction set of the machine.
//!
//! `benchmarks/kernels.py` makes tables of the results: criterion has a group for each mesh, named by the timed
//! operation and the number of nodes. A mesh without a benchmark in the filter is not built.
#![allow(missing_docs, clippy::unwrap_used)]

#[path = "../core/tests/common/mod.rs"]
mod common;
mod contenders;
#[path = "../core/tests/oracle/mod.rs"]
mod oracle;

use std::time::{Duration, Instant};

use common::sail;
use contenders::{PARTS, Scene, label, widths};
use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, BenchmarkId, Criterion, SamplingMode, criterion_group, criterion_main};
use membrane_core::model::input::Model;
use membrane_core::simd::aligned::Aligned;
use membrane_core::simd::dispatch::InstructionSet;
use membrane_core::simulation::{Progress, Settings, Simulation};
use membrane_core::stability::Limit;
use oracle::Motion;
use oracle::steps::{METHODS, Stepper};

/// As in the Python module.
#[global_allocator]
static ALLOCATOR: Aligned = Aligned;

/// Finenesses relative to model 1: 2 and 28 thousand, half a million and a million nodes.
const FINENESSES: [usize; 4] = [1, 4, 17, 24];
/// Step of model 1 [s]; inversely proportional to the fineness.
const STEP: f64 = 4e-6;
/// Number of steps after which the motion restarts, so that all samples are alike.
const MOST_STEPS: u64 = 1000;

/// A group of benchmarks; on the largest mesh a sample has only some evaluations.
fn group<'a>(criterion: &'a mut Criterion, what: &str, fineness: usize) -> BenchmarkGroup<'a, WallTime> {
    let nodes = sail::node_count(fineness) + sail::TETHER_NODES;
    let mut group = criterion.benchmark_group(format!("{what}-{nodes}"));
    let milliseconds = if nodes > 100_000 { 300 } else { 500 };
    group.sampling_mode(SamplingMode::Flat).sample_size(10);
    group.warm_up_time(Duration::from_millis(milliseconds / 3));
    group.measurement_time(Duration::from_millis(milliseconds));
    group
}

fn evaluations(criterion: &mut Criterion, fineness: usize, model: &mut Option<Model>) {
    let mut group = group(criterion, "evaluation", fineness);
    let mut new_scene = || Scene::new(model.get_or_insert_with(|| sail::sail(fineness)).clone());
    let (mut scene, mut loops) = (None, None);
    for part in 0..PARTS {
        group.bench_function(BenchmarkId::new(label(part), "scalar"), |bencher| {
            let loops = loops.get_or_insert_with(|| scene.get_or_insert_with(&mut new_scene).loops());
            bencher.iter(|| loops.evaluate(part));
        });
    }
    drop(loops);
    for instructions in widths() {
        let mut kernels = None;
        for part in 0..PARTS {
            group.bench_function(BenchmarkId::new(label(part), instructions.name()), |bencher| {
                let scene = scene.get_or_insert_with(&mut new_scene);
                let kernels = kernels.get_or_insert_with(|| scene.kernels(instructions));
                bencher.iter(|| kernels.evaluate(part, scene.at()));
            });
        }
    }
    group.finish();
}

/// Steps from a start, repeatedly.
trait Steps {
    fn begin(&mut self);
    fn step(&mut self, count: u64);
}

/// The plain loops, with start, method and step.
struct Plain(Stepper, Motion, &'static str, f64);

impl Steps for Plain {
    fn begin(&mut self) {
        self.0.resume(&self.1);
    }

    fn step(&mut self, count: u64) {
        self.0.step(self.2, self.3, count);
    }
}

impl Steps for (Simulation, Progress) {
    fn begin(&mut self) {
        self.0.resume(&self.1).unwrap();
    }

    fn step(&mut self, count: u64) {
        self.0.step(count).unwrap();
    }
}

fn steps(criterion: &mut Criterion, fineness: usize, model: &mut Option<Model>) {
    let mut group = group(criterion, "step", fineness);
    let mut model = || model.get_or_insert_with(|| sail::sail(fineness)).clone();
    let dt = STEP / fineness as f64;
    // An approximate limit suffices without monitor.
    let limit = Limit { dt, largest_frequency: 2.0 / dt, law: "springs", node: 0 };
    for (method, instructions) in METHODS
        .into_iter()
        .flat_map(|method| [None].into_iter().chain(widths().map(Some)).map(move |instructions| (method, instructions)))
    {
        let mut contender: Option<Box<dyn Steps>> = None;
        group.bench_function(
            BenchmarkId::new(method, instructions.map_or("scalar", InstructionSet::name)),
            |bencher| {
                let contender = contender.get_or_insert_with(|| match instructions {
                    None => {
                        let scene = Scene::new(model());
                        let stepper = Stepper::new(scene.loops().oracle, &scene.assembly);
                        Box::new(Plain(stepper, Motion::of(&scene.assembly), method, dt))
                    }
                    Some(instructions) => {
                        let settings = Settings {
                            check_interval: u64::MAX,
                            energy_tolerance: 1e9,
                            instructions,
                            ..Settings::default()
                        };
                        let simulation = sail::simulation(model(), method, Some(dt), settings, Some(limit.clone()));
                        let start = simulation.progress();
                        Box::new((simulation, start))
                    }
                });
                bencher.iter_custom(|count| {
                    let (mut left, mut spent) = (count, Duration::ZERO);
                    while left > 0 {
                        contender.begin();
                        // The first step of leapfrog has two evaluations.
                        contender.step(1);
                        let chunk = left.min(MOST_STEPS);
                        let began = Instant::now();
                        contender.step(chunk);
                        spent += began.elapsed();
                        left -= chunk;
                    }
                    spent
                });
            },
        );
    }
    group.finish();
}

fn all(criterion: &mut Criterion) {
    for fineness in FINENESSES {
        let mut model = None;
        evaluations(criterion, fineness, &mut model);
        steps(criterion, fineness, &mut model);
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default().nresamples(2000).without_plots();
    targets = all
}
criterion_main!(benches);
