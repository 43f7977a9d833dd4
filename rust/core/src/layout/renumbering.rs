//! The order in which the core keeps nodes and elements: its own business, unseen by callers.
//!
//! Positions go in and come out in the caller's order. Inside, nodes are numbered so that most elements fall into *contiguous*:
//! eight elements of a kind whose first, second, ... nodes are each eight consecutive numbers. A kernel then reads and
//! writes straight pieces of the columns, without gather, scatter or conflict:
//!
//!     element    0   1   2 ...  7          a kernel reads   x[a .. a+8] and x[b .. b+8]
//!     nodes    a b  . .  . .   a+7 b+7     and adds to      f[a .. a+8] and f[b .. b+8]
//!
//! Where an element is missing its lane has the factor zero, which costs less than a gather; a batch may also be two *split*
//! of four lanes, each with its own first nodes. What stands alone is *gathered*: gathered, eight elements at a time, into the
//! same kernel. All batches stand by *tile*, 2048 nodes that all laws go over before the next (see `state`).
//!
//! Triangulations that a pattern numbers row by row repeat themselves: alternating diagonals every second node, and
//! petals every n/4 nodes. So the numbering takes `blocks` equal blocks of the caller's order in turn, and in each row every
//! `stride`-th node before the next set: nodes that play the same part in the pattern become neighbours, and rows stay
//! together, which keeps what an element needs in the cache. For four petals p and a row of five nodes, at stride 2:
//!
//!     caller    p0: 0 1 2 3 4    p1: 0 1 2 3 4    ...    core    p0:0 p1:0 p2:0 p3:0  p0:2 p1:2 ...  p3:4  p0:1 p1:1 ...  p3:3
//!
//! A row ends where no edge joins a node to the next. The pair that costs the springs the least is kept; for meshes in no
//! order, breadth first through the springs (Cuthill and McKee 1969).

use std::collections::VecDeque;

use super::batches::Cover;
use crate::arrays::state::NodeVectors;
use crate::simd::lanes::LANES;

/// A numbering of the nodes.
#[derive(Debug, Clone)]
pub struct Renumbering {
    /// `order[inside]` is the caller's index.
    order: Vec<u32>,
    /// `rank[outside]` is the core's index.
    rank: Vec<u32>,
}

/// How many blocks and strides are tried.
const BLOCKS: [usize; 6] = [1, 2, 3, 4, 6, 8];
const STRIDES: [usize; 4] = [1, 2, 3, 4];
/// Springs that are looked at to choose among them.
const SAMPLE: usize = 40_000;

impl Renumbering {
    /// Numbers `node_count` nodes, of which the first `mesh_count` are a mesh's with these edges; `links` are all springs.
    pub fn new(node_count: usize, mesh_count: usize, edges: &[[u32; 2]], links: &[[u32; 2]]) -> Self {
        let share = |blocks: usize, order: &[u32]| {
            let (rank, size) = (inverse(order), (mesh_count / blocks).max(1));
            // The first springs of every block.
            let limit = size.min((SAMPLE * mesh_count / (edges.len().max(1) * blocks)).max(1));
            let sample: Vec<[u32; 2]> = edges
                .iter()
                .filter(|edge| (edge[0] as usize) % size < limit)
                .map(|edge| ascending(edge.map(|node| rank[node as usize])))
                .collect();
            // Springs per lane that is paid for, at best 1.
            sample.len() as f64 / (Cover::new(&sample, node_count).cost() * LANES as f64).max(1.0)
        };
        let mut best = (0.0, (0..node_count as u32).collect());
        let breaks = breaks(mesh_count, edges);
        for blocks in BLOCKS.into_iter().filter(|blocks| mesh_count.is_multiple_of(*blocks)) {
            for stride in STRIDES {
                let order = repeating(node_count, mesh_count, &breaks, blocks, stride);
                let score = share(blocks, &order);
                if score > best.0 + 1e-3 {
                    best = (score, order);
                }
            }
        }
        if best.0 < 0.5 {
            let order = breadth_first(node_count, links);
            if share(1, &order) >= best.0 {
                best.1 = order;
            }
        }
        let rank = inverse(&best.1);
        Self { order: best.1, rank }
    }

    /// Nodes of an element, from the caller's numbers to the core's.
    pub fn to_internal<const N: usize>(&self, nodes: [u32; N]) -> [u32; N] {
        nodes.map(|node| self.rank[node as usize])
    }

    /// Node pairs, from the caller's numbers to the core's, lower first: a spring has no direction.
    pub fn pairs_to_internal(&self, pairs: impl Iterator<Item = [u32; 2]>) -> Vec<[u32; 2]> {
        pairs.map(|pair| ascending(self.to_internal(pair))).collect()
    }

    /// The caller's number of the core's node `inside`.
    pub fn to_external(&self, inside: usize) -> usize {
        self.order[inside] as usize
    }

