//! ElementSet in batches of eight, and how kernels read and add to their nodes.

use std::ops::Range;

use super::batches::{Cover, NONE, Window, apart};
use crate::arrays::blocks::{rows_of, tiles};
use crate::arrays::columns::{Columns, ColumnsMut};
use crate::simd::dispatch::{CONTIGUOUS, GATHERED, SPLIT};
use crate::simd::lanes::{F64x8, HALF, LANES, SimdF64, Vec3};

/// Groups in a chunk.
pub const CHUNK: usize = 32;

/// ElementSet of N nodes each, eight to a batch. Node numbers are the core's.
///
/// Groups of each kind stand by *tile*: the stretch of nodes that holds the lowest node of the batch. When all laws have
/// gone over the batches of a tile, nothing more acts on its nodes.
#[derive(Debug, Clone)]
pub struct ElementSet<const N: usize> {
    /// First nodes of each contiguous.
    contiguous: Vec<[u32; N]>,
    /// First nodes of the two split of each batch.
    split: Vec<[[u32; 2]; N]>,
    /// Nodes of each gathered batch, lane by lane; where elements contiguous out the last one is repeated.
    gathered: Vec<[[u32; LANES]; N]>,
    /// How many batches of each kind there are up to the end of each tile.
    ends: Vec<[usize; 3]>,
    /// Above every node that batches of a tile and of those before it name, and the nodes of these tiles.
    reach: Vec<usize>,
    /// The caller's row of each lane of each batch; `NONE` for a filler.
    origin: Vec<[u32; LANES]>,
    count: usize,
    /// Above every node of every lane, fillers included: what `read` and `add` rely on.
    node_bound: usize,
}

impl<const N: usize> ElementSet<N> {
    /// Arranges elements of a scene with `node_count` nodes.
    pub fn new(elements: &[[u32; N]], node_count: usize) -> Self {
        let Cover { mut contiguous, mut split, mut gathered } = Cover::new(elements, node_count);
        let lowest = |&row: &u32| elements[row as usize].iter().copied().min().unwrap_or(0);
        contiguous.sort_by_key(|contiguous| (contiguous.lowest(), contiguous.first));
        split.sort_by_key(|half| (half.lowest(), half.first));
        gathered.sort_by_key(|row| (lowest(row), *row));
        let mut made = Self {
            contiguous: Vec::with_capacity(contiguous.len()),
            split: Vec::new(),
            gathered: Vec::new(),
            ends: Vec::new(),
            reach: Vec::new(),
            origin: Vec::with_capacity(contiguous.len()),
            count: elements.len(),
            node_bound: 0,
        };
        let (mut of_halves, mut of_loose) = (Vec::new(), Vec::new());
        let (mut contiguous, mut split, mut gathered) = (&contiguous[..], &split[..], &gathered[..]);
        for tile in tiles(node_count) {
            let end = rows_of(tile, node_count).end as u32;
            let here = take_while(&mut contiguous, |contiguous| contiguous.lowest() < end).to_vec();
            for Window { first, rows } in apart(here, LANES as u32, |contiguous| contiguous.first) {
                made.contiguous.push(first);
                made.origin.push(rows);
            }
            let here = pairs(take_while(&mut split, |half| half.lowest() < end)).collect();
            for (nodes, rows) in apart(here, HALF as u32, |&(nodes, _)| nodes.into_iter().flatten()) {
                made.split.push(nodes);
                of_halves.push(rows);
            }
            for rows in take_while(&mut gathered, |row| lowest(row) < end).chunks(LANES) {
                let of_lane = |lane: usize| elements[rows[lane.min(rows.len() - 1)] as usize];
                made.gathered.push(std::array::from_fn(|k| std::array::from_fn(|lane| of_lane(lane)[k])));
                of_loose.push(std::array::from_fn(|lane| rows.get(lane).copied().unwrap_or(NONE)));
            }
            let [of_runs, of_pairs, alone] = made.ends.last().copied().unwrap_or_default();
            let ends = made.contiguous[of_runs..].iter().flatten().map(|&first| first as usize + LANES);
            let half_ends = made.split[of_pairs..].iter().flatten().flatten().map(|&first| first as usize + HALF);
            let places = made.gathered[alone..].iter().flatten().flatten().map(|&node| node as usize + 1);
            let bound = ends.chain(half_ends).chain(places).max().unwrap_or(0);
            made.node_bound = made.node_bound.max(bound);
            made.reach.push(made.node_bound.max(end as usize));
            made.ends.push([made.contiguous.len(), made.split.len(), made.gathered.len()]);
        }
        made.origin.extend(of_halves);
        made.origin.extend(of_loose);
        made
    }

