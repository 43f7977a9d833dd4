//! The elements near a body: those that may touch it while no node of another element has moved by its allowance.
//!
//! The distance of an element from the surface changes by no more than the ways of its nodes and of the body. So the
//! allowance of a node is the least distance of the elements that have it and are not near, less the way of the body.
//! Elements that are not near contribute exactly nothing, and those that are near come in the order of their numbers.
//! So results do not depend on when the list was made.

use std::ops::Range;

use crate::arrays::blocks::rows_of;
use crate::arrays::state::{NodeVectors, columns};
use crate::bodies::rigid_body::Pose;
use crate::bodies::shape::Shape;
use crate::model::mesh::{dot, sub};
use crate::simd::dispatch::InstructionSet;
use crate::simd::lanes::SimdF64;
use crate::simd::map::{Formula, each};

/// Where fewer than one node in so many belongs to an element, these are looked at one by one.
const MANY: usize = 8;

/// Elements of K nodes, in ascending order, and those near a copy of a body.
#[derive(Debug, Clone, Default)]
pub struct Elements<const K: usize> {
    /// The nodes of each, internal numbers, ascending.
    pub nodes: Vec<[u32; K]>,
    /// Element and copy, ascending.
    near: Vec<(u32, u32)>,
}

/// All elements that may touch a body.
#[derive(Debug, Clone, Default)]
pub struct Candidates {
    /// Single nodes.
    pub points: Elements<1>,
    /// Edges.
    pub edges: Elements<2>,
    /// Triangles.
    pub triangles: Elements<3>,
}

/// The candidates near a body, while no node has moved by more than its allowance.
#[derive(Debug, Clone, Default)]
pub struct Near {
    /// All elements.
    pub candidates: Candidates,
    /// The nodes of all elements; empty where most nodes are among them, and all are looked at.
    few: Vec<u32>,
    /// Distance from the surface up to which an element is near \[m\].
    skin: f64,
    /// Of each node; infinite for one whose elements are all near \[m\].
    allowances: Vec<f64>,
    /// Positions and poses for which the list was made, and the reach of the nodes.
    positions: Option<NodeVectors>,
    poses: Vec<Pose>,
    reach: f64,
    /// The least allowance \[m\].
    least: f64,
}

impl<const K: usize> Elements<K> {
    /// The elements of these nodes, internal numbers.
    pub fn new(nodes: impl IntoIterator<Item = [u32; K]>) -> Self {
        let mut nodes: Vec<[u32; K]> = nodes.into_iter().collect();
        nodes.iter_mut().for_each(|nodes| nodes.sort_unstable());
        nodes.sort_unstable();
        nodes.dedup();
        Self { nodes, near: Vec::new() }
    }

    /// Element and copy of those near the body, with their lowest node in a tile.
    pub fn near(&self, tile: usize, count: usize) -> impl Iterator<Item = ([u32; K], usize)> {
        let Range { start, end } = rows_of(tile, count);
        let lowest = |&(element, _): &(u32, u32)| self.nodes[element as usize][0] as usize;
        let [start, end] = [start, end].map(|row| self.near.partition_point(|pair| lowest(pair) < row));
        self.near[start..end].iter().map(|&(element, copy)| (self.nodes[element as usize], copy as usize))
    }

    /// Finds the elements within `skin` of the body, by the distances of all nodes from the surface of each copy, and
    /// lowers the allowances of the nodes of all others.
    fn find(
        &mut self,
        shape: &Shape,
        x: [&[f64]; 3],
        poses: &[Pose],
        gaps: &[Vec<f64>],
        skin: f64,
        allowances: &mut [f64],
    ) {
        self.near.clear();
        for (element, nodes) in self.nodes.iter().enumerate() {
            let corners = nodes.map(|node| point(x, node));
            let longest = (1..K).map(|k| distance(corners[k], corners[k - 1])).fold(0.0, f64::max).max(if K > 2 {
                distance(corners[0], corners[K - 1])
            } else {
                0.0
            });
            for (copy, gaps) in gaps.iter().enumerate() {
                let furthest = nodes.iter().map(|&node| gaps[node as usize]).fold(f64::MIN, f64::max);
                let mut gap = furthest - longest;
                if gap <= skin {
                    gap = -shape.depth(&poses[copy], &corners);
                }
                if gap <= skin {
                    self.near.push((element as u32, copy as u32));
                    continue;
                }
                for &node in nodes {
                    let allowance = &mut allowances[node as usize];
                    *allowance = allowance.min(gap);
                }
            }
        }
    }
}

/// Whether a point has moved by more than an allowance, less the way of the body: the sum of what its square has over
/// that of the allowance.
struct BeyondAllowance {
    way: f64,
}

impl Formula<7, 0> for BeyondAllowance {
    #[inline(always)]
    fn row<V: SimdF64>(&self, _: [V; 7], _: [V; 0]) -> [V; 0] {
        []
    }

    #[inline(always)]
    fn summand<V: SimdF64>(&self, [x, y, z, u, v, w, allowance]: [V; 7], _: [V; 0]) -> V {
        let (x, y, z, left) = (x - u, y - v, z - w, allowance - V::all(self.way));
        (x * x + y * y + z * z - left * left).max(V::zero())
    }
}

