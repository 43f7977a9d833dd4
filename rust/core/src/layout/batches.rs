//! The arrangement of elements in batches of eight lanes.
//!
//! A batch is *contiguous* (one window of eight lanes), *split* (two windows of four) or *gathered* (eight single
//! elements). Lane k of a window has the first nodes of the window plus k. Its elements have one shape, that is the
//! same differences between their nodes; a lane without an element is a padding lane. The elements of a shape, sorted
//! by their first nodes, are covered by windows and single elements at the least total cost, by dynamic programming
//! from the last element.

use std::collections::VecDeque;

use super::radix::order_by;
use crate::simd::lanes::{HALF, LANES};

/// Cost of half a split batch and of a gathered element, relative to a contiguous batch.
const HALF_COST: f64 = 0.55;
const GATHERED_COST: f64 = 0.5;
/// Additional cost of a contiguous batch for each node whose eight numbers lie in two cache lines.
const TWO_LINES_COST: f64 = 0.1;
/// Nodes of a granule; batches conflict where they write to the same granule.
const GRANULE: u32 = 4;
/// Batches between two that conflict, and number of candidates for the next batch.
const DISTANCE: usize = 4;
const CANDIDATES: usize = 64;
/// The row of a padding lane.
pub(super) const PADDING: u32 = u32::MAX;

/// The first nodes of `WIDTH` contiguous lanes, and the row of the element in each lane.
#[derive(Debug, Clone, Copy)]
pub(super) struct Window<const N: usize, const WIDTH: usize> {
    pub(super) first: [u32; N],
    pub(super) rows: [u32; WIDTH],
}

impl<const N: usize, const WIDTH: usize> Window<N, WIDTH> {
    /// The window, shifted where it would pass the last of `node_count` nodes; `None` where its elements exclude this.
    fn within(self, node_count: usize) -> Option<Self> {
        let last = self.first.iter().max().map_or(0, |&node| node as usize + WIDTH);
        let shift = last.saturating_sub(node_count);
        if shift >= WIDTH
            || self.rows[WIDTH - shift..].iter().any(|&row| row != PADDING)
            || self.first.iter().any(|&node| (node as usize) < shift)
        {
            return None;
        }
        let mut rows = [PADDING; WIDTH];
        rows[shift..].copy_from_slice(&self.rows[..WIDTH - shift]);
        Some(Self { first: self.first.map(|node| node - shift as u32), rows })
    }

    /// The lowest node.
    pub(super) fn lowest(&self) -> u32 {
        self.first.iter().copied().min().unwrap_or(0)
    }
}

/// Elements by kind of batch: windows of eight and of four lanes, and rows of single elements.
#[derive(Debug, Default)]
pub(super) struct Cover<const N: usize> {
    pub(super) contiguous: Vec<Window<N, LANES>>,
    pub(super) split: Vec<Window<N, HALF>>,
    pub(super) gathered: Vec<u32>,
}

impl<const N: usize> Cover<N> {
    /// The cover of elements on `node_count` nodes.
    pub(super) fn new(elements: &[[u32; N]], node_count: usize) -> Self {
        let shape = |nodes: &[u32; N]| nodes.map(|node| node.wrapping_sub(nodes[0]));
        // By shapes, and alike ones by their first nodes.
        let word = |k: usize, row: usize| match k {
            0 => elements[row][0],
            k => elements[row][N - k].wrapping_sub(elements[row][0]),
        };
        let rows = order_by(elements.len(), N, word);
        let mut cover = Self { contiguous: Vec::new(), split: Vec::new(), gathered: Vec::new() };
        for alike in rows.chunk_by(|&a, &b| shape(&elements[a as usize]) == shape(&elements[b as usize])) {
            cover.add(elements, alike, node_count);
        }
        cover
    }