    /// Every element's batch, lane and nodes; for what is done once and not at every step.
    pub fn each(&self) -> impl Iterator<Item = (usize, usize, [u32; N])> + '_ {
        let lanes = self
            .origin
            .iter()
            .enumerate()
            .flat_map(|(batch, rows)| (0..LANES).filter(|&lane| rows[lane] != NONE).map(move |lane| (batch, lane)));
        lanes.map(|(batch, lane)| (batch, lane, self.nodes(batch, lane)))
    }

    /// Number of batches of eight.
    #[inline(always)]
    pub fn batch_count(&self) -> usize {
        self.origin.len()
    }

    /// The nodes that batches of a tile reach and those of tiles before it do not: what must be ready before the tile.
    pub fn new_rows(&self, tile: usize) -> Range<usize> {
        let before = if tile == 0 { 0 } else { self.reach[tile - 1] };
        before..self.reach[tile]
    }

    /// How many elements, and how many lanes they take up, fillers included.
    pub fn lanes(&self) -> [usize; 2] {
        [self.count, LANES * self.batch_count()]
    }

    /// Share of the elements that are in contiguous of eight or four.
    pub fn contiguous_share(&self) -> f64 {
        let alone = self.origin[self.contiguous.len() + self.split.len()..]
            .iter()
            .flatten()
            .filter(|&&row| row != NONE)
            .count();
        1.0 - alone as f64 / self.count.max(1) as f64
    }

    /// One number per element, from the caller's order to lanes, and `filler` in lanes without one. The factor that makes
    /// an element's force must be zero there, and what it is multiplied with finite.
    pub fn pack(&self, filler: f64, values: impl Fn(usize) -> f64) -> Vec<F64x8> {
        let value = |row: u32| if row == NONE { filler } else { values(row as usize) };
        self.origin.iter().map(|rows| F64x8(rows.map(value))).collect()
    }

    /// One number per element, from lanes to the caller's order.
    pub fn unpack(&self, values: impl Iterator<Item = F64x8>) -> Vec<f64> {
        let mut numbers = vec![0.0; self.count];
        for (&row, value) in self.origin.iter().flatten().zip(values.flat_map(|lanes| lanes.0)) {
            if row != NONE {
                numbers[row as usize] = value;
            }
        }
        numbers
    }

    /// The batches of one kind in one tile, for columns of `rows` rows. A sweep goes over one kind after the other, so that the
    /// compiler sees straight reads and writes in the loop over contiguous.
    #[inline(always)]
    pub fn pass<const KIND: usize>(&self, tile: usize, rows: usize) -> Pass<'_, N, KIND> {
        assert!(self.node_bound <= rows);
        let start = if tile == 0 { 0 } else { self.ends[tile - 1][KIND] };
        let batches = start..self.ends[tile][KIND];
        let before = [0, self.contiguous.len(), self.contiguous.len() + self.split.len()][KIND];
        let (first, count) = (before + start, batches.len());
        Pass {
            contiguous: if KIND == CONTIGUOUS { &self.contiguous[batches.clone()] } else { &[] },
            split: if KIND == SPLIT { &self.split[batches.clone()] } else { &[] },
            gathered: if KIND == GATHERED { &self.gathered[batches] } else { &[] },
            first,
            count,
            rows,
        }
    }

    /// The vectors of the nodes of any batch; for what is done once and not at every step.
    pub fn read_any(&self, columns: Columns<'_>, batch: usize) -> [Vec3; N] {
        let nodes = self.nodes_of(batch);
        std::array::from_fn(|k| std::array::from_fn(|axis| columns.gather_checked(axis, &nodes[k])))
    }

    /// Adds a vector to each node of any batch; for what is done once and not at every step.
    pub fn add_any(&self, columns: &mut ColumnsMut<'_>, batch: usize, vectors: [Vec3; N]) {
        for (nodes, vector) in self.nodes_of(batch).iter().zip(vectors) {
            (0..3).for_each(|axis| columns.scatter_checked(axis, nodes, vector[axis]));
        }
    }

    /// The nodes of a batch, lane by lane.
    fn nodes_of(&self, batch: usize) -> [[u32; LANES]; N] {
        if let Some(first) = self.contiguous.get(batch) {
            return first.map(|first| std::array::from_fn(|lane| first + lane as u32));
        }
        let batch = batch - self.contiguous.len();
        if let Some(first) = self.split.get(batch) {
            return first.map(|first| std::array::from_fn(|lane| first[lane / HALF] + (lane % HALF) as u32));
        }
        self.gathered[batch - self.split.len()]
    }

    /// The core's nodes of the element in `lane` of `batch`.
    pub fn nodes(&self, batch: usize, lane: usize) -> [u32; N] {
        self.nodes_of(batch).map(|nodes| nodes[lane])
    }
}

