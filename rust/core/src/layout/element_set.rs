//! Elements in batches of eight.

use std::ops::Range;

use super::batches::{Cover, PADDING, Window, without_conflicts};
use super::pass::Pass;
use crate::arrays::blocks::{rows_of, tiles};
use crate::arrays::columns::{Columns, ColumnsMut};
use crate::simd::dispatch::{CONTIGUOUS, GATHERED, SPLIT};
use crate::simd::lanes::{F64x8, HALF, LANES, Vec3};

/// Elements of N nodes each, in batches of eight. Node numbers are internal.
///
/// The batches of each kind are sorted by *tile*, the block of nodes with the lowest node of the batch. After the
/// batches of a tile, of all laws, no element acts on its nodes.
#[derive(Debug, Clone)]
pub struct ElementSet<const N: usize> {
    /// First nodes of each contiguous batch.
    contiguous: Vec<[u32; N]>,
    /// First nodes of the two windows of each split batch.
    split: Vec<[[u32; 2]; N]>,
    /// Nodes of each gathered batch, lane by lane; padding lanes repeat the last element.
    gathered: Vec<[[u32; LANES]; N]>,
    /// Number of batches of each kind up to the end of each tile.
    ends: Vec<[usize; 3]>,
    /// Bound above the nodes of each tile and the tiles before it, and above the nodes of their batches.
    reach: Vec<usize>,
    /// The external row of each lane of each batch, or `PADDING`.
    rows: Vec<[u32; LANES]>,
    count: usize,
    /// Bound above the nodes of all lanes, padding lanes included; `Reader` and `Adder` rely on it.
    node_bound: usize,
}

impl<const N: usize> ElementSet<N> {
    /// Arranges elements of a scene of `node_count` nodes in batches.
    pub fn new(elements: &[[u32; N]], node_count: usize) -> Self {
        let Cover { mut contiguous, mut split, mut gathered } = Cover::new(elements, node_count);
        let lowest = |&row: &u32| elements[row as usize].iter().copied().min().unwrap_or(0);
        contiguous.sort_by_key(|window| (window.lowest(), window.first));
        split.sort_by_key(|window| (window.lowest(), window.first));
        gathered.sort_by_key(|row| (lowest(row), *row));
        let mut made = Self {
            contiguous: Vec::with_capacity(contiguous.len()),
            split: Vec::new(),
            gathered: Vec::new(),
            ends: Vec::new(),
            reach: Vec::new(),
            rows: Vec::with_capacity(contiguous.len()),
            count: elements.len(),
            node_bound: 0,
        };
        let (mut split_rows, mut gathered_rows) = (Vec::new(), Vec::new());
        let (mut contiguous, mut split, mut gathered) = (&contiguous[..], &split[..], &gathered[..]);
        for tile in tiles(node_count) {
            let end = rows_of(tile, node_count).end as u32;
            let windows = take_while(&mut contiguous, |window| window.lowest() < end).to_vec();
            for Window { first, rows } in without_conflicts(windows, LANES as u32, |window| window.first) {
                made.contiguous.push(first);
                made.rows.push(rows);
            }
            let windows = pairs(take_while(&mut split, |window| window.lowest() < end)).collect();
            for (nodes, rows) in without_conflicts(windows, HALF as u32, |&(nodes, _)| nodes.into_iter().flatten()) {
                made.split.push(nodes);
                split_rows.push(rows);
            }
            for rows in take_while(&mut gathered, |row| lowest(row) < end).chunks(LANES) {
                let of_lane = |lane: usize| elements[rows[lane.min(rows.len() - 1)] as usize];
                made.gathered.push(std::array::from_fn(|k| std::array::from_fn(|lane| of_lane(lane)[k])));
                gathered_rows.push(std::array::from_fn(|lane| rows.get(lane).copied().unwrap_or(PADDING)));
            }
            let starts = made.ends.last().copied().unwrap_or_default();
            let ends = made.contiguous[starts[0]..].iter().flatten().map(|&first| first as usize + LANES);
            let split_ends = made.split[starts[1]..].iter().flatten().flatten().map(|&first| first as usize + HALF);
            let gathered_ends = made.gathered[starts[2]..].iter().flatten().flatten().map(|&node| node as usize + 1);
            let bound = ends.chain(split_ends).chain(gathered_ends).max().unwrap_or(0);
            made.node_bound = made.node_bound.max(bound);
            made.reach.push(made.node_bound.max(end as usize));
            made.ends.push([made.contiguous.len(), made.split.len(), made.gathered.len()]);
        }
        made.rows.extend(split_rows);
        made.rows.extend(gathered_rows);
        made
    }

