//! The columns of node vectors, read and written eight rows at a time.
//!
//! Kernels access them without bounds checks. Each function states its safety conditions; `layout::Pass`, the
//! only user, checks them once per pass.

use crate::arrays::state::NodeVectors;
use crate::simd::lanes::{F64x8, LANES, SimdF64};

/// `COUNT` columns of equal length, one after the other.
#[derive(Debug, Clone, Copy)]
pub struct Columns<'a, const COUNT: usize = 3> {
    /// `COUNT` times `rows` numbers.
    data: &'a [f64],
    rows: usize,
}

/// The same for writing.
#[derive(Debug)]
pub struct ColumnsMut<'a, const COUNT: usize = 3> {
    /// `COUNT` times `rows` numbers.
    data: &'a mut [f64],
    rows: usize,
}

/// The sum of a column, in a fixed order: four partial sums of eight lanes each.
#[inline(always)]
pub fn total(column: &[f64]) -> f64 {
    let mut sums = [[0.0; LANES]; 4];
    let blocks = column.chunks_exact(4 * LANES);
    let mut rest = 0.0;
    for number in blocks.remainder() {
        rest += number;
    }
    for block in blocks {
        for k in 0..4 {
            for lane in 0..LANES {
                sums[k][lane] += block[LANES * k + lane];
            }
        }
    }
    let [a, b, c, d] = sums;
    ((F64x8(a) + F64x8(b)) + (F64x8(c) + F64x8(d))).sum() + rest
}

impl<'a> Columns<'a> {
    /// The columns of `vectors`.
    pub fn of(vectors: &'a NodeVectors) -> Self {
        Self { data: vectors.as_slice(), rows: vectors.nrows() }
    }
}

impl<'a, const COUNT: usize> Columns<'a, COUNT> {
    /// The columns in `data`.
    ///
    /// # Panics
    /// If the length of `data` is no multiple of `COUNT`.
    pub fn in_slice(data: &'a [f64]) -> Self {
        assert!(data.len().is_multiple_of(COUNT));
        Self { data, rows: data.len() / COUNT }
    }

    /// Number of rows.
    #[inline(always)]
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Eight rows of a column.
    ///
    /// # Panics
    /// For a row out of range.
    pub fn gather_checked(self, axis: usize, places: &[u32; LANES]) -> F64x8 {
        let column = &self.data[axis * self.rows..][..self.rows];
        F64x8(places.map(|place| column[place as usize]))
    }

    /// Rows `at` to `at + 8` of a column.
    ///
    /// # Safety
    /// `axis < COUNT` and `at + 8 <= rows`.
    #[inline(always)]
    #[allow(unsafe_code)]
    pub unsafe fn read<V: SimdF64>(self, axis: usize, at: u32) -> V {
        // SAFETY: `data` has COUNT times `rows` numbers, so that the eight from axis * rows + at on lie within it.
        V::load_from(unsafe { &*self.data.as_ptr().add(axis * self.rows + at as usize).cast() })
    }

    /// Rows `at` to `at + 4` of a column, for both entries of `at`.
    ///
    /// # Safety
    /// `axis < COUNT` and `at + 4 <= rows`.
    #[inline(always)]
    #[allow(unsafe_code)]
    pub unsafe fn read_split<V: SimdF64>(self, axis: usize, at: [u32; 2]) -> V {
        // SAFETY: `data` has COUNT times `rows` numbers, so that the four from axis * rows + at on lie within it.
        let low = unsafe { &*self.data.as_ptr().add(axis * self.rows + at[0] as usize).cast() };
        // SAFETY: the same.
        let high = unsafe { &*self.data.as_ptr().add(axis * self.rows + at[1] as usize).cast() };
        V::load_split(low, high)
    }

    /// Eight rows of a column.
    ///
    /// # Safety
    /// `axis < COUNT` and every place is below `rows`.
    #[inline(always)]
    #[allow(unsafe_code)]
    pub unsafe fn gather(self, axis: usize, places: &[u32; LANES]) -> F64x8 {
        let mut out = [0.0; LANES];
        for lane in 0..LANES {
            // SAFETY: `data` has COUNT times `rows` numbers, and places[lane] < rows.
            out[lane] = unsafe { *self.data.get_unchecked(axis * self.rows + places[lane] as usize) };
        }
        F64x8(out)
    }
}

impl<'a> ColumnsMut<'a> {
    /// The columns of `vectors`.
    pub fn of(vectors: &'a mut NodeVectors) -> Self {
        let rows = vectors.nrows();
        Self { data: vectors.as_mut_slice(), rows }
    }
}

impl<'a> ColumnsMut<'a, 1> {
    /// One column.
    pub fn single(data: &'a mut [f64]) -> Self {
        let rows = data.len();
        Self { data, rows }
    }
}

impl<const COUNT: usize> ColumnsMut<'_, COUNT> {
    /// The same columns, for a shorter time.
    #[inline(always)]
    pub fn reborrow(&mut self) -> ColumnsMut<'_, COUNT> {
        ColumnsMut { data: self.data, rows: self.rows }
    }

    /// Number of rows.
    #[inline(always)]
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Adds to eight rows of a column, one after the other; places may coincide.
    ///
    /// # Panics
    /// For a row out of range.
    pub fn scatter_checked(&mut self, axis: usize, places: &[u32; LANES], values: F64x8) {
        let column = &mut self.data[axis * self.rows..][..self.rows];
        for (&place, value) in places.iter().zip(values.0) {
            column[place as usize] += value;
        }
    }

    /// Adds to rows `at` to `at + 8` of a column.
    ///
    /// # Safety
    /// `axis < COUNT` and `at + 8 <= rows`.
    #[inline(always)]
    #[allow(unsafe_code)]
    pub unsafe fn add<V: SimdF64>(&mut self, axis: usize, at: u32, values: V) {
        // SAFETY: as in `Columns::read`; the borrow is unique, because `self` is.
        let place: &mut [f64; LANES] =
            unsafe { &mut *self.data.as_mut_ptr().add(axis * self.rows + at as usize).cast() };
        *place = (V::load_from(place) + values).lanes().0;
    }

    /// Adds to rows `at` to `at + 4` of a column, for one entry of `at` after the other; they may overlap.
    ///
    /// # Safety
    /// `axis < COUNT` and `at + 4 <= rows`.
    #[inline(always)]
    #[allow(unsafe_code)]
    pub unsafe fn add_split<V: SimdF64>(&mut self, axis: usize, at: [u32; 2], values: V) {
        let (low, high) = (axis * self.rows + at[0] as usize, axis * self.rows + at[1] as usize);
        // SAFETY: as in `read_split`; the borrow is unique, because `self` is, and ends before the next.
        values.add_low_to(unsafe { &mut *self.data.as_mut_ptr().add(low).cast() });
        // SAFETY: the same.
        values.add_high_to(unsafe { &mut *self.data.as_mut_ptr().add(high).cast() });
    }

    /// Adds to eight rows of a column, one after the other; places may coincide.
    ///
    /// # Safety
    /// `axis < COUNT` and every place is below `rows`.
    #[inline(always)]
    #[allow(unsafe_code)]
    pub unsafe fn scatter(&mut self, axis: usize, places: &[u32; LANES], values: F64x8) {
        for lane in 0..LANES {
            // SAFETY: `data` has COUNT times `rows` numbers, and places[lane] < rows.
            unsafe { *self.data.get_unchecked_mut(axis * self.rows + places[lane] as usize) += values.0[lane] };
        }
    }
}
