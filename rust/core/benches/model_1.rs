//! Model 1's sail: the kernels at every width against plain scalar loops, in one run on one thread.
//!
//! The scalar loops are those of the tests (`tests/oracle`), compiled with the same flags. All are timed in turn, a few
//! evaluations at a time, and the tenth percentile is given, so that a slow moment of the machine falls on all alike and
//! a busy neighbour shows little. Prints tables in Markdown: the parts of an evaluation of model 1, and a whole evaluation on
//! meshes whose cells are several times as fine (`-- 4 16`; 1, 4 and 16 where nothing is said).
#![allow(missing_docs, clippy::unwrap_used, clippy::print_stdout)]

#[path = "../tests/common/mod.rs"]
mod common;
#[path = "../tests/oracle/mod.rs"]
mod oracle;

use std::hint::black_box;

use common::sail;
use membrane_core::aligned::Aligned;
use membrane_core::forces::{self, Law};
use membrane_core::model::Assembly;
use membrane_core::state::{Instant, Vectors};
use membrane_core::width::Width;
use oracle::{Motion, Oracle};

/// As in the Python module.
#[global_allocator]
static ALLOCATOR: Aligned = Aligned;

/// Evaluations in one timing at fineness 1, and timings of each contender.
const EVALUATIONS: usize = 8;
const ROUNDS: usize = 150;

/// One law's or all laws' evaluation, ready to be timed.
struct Contender<'a> {
    label: &'static str,
    evaluate: Box<dyn FnMut() + 'a>,
    times: Vec<f64>,
}

impl<'a> Contender<'a> {
    fn new(label: &'static str, evaluate: impl FnMut() + 'a) -> Self {
        Self { label, evaluate: Box::new(evaluate), times: Vec::new() }
    }

    fn tenth_percentile(&mut self) -> f64 {
        self.times.sort_by(f64::total_cmp);
        self.times[self.times.len() / 10]
    }
}

/// Times of each part on a sail of this fineness [us], scalar first; the last part is the whole. And the number of nodes.
fn measure(fineness: usize) -> (usize, Vec<(&'static str, Vec<f64>)>) {
    let widths: Vec<Width> = Width::ALL.into_iter().filter(|width| width.is_available()).collect();
    let scene = sail::laws();
    let assemblies: Vec<Assembly> =
        widths.iter().map(|&width| Assembly::new(sail::sail(fineness), width).unwrap()).collect();
    let built: Vec<Vec<Box<dyn Law>>> =
        assemblies.iter().map(|assembly| forces::build(&scene, assembly).unwrap()).collect();
    let oracle = Oracle::new(&scene, &assemblies[0]);
    let model = &assemblies[0].model;
    let nodes = model.positions.len();
    let positions = assemblies[0].layout.gather_vectors(&model.positions);
    let velocities = assemblies[0].layout.gather_vectors(&model.velocities);
    let at = Instant { time: 0.0, positions: &positions, velocities: &velocities };
    let motion = || Motion {
        positions: model.positions.clone(),
        velocities: model.velocities.clone(),
        forces: vec![[0.0; 3]; nodes],
    };
    if fineness == 1 {
        let counts = [oracle.springs.len(), oracle.creases.len(), oracle.triangles.len()];
        println!("{nodes} nodes, {} springs, {} creases, {} triangles\n", counts[0], counts[1], counts[2]);
    }

    // A row of contenders for each part: scalar first, then the widths.
    let mut rows: Vec<Vec<Contender<'_>>> = Vec::new();
    let parts = Oracle::PARTS.into_iter().map(Some).chain([None]);
    for part in parts {
        let mut scalar = motion();
        let oracle = &oracle;
        let label = part.map_or("all", |(label, _, _)| label);
        let mut row = vec![Contender::new(label, move || {
            match part {
                Some((_, _, evaluate)) => evaluate(oracle, black_box(&mut scalar)),
                None => oracle.evaluate(black_box(&mut scalar)),
            };
        })];
        for (laws, width) in built.iter().zip(&widths) {
            let mut forces = Vectors::zeros(nodes);
            let mut powers = vec![0.0; laws.len()];
            let mut taken = Vec::new();
            if let Some((_, names, _)) = part {
                let all = forces::build(&scene, &assemblies[row.len() - 1]).unwrap();
                taken = all.into_iter().filter(|law| names.contains(&law.name())).collect();
            }
            row.push(Contender::new(width.name(), move || {
                let laws = if part.is_some() { &taken } else { laws };
                forces.as_mut_slice().fill(0.0);
                let count = laws.len();
                forces::add_all(laws, black_box(at), &mut forces, &mut powers[..count]);
            }));
        }
        rows.push(row);
    }
    let (evaluations, rounds) = ((EVALUATIONS / fineness).max(1), (ROUNDS / fineness / fineness).max(10));
    for _ in 0..rounds {
        for contender in rows.iter_mut().flatten() {
            (contender.evaluate)();
            let began = std::time::Instant::now();
            (0..evaluations).for_each(|_| (contender.evaluate)());
            contender.times.push(began.elapsed().as_secs_f64() / evaluations as f64 * 1e6);
        }
    }
    let times = |row: &mut Vec<Contender<'_>>| row.iter_mut().map(Contender::tenth_percentile).collect();
    (nodes, rows.iter_mut().map(|row| (row[0].label, times(row))).collect())
}

/// A table: first the scalar loops, then each width and how many times as fast it is.
fn print_table(title: &str, rows: &[(String, Vec<f64>)]) {
    let widths = Width::ALL.into_iter().filter(|width| width.is_available()).map(Width::name);
    println!("| {title} | scalar | {} |", widths.collect::<Vec<_>>().join(" | "));
    println!("|---|{}", "---:|".repeat(rows[0].1.len()));
    for (label, times) in rows {
        let cells: Vec<String> = times[1..].iter().map(|time| format!("{time:.1} ({:.1}x)", times[0] / time)).collect();
        println!("| {label} | {:.1} | {} |", times[0], cells.join(" | "));
    }
    println!();
}

fn main() {
    let mut finenesses: Vec<usize> = std::env::args().filter_map(|argument| argument.parse().ok()).collect();
    if finenesses.is_empty() {
        finenesses = vec![4, 16];
    }
    finenesses.insert(0, 1);
    for fineness in finenesses {
        let (nodes, parts) = measure(fineness);
        let (title, unit) = match fineness {
            1 => ("one evaluation [us]".to_owned(), 1.0),
            _ => (format!("per node, of {nodes} nodes [ns]"), 1e3 / nodes as f64),
        };
        let mut rows: Vec<(String, Vec<f64>)> = Vec::new();
        for (label, times) in parts {
            rows.push((label.to_owned(), times.iter().map(|time| time * unit).collect()));
        }
        if fineness == 1 {
            let times = rows[rows.len() - 1].1.iter().map(|time| time * 1e3 / nodes as f64);
            rows.push(("all, per node [ns]".to_owned(), times.collect()));
        }
        print_table(&title, &rows);
    }
}