    /// Batch, lane and nodes of every element; not for use in every step.
    pub fn each(&self) -> impl Iterator<Item = (usize, usize, [u32; N])> + '_ {
        let lanes =
            self.rows.iter().enumerate().flat_map(|(batch, rows)| {
                (0..LANES).filter(|&lane| rows[lane] != PADDING).map(move |lane| (batch, lane))
            });
        lanes.map(|(batch, lane)| (batch, lane, self.nodes(batch, lane)))
    }

    /// Number of batches of eight.
    #[inline(always)]
    pub fn batch_count(&self) -> usize {
        self.rows.len()
    }

    /// The nodes that the batches of a tile reach first: kernels of the tile need data of these and earlier nodes.
    pub fn new_rows(&self, tile: usize) -> Range<usize> {
        let before = if tile == 0 { 0 } else { self.reach[tile - 1] };
        before..self.reach[tile]
    }

    /// Bound above the nodes of the batches of a tile and of the tiles before it, and above the nodes of these tiles.
    pub fn reach(&self, tile: usize) -> usize {
        self.reach[tile]
    }

    /// Number of elements, and number of lanes including padding lanes.
    pub fn lanes(&self) -> [usize; 2] {
        [self.count, LANES * self.batch_count()]
    }

    /// Share of the elements in contiguous or split batches.
    pub fn contiguous_share(&self) -> f64 {
        let gathered = self.rows[self.contiguous.len() + self.split.len()..]
            .iter()
            .flatten()
            .filter(|&&row| row != PADDING)
            .count();
        1.0 - gathered as f64 / self.count.max(1) as f64
    }

    /// One number per element, from external order to lanes, with `padding` in padding lanes. There the factor of an
    /// element's force must be zero, and the other factors finite.
    pub fn pack(&self, padding: f64, values: impl Fn(usize) -> f64) -> Vec<F64x8> {
        let value = |row: u32| if row == PADDING { padding } else { values(row as usize) };
        self.rows.iter().map(|rows| F64x8(rows.map(value))).collect()
    }

    /// One number per element, from lanes to external order.
    pub fn unpack(&self, values: impl Iterator<Item = F64x8>) -> Vec<f64> {
        let mut numbers = vec![0.0; self.count];
        for (&row, value) in self.rows.iter().flatten().zip(values.flat_map(|lanes| lanes.0)) {
            if row != PADDING {
                numbers[row as usize] = value;
            }
        }
        numbers
    }

    /// Some numbers per element, from lanes to external order.
    pub fn unpack_rows<const K: usize>(&self, values: impl Iterator<Item = [F64x8; K]>) -> Vec<[f64; K]> {
        let mut unpacked = vec![[0.0; K]; self.count];
        for (rows, values) in self.rows.iter().zip(values) {
            for (lane, &row) in rows.iter().enumerate().filter(|(_, row)| **row != PADDING) {
                unpacked[row as usize] = values.map(|lanes| lanes.0[lane]);
            }
        }
        unpacked
    }

    /// The batches of one kind in one tile, for columns of `rows` rows. A sweep takes one kind after the other, so that
    /// the loop over contiguous batches has contiguous loads and stores only.
    #[inline(always)]
    pub fn pass<const KIND: usize>(&self, tile: usize, rows: usize) -> Pass<'_, N, KIND> {
        let start = if tile == 0 { 0 } else { self.ends[tile - 1][KIND] };
        let batches = start..self.ends[tile][KIND];
        let before = [0, self.contiguous.len(), self.contiguous.len() + self.split.len()][KIND];
        Pass::new(
            if KIND == CONTIGUOUS { &self.contiguous[batches.clone()] } else { &[] },
            if KIND == SPLIT { &self.split[batches.clone()] } else { &[] },
            if KIND == GATHERED { &self.gathered[batches] } else { &[] },
            before + start,
            [self.node_bound, rows],
        )
    }

    /// The vectors of the nodes of any batch; not for use in every step.
    pub fn read_any(&self, columns: Columns<'_>, batch: usize) -> [Vec3; N] {
        let nodes = self.nodes_of(batch);
        std::array::from_fn(|k| std::array::from_fn(|axis| columns.gather_checked(axis, &nodes[k])))
    }

    /// Adds a vector to each node of any batch; not for use in every step.
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

    /// The nodes of the element in `lane` of `batch`.
    pub fn nodes(&self, batch: usize, lane: usize) -> [u32; N] {
        self.nodes_of(batch).map(|nodes| nodes[lane])
    }
}