    /// One number per node, from the caller's order to the core's.
    pub fn internal_values(&self, values: &[f64]) -> Vec<f64> {
        self.order.iter().map(|&outside| values[outside as usize]).collect()
    }

    /// One number per node, from the core's order to the caller's.
    pub fn external_values(&self, values: &[f64]) -> Vec<f64> {
        self.rank.iter().map(|&inside| values[inside as usize]).collect()
    }

    /// One vector per node, from the caller's order to the core's.
    pub fn internal_vectors(&self, rows: &[[f64; 3]]) -> NodeVectors {
        NodeVectors::from_fn(self.order.len(), |inside, axis| rows[self.order[inside] as usize][axis])
    }

    /// One vector per node, from the core's order to the caller's.
    pub fn external_vectors(&self, vectors: &NodeVectors) -> Vec<[f64; 3]> {
        self.rank.iter().map(|&inside| [0, 1, 2].map(|axis| vectors[(inside as usize, axis)])).collect()
    }
}

/// The inverse permutation.
fn inverse(order: &[u32]) -> Vec<u32> {
    let mut rank = vec![0; order.len()];
    for (inside, &outside) in order.iter().enumerate() {
        rank[outside as usize] = inside as u32;
    }
    rank
}

/// Whether no edge joins each node of the mesh to the next: there a row of nodes ends.
fn breaks(mesh_count: usize, edges: &[[u32; 2]]) -> Vec<bool> {
    let mut breaks = vec![true; mesh_count];
    for edge in edges {
        if edge[0].abs_diff(edge[1]) == 1 {
            breaks[edge[0].min(edge[1]) as usize] = false;
        }
    }
    breaks
}

/// `blocks` equal blocks of the mesh's nodes taken in turn, in each row every `stride`-th node first; then all other nodes.
fn repeating(node_count: usize, mesh_count: usize, breaks: &[bool], blocks: usize, stride: usize) -> Vec<u32> {
    let size = mesh_count / blocks;
    let mut order = Vec::with_capacity(node_count);
    let mut start = 0;
    while start < size {
        let end = (start..size).find(|&node| breaks[node]).map_or(size, |last| last + 1);
        for first in 0..stride {
            for node in (start + first..end).step_by(stride) {
                order.extend((0..blocks).map(|block| (block * size + node) as u32));
            }
        }
        start = end;
    }
    order.extend(mesh_count as u32..node_count as u32);
    order
}

/// Breadth first through the links, each component from its node of lowest degree.
fn breadth_first(node_count: usize, links: &[[u32; 2]]) -> Vec<u32> {
    let mut neighbours = vec![Vec::new(); node_count];
    for &[i, j] in links {
        neighbours[i as usize].push(j);
        neighbours[j as usize].push(i);
    }
    let degree = |node: &u32| (neighbours[*node as usize].len(), *node);
    let mut seeds: Vec<u32> = (0..node_count as u32).collect();
    seeds.sort_by_key(degree);
    let mut seen = vec![false; node_count];
    let mut order = Vec::with_capacity(node_count);
    let mut queue = VecDeque::new();
    for seed in seeds {
        if std::mem::replace(&mut seen[seed as usize], true) {
            continue;
        }
        queue.push_back(seed);
        while let Some(node) = queue.pop_front() {
            order.push(node);
            let unseen = neighbours[node as usize].iter().copied();
            let mut next: Vec<u32> =
                unseen.filter(|&other| !std::mem::replace(&mut seen[other as usize], true)).collect();
            next.sort_by_key(degree);
            queue.extend(next);
        }
    }
    order
}

fn ascending(mut pair: [u32; 2]) -> [u32; 2] {
    pair.sort_unstable();
    pair
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scrambled_chain_becomes_consecutive() {
        let order = breadth_first(5, &[[3, 0], [0, 4], [4, 1], [1, 2]]);
        let rank = inverse(&order);
        for [i, j] in [[3, 0], [0, 4], [4, 1], [1, 2]] {
            assert_eq!(rank[i].abs_diff(rank[j]), 1);
        }
    }

    #[test]
    fn out_undoes_in() {
        let layout = Renumbering::new(5, 4, &[[1, 3], [0, 1]], &[[1, 3], [0, 1], [4, 0]]);
        let rows: Vec<[f64; 3]> = (0..5).map(|i| [f64::from(i), 0.5, -1.0]).collect();
        assert_eq!(layout.external_vectors(&layout.internal_vectors(&rows)), rows);
        let values = [3.0, 1.0, 4.0, 1.0, 5.0];
        assert_eq!(layout.external_values(&layout.internal_values(&values)), values);
        for node in 0..5 {
            assert_eq!(layout.to_external(layout.to_internal([node])[0] as usize), node as usize);
        }
    }
}