/// Takes from the front of `items` what fulfils a condition that holds for no item behind.
fn take_while<'a, T>(items: &mut &'a [T], is_in: impl Fn(&T) -> bool) -> &'a [T] {
    let (taken, rest) = items.split_at(items.partition_point(is_in));
    *items = rest;
    taken
}

/// Halves two and two, from distant places: neighbours often share nodes, and would wait for each other.
fn pairs<const N: usize>(split: &[Window<N, HALF>]) -> impl Iterator<Item = ([[u32; 2]; N], [u32; LANES])> {
    let (low, high) = split.split_at(split.len().div_ceil(2));
    low.iter().enumerate().map(move |(place, low)| {
        // The last one may have no partner: then it is repeated as a filler.
        let (other, has_other) = high.get(place).map_or((low, false), |high| (high, true));
        let nodes = std::array::from_fn(|k| [low.first[k], other.first[k]]);
        let mut rows = [NONE; LANES];
        rows[..HALF].copy_from_slice(&low.rows);
        if has_other {
            rows[HALF..].copy_from_slice(&other.rows);
        }
        (nodes, rows)
    })
}

/// The batches of one kind in one tile, as kernels see them: each batch by its place among these.
#[derive(Debug, Clone, Copy)]
pub struct Pass<'a, const N: usize, const KIND: usize> {
    contiguous: &'a [[u32; N]],
    split: &'a [[[u32; 2]; N]],
    gathered: &'a [[[u32; LANES]; N]],
    /// Groups before these in arrays of one entry per batch.
    first: usize,
    count: usize,
    /// At least as many as the nodes that these batches name, fillers included.
    rows: usize,
}

impl<'a, const N: usize, const KIND: usize> Pass<'a, N, KIND> {
    /// How many batches.
    #[inline(always)]
    pub fn len(&self) -> usize {
        self.count
    }

    /// Whether there are none.
    #[inline(always)]
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// The place of a batch among all batches.
    #[inline(always)]
    pub fn place(&self, batch: usize) -> usize {
        self.first + batch
    }

