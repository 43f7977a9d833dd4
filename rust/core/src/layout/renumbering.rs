//! Renumbering: the core's own order of nodes, unseen by callers.
//!
//! Callers pass and receive arrays in external order. The internal order makes most batches of elements *contiguous*:
//! eight elements of a kind whose first, second, ... nodes are each eight consecutive numbers. A kernel then reads and
//! writes contiguous parts of the columns, without gather, scatter or conflict:
//!
//!     element    0   1   2 ...  7          reads of a kernel       x[a .. a+8] and x[b .. b+8]
//!     nodes    a b  . .  . .   a+7 b+7     additions               f[a .. a+8] and f[b .. b+8]
//!
//! A missing element leaves a padding lane with the factor zero, which costs less than a gather. A *split* batch has
//! two windows of four lanes, each with its own first nodes. Remaining elements are *gathered*, eight at a time, for
//! the same kernel. Batches are sorted by *tile*, a block of nodes on which all laws act before the next.
//!
//! Triangulations numbered row by row are periodic: alternating diagonals repeat every second node, petals every n/4
//! nodes. The internal order therefore takes the nodes of `blocks` equal blocks of the external order in turn, and in
//! each row every `stride`-th node first. Nodes with the same role in the pattern become neighbours. Rows stay
//! together, so that the data of an element stay in the cache. For four petals p and a row of five nodes, at stride 2:
//!
//!     external    p0: 0 1 2 3 4    p1: 0 1 2 3 4    ...
//!     internal    p0:0 p1:0 p2:0 p3:0  p0:2 p1:2 ...  p3:4  p0:1 p1:1 ...  p3:3
//!
//! A row ends where no edge joins a node to the next. The search keeps the pair of blocks and stride with the least
//! cost of the springs. Other meshes are numbered breadth first along the springs (Cuthill and McKee 1969).

use std::collections::VecDeque;

use super::batches::Cover;
use crate::arrays::state::NodeVectors;
use crate::simd::lanes::LANES;

/// A permutation of the nodes between external and internal order.
#[derive(Debug, Clone)]
pub struct Renumbering {
    /// `order[internal]` is the external number.
    order: Vec<u32>,
    /// `rank[external]` is the internal number.
    rank: Vec<u32>,
}

/// Numbers of blocks, and strides, in the search.
const BLOCKS: [usize; 6] = [1, 2, 3, 4, 6, 8];
const STRIDES: [usize; 4] = [1, 2, 3, 4];
/// Number of springs by which the search compares them.
const SAMPLE: usize = 40_000;

impl Renumbering {
    /// Numbers `node_count` nodes. The first `mesh_count` are those of a mesh with `edges`; `links` are all springs.
    pub fn new(node_count: usize, mesh_count: usize, edges: &[[u32; 2]], links: &[[u32; 2]]) -> Self {
        // The first springs of every block.
        let sample = |blocks: usize| {
            let size = (mesh_count / blocks).max(1);
            let limit = size.min((SAMPLE * mesh_count / (edges.len().max(1) * blocks)).max(1));
            edges.iter().copied().filter(|edge| (edge[0] as usize) % size < limit).collect::<Vec<_>>()
        };
        // Springs per lane, weighted by cost: at best 1.
        let utilisation = |sample: &[[u32; 2]], order: &[u32]| {
            let rank = inverse(order);
            let sample: Vec<[u32; 2]> =
                sample.iter().map(|edge| ascending(edge.map(|node| rank[node as usize]))).collect();
            sample.len() as f64 / (Cover::new(&sample, node_count).cost() * LANES as f64).max(1.0)
        };
        let mut best = (0.0, (0..node_count as u32).collect());
        let row_ends = row_ends(mesh_count, edges);
        for blocks in BLOCKS.into_iter().filter(|blocks| mesh_count.is_multiple_of(*blocks)) {
            let sample = sample(blocks);
            for stride in STRIDES {
                let order = interleaved(node_count, mesh_count, &row_ends, blocks, stride);
                let score = utilisation(&sample, &order);
                if score > best.0 + 1e-3 {
                    best = (score, order);
                }
            }
        }
        if best.0 < 0.5 {
            let order = breadth_first(node_count, links);
            if utilisation(&sample(1), &order) >= best.0 {
                best.1 = order;
            }
        }
        let rank = inverse(&best.1);
        Self { order: best.1, rank }
    }

