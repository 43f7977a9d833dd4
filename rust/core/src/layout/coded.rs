//! Parameters of batches in coded form: each distinct entry once, and a code for each batch.
//!
//! A regular mesh has few kinds of elements, and few sequences of eight of them. Each entry of a batch is a number for
//! each of eight elements, or several, 64 bytes a number. Read in every evaluation, such parameters would be a third of
//! the data of a large mesh. Coded they are 4 bytes a batch, and the distinct entries remain in the cache. A mesh
//! without regularity has as many entries as batches, and the codes besides.
//!
//! Elements that are equal by symmetry differ in the last bits of their parameters, by rounding of the coordinates.
//! `merged` gives them one value in sets that the cache does not hold. A rest length that differs by rounding from the
//! length itself strains a film at rest, so that smaller sets, which gain nothing, keep their values.

use std::collections::HashMap;
use std::hash::Hash;
use std::ops::Index;

use super::pass::Pass;
use super::radix::{high_word, order_by};
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
    if values.len() > HELD { within_tolerance(&values) } else { values }
}

/// The values, where those that differ by no more than `TOLERANCE` of the smallest of them are equal to it.
fn within_tolerance(values: &[f64]) -> Vec<f64> {
    // Values of one high word, 1e-6 of them, mostly differ by rounding alone and need no further order.
    let mut order = order_by(values.len(), 1, |_, row| high_word(values[row]));
    let is_near = |value: f64, least: f64| value - least <= TOLERANCE * least.abs();
    let (mut found, mut least) = (values.to_vec(), f64::NAN);
    for alike in order.chunk_by_mut(|&a, &b| high_word(values[a as usize]) == high_word(values[b as usize])) {
        let of_alike = || alike.iter().map(|&row| values[row as usize]);
        let ends = [of_alike().min_by(f64::total_cmp), of_alike().max_by(f64::total_cmp)];
        let [first, last] = ends.map(|value| value.unwrap_or(f64::NAN));
        let common = if is_near(last, least) { least } else { first };
        if is_near(last, common) && (common == least || !is_near(first, least)) {
            alike.iter().for_each(|&row| found[row as usize] = common);
            least = common;
            continue;
        }
        alike.sort_unstable_by(|&i, &j| values[i as usize].total_cmp(&values[j as usize]));
        for &mut row in alike {
            let value = &mut found[row as usize];
            if is_near(*value, least) {
                *value = least;
            } else {
                least = *value;
            }
        }
    }
    found
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
        assert_eq!(within_tolerance(&[near, 5.0, 1.0, -2.0, 0.0, far]), vec![1.0, 5.0, 1.0, -2.0, 0.0, far]);
        // Steps within the tolerance do not add up.
        let chain: Vec<f64> = (0..5).map(|k| 1.0 + 0.6e-12 * f64::from(k)).collect();
        let found = within_tolerance(&chain);
        assert_eq!(found, vec![chain[0], chain[0], chain[2], chain[2], chain[4]]);
        assert!(within_tolerance(&[]).is_empty());
    }

    #[test]
    fn values_are_merged_as_by_a_whole_order() {
        let plain = |mut values: Vec<f64>| {
            let mut order: Vec<usize> = (0..values.len()).collect();
            order.sort_by(|&i, &j| values[i].total_cmp(&values[j]));
            let mut least = f64::NAN;
            for row in order {
                if values[row] - least <= TOLERANCE * least.abs() {
                    values[row] = least;
                } else {
                    least = values[row];
                }
            }
            values
        };
        // Clusters of several widths about numbers near and far from a change of the high word.
        let values = (0..6000_u32).map(|k| {
            let centre =
                [1.0, 1.0 + 2.0_f64.powi(-20), -3.7, 0.0, 5e-324, 1e300, f64::INFINITY, f64::NAN][k as usize % 8];
            let offset = f64::from(k.wrapping_mul(2_654_435_761) >> 8) / f64::from(1 << 24) - 0.5;
            centre * (1.0 + offset * [1e-15, 1e-13, 3e-12, 1e-9][k as usize / 8 % 4])
        });
        let values: Vec<f64> = values.chain([0.0, -0.0, f64::NEG_INFINITY, -f64::NAN]).collect();
        let bits = |values: Vec<f64>| values.into_iter().map(f64::to_bits).collect::<Vec<u64>>();
        assert_eq!(bits(within_tolerance(&values)), bits(plain(values)));
    }

    #[test]
    fn values_of_a_set_that_the_cache_holds_are_kept() {
        let values = |count| [vec![1.0 + 0.5e-12; count - 1], vec![1.0]].concat();
        assert_eq!(merged(values(HELD)), values(HELD));
        assert_eq!(merged(values(HELD + 1)), vec![1.0; HELD + 1]);
    }
}
