//! Pairs and lists against all pairs, one by one.

use std::collections::BTreeMap;

use super::lists::{LISTS, Lists};
use super::pairs::Step;
use super::surface::{Pair, Surface};
use super::{MARGIN, SHARE, Scheme};
use crate::arrays::state::{NodeVectors, columns};
use crate::assembly::Assembly;
use crate::contact::closest::{edge_edge, node_triangle};
use crate::error::Result;
use crate::model::input::{Bridges, Cord, Film, Model};
use crate::simd::dispatch::InstructionSet;
use crate::simd::lanes::{F64x8, SimdF64};

const FILM: Film = Film { youngs_modulus: 3.2e9, poisson_ratio: 0.34, density: 1420.0, thickness: 7.5e-6 };
const TOUCHING: [f64; 2] = [7.5e-6, 9e-6];
const CELLS: u32 = 3;
const SIZE: f64 = 0.011;

/// Two sheets above each other, the second one turned and `gap` higher, and a cord of three segments between them.
fn sheets(gap: f64) -> Model {
    let mut model = Model { film: Some(FILM), ..Model::default() };
    for layer in 0..2 {
        let first = model.positions.len() as u32;
        let (s, c) = (0.2 * f64::from(layer)).sin_cos();
        for node in 0..(CELLS + 1) * (CELLS + 1) {
            let [x, y] = [node % (CELLS + 1), node / (CELLS + 1)].map(|k| SIZE * f64::from(k));
            model.positions.push([c * x - s * y, s * x + c * y, gap * f64::from(layer)]);
        }
        for cell in 0..CELLS * CELLS {
            let a = first + cell % CELLS + cell / CELLS * (CELLS + 1);
            let [b, d, e] = [a + 1, a + CELLS + 1, a + CELLS + 2];
            model.triangles.extend([[a, b, e], [a, e, d]]);
        }
    }
    model.reference = model.positions.clone();
    let first = model.positions.len() as u32;
    model.positions.extend((0..4).map(|k| [SIZE * (f64::from(k) - 0.2), 0.01, 0.5 * gap]));
    let cord = |k| Cord {
        nodes: [first + k, first + k + 1],
        stiffness: 1.0,
        rest_length: SIZE,
        strain_limit: 1e9,
        ..Default::default()
    };
    model.cords = (0..3).map(cord).collect();
    model.velocities = vec![[0.0; 3]; model.positions.len()];
    model.extra_masses = vec![1e-6; model.positions.len()];
    model.layers = (0..model.triangles.len() as u32).rev().collect();
    model
}

fn surface_of(model: Model, has_edges: bool) -> Result<(Assembly, Surface)> {
    let assembly = Assembly::new(model, InstructionSet::widest())?;
    let surface = Surface::new(&assembly, true, TOUCHING, has_edges);
    Ok((assembly, surface))
}

/// Every pair of a surface whose elements have no node in common, by all nodes, triangles and edges.
fn all_pairs(assembly: &Assembly, surface: &Surface, has_edges: bool) -> Vec<Pair> {
    let bridges: Vec<[u32; 2]> =
        assembly.model.bridges.nodes.iter().map(|&nodes| assembly.numbering.to_internal(nodes)).collect();
    let is_one = |a: u32, b: u32| a == b || bridges.contains(&[a, b]) || bridges.contains(&[b, a]);
    let is_apart = |some: &[u32], others: &[u32]| some.iter().all(|&a| others.iter().all(|&b| !is_one(a, b)));
    let mut nodes: Vec<u32> = surface.edges.iter().flatten().copied().collect();
    nodes.sort_unstable();
    nodes.dedup();
    let mut pairs = Vec::new();
    for (number, corners) in (0..).zip(&surface.triangles) {
        pairs.extend(nodes.iter().filter(|&&node| is_apart(&[node], corners)).map(|&node| Pair::of_node(node, number)));
    }
    let segments = surface.edges.len() - assembly.model.cords.len();
    for first in 0..if has_edges { segments } else { 0 } {
        let others = first + 1..surface.edges.len();
        let apart = others.filter(|&second| is_apart(&surface.edges[first], &surface.edges[second]));
        pairs.extend(apart.map(|second| Pair::of_edges(first as u32, second as u32)));
    }
    pairs.sort_unstable();
    pairs
}

