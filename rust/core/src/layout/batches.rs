//! How elements are put into batches of eight lanes.
//!
//! A batch is a *contiguous* of eight, two *split* of four, or eight *gathered* elements. ElementSet of one shape (the same
//! differences between their nodes) follow each other by their first nodes; a contiguous or a half begins at one of them and
//! takes what there is of the next eight or four, so that lanes may stay empty. Of all ways to cover the elements of a shape
//! so, from the lowest on, the cheapest is taken.

use std::collections::VecDeque;

use crate::simd::lanes::{HALF, LANES};

/// What a half and a gathered element cost, in batches of a contiguous.
const HALF_COST: f64 = 0.55;
const GATHERED_COST: f64 = 0.5;
/// What a contiguous costs beside for each of its nodes whose eight numbers lie in two cache lines.
const SPLIT_COST: f64 = 0.1;
/// Nodes that are looked at together where batches are kept apart.
const NEAR: u32 = 4;
/// Groups between two that add to the same nodes, and how many are looked at to find such an order.
const APART: usize = 4;
const POOL: usize = 64;
/// A lane that holds no element.
pub(super) const NONE: u32 = u32::MAX;

/// The first nodes of `WIDTH` lanes that read straight on, and the row of the element in each lane.
#[derive(Debug, Clone, Copy)]
pub(super) struct Window<const N: usize, const WIDTH: usize> {
    pub(super) first: [u32; N],
    pub(super) rows: [u32; WIDTH],
}

impl<const N: usize, const WIDTH: usize> Window<N, WIDTH> {
    /// The window moved back from the last of `node_count` nodes, so that every lane of every node exists; or `None`.
    fn within(self, node_count: usize) -> Option<Self> {
        let last = self.first.iter().max().map_or(0, |&node| node as usize + WIDTH);
        let back = last.saturating_sub(node_count);
        if back >= WIDTH
            || self.rows[WIDTH - back..].iter().any(|&row| row != NONE)
            || self.first.iter().any(|&node| (node as usize) < back)
        {
            return None;
        }
        let mut rows = [NONE; WIDTH];
        rows[back..].copy_from_slice(&self.rows[..WIDTH - back]);
        Some(Self { first: self.first.map(|node| node - back as u32), rows })
    }

    /// The lowest node.
    pub(super) fn lowest(&self) -> u32 {
        self.first.iter().copied().min().unwrap_or(0)
    }
}

/// ElementSet in contiguous, in split, and alone.
#[derive(Debug, Default)]
pub(super) struct Cover<const N: usize> {
    pub(super) contiguous: Vec<Window<N, LANES>>,
    pub(super) split: Vec<Window<N, HALF>>,
    pub(super) gathered: Vec<u32>,
}

impl<const N: usize> Cover<N> {
    /// Of elements that have at most `node_count` nodes.
    pub(super) fn new(elements: &[[u32; N]], node_count: usize) -> Self {
        let shape = |row: u32| {
            let nodes = elements[row as usize];
            nodes.map(|node| node.wrapping_sub(nodes[0]))
        };
        let mut rows: Vec<u32> = (0..elements.len() as u32).collect();
        rows.sort_unstable_by_key(|&row| (shape(row), elements[row as usize][0], row));
        let mut cover = Self { contiguous: Vec::new(), split: Vec::new(), gathered: Vec::new() };
        for alike in rows.chunk_by(|&a, &b| shape(a) == shape(b)) {
            cover.add(elements, alike, node_count);
        }
        cover
    }

    /// Covers elements of one shape, in the order of their first nodes, from the cheapest way to cover those behind.
    fn add(&mut self, elements: &[[u32; N]], alike: &[u32], node_count: usize) {
        let first = |place: usize| elements[alike[place] as usize][0];
        // The place behind a window that begins at `place`. An element that is there twice ends it.
        let behind = |place: usize, width: usize| {
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
            let split = elements[alike[place] as usize].iter().filter(|&&node| node % LANES as u32 != 0).count();
            for (width, cost) in [(LANES, 1.0 + SPLIT_COST * split as f64), (HALF, HALF_COST)] {
                let cost = cost + costs[behind(place, width)];
                if cost < costs[place] {
                    (costs[place], widths[place]) = (cost, width as u8);
                }
            }
        }
        let mut place = 0;
        while place < alike.len() {
            let (width, start) = (widths[place] as usize, place);
            place = behind(start, width);
            let here = &alike[start..place];
            let is_covered = match width {
                LANES => window(elements, here).within(node_count).map(|contiguous| self.contiguous.push(contiguous)),
                HALF => window(elements, here).within(node_count).map(|half| self.split.push(half)),
                _ => None,
            };
            if is_covered.is_none() {
                self.gathered.extend(here);
            }
        }
    }

    /// About what going over all of them costs, in batches of a contiguous, wherever they begin.
    pub(super) fn cost(&self) -> f64 {
        self.contiguous.len() as f64 + HALF_COST * self.split.len() as f64 + GATHERED_COST * self.gathered.len() as f64
    }
}

/// The window that holds these rows.
fn window<const N: usize, const WIDTH: usize>(elements: &[[u32; N]], here: &[u32]) -> Window<N, WIDTH> {
    let first = elements[here[0] as usize];
    let mut rows = [NONE; WIDTH];
    for &row in here {
        rows[(elements[row as usize][0] - first[0]) as usize] = row;
    }
    Window { first, rows }
}

/// Groups in an order in which none adds to nodes that one of the last `APART` added to, as far as the next `POOL` batches
/// allow: a processor that adds to a number just stored waits for it. `starts` gives the first nodes of the `width` lanes that
/// a batch reads straight on.
pub(super) fn apart<T, I: IntoIterator<Item = u32>>(batches: Vec<T>, width: u32, starts: impl Fn(&T) -> I) -> Vec<T> {
    let row_blocks = |batch: &T| starts(batch).into_iter().flat_map(|node| node / NEAR..(node + width - 1) / NEAR + 1);
    let (mut low, mut high) = (u32::MAX, 0);
    for stretch in batches.iter().flat_map(row_blocks) {
        (low, high) = (low.min(stretch), high.max(stretch + 1));
    }
    // When each stretch of four nodes was last added to.
    let mut touched = vec![0_usize; high.saturating_sub(low) as usize];
    let mut pool = VecDeque::with_capacity(POOL);
    let mut waiting = batches.into_iter();
    let mut ordered = Vec::with_capacity(waiting.len());
    loop {
        pool.extend(waiting.by_ref().take(POOL - pool.len()));
        let now = ordered.len() + APART + 1;
        let age = |batch: &T| now - row_blocks(batch).map(|at| touched[(at - low) as usize]).max().unwrap_or(0);
        let mut best = (0, 0);
        for (place, batch) in pool.iter().enumerate() {
            let age = age(batch).min(APART + 1);
            if age > best.1 {
                best = (place, age);
            }
            if age > APART {
                break;
            }
        }
        let Some(batch) = pool.remove(best.0) else { return ordered };
        row_blocks(&batch).for_each(|at| touched[(at - low) as usize] = now);
        ordered.push(batch);
    }
}
