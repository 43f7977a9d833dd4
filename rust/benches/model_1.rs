//! The sail of model 1: the kernels at every width against plain scalar loops and against bounds of the machine, in one
//! session on one thread.
//!
//! The scalar loops are those of the tests (`tests/oracle`), compiled with the same flags. All are timed in turn, a few
//! evaluations at a time, and the result is the tenth percentile, so that other load of the machine affects all alike.
//! Prints tables in Markdown: the parts of an evaluation of model 1, and of finer meshes by arguments (`-- 4 16`).
//! `-- quick` takes fewer timings.
#![allow(missing_docs, clippy::unwrap_used, clippy::print_stdout)]

mod bound;
#[path = "../core/tests/common/mod.rs"]
mod common;
mod contenders;
#[path = "../core/tests/oracle/mod.rs"]
mod oracle;

use std::time::Instant;

use bound::OperationTimes;
use common::sail;
use contenders::{PARTS, Scene, label, widths};
use membrane_core::simd::aligned::Aligned;
use membrane_core::simd::counted::{Counts, count};
use membrane_core::simd::dispatch::InstructionSet;
use membrane_core::simd::lanes::LANES;

/// As in the Python module.
#[global_allocator]
static ALLOCATOR: Aligned = Aligned;

/// Evaluations in one timing at fineness 1, and timings of each contender.
const EVALUATIONS: usize = 8;
const ROUNDS: usize = 150;

/// Times of each part of an evaluation [us]: the scalar loops, then each width.
fn measure(scene: &mut Scene, fineness: usize, rounds: usize) -> Vec<Vec<f64>> {
    let mut loops = scene.loops();
    let mut kernels: Vec<_> = widths().map(|instructions| scene.kernels(instructions)).collect();
    let columns = 1 + kernels.len();
    let evaluations = (EVALUATIONS / fineness).max(1);
    let mut times = vec![vec![Vec::new(); columns]; PARTS];
    for _ in 0..(rounds / fineness / fineness).max(10) {
        for (part, times) in times.iter_mut().enumerate() {
            for (column, times) in times.iter_mut().enumerate() {
                let mut evaluate = || match column.checked_sub(1) {
                    None => loops.evaluate(part),
                    Some(instructions) => kernels[instructions].evaluate(part, scene.at()),
                };
                evaluate();
                let began = Instant::now();
                (0..evaluations).for_each(|_| evaluate());
                times.push(began.elapsed().as_secs_f64() / evaluations as f64 * 1e6);
            }
        }
    }
    times.into_iter().map(|columns| columns.into_iter().map(tenth_percentile).collect()).collect()
}

fn tenth_percentile(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 10]
}

/// Prints a table: the scalar loops, then each width with its speed-up.
fn print_table(title: &str, rows: &[(String, Vec<f64>)]) {
    println!("| {title} | scalar | {} |", widths().map(InstructionSet::name).collect::<Vec<_>>().join(" | "));
    println!("|---|{}", "---:|".repeat(rows[0].1.len()));
    for (label, times) in rows {
        let cells: Vec<String> = times[1..].iter().map(|time| format!("{time:.1} ({:.1}x)", times[0] / time)).collect();
        println!("| {label} | {:.1} | {} |", times[0], cells.join(" | "));
    }
    println!();
}

/// Prints the times of operations, the operation counts of an evaluation, and the bounds that follow.
fn print_bounds(scene: &mut Scene, times: &[Vec<f64>]) {
    let operation_times: Vec<(InstructionSet, OperationTimes)> =
        widths().map(|instructions| (instructions, OperationTimes::of(instructions))).collect();
    let names: Vec<&str> = operation_times.iter().map(|(instructions, _)| instructions.name()).collect();
    println!("| an operation on eight numbers [ns] | {} |\n|---|{}", names.join(" | "), "---:|".repeat(names.len()));
    for row in 0..OperationTimes::ROWS {
        let cells: Vec<String> = operation_times.iter().map(|(_, own)| format!("{:.2}", own.rows()[row].1)).collect();
        println!("| {} | {} |", operation_times[0].1.rows()[row].0, cells.join(" | "));
    }

    let mut counted = scene.kernels(InstructionSet::Counted);
    let counts: Vec<Counts> = (0..PARTS).map(|part| count(|| counted.evaluate(part, scene.at()))).collect();
    println!(
        "\n| operations on eight numbers, per batch of eight | + - | x | / | root | larger, smaller | choice | sign | \
         read | write | batches | padding |"
    );
    println!("|---|{}", "---:|".repeat(11));
    for (part, counts) in counts.iter().enumerate() {
        let [elements, lanes] = counted.lanes(part);
        if lanes == 0 {
            continue;
        }
        let Counts { additions, multiplications, divisions, roots, extremes, choices, signs, loads, stores } = *counts;
        let all = [additions, multiplications, divisions, roots, extremes, choices, signs, loads, stores];
        let batches = lanes / LANES;
        let cells: Vec<String> = all.iter().map(|&count| format!("{:.1}", count as f64 / batches as f64)).collect();
        let padding = 100.0 * (1.0 - elements as f64 / lanes as f64);
        println!("| {} | {} | {batches} | {padding:.0} % |", label(part), cells.join(" | "));
    }

    println!(
        "\n| what the machine allows | width | bound [us] | measured [us] | times the bound | bound by | \
         of it for padding [us] |"
    );
    println!("|---|---|---:|---:|---:|---|---:|");
    for part in 0..PARTS {
        let [elements, lanes] = counted.lanes(part);
        for (column, (instructions, own)) in operation_times.iter().enumerate() {
            let (bound, unit) = own.bound(&counts[part]);
            if bound == 0.0 {
                continue;
            }
            let measured = times[part][1 + column];
            let padding = if lanes > 0 { bound * (1.0 - elements as f64 / lanes as f64) } else { 0.0 };
            println!(
                "| {} | {} | {bound:.1} | {measured:.1} | {:.1} | {unit} | {padding:.1} |",
                label(part),
                instructions.name(),
                measured / bound
            );
        }
    }
    println!();
}

fn main() {
    let finenesses = std::env::args().filter_map(|argument| argument.parse().ok());
    let rounds = if std::env::args().any(|argument| argument == "quick") { ROUNDS / 10 } else { ROUNDS };
    for fineness in [1].into_iter().chain(finenesses) {
        let mut scene = Scene::new(sail::sail(fineness));
        let nodes = scene.assembly.masses.len();
        let times = measure(&mut scene, fineness, rounds);
        let unit = if fineness == 1 { 1.0 } else { 1e3 / nodes as f64 };
        let scaled = |times: &[f64], unit: f64| times.iter().map(|time| time * unit).collect();
        let mut rows: Vec<_> =
            times.iter().enumerate().map(|(part, times)| (label(part).to_owned(), scaled(times, unit))).collect();
        let title = if fineness == 1 {
            let model = &scene.assembly.model;
            let springs = scene.assembly.mesh.edges.len() + model.cords.len();
            let (creases, triangles) = (model.creases.nodes.len(), model.triangles.len());
            println!("{nodes} nodes, {springs} springs, {creases} creases, {triangles} triangles\n");
            rows.push(("all, per node [ns]".to_owned(), scaled(&times[PARTS - 1], 1e3 / nodes as f64)));
            "one evaluation [us]".to_owned()
        } else {
            format!("per node, of {nodes} nodes [ns]")
        };
        print_table(&title, &rows);
        if fineness == 1 {
            print_bounds(&mut scene, &times);
        }
    }
}