#[test]
fn each_pair_of_all_elements_comes_once() -> Result<()> {
    for (has_edges, bridges) in [(true, vec![]), (true, vec![[0, 17], [3, 20]]), (false, vec![])] {
        let mut model = sheets(1e-5);
        model.bridges = Bridges { nodes: bridges, stiffness: 1.0 };
        // Some triangles are left out, and their nodes with them.
        model.layers.retain(|number| number % 7 != 0);
        let (assembly, surface) = surface_of(model, has_edges)?;
        let mut found: BTreeMap<Pair, u32> = BTreeMap::new();
        for first in 0..surface.elements.len() {
            for second in first + 1..surface.elements.len() {
                surface.visit_pairs(first, second, &mut |pair| *found.entry(pair).or_default() += 1);
            }
        }
        let expected = all_pairs(&assembly, &surface, has_edges);
        assert!(found.values().all(|&count| count == 1));
        assert!(expected.len() > 800 && expected.iter().any(|pair| surface.has_cord(*pair)));
        assert_eq!(found.into_keys().collect::<Vec<_>>(), expected);
    }
    Ok(())
}

/// The distance of a pair.
fn distance(surface: &Surface, pair: Pair, positions: &NodeVectors) -> f64 {
    let columns = columns(positions);
    let x = surface.nodes(pair).map(|node| columns.map(|column| F64x8::all(column[node as usize])));
    let found = if pair.has_edges() { edge_edge(x) } else { node_triangle(x) };
    found.gap.iter().map(|gap| gap.0[0] * gap.0[0]).sum::<f64>().sqrt()
}

/// A number between -1 and 1 without an order.
fn noise(a: usize, b: usize, c: usize) -> f64 {
    ((a * 31 + b * 17 + c * 7919) as f64 * 12.9898).sin()
}

/// Velocities that change slowly, and vibrate.
fn velocities(step: usize, nodes: usize, vibration: f64) -> NodeVectors {
    NodeVectors::from_fn(nodes, |node, axis| {
        let slow = 0.3 * noise(node, axis, step / 60) + 0.1 * noise(node, axis, step / 7);
        slow + vibration * noise(node, axis, step)
    })
}

#[test]
fn no_list_misses_a_pair_that_comes_near() -> Result<()> {
    const STEPS: usize = 250;
    let rules = [
        (Scheme::default(), 0.01),
        (Scheme::default(), 0.4),
        (Scheme { skins: [40.0, 4.0, 1.0, 1.0], horizons: [100.0, 10.0, 10.0, 10.0], ..Scheme::default() }, 0.1),
        (Scheme { skins: [0.3; LISTS], horizons: [1.0; LISTS], ..Scheme::default() }, 0.1),
    ];
    for (scheme, vibration) in rules {
        let (assembly, surface) = surface_of(sheets(1.2e-5), true)?;
        let nodes = assembly.masses.len();
        let (dt, margin) = (4e-6, MARGIN * TOUCHING[1]);
        let all = all_pairs(&assembly, &surface, true);
        let mut lists = Lists::new(&surface, SHARE, margin, nodes, assembly.instructions, scheme);
        let mut positions = assembly.numbering.internal_vectors(&assembly.model.positions);
        let mut shapes = vec![positions.clone()];
        let (mut near, mut listed) = (0, 0);
        for step in 0..STEPS {
            if step == 100 {
                shapes.push(positions.clone());
                lists.forget();
            }
            let drift = velocities(step, nodes, vibration);
            let time = step as f64 * dt;
            let (list, _) =
                lists.at(Step { time, dt, positions: &positions, velocities: &drift }, &surface, SHARE, &shapes);
            let of_levels = list.iter().flat_map(|pairs| pairs.0.iter().flatten());
            let list: BTreeMap<Pair, f64> = of_levels.map(|listed| (listed.pair, listed.kept)).collect();
            listed += list.len();
            let ways = [0.0, 0.3, 0.7, 1.0].map(|share| &positions + &drift * (share * dt));
            for &pair in &all {
                let of_shapes = shapes.iter().map(|shape| distance(&surface, pair, shape));
                let kept = SHARE * of_shapes.fold(0.0, f64::max).min(surface.touching(pair));
                let least = ways.iter().map(|x| distance(&surface, pair, x)).fold(f64::INFINITY, f64::min);
                let found = list.get(&pair);
                if least < kept + margin {
                    near += 1;
                    assert!(found.is_some(), "{scheme:?}, step {step}: {pair:?} at {least:e}");
                }
                if let Some(found) = found {
                    assert!((found - kept).abs() < 1e-18, "{scheme:?}: {found} {kept}");
                }
            }
            positions = &positions + &drift * dt;
        }
        assert!(near > 1000 && listed < 12 * near, "{near} {listed}");
        // The first lists hold for many steps, and the last one where the motion is smooth.
        let [first, .., last] = lists.made();
        if scheme == Scheme::default() {
            assert!(first < 5 && (vibration > 0.1 || last < 3 * STEPS as u64 / 4), "{vibration}: {first} {last}");
        }
    }
    Ok(())
}
