//! The batches of one kind in one tile, as kernels read and add by them.

use std::ops::Range;

use crate::arrays::columns::{Columns, ColumnsMut};
use crate::simd::dispatch::{CONTIGUOUS, SPLIT};
use crate::simd::lanes::{LANES, SimdF64};

/// Batches in a chunk.
pub const CHUNK: usize = 32;

/// The batches of one kind in one tile; batches are numbered from 0 within the pass.
#[derive(Debug, Clone, Copy)]
pub struct Pass<'a, const N: usize, const KIND: usize> {
    contiguous: &'a [[u32; N]],
    split: &'a [[[u32; 2]; N]],
    gathered: &'a [[[u32; LANES]; N]],
    /// Number of batches before these in arrays of one entry per batch.
    first: usize,
    /// Bound above the nodes of these batches, padding lanes included.
    rows: usize,
}

impl<'a, const N: usize, const KIND: usize> Pass<'a, N, KIND> {
    /// The batches of the kind `KIND`, of slices of all kinds, with so many batches before them, for columns of `rows`
    /// rows. `node_bound` lies above the nodes of all lanes of these batches.
    ///
    /// # Panics
    /// If the rows do not reach the bound.
    #[inline(always)]
    pub(super) fn new(
        contiguous: &'a [[u32; N]],
        split: &'a [[[u32; 2]; N]],
        gathered: &'a [[[u32; LANES]; N]],
        first: usize,
        [node_bound, rows]: [usize; 2],
    ) -> Self {
        assert!(node_bound <= rows);
        Self { contiguous, split, gathered, first, rows }
    }

    /// Number of batches.
    #[inline(always)]
    pub fn len(&self) -> usize {
        match KIND {
            CONTIGUOUS => self.contiguous.len(),
            SPLIT => self.split.len(),
            _ => self.gathered.len(),
        }
    }

    /// Whether the pass has no batch.
    #[inline(always)]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The number of a batch among all batches of the set.
    #[inline(always)]
    pub fn place(&self, batch: usize) -> usize {
        self.first + batch
    }

    /// The entries of these batches in an array of one entry per batch.
    #[inline(always)]
    pub fn of<T>(&self, values: &'a [T]) -> &'a [T] {
        &values[self.first..][..self.len()]
    }

    /// The batches in chunks, for sweeps in several stages over each chunk.
    #[inline(always)]
    pub fn chunks_of_batches(&self) -> impl Iterator<Item = Range<usize>> + use<N, KIND> {
        let count = self.len();
        (0..count).step_by(CHUNK).map(move |first| first..count.min(first + CHUNK))
    }

    /// Reads the columns for the nodes of these batches.
    ///
    /// # Panics
    /// If the columns have fewer rows than these batches need.
    #[inline(always)]
    pub fn reader<const COUNT: usize>(self, columns: Columns<'a, COUNT>) -> Reader<'a, N, KIND, COUNT> {
        assert!(self.rows <= columns.rows());
        Reader { pass: self, columns }
    }

    /// Adds to the columns for the nodes of these batches.
    ///
    /// # Panics
    /// If the columns have fewer rows than these batches need.
    #[inline(always)]
    pub fn adder<'b, const COUNT: usize>(
        self,
        columns: &'b mut ColumnsMut<'_, COUNT>,
    ) -> Adder<'a, 'b, N, KIND, COUNT> {
        assert!(self.rows <= columns.rows());
        Adder { pass: self, columns: columns.reborrow() }
    }
}

/// The columns as a pass reads them: their rows are checked once.
#[derive(Debug, Clone, Copy)]
pub struct Reader<'a, const N: usize, const KIND: usize, const COUNT: usize> {
    pass: Pass<'a, N, KIND>,
    /// At least `pass.rows` rows.
    columns: Columns<'a, COUNT>,
}

impl<const N: usize, const KIND: usize, const COUNT: usize> Reader<'_, N, KIND, COUNT> {
    /// The entries of the columns for the nodes of a batch; with three columns, their vectors.
    #[inline(always)]
    #[allow(unsafe_code)]
    pub fn read<V: SimdF64>(&self, batch: usize) -> [[V; COUNT]; N] {
        let Self { pass, columns } = self;
        let mut points = [[V::zero(); COUNT]; N];
        // SAFETY: the nodes of all lanes are below the bound that `ElementSet` keeps and gives to `Pass::new`, which
        // checks that it is at most `pass.rows`. That is at most the rows of the columns, as `Pass::reader` checks.
        // `axis` is below COUNT.
        unsafe {
            if KIND == CONTIGUOUS {
                let first = pass.contiguous[batch];
                for k in 0..N {
                    for axis in 0..COUNT {
                        points[k][axis] = columns.read(axis, first[k]);
                    }
                }
            } else if KIND == SPLIT {
                let first = pass.split[batch];
                for k in 0..N {
                    for axis in 0..COUNT {
                        points[k][axis] = columns.read_split(axis, first[k]);
                    }
                }
            } else {
                let nodes = &pass.gathered[batch];
                for k in 0..N {
                    for axis in 0..COUNT {
                        points[k][axis] = V::load(&columns.gather(axis, &nodes[k]));
                    }
                }
            }
        }
        points
    }
}

/// The columns to which a pass adds: their rows are checked once.
#[derive(Debug)]
pub struct Adder<'a, 'b, const N: usize, const KIND: usize, const COUNT: usize> {
    pass: Pass<'a, N, KIND>,
    /// At least `pass.rows` rows.
    columns: ColumnsMut<'b, COUNT>,
}

impl<const N: usize, const KIND: usize, const COUNT: usize> Adder<'_, '_, N, KIND, COUNT> {
    /// Adds to the entries of the columns for the nodes of a batch, with three columns a vector to each node; zero in
    /// padding lanes.
    #[inline(always)]
    #[allow(unsafe_code)]
    pub fn add<V: SimdF64>(&mut self, batch: usize, rows: [[V; COUNT]; N]) {
        let Self { pass, columns } = self;
        // SAFETY: as in `Reader::read`, by the check of `Pass::adder`; `axis` is below COUNT.
        unsafe {
            if KIND == CONTIGUOUS {
                let first = pass.contiguous[batch];
                for k in 0..N {
                    for axis in 0..COUNT {
                        columns.add(axis, first[k], rows[k][axis]);
                    }
                }
            } else if KIND == SPLIT {
                let first = pass.split[batch];
                for k in 0..N {
                    for axis in 0..COUNT {
                        columns.add_split(axis, first[k], rows[k][axis]);
                    }
                }
            } else {
                let nodes = &pass.gathered[batch];
                for k in 0..N {
                    for axis in 0..COUNT {
                        columns.scatter(axis, &nodes[k], rows[k][axis].lanes());
                    }
                }
            }
        }
    }
}