    /// Covers elements of one shape, sorted by their first nodes, at the least cost.
    fn add(&mut self, elements: &[[u32; N]], alike: &[u32], node_count: usize) {
        let first = |place: usize| elements[alike[place] as usize][0];
        // The end of a window that begins at `place`. A duplicate element ends it.
        let end_of = |place: usize, width: usize| {
            let mut end = place + 1;
            while end < alike.len() && first(end) > first(end - 1) && ((first(end) - first(place)) as usize) < width {
                end += 1;
            }
            end
        };
        let mut costs = vec![0.0_f64; alike.len() + 1];
        let mut widths = vec![1_u8; alike.len()];
        for place in (0..alike.len()).rev() {
            costs[place] = GATHERED_COST + costs[place + 1];
            let in_two_lines = elements[alike[place] as usize].iter().filter(|&&node| node % LANES as u32 != 0).count();
            for (width, cost) in [(LANES, 1.0 + TWO_LINES_COST * in_two_lines as f64), (HALF, HALF_COST)] {
                let cost = cost + costs[end_of(place, width)];
                if cost < costs[place] {
                    (costs[place], widths[place]) = (cost, width as u8);
                }
            }
        }
        let mut place = 0;
        while place < alike.len() {
            let (width, start) = (widths[place] as usize, place);
            place = end_of(start, width);
            let covered = &alike[start..place];
            let is_covered = match width {
                LANES => window(elements, covered).within(node_count).map(|window| self.contiguous.push(window)),
                HALF => window(elements, covered).within(node_count).map(|window| self.split.push(window)),
                _ => None,
            };
            if is_covered.is_none() {
                self.gathered.extend(covered);
            }
        }
    }

    /// Estimated cost of a pass over all elements, relative to a contiguous batch, without that of cache lines.
    pub(super) fn cost(&self) -> f64 {
        self.contiguous.len() as f64 + HALF_COST * self.split.len() as f64 + GATHERED_COST * self.gathered.len() as f64
    }
}

/// The window with these rows.
fn window<const N: usize, const WIDTH: usize>(elements: &[[u32; N]], covered: &[u32]) -> Window<N, WIDTH> {
    let first = elements[covered[0] as usize];
    let mut rows = [PADDING; WIDTH];
    for &row in covered {
        rows[(elements[row as usize][0] - first[0]) as usize] = row;
    }
    Window { first, rows }
}

/// Reorders batches so that none writes to a granule of the last `DISTANCE` batches, as far as the next `CANDIDATES`
/// allow: a load of a number just stored stalls the processor. `starts` gives the first nodes of windows of `width`.
pub(super) fn without_conflicts<T, I: IntoIterator<Item = u32>>(
    batches: Vec<T>,
    width: u32,
    starts: impl Fn(&T) -> I,
) -> Vec<T> {
    let granules =
        |batch: &T| starts(batch).into_iter().flat_map(|node| node / GRANULE..(node + width - 1) / GRANULE + 1);
    let (mut low, mut high) = (u32::MAX, 0);
    for granule in batches.iter().flat_map(granules) {
        (low, high) = (low.min(granule), high.max(granule + 1));
    }
    // The place of the last batch that writes to each granule, offset by DISTANCE + 1.
    let mut written = vec![0_usize; high.saturating_sub(low) as usize];
    let mut candidates = VecDeque::with_capacity(CANDIDATES);
    let mut rest = batches.into_iter();
    let mut ordered = Vec::with_capacity(rest.len());
    loop {
        candidates.extend(rest.by_ref().take(CANDIDATES - candidates.len()));
        let now = ordered.len() + DISTANCE + 1;
        let age = |batch: &T| now - granules(batch).map(|at| written[(at - low) as usize]).max().unwrap_or(0);
        let mut best = (0, 0);
        for (place, batch) in candidates.iter().enumerate() {
            let age = age(batch).min(DISTANCE + 1);
            if age > best.1 {
                best = (place, age);
            }
            if age > DISTANCE {
                break;
            }
        }
        let Some(batch) = candidates.remove(best.0) else { return ordered };
        granules(&batch).for_each(|at| written[(at - low) as usize] = now);
        ordered.push(batch);
    }
}
