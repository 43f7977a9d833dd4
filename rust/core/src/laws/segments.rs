//! Elements of two nodes, few of them, one after the other: by tiles, without batches.

use crate::arrays::blocks::{rows_of, tiles};

/// An element of two nodes.
pub(super) trait Ends {
    /// Internal numbers, the lower one first.
    fn ends(&self) -> [u32; 2];
}

/// Elements in the order of their lower nodes.
pub(super) struct Segments<T> {
    elements: Vec<T>,
    /// See `Law::reach`, by tiles.
    reach: Vec<usize>,
    node_count: usize,
}

impl<T: Ends> Segments<T> {
    pub(super) fn new(mut elements: Vec<T>, node_count: usize) -> Self {
        elements.sort_by_key(Ends::ends);
        let mut own = Self { elements, reach: Vec::new(), node_count };
        let mut reach = 0;
        for tile in tiles(node_count) {
            reach = own.of_tile(tile).iter().map(|element| element.ends()[1] as usize + 1).fold(reach, usize::max);
            own.reach.push(reach);
        }
        own
    }

    /// All elements.
    pub(super) fn all(&self) -> &[T] {
        &self.elements
    }

    /// The elements of a tile, those whose lower node is in it.
    pub(super) fn of_tile(&self, tile: usize) -> &[T] {
        let rows = rows_of(tile, self.node_count);
        let place = |row: usize| self.elements.partition_point(|element| (element.ends()[0] as usize) < row);
        &self.elements[place(rows.start)..place(rows.end)]
    }

    /// See `Law::reach`.
    pub(super) fn reach(&self, tile: usize) -> usize {
        self.reach.get(tile).copied().unwrap_or(usize::MAX)
    }
}
