//! The order in which the core keeps nodes and elements: its own business, unseen by callers.
//!
//! Positions go in and come out in the caller's order. Inside, nodes are numbered so that most elements fall into *runs*:
//! eight elements of a kind whose first, second, ... nodes are each eight consecutive numbers. A kernel then reads and
//! writes straight pieces of the columns, without gather, scatter or conflict:
//!
//!     element    0   1   2 ...  7          a kernel reads   x[a .. a+8] and x[b .. b+8]
//!     nodes    a b  . .  . .   a+7 b+7     and adds to      f[a .. a+8] and f[b .. b+8]
//!
//! A shorter run is filled up with lanes of factor zero, which cost less than a gather. What stands alone is *loose*:
//! gathered, eight elements at a time, into the same kernel.
//!
//! Triangulations that a pattern numbers row by row repeat themselves: alternating diagonals every second node, and
//! petals every n/4 nodes. So the numbering takes `blocks` equal blocks of the caller's order in turn, every `stride`-th
//! node of a block before the next set: nodes that play the same part in the pattern become neighbours. The pair that puts
//! the most springs into runs is kept; for meshes in no order, breadth first through the springs (Cuthill and McKee 1969).

use std::collections::VecDeque;
use std::ops::Range;

use crate::columns::{Columns, ColumnsMut};
use crate::lanes::{LANES, Lanes, Point};
use crate::state::Vectors;