    /// The entries of these batches in an array of one entry per batch.
    #[inline(always)]
    pub fn of<T>(&self, values: &'a [T]) -> &'a [T] {
        &values[self.first..][..self.count]
    }

    /// The batches, a chunk at a time: for sweeps that work out all of one thing before the next.
    #[inline(always)]
    pub fn chunks_of_batches(&self) -> impl Iterator<Item = Range<usize>> + use<N, KIND> {
        let count = self.count;
        (0..count).step_by(CHUNK).map(move |first| first..count.min(first + CHUNK))
    }

    /// What the columns hold for the nodes of a batch: their vectors, where there are three.
    #[inline(always)]
    #[allow(unsafe_code)]
    pub fn read<V: SimdF64, const COUNT: usize>(&self, columns: Columns<'_, COUNT>, batch: usize) -> [[V; COUNT]; N] {
        assert!(self.rows <= columns.rows());
        let mut points = [[V::zero(); COUNT]; N];
        // SAFETY: nodes of all batches, all their lanes included, are below `ElementSet::node_bound`, which `pass`
        // found to be at most `rows`, and so below the number of rows of the columns; `axis` is below COUNT.
        unsafe {
            if KIND == CONTIGUOUS {
                let first = self.contiguous[batch];
                for k in 0..N {
                    for axis in 0..COUNT {
                        points[k][axis] = columns.read(axis, first[k]);
                    }
                }
            } else if KIND == SPLIT {
                let first = self.split[batch];
                for k in 0..N {
                    for axis in 0..COUNT {
                        points[k][axis] = columns.read_split(axis, first[k]);
                    }
                }
            } else {
                let nodes = &self.gathered[batch];
                for k in 0..N {
                    for axis in 0..COUNT {
                        points[k][axis] = V::load(&columns.gather(axis, &nodes[k]));
                    }
                }
            }
        }
        points
    }

    /// Adds a vector to each node of a batch; those of fillers must be zero.
    #[inline(always)]
    pub fn add<V: SimdF64>(&self, columns: &mut ColumnsMut<'_>, batch: usize, vectors: [Vec3<V>; N]) {
        self.add_rows(columns, batch, vectors);
    }

    /// Adds a number to each node of a batch; those of fillers must be zero.
    #[inline(always)]
    pub fn add_numbers<V: SimdF64>(&self, column: &mut ColumnsMut<'_, 1>, batch: usize, numbers: [V; N]) {
        let mut rows = [[V::zero()]; N];
        for k in 0..N {
            rows[k][0] = numbers[k];
        }
        self.add_rows(column, batch, rows);
    }

    #[inline(always)]
    #[allow(unsafe_code)]
    fn add_rows<V: SimdF64, const COUNT: usize>(
        &self,
        columns: &mut ColumnsMut<'_, COUNT>,
        batch: usize,
        rows: [[V; COUNT]; N],
    ) {
        assert!(self.rows <= columns.rows());
        // SAFETY: as in `read`; `axis` is below COUNT.
        unsafe {
            if KIND == CONTIGUOUS {
                let first = self.contiguous[batch];
                for k in 0..N {
                    for axis in 0..COUNT {
                        columns.add(axis, first[k], rows[k][axis]);
                    }
                }
            } else if KIND == SPLIT {
                let first = self.split[batch];
                for k in 0..N {
                    for axis in 0..COUNT {
                        columns.add_split(axis, first[k], rows[k][axis]);
                    }
                }
            } else {
                let nodes = &self.gathered[batch];
                for k in 0..N {
                    for axis in 0..COUNT {
                        columns.scatter(axis, &nodes[k], rows[k][axis].lanes());
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arrays::state::NodeVectors;

    #[test]
    fn each_element_stands_in_exactly_one_lane() {
        // A ladder: rungs and rails, every third rung missing, and a brace that stands alone.
        let mut pairs: Vec<[u32; 2]> = (0..40).filter(|k| k % 3 != 0).map(|k| [k, k + 40]).collect();
        pairs.extend((0..39).map(|k| [k, k + 1]));
        pairs.push([3, 77]);
        let elements = ElementSet::new(&pairs, 80);
        assert_eq!(elements.contiguous_share(), 1.0 - 1.0 / pairs.len() as f64);
        let numbers = elements.pack(-1.0, |row| row as f64);
        let rows: Vec<f64> = (0..pairs.len()).map(|row| row as f64).collect();
        assert_eq!(elements.unpack(numbers.iter().copied()), rows);
        for (batch, lanes) in numbers.iter().enumerate() {
            for lane in (0..LANES).filter(|&lane| lanes.0[lane] >= 0.0) {
                assert_eq!(elements.nodes(batch, lane), pairs[lanes.0[lane] as usize]);
            }
        }
        // Adding one to both ends of every element counts each node's elements.
        let mut counts = NodeVectors::zeros(80);
        for (batch, one) in elements.pack(0.0, |_| 1.0).into_iter().enumerate() {
            let one = [one, F64x8::ZERO, F64x8::ZERO];
            elements.add_any(&mut ColumnsMut::of(&mut counts), batch, [one, one]);
        }
        for (node, count) in counts.column(0).iter().enumerate() {
            assert_eq!(*count, pairs.iter().flatten().filter(|&&end| end as usize == node).count() as f64);
        }
    }
}