/// Whether a point has moved by more than a distance: the sum of what its square has over that of the distance.
struct Beyond {
    square: f64,
}

impl Formula<6, 0> for Beyond {
    #[inline(always)]
    fn row<V: SimdF64>(&self, _: [V; 6], _: [V; 0]) -> [V; 0] {
        []
    }

    #[inline(always)]
    fn summand<V: SimdF64>(&self, [x, y, z, u, v, w]: [V; 6], _: [V; 0]) -> V {
        let (x, y, z) = (x - u, y - v, z - w);
        (x * x + y * y + z * z - V::all(self.square)).max(V::zero())
    }
}

impl Near {
    /// No element is near yet; of so many nodes.
    pub fn new(candidates: Candidates, skin: f64, count: usize) -> Self {
        let Candidates { points, edges, triangles } = &candidates;
        let of_edges = edges.nodes.as_flattened().iter().chain(triangles.nodes.as_flattened());
        let mut few: Vec<u32> = points.nodes.as_flattened().iter().chain(of_edges).copied().collect();
        few.sort_unstable();
        few.dedup();
        if few.len() > count / MANY {
            few.clear();
        }
        Self { candidates, few, skin, ..Self::default() }
    }

    /// Whether any node that matters has moved by more than a distance \[m\].
    pub fn has_moved(&self, instructions: InstructionSet, from: &NodeVectors, to: &NodeVectors, by: f64) -> bool {
        let (old, new) = (columns(from), columns(to));
        if !self.few.is_empty() {
            let way = |node: u32| distance(point(old, node), point(new, node));
            return self.few.iter().any(|&node| way(node) > by);
        }
        let ([x, y, z], [u, v, w]) = (old, new);
        each(instructions, &Beyond { square: by * by }, [x, y, z, u, v, w], []) > 0.0
    }

    /// Makes the list anew where nodes or body have moved too far.
    pub fn update(&mut self, shape: &Shape, positions: &NodeVectors, poses: &[Pose], instructions: InstructionSet) {
        if self.is_valid(positions, poses, instructions) {
            return;
        }
        match &mut self.positions {
            Some(own) => own.copy_from(positions),
            None => self.positions = Some(positions.clone()),
        }
        self.poses.clear();
        self.poses.extend_from_slice(poses);
        let x = columns(positions);
        let count = positions.nrows() as u32;
        let all: Vec<u32> = if self.few.is_empty() { (0..count).collect() } else { self.few.clone() };
        let furthest = |pose: &Pose| all.iter().map(|&node| distance(point(x, node), pose.centre)).fold(0.0, f64::max);
        let gaps_of = |pose: &Pose| {
            let mut gaps = vec![0.0; count as usize];
            all.iter().for_each(|&node| gaps[node as usize] = -shape.depth(pose, &[point(x, node)]));
            gaps
        };
        let gaps: Vec<Vec<f64>> = poses.iter().map(gaps_of).collect();
        let Candidates { points, edges, triangles } = &mut self.candidates;
        let allowances = &mut self.allowances;
        allowances.clear();
        allowances.resize(count as usize, f64::INFINITY);
        points.find(shape, x, poses, &gaps, self.skin, allowances);
        edges.find(shape, x, poses, &gaps, self.skin, allowances);
        triangles.find(shape, x, poses, &gaps, self.skin, allowances);
        let finite = allowances.iter().copied().filter(|allowance| allowance.is_finite());
        self.reach = poses.iter().map(furthest).fold(0.0, f64::max) + finite.clone().fold(self.skin, f64::max);
        self.least = finite.fold(f64::INFINITY, f64::min);
    }

    /// Whether the list holds at these positions and poses.
    pub fn is_valid(&self, positions: &NodeVectors, poses: &[Pose], instructions: InstructionSet) -> bool {
        let Candidates { points, edges, triangles } = &self.candidates;
        if points.nodes.is_empty() && edges.nodes.is_empty() && triangles.nodes.is_empty() {
            return true;
        }
        let Some(own) = &self.positions else { return false };
        let shifts = self.poses.iter().zip(poses).map(|(before, now)| before.shift(now, self.reach));
        let way = shifts.fold(0.0, f64::max);
        let (old, new) = (columns(own), columns(positions));
        if way >= self.least {
            return false;
        }
        if !self.few.is_empty() {
            let is_within =
                |&node: &u32| distance(point(old, node), point(new, node)) <= self.allowances[node as usize] - way;
            return self.few.iter().all(is_within);
        }
        let ([x, y, z], [u, v, w]) = (old, new);
        each(instructions, &BeyondAllowance { way }, [x, y, z, u, v, w, &self.allowances[..]], []) == 0.0
    }
}

/// The position of a node.
#[inline(always)]
pub fn point(x: [&[f64]; 3], node: u32) -> [f64; 3] {
    x.map(|column| column[node as usize])
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    dot(sub(a, b), sub(a, b)).sqrt()
}
