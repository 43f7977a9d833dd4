//! The three columns of a set of vectors, read and written eight rows at a time.
//!
//! Kernels read and write here without a check for every access. What makes that sound is said at each function, and
//! checked once per group by `layout::Elements`, the one user.

use crate::lanes::{LANES, Lanes, Vector};
use crate::state::Vectors;

/// Three columns of equal length, one after the other.
#[derive(Debug, Clone, Copy)]
pub struct Columns<'a> {
    /// 3 `rows` numbers.
    data: &'a [f64],
    rows: usize,
}

/// `COUNT` such columns, to be written.
#[derive(Debug)]
pub struct ColumnsMut<'a, const COUNT: usize = 3> {
    /// `COUNT` `rows` numbers.
    data: &'a mut [f64],
    rows: usize,
}

/// The sum of a column, in a fixed order: four times eight numbers side by side.
#[inline(always)]
pub fn total(column: &[f64]) -> f64 {
    let mut sums = [[0.0; LANES]; 4];
    let blocks = column.chunks_exact(4 * LANES);
    let mut rest = 0.0;
    for number in blocks.remainder() {
        rest += number;
    }
    for block in blocks {
        for part in 0..4 {
            for lane in 0..LANES {
                sums[part][lane] += block[LANES * part + lane];
            }
        }
    }
    let [a, b, c, d] = sums;
    ((Lanes(a) + Lanes(b)) + (Lanes(c) + Lanes(d))).sum() + rest
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
    pub unsafe fn read<V: Vector>(self, axis: usize, at: u32) -> V {
        // SAFETY: `data` has 3 `rows` numbers, so eight from axis rows + at on lie within it.
        V::load_from(unsafe { &*self.data.as_ptr().add(axis * self.rows + at as usize).cast() })
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
}

impl<'a> ColumnsMut<'a, 1> {
    /// One column.
    pub fn single(data: &'a mut [f64]) -> Self {
        let rows = data.len();
        Self { data, rows }
    }
}

impl<const COUNT: usize> ColumnsMut<'_, COUNT> {
    /// Number of rows.
    #[inline(always)]
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Adds to rows `at` to `at + 8` of a column.
    ///
    /// # Safety
    /// `axis < COUNT` and `at + 8 <= rows`.
    #[inline(always)]
    #[allow(unsafe_code)]
    pub unsafe fn add<V: Vector>(&mut self, axis: usize, at: u32, values: V) {
        // SAFETY: as in `Columns::read`; the borrow is unique, because `self` is.
        let place: &mut [f64; LANES] =
            unsafe { &mut *self.data.as_mut_ptr().add(axis * self.rows + at as usize).cast() };
        *place = (V::load_from(place) + values).lanes().0;
    }

    /// Adds to eight rows of a column, one after the other: two places may be the same.
    ///
    /// # Safety
    /// `axis < COUNT` and every place is below `rows`.
    #[inline(always)]
    #[allow(unsafe_code)]
    pub unsafe fn scatter(&mut self, axis: usize, places: &[u32; LANES], values: Lanes) {
        for lane in 0..LANES {
            // SAFETY: `data` has COUNT `rows` numbers, and places[lane] < rows.
            unsafe { *self.data.get_unchecked_mut(axis * self.rows + places[lane] as usize) += values.0[lane] };
        }
    }
}