/// Removes the leading items that fulfil a condition; no later item fulfils it.
fn take_while<'a, T>(items: &mut &'a [T], is_in: impl Fn(&T) -> bool) -> &'a [T] {
    let (taken, rest) = items.split_at(items.partition_point(is_in));
    *items = rest;
    taken
}

/// Pairs of windows from distant places: neighbours often share nodes, and their additions would conflict.
fn pairs<const N: usize>(split: &[Window<N, HALF>]) -> impl Iterator<Item = ([[u32; 2]; N], [u32; LANES])> {
    let (low, high) = split.split_at(split.len().div_ceil(2));
    low.iter().enumerate().map(move |(place, low)| {
        // A last window without partner is repeated in padding lanes.
        let (other, has_other) = high.get(place).map_or((low, false), |high| (high, true));
        let nodes = std::array::from_fn(|k| [low.first[k], other.first[k]]);
        let mut rows = [PADDING; LANES];
        rows[..HALF].copy_from_slice(&low.rows);
        if has_other {
            rows[HALF..].copy_from_slice(&other.rows);
        }
        (nodes, rows)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arrays::state::NodeVectors;

    #[test]
    fn each_element_has_exactly_one_lane() {
        // A ladder without every third step, and a brace of a shape of its own.
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
        // One, added to both ends of every element, counts the elements of each node.
        let mut counts = NodeVectors::zeros(80);
        for (batch, one) in elements.pack(0.0, |_| 1.0).into_iter().enumerate() {
            let one = [one, F64x8::ZERO, F64x8::ZERO];
            elements.add_any(&mut ColumnsMut::of(&mut counts), batch, [one, one]);
        }
        for (node, count) in counts.column(0).iter().enumerate() {
            assert_eq!(*count, pairs.iter().flatten().filter(|&&end| end as usize == node).count() as f64);
        }
    }

    fn on_columns(rows: usize, access: impl FnOnce(Pass<'_, 2, GATHERED>, &mut NodeVectors)) {
        let elements = ElementSet::new(&[[0, 9]], 10);
        access(elements.pass(0, 10), &mut NodeVectors::zeros(rows));
    }

    #[test]
    #[should_panic(expected = "assertion failed")]
    fn a_reader_refuses_columns_that_are_too_short() {
        on_columns(9, |pass, vectors| _ = pass.reader(Columns::of(vectors)));
    }

    #[test]
    #[should_panic(expected = "assertion failed")]
    fn an_adder_refuses_columns_that_are_too_short() {
        on_columns(9, |pass, vectors| _ = pass.adder(&mut ColumnsMut::of(vectors)));
    }

    #[test]
    #[should_panic(expected = "assertion failed")]
    fn a_pass_refuses_fewer_rows_than_it_has_nodes() {
        ElementSet::new(&[[0, 9]], 10).pass::<GATHERED>(0, 9);
    }

    #[test]
    fn columns_as_long_as_the_nodes_are_accepted() {
        on_columns(10, |pass, vectors| {
            assert_eq!(pass.len(), 1);
            pass.reader(Columns::of(vectors)).read::<F64x8>(0);
            pass.adder(&mut ColumnsMut::of(vectors)).add(0, [[F64x8::ZERO; 3]; 2]);
        });
    }
}