/// A numbering of the nodes.
#[derive(Debug, Clone)]
pub struct Layout {
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
/// About what a loose element costs, in groups of a run.
const LOOSE_COST: usize = 1;
/// A lane that holds no element.
const NONE: u32 = u32::MAX;

impl Layout {
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
            // Springs per group of eight lanes, at best 1.
            let (runs, loose) = runs_of(&sample);
            let groups: usize = runs.iter().map(|run| run.len().div_ceil(LANES)).sum();
            sample.len() as f64 / ((groups + LOOSE_COST * loose.len()) * LANES).max(1) as f64
        };
        let mut best = (0.0, (0..node_count as u32).collect());
        for blocks in BLOCKS.into_iter().filter(|blocks| mesh_count.is_multiple_of(*blocks)) {
            for stride in STRIDES {
                let order = repeating(node_count, mesh_count, blocks, stride);
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
    pub fn inward<const N: usize>(&self, nodes: [u32; N]) -> [u32; N] {
        nodes.map(|node| self.rank[node as usize])
    }

    /// Node pairs, from the caller's numbers to the core's, lower first: a spring has no direction.
    pub fn inward_pairs(&self, pairs: impl Iterator<Item = [u32; 2]>) -> Vec<[u32; 2]> {
        pairs.map(|pair| ascending(self.inward(pair))).collect()
    }

    /// The caller's number of the core's node `inside`.
    pub fn outward(&self, inside: usize) -> usize {
        self.order[inside] as usize
    }

    /// One number per node, from the caller's order to the core's.
    pub fn gather(&self, values: &[f64]) -> Vec<f64> {
        self.order.iter().map(|&outside| values[outside as usize]).collect()
    }

    /// One number per node, from the core's order to the caller's.
    pub fn scatter(&self, values: &[f64]) -> Vec<f64> {
        self.rank.iter().map(|&inside| values[inside as usize]).collect()
    }

    /// One vector per node, from the caller's order to the core's.
    pub fn gather_vectors(&self, rows: &[[f64; 3]]) -> Vectors {
        Vectors::from_fn(self.order.len(), |inside, axis| rows[self.order[inside] as usize][axis])
    }

    /// One vector per node, from the core's order to the caller's.
    pub fn scatter_vectors(&self, vectors: &Vectors) -> Vec<[f64; 3]> {
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

/// `blocks` equal blocks of the mesh's nodes taken in turn, every `stride`-th node first; then all other nodes.
fn repeating(node_count: usize, mesh_count: usize, blocks: usize, stride: usize) -> Vec<u32> {
    let size = mesh_count / blocks;
    let mut order = Vec::with_capacity(node_count);
    for first in 0..stride {
        for node in (first..size).step_by(stride) {
            order.extend((0..blocks).map(|block| (block * size + node) as u32));
        }
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

/// Rows of `elements` in runs of two and more, each by first node, and the rows that stand alone.
fn runs_of<const N: usize>(elements: &[[u32; N]]) -> (Vec<Vec<u32>>, Vec<u32>) {
    // Elements of one shape (the same differences between their nodes), in order of their first node.
    let shape = |row: u32| {
        let nodes = elements[row as usize];
        nodes.map(|node| node.wrapping_sub(nodes[0]))
    };
    let mut rows: Vec<u32> = (0..elements.len() as u32).collect();
    rows.sort_unstable_by_key(|&row| (shape(row), elements[row as usize][0]));
    let follows = |a: &u32, b: &u32| {
        shape(*a) == shape(*b) && elements[*b as usize][0] == elements[*a as usize][0].wrapping_add(1)
    };
    let (mut runs, mut loose) = (Vec::new(), Vec::new());
    for run in rows.chunk_by(follows) {
        if run.len() > 1 { runs.push(run.to_vec()) } else { loose.push(run[0]) }
    }
    (runs, loose)
}

/// Elements of N nodes each, eight to a group: runs first, then loose ones. Node numbers are the core's.
#[derive(Debug, Clone)]
pub struct Elements<const N: usize> {
    /// First nodes of each group of a run.
    runs: Vec<[u32; N]>,
    /// Nodes of each loose group, lane by lane; the last group is filled up by repeating its last element.
    loose: Vec<[[u32; LANES]; N]>,
    /// The caller's row of each lane of each group; `NONE` for a filler.
    origin: Vec<[u32; LANES]>,
    count: usize,
    /// Above every node of every lane, fillers included: what `read` and `add` rely on.
    node_bound: usize,
}

/// Groups in a batch.
pub const BATCH: usize = 32;

impl<const N: usize> Elements<N> {
    /// Arranges elements of a scene with `node_count` nodes.
    pub fn new(elements: &[[u32; N]], node_count: usize) -> Self {
        let (found, mut alone) = runs_of(elements);
        let mut groups: Vec<([u32; N], [u32; LANES])> = Vec::new();
        for run in &found {
            for rows in run.chunks(LANES) {
                let first = elements[rows[0] as usize];
                // Back from the last nodes there are, so that all eight lanes of every node exist.
                let last = first.iter().max().map_or(0, |&node| node as usize + LANES);
                let back = last.saturating_sub(node_count);
                if rows.len() + back > LANES || first.iter().any(|&node| (node as usize) < back) {
                    alone.extend(rows);
                    continue;
                }
                let mut origin = [NONE; LANES];
                origin[back..back + rows.len()].copy_from_slice(rows);
                groups.push((first.map(|node| node - back as u32), origin));
            }
        }
        groups.sort_by_key(|(first, _)| first[0]);
        alone.sort_by_key(|&row| elements[row as usize]);
        let (runs, mut origin): (Vec<_>, Vec<_>) = groups.into_iter().unzip();
        let mut loose = Vec::with_capacity(alone.len().div_ceil(LANES));
        for rows in alone.chunks(LANES) {
            let mut nodes = [[0; LANES]; N];
            let mut lanes = [NONE; LANES];
            lanes[..rows.len()].copy_from_slice(rows);
            for lane in 0..LANES {
                let element = elements[rows[lane.min(rows.len() - 1)] as usize];
                (0..N).for_each(|k| nodes[k][lane] = element[k]);
            }
            loose.push(nodes);
            origin.push(lanes);
        }
        let ends = runs.iter().flatten().map(|&first: &u32| first as usize + LANES);
        let places = loose.iter().flatten().flatten().map(|&node: &u32| node as usize + 1);
        let node_bound = ends.chain(places).max().unwrap_or(0);
        Self { runs, loose, origin, count: elements.len(), node_bound }
    }

    /// Every element's group, lane and nodes; for what is done once and not at every step.
    pub fn each(&self) -> impl Iterator<Item = (usize, usize, [u32; N])> + '_ {
        let lanes = self
            .origin
            .iter()
            .enumerate()
            .flat_map(|(group, rows)| (0..LANES).filter(|&lane| rows[lane] != NONE).map(move |lane| (group, lane)));
        lanes.map(|(group, lane)| (group, lane, self.nodes(group, lane)))
    }

    /// Number of groups of eight.
    #[inline(always)]
    pub fn group_count(&self) -> usize {
        self.runs.len() + self.loose.len()
    }

    /// Share of the elements that are in runs.
    pub fn share_in_runs(&self) -> f64 {
        let alone = self.origin[self.runs.len()..].iter().flatten().filter(|&&row| row != NONE).count();
        1.0 - alone as f64 / self.count.max(1) as f64
    }

    /// One number per element, from the caller's order to lanes, and `filler` in lanes without one. The factor that makes
    /// an element's force must be zero there, and what it is multiplied with finite.
    pub fn pack(&self, filler: f64, values: impl Fn(usize) -> f64) -> Vec<Lanes> {
        let value = |row: u32| if row == NONE { filler } else { values(row as usize) };
        self.origin.iter().map(|rows| Lanes(rows.map(value))).collect()
    }

    /// One number per element, from lanes to the caller's order.
    pub fn unpack(&self, values: impl Iterator<Item = Lanes>) -> Vec<f64> {
        let mut numbers = vec![0.0; self.count];
        for (&row, value) in self.origin.iter().flatten().zip(values.flat_map(|lanes| lanes.0)) {
            if row != NONE {
                numbers[row as usize] = value;
            }
        }
        numbers
    }

    /// The groups that are loose, or those that are runs. A sweep does the one and then the other, so that the compiler
    /// sees straight reads and writes in the loop over runs.
    #[inline(always)]
    pub fn groups<const LOOSE: bool>(&self) -> Range<usize> {
        if LOOSE { self.runs.len()..self.group_count() } else { 0..self.runs.len() }
    }

    /// The same groups, a batch at a time: for sweeps that sum. They write one result per group and sum after the batch; a
    /// sum carried through the loop keeps the compiler from using whole vectors.
    #[inline(always)]
    pub fn batches<const LOOSE: bool>(&self) -> impl Iterator<Item = Range<usize>> {
        let Range { start, end } = self.groups::<LOOSE>();
        (start..end).step_by(BATCH).map(move |first| first..end.min(first + BATCH))
    }

    /// The vectors of the nodes of a group, which is loose or not.
    #[inline(always)]
    #[allow(unsafe_code)]
    pub fn read<const LOOSE: bool>(&self, columns: Columns<'_>, group: usize) -> [Point; N] {
        assert!(self.node_bound <= columns.rows());
        let mut points = [[Lanes::ZERO; 3]; N];
        // SAFETY: nodes of runs and loose groups, all their lanes included, are below `node_bound`, and so below the number
        // of rows of the columns; `axis` is below three.
        unsafe {
            if LOOSE {
                let nodes = &self.loose[group - self.runs.len()];
                for k in 0..N {
                    for axis in 0..3 {
                        points[k][axis] = columns.gather(axis, &nodes[k]);
                    }
                }
            } else {
                let first = self.runs[group];
                for k in 0..N {
                    for axis in 0..3 {
                        points[k][axis] = columns.read(axis, first[k]);
                    }
                }
            }
        }
        points
    }

    /// Adds a vector to each node of a group, which is loose or not; those of fillers must be zero.
    #[inline(always)]
    #[allow(unsafe_code)]
    pub fn add<const LOOSE: bool>(&self, columns: &mut ColumnsMut<'_>, group: usize, vectors: [Point; N]) {
        assert!(self.node_bound <= columns.rows());
        // SAFETY: as in `read`.
        unsafe {
            if LOOSE {
                let nodes = &self.loose[group - self.runs.len()];
                for k in 0..N {
                    for axis in 0..3 {
                        columns.scatter(axis, &nodes[k], vectors[k][axis]);
                    }
                }
            } else {
                let first = self.runs[group];
                for k in 0..N {
                    for axis in 0..3 {
                        columns.add(axis, first[k], vectors[k][axis]);
                    }
                }
            }
        }
    }

    /// The vectors of the nodes of any group; for what is done once and not at every step.
    pub fn read_any(&self, columns: Columns<'_>, group: usize) -> [Point; N] {
        if group < self.runs.len() { self.read::<false>(columns, group) } else { self.read::<true>(columns, group) }
    }

    /// Adds a vector to each node of any group; for what is done once and not at every step.
    pub fn add_any(&self, columns: &mut ColumnsMut<'_>, group: usize, vectors: [Point; N]) {
        if group < self.runs.len() {
            self.add::<false>(columns, group, vectors);
        } else {
            self.add::<true>(columns, group, vectors);
        }
    }

    /// The core's nodes of the element in `lane` of `group`.
    pub fn nodes(&self, group: usize, lane: usize) -> [u32; N] {
        match self.loose.get(group.wrapping_sub(self.runs.len())) {
            Some(nodes) if group >= self.runs.len() => std::array::from_fn(|k| nodes[k][lane]),
            _ => self.runs[group].map(|first| first + lane as u32),
        }
    }
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
        let layout = Layout::new(5, 4, &[[1, 3], [0, 1]], &[[1, 3], [0, 1], [4, 0]]);
        let rows: Vec<[f64; 3]> = (0..5).map(|i| [f64::from(i), 0.5, -1.0]).collect();
        assert_eq!(layout.scatter_vectors(&layout.gather_vectors(&rows)), rows);
        let values = [3.0, 1.0, 4.0, 1.0, 5.0];
        assert_eq!(layout.scatter(&layout.gather(&values)), values);
        for node in 0..5 {
            assert_eq!(layout.outward(layout.inward([node])[0] as usize), node as usize);
        }
    }

    #[test]
    fn each_element_stands_in_exactly_one_lane() {
        // A ladder: rungs and rails, every third rung missing, and a brace that stands alone.
        let mut pairs: Vec<[u32; 2]> = (0..40).filter(|k| k % 3 != 0).map(|k| [k, k + 40]).collect();
        pairs.extend((0..39).map(|k| [k, k + 1]));
        pairs.push([3, 77]);
        let elements = Elements::new(&pairs, 80);
        assert_eq!(elements.share_in_runs(), 1.0 - 1.0 / pairs.len() as f64);
        let numbers = elements.pack(-1.0, |row| row as f64);
        let rows: Vec<f64> = (0..pairs.len()).map(|row| row as f64).collect();
        assert_eq!(elements.unpack(numbers.iter().copied()), rows);
        for (group, lanes) in numbers.iter().enumerate() {
            for lane in (0..LANES).filter(|&lane| lanes.0[lane] >= 0.0) {
                assert_eq!(elements.nodes(group, lane), pairs[lanes.0[lane] as usize]);
            }
        }
        // Adding one to both ends of every element counts each node's elements.
        let mut counts = Vectors::zeros(80);
        for (group, one) in elements.pack(0.0, |_| 1.0).into_iter().enumerate() {
            let one = [one, Lanes::ZERO, Lanes::ZERO];
            elements.add_any(&mut ColumnsMut::of(&mut counts), group, [one, one]);
        }
        for (node, count) in counts.column(0).iter().enumerate() {
            assert_eq!(*count, pairs.iter().flatten().filter(|&&end| end as usize == node).count() as f64);
        }
    }
}