    /// Internal numbers of the nodes of an element.
    pub fn to_internal<const N: usize>(&self, nodes: [u32; N]) -> [u32; N] {
        nodes.map(|node| self.rank[node as usize])
    }

    /// Internal numbers of node pairs, the lower first: a spring has no direction.
    pub fn pairs_to_internal(&self, pairs: impl Iterator<Item = [u32; 2]>) -> Vec<[u32; 2]> {
        pairs.map(|pair| ascending(self.to_internal(pair))).collect()
    }

    /// External number of a node.
    pub fn to_external(&self, internal: usize) -> usize {
        self.order[internal] as usize
    }

    /// One number per node, from external to internal order.
    pub fn internal_values(&self, values: &[f64]) -> Vec<f64> {
        self.order.iter().map(|&external| values[external as usize]).collect()
    }

    /// One number per node, from internal to external order.
    pub fn external_values(&self, values: &[f64]) -> Vec<f64> {
        self.rank.iter().map(|&internal| values[internal as usize]).collect()
    }

    /// One vector per node, from external to internal order.
    pub fn internal_vectors(&self, rows: &[[f64; 3]]) -> NodeVectors {
        NodeVectors::from_fn(self.order.len(), |internal, axis| rows[self.order[internal] as usize][axis])
    }

    /// One vector per node, from internal to external order.
    pub fn external_vectors(&self, vectors: &NodeVectors) -> Vec<[f64; 3]> {
        self.rank.iter().map(|&internal| [0, 1, 2].map(|axis| vectors[(internal as usize, axis)])).collect()
    }
}

/// The inverse permutation.
fn inverse(order: &[u32]) -> Vec<u32> {
    let mut rank = vec![0; order.len()];
    for (internal, &external) in order.iter().enumerate() {
        rank[external as usize] = internal as u32;
    }
    rank
}

/// Whether each node of the mesh is the last of a row: no edge joins it to the next.
fn row_ends(mesh_count: usize, edges: &[[u32; 2]]) -> Vec<bool> {
    let mut is_end = vec![true; mesh_count];
    for edge in edges {
        if edge[0].abs_diff(edge[1]) == 1 {
            is_end[edge[0].min(edge[1]) as usize] = false;
        }
    }
    is_end
}

/// The nodes of `blocks` equal blocks of the mesh in turn, in each row every `stride`-th node first; then the others.
fn interleaved(node_count: usize, mesh_count: usize, row_ends: &[bool], blocks: usize, stride: usize) -> Vec<u32> {
    let size = mesh_count / blocks;
    let mut order = Vec::with_capacity(node_count);
    let mut start = 0;
    while start < size {
        let end = (start..size).find(|&node| row_ends[node]).map_or(size, |last| last + 1);
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

/// Breadth first along the links, each component from its node of least degree.
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
    fn the_nodes_of_a_chain_in_random_order_become_consecutive() {
        let order = breadth_first(5, &[[3, 0], [0, 4], [4, 1], [1, 2]]);
        let rank = inverse(&order);
        for [i, j] in [[3, 0], [0, 4], [4, 1], [1, 2]] {
            assert_eq!(rank[i].abs_diff(rank[j]), 1);
        }
    }

    #[test]
    fn external_order_is_the_inverse_of_internal_order() {
        let numbering = Renumbering::new(5, 4, &[[1, 3], [0, 1]], &[[1, 3], [0, 1], [4, 0]]);
        let rows: Vec<[f64; 3]> = (0..5).map(|i| [f64::from(i), 0.5, -1.0]).collect();
        assert_eq!(numbering.external_vectors(&numbering.internal_vectors(&rows)), rows);
        let values = [3.0, 1.0, 4.0, 1.0, 5.0];
        assert_eq!(numbering.external_values(&numbering.internal_values(&values)), values);
        for node in 0..5 {
            assert_eq!(numbering.to_external(numbering.to_internal([node])[0] as usize), node as usize);
        }
    }
}
