//! The three columns of a set of vectors, read and written eight rows at a time.
//!
//! Kernels read and write here without a check for every access. What makes that sound is said at each function, and
//! checked once per group by `layout::Elements`, the one user.

use crate::lanes::{LANES, Lanes};
use crate::state::Vectors;

/// Three columns of equal length, one after the other.
#[derive(Debug, Clone, Copy)]
pub struct Columns<'a> {
    /// 3 `rows` numbers.
    data: &'a [f64],
    rows: usize,
}

/// The same, to be written.
#[derive(Debug)]
pub struct ColumnsMut<'a> {
    /// 3 `rows` numbers.
    data: &'a mut [f64],
    rows: usize,
}

impl<'a> Columns<'a> {
    /// The columns of `vectors`.
    pub fn of(vectors: &'a Vectors) -> Self {
        Self { data: vectors.as_slice(), rows: vectors.nrows() }
    }

    /// Number of rows.
    #[inline(always)]
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Rows `at` to `at + 8` of a column.
    ///
    /// # Safety
    /// `axis < 3` and `at + 8 <= rows`.
    #[inline(always)]
    #[allow(unsafe_code)]
    pub unsafe fn read(self, axis: usize, at: u32) -> Lanes {
        // SAFETY: `data` has 3 `rows` numbers, so eight from axis rows + at on lie within it.
        unsafe { Lanes(*self.data.as_ptr().add(axis * self.rows + at as usize).cast()) }
    }

    /// Eight rows of a column.
    ///
    /// # Safety
    /// `axis < 3` and every place is below `rows`.
    #[inline(always)]
    #[allow(unsafe_code)]
    pub unsafe fn gather(self, axis: usize, places: &[u32; LANES]) -> Lanes {
        let mut out = [0.0; LANES];
        for lane in 0..LANES {
            // SAFETY: `data` has 3 `rows` numbers, and places[lane] < rows.
            out[lane] = unsafe { *self.data.get_unchecked(axis * self.rows + places[lane] as usize) };
        }
        Lanes(out)
    }
}

impl<'a> ColumnsMut<'a> {
    /// The columns of `vectors`.
    pub fn of(vectors: &'a mut Vectors) -> Self {
        let rows = vectors.nrows();
        Self { data: vectors.as_mut_slice(), rows }
    }

    /// Number of rows.
    #[inline(always)]
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Adds to rows `at` to `at + 8` of a column.
    ///
    /// # Safety
    /// `axis < 3` and `at + 8 <= rows`.
    #[inline(always)]
    #[allow(unsafe_code)]
    pub unsafe fn add(&mut self, axis: usize, at: u32, values: Lanes) {
        // SAFETY: as in `Columns::read`; the borrow is unique, because `self` is.
        let place: &mut [f64; LANES] =
            unsafe { &mut *self.data.as_mut_ptr().add(axis * self.rows + at as usize).cast() };
        *place = (Lanes(*place) + values).0;
    }

    /// Adds to eight rows of a column, one after the other: two places may be the same.
    ///
    /// # Safety
    /// `axis < 3` and every place is below `rows`.
    #[inline(always)]
    #[allow(unsafe_code)]
    pub unsafe fn scatter(&mut self, axis: usize, places: &[u32; LANES], values: Lanes) {
        for lane in 0..LANES {
            // SAFETY: `data` has 3 `rows` numbers, and places[lane] < rows.
            unsafe { *self.data.get_unchecked_mut(axis * self.rows + places[lane] as usize) += values.0[lane] };
        }
    }
}
