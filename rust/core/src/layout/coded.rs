//! Parameters of batches in coded form: each distinct entry once, and a code for each batch.
//!
//! A regular mesh has few kinds of elements, and few sequences of eight of them. Each entry of a batch is a number for
//! each of eight elements, or several, 64 bytes a number. Read in every evaluation, such parameters were a third of the
//! data of a large mesh. Coded they are 4 bytes a batch, and the distinct entries remain in the cache. A mesh
//! without regularity has as many entries as before, and the codes besides.
//!
//! Elements that are equal by symmetry differ in the last bits of their parameters, by rounding of the coordinates.
//! `merged` gives them one value in sets that the cache does not hold. A rest length that differs by rounding from the
//! length itself strains a film at rest, so that smaller sets, which gain nothing, keep their values.

use std::collections::HashMap;
use std::hash::Hash;
use std::ops::Index;

use super::element_set::Pass;
use crate::simd::lanes::{F64x8, LANES};

/// Relative difference below which two parameters are one: larger than the rounding of the coordinates on meshes of a
/// million nodes, and far below any physical meaning.
const TOLERANCE: f64 = 1e-12;

/// Number of elements up to which parameters remain in the cache as they are.
const HELD: usize = 40_000;

/// An entry of a batch.
pub trait Entry: Copy {
    /// Its bits.
    type Key: Eq + Hash;

    /// Its bits.
    fn key(&self) -> Self::Key;
}

impl Entry for F64x8 {
    type Key = [u64; LANES];

    fn key(&self) -> Self::Key {
        self.0.map(f64::to_bits)
    }
}

/// One entry for each batch.
#[derive(Debug, Clone)]
pub struct Coded<T> {
    /// The distinct entries, in order of their first batch.
    distinct: Vec<T>,
    /// The place of the entry of each batch among them.
    codes: Vec<u32>,
}

impl<T: Entry> Coded<T> {
    /// From the entry of each batch.
    pub fn new(entries: impl IntoIterator<Item = T>) -> Self {
        let (mut distinct, mut places) = (Vec::new(), HashMap::new());
        let codes = entries.into_iter().map(|entry| {
            *places.entry(entry.key()).or_insert_with(|| {
                distinct.push(entry);
                (distinct.len() - 1) as u32
            })
        });
        let codes = codes.collect();
        Self { distinct, codes }
    }
}

impl<T> Coded<T> {
    /// The entry of each batch.
    pub fn iter(&self) -> impl Iterator<Item = &T> {
        self.codes.iter().map(|&code| &self.distinct[code as usize])
    }

    /// Number of distinct entries, and of batches.
    pub fn counts(&self) -> [usize; 2] {
        [self.distinct.len(), self.codes.len()]
    }

    /// The entries of the batches of a pass, numbered as there.
    #[inline(always)]
    pub(crate) fn of<'a, const N: usize, const KIND: usize>(&'a self, pass: &Pass<'a, N, KIND>) -> CodedPass<'a, T> {
        CodedPass { distinct: &self.distinct, codes: pass.of(&self.codes) }
    }
}

impl<T> Index<usize> for Coded<T> {
    type Output = T;

    fn index(&self, batch: usize) -> &T {
        &self.distinct[self.codes[batch] as usize]
    }
}

/// The entries of the batches of a pass.
#[derive(Debug)]
pub(crate) struct CodedPass<'a, T> {
    distinct: &'a [T],
    codes: &'a [u32],
}

impl<T> Index<usize> for CodedPass<'_, T> {
    type Output = T;

    #[inline(always)]
    fn index(&self, batch: usize) -> &T {
        &self.distinct[self.codes[batch] as usize]
    }
}

/// The values of a set of elements, merged where there are more than `HELD`.
pub(crate) fn merged(values: Vec<f64>) -> Vec<f64> {
    if values.len() > HELD { within_tolerance(values) } else { values }
}

/// The values, where those that differ by no more than `TOLERANCE` of the smallest of them are equal to it.
fn within_tolerance(mut values: Vec<f64>) -> Vec<f64> {
    let mut order: Vec<u32> = (0..values.len() as u32).collect();
    order.sort_unstable_by(|&i, &j| values[i as usize].total_cmp(&values[j as usize]).then(i.cmp(&j)));
    let mut least = f64::NAN;
    for row in order {
        let value = &mut values[row as usize];
        // True for the first value as well, with NaN.
        let is_near = *value - least <= TOLERANCE * least.abs();
        if is_near {
            *value = least;
        } else {
            least = *value;
        }
    }
    values
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::lanes::SimdF64;

    #[test]
    fn each_batch_has_its_entry_and_equal_ones_are_stored_once() {
        let entries: Vec<_> = [1.0, 2.0, 1.0, 3.0, 2.0, -0.0, 0.0].map(F64x8::all).to_vec();
        let coded = Coded::new(entries.iter().copied());
        assert_eq!(coded.counts(), [5, 7]);
        assert!(coded.iter().zip(&entries).all(|(found, entry)| found.key() == entry.key()));
        assert!((0..7).all(|batch| coded[batch].key() == entries[batch].key()));
    }

    #[test]
    fn values_within_rounding_are_merged_and_no_others() {
        let (near, far) = (1.0 + 0.9e-12, 1.0 + 1.1e-12);
        assert_eq!(within_tolerance(vec![near, 5.0, 1.0, -2.0, 0.0, far]), vec![1.0, 5.0, 1.0, -2.0, 0.0, far]);
        // Steps within the tolerance do not add up.
        let chain: Vec<f64> = (0..5).map(|k| 1.0 + 0.6e-12 * f64::from(k)).collect();
        let found = within_tolerance(chain.clone());
        assert_eq!(found, vec![chain[0], chain[0], chain[2], chain[2], chain[4]]);
        assert!(within_tolerance(vec![]).is_empty());
    }

    #[test]
    fn values_of_a_set_that_the_cache_holds_are_kept() {
        let values = |count| [vec![1.0 + 0.5e-12; count - 1], vec![1.0]].concat();
        assert_eq!(merged(values(HELD)), values(HELD));
        assert_eq!(merged(values(HELD + 1)), vec![1.0; HELD + 1]);
    }
}
