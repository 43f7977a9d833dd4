//! Elements in groups of eight, and how kernels read and add to their nodes.

use std::collections::VecDeque;
use std::ops::Range;

use crate::columns::{Columns, ColumnsMut};
use crate::lanes::{LANES, Lanes, Point, Vector};

/// Nodes that are looked at together where groups are kept apart.
const STRETCH: usize = 4;
/// Groups between two that add to the same nodes, and how many are looked at to find such an order.
const APART: usize = 4;
const POOL: usize = 64;
/// A lane that holds no element.
const NONE: u32 = u32::MAX;

/// Rows of `elements` in runs of two and more, each by first node, and the rows that stand alone.
pub(super) fn runs_of<const N: usize>(elements: &[[u32; N]]) -> (Vec<Vec<u32>>, Vec<u32>) {
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

/// Groups in an order in which none adds to nodes that one of the last `APART` added to, as far as the next `POOL` groups
/// allow: a processor that adds to a number just stored waits for it.
fn apart<const N: usize>(groups: Vec<([u32; N], [u32; LANES])>) -> Vec<([u32; N], [u32; LANES])> {
    let bound = groups.iter().flat_map(|(first, _)| first).max().map_or(0, |&node| node as usize + LANES);
    // When each stretch of four nodes was last added to.
    let mut touched = vec![0_usize; bound / STRETCH + 1];
    let stretches = |first: &[u32; N]| {
        first.map(|node| node as usize / STRETCH..(node as usize + LANES - 1) / STRETCH + 1).into_iter().flatten()
    };
    let mut pool = VecDeque::with_capacity(POOL);
    let mut waiting = groups.into_iter();
    let mut ordered = Vec::new();
    loop {
        pool.extend(waiting.by_ref().take(POOL - pool.len()));
        let now = ordered.len() + APART + 1;
        let age = |(first, _): &([u32; N], _)| now - stretches(first).map(|at| touched[at]).max().unwrap_or(0);
        let mut best = (0, 0);
        for (place, group) in pool.iter().enumerate() {
            let age = age(group).min(APART + 1);
            if age > best.1 {
                best = (place, age);
            }
            if age > APART {
                break;
            }
        }
        let Some(group) = pool.remove(best.0) else { return ordered };
        stretches(&group.0).for_each(|at| touched[at] = now);
        ordered.push(group);
    }
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
        let groups = apart(groups);
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

    /// How many elements, and how many lanes they take up, fillers included.
    pub fn lanes(&self) -> [usize; 2] {
        [self.count, LANES * self.group_count()]
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

    /// The groups that are loose, or those that are runs, for columns of `rows` rows. A sweep does the one and then the other,
    /// so that the compiler sees straight reads and writes in the loop over runs.
    #[inline(always)]
    pub fn pass<const LOOSE: bool>(&self, rows: usize) -> Pass<'_, N, LOOSE> {
        assert!(self.node_bound <= rows);
        let first = if LOOSE { self.runs.len() } else { 0 };
        let count = if LOOSE { self.loose.len() } else { self.runs.len() };
        Pass { runs: &self.runs, loose: &self.loose, first, count, rows }
    }

    /// The vectors of the nodes of any group; for what is done once and not at every step.
    pub fn read_any(&self, columns: Columns<'_>, group: usize) -> [Point; N] {
        match group.checked_sub(self.runs.len()) {
            None => self.pass::<false>(columns.rows()).read(columns, group),
            Some(loose) => self.pass::<true>(columns.rows()).read(columns, loose),
        }
    }

    /// Adds a vector to each node of any group; for what is done once and not at every step.
    pub fn add_any(&self, columns: &mut ColumnsMut<'_>, group: usize, vectors: [Point; N]) {
        match group.checked_sub(self.runs.len()) {
            None => self.pass::<false>(columns.rows()).add(columns, group, vectors),
            Some(loose) => self.pass::<true>(columns.rows()).add(columns, loose, vectors),
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

/// The runs of a set of elements, or its loose groups, as kernels see them: each group by its place among these.
#[derive(Debug, Clone, Copy)]
pub struct Pass<'a, const N: usize, const LOOSE: bool> {
    runs: &'a [[u32; N]],
    loose: &'a [[[u32; LANES]; N]],
    /// Groups before these in arrays of one entry per group.
    first: usize,
    count: usize,
    /// At least as many as the nodes that these groups name, fillers included.
    rows: usize,
}

impl<'a, const N: usize, const LOOSE: bool> Pass<'a, N, LOOSE> {
    /// How many groups.
    #[inline(always)]
    pub fn len(&self) -> usize {
        self.count
    }

    /// Whether there are none.
    #[inline(always)]
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// The place of a group among all groups.
    #[inline(always)]
    pub fn place(&self, group: usize) -> usize {
        self.first + group
    }

    /// The entries of these groups in an array of one entry per group.
    #[inline(always)]
    pub fn of<T>(&self, values: &'a [T]) -> &'a [T] {
        &values[self.first..][..self.count]
    }

    /// The groups, a batch at a time: for sweeps that work out all of one thing before the next.
    #[inline(always)]
    pub fn batches(&self) -> impl Iterator<Item = Range<usize>> + use<N, LOOSE> {
        let count = self.count;
        (0..count).step_by(BATCH).map(move |first| first..count.min(first + BATCH))
    }

    /// The vectors of the nodes of a group.
    #[inline(always)]
    #[allow(unsafe_code)]
    pub fn read<V: Vector>(&self, columns: Columns<'_>, group: usize) -> [Point<V>; N] {
        assert!(self.rows <= columns.rows());
        let mut points = [[V::zero(); 3]; N];
        // SAFETY: nodes of runs and loose groups, all their lanes included, are below `Elements::node_bound`, which `pass`
        // found to be at most `rows`, and so below the number of rows of the columns; `axis` is below three.
        unsafe {
            if LOOSE {
                let nodes = &self.loose[group];
                for k in 0..N {
                    for axis in 0..3 {
                        points[k][axis] = V::load(&columns.gather(axis, &nodes[k]));
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

    /// Adds a vector to each node of a group; those of fillers must be zero.
    #[inline(always)]
    pub fn add<V: Vector>(&self, columns: &mut ColumnsMut<'_>, group: usize, vectors: [Point<V>; N]) {
        self.add_rows(columns, group, vectors);
    }

    /// Adds a number to each node of a group; those of fillers must be zero.
    #[inline(always)]
    pub fn add_numbers<V: Vector>(&self, column: &mut ColumnsMut<'_, 1>, group: usize, numbers: [V; N]) {
        let mut rows = [[V::zero()]; N];
        for k in 0..N {
            rows[k][0] = numbers[k];
        }
        self.add_rows(column, group, rows);
    }

    #[inline(always)]
    #[allow(unsafe_code)]
    fn add_rows<V: Vector, const COUNT: usize>(
        &self,
        columns: &mut ColumnsMut<'_, COUNT>,
        group: usize,
        rows: [[V; COUNT]; N],
    ) {
        assert!(self.rows <= columns.rows());
        // SAFETY: as in `read`; `axis` is below COUNT.
        unsafe {
            if LOOSE {
                let nodes = &self.loose[group];
                for k in 0..N {
                    for axis in 0..COUNT {
                        columns.scatter(axis, &nodes[k], rows[k][axis].lanes());
                    }
                }
            } else {
                let first = self.runs[group];
                for k in 0..N {
                    for axis in 0..COUNT {
                        columns.add(axis, first[k], rows[k][axis]);
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::state::Vectors;

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
