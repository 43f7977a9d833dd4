//! One formula applied to each row of several arrays, eight rows at a time.
//!
//! The compiler does not vectorise a plain loop over more than a few arrays that might overlap.

use crate::simd::dispatch::{InstructionSet, Kernel};
use crate::simd::lanes::{LANES, SimdF64};

/// A formula that reads `R` numbers of a row and updates `W` others.
pub(crate) trait Formula<const R: usize, const W: usize> {
    /// The updated numbers.
    fn row<V: SimdF64>(&self, read: [V; R], changed: [V; W]) -> [V; W];

    /// Contribution of a row, from the numbers before the update, to a sum over all rows.
    #[inline(always)]
    fn summand<V: SimdF64>(&self, _read: [V; R], _changed: [V; W]) -> V {
        V::zero()
    }
}

/// A formula and its arrays.
struct Each<'a, F, const R: usize, const W: usize> {
    formula: &'a F,
    read: [&'a [f64]; R],
    changed: [&'a mut [f64]; W],
}

/// A formula and three columns for each of its numbers.
struct Axes<'a, F, const R: usize, const W: usize> {
    formula: &'a F,
    read: [[&'a [f64]; 3]; R],
    changed: [[&'a mut [f64]; 3]; W],
}

/// Applies a formula to all rows, and returns the sum of its summands, added in a fixed order.
///
/// # Panics
/// Where arrays differ in length.
pub(crate) fn each<F: Formula<R, W>, const R: usize, const W: usize>(
    instructions: InstructionSet,
    formula: &F,
    read: [&[f64]; R],
    changed: [&mut [f64]; W],
) -> f64 {
    instructions.dispatch(Each { formula, read, changed })
}

/// Applies a formula to all rows of three columns, one axis after the other.
///
/// # Panics
/// Where columns differ in length.
pub(crate) fn on_axes<F: Formula<R, W>, const R: usize, const W: usize>(
    instructions: InstructionSet,
    formula: &F,
    read: [[&[f64]; 3]; R],
    changed: [[&mut [f64]; 3]; W],
) {
    instructions.dispatch(Axes { formula, read, changed });
}

impl<F: Formula<R, W>, const R: usize, const W: usize> Kernel for Axes<'_, F, R, W> {
    type Output = ();

    #[inline(always)]
    fn sweep<V: SimdF64>(self) {
        let Self { formula, read, mut changed } = self;
        for axis in 0..3 {
            let read = read.map(|columns| columns[axis]);
            let changed = changed.each_mut().map(|columns| &mut *columns[axis]);
            Each { formula, read, changed }.sweep::<V>();
        }
    }
}

impl<F: Formula<R, W>, const R: usize, const W: usize> Kernel for Each<'_, F, R, W> {
    type Output = f64;

    #[inline(always)]
    fn sweep<V: SimdF64>(self) -> f64 {
        let Self { formula, read, changed } = self;
        let rows = if W > 0 { changed[0].len() } else { read[0].len() };
        for k in 0..R {
            assert!(read[k].len() == rows);
        }
        for k in 0..W {
            assert!(changed[k].len() == rows);
        }
        let count = rows / LANES;
        // Slices of equal length, so that the loop needs no bounds checks.
        let read = read.map(|array| {
            let (blocks, rest) = array.as_chunks::<LANES>();
            (&blocks[..count], rest)
        });
        let changed = changed.map(|array| {
            let (blocks, rest) = array.as_chunks_mut::<LANES>();
            (&mut blocks[..count], rest)
        });
        let mut sum = V::zero();
        for i in 0..count {
            let (mut numbers, mut old) = ([V::zero(); R], [V::zero(); W]);
            for k in 0..R {
                numbers[k] = V::load_from(&read[k].0[i]);
            }
            for k in 0..W {
                old[k] = V::load_from(&changed[k].0[i]);
            }
            let new = formula.row(numbers, old);
            sum += formula.summand(numbers, old);
            for k in 0..W {
                changed[k].0[i] = new[k].lanes().0;
            }
        }
        let rest = rows - count * LANES;
        if rest > 0 {
            let (mut numbers, mut old) = ([V::zero(); R], [V::zero(); W]);
            for k in 0..R {
                numbers[k] = padded(&read[k].1[..rest]);
            }
            for k in 0..W {
                old[k] = padded(&changed[k].1[..rest]);
            }
            let new = formula.row(numbers, old);
            sum += formula.summand(numbers, old);
            for k in 0..W {
                changed[k].1.copy_from_slice(&new[k].lanes().0[..rest]);
            }
        }
        sum.lanes().sum()
    }
}

/// Fewer than eight numbers, padded with zeros.
#[inline(always)]
fn padded<V: SimdF64>(rest: &[f64]) -> V {
    let mut numbers = [0.0; LANES];
    numbers[..rest.len()].copy_from_slice(rest);
    V::load_from(&numbers)
}

/// Adds one array to another.
pub(crate) struct Add;

impl Formula<1, 1> for Add {
    #[inline(always)]
    fn row<V: SimdF64>(&self, [from]: [V; 1], [to]: [V; 1]) -> [V; 1] {
        [to + from]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_row_is_changed_at_every_width_and_length() {
        for count in [0, 1, 7, 8, 9, 31] {
            let from: Vec<f64> = (0..count).map(|i| 0.1 * f64::from(i)).collect();
            for instructions in InstructionSet::ALL {
                let mut to: Vec<f64> = from.iter().map(|x| 3.0 * x).collect();
                each(instructions, &Add, [&from], [&mut to]);
                assert!(to.iter().zip(&from).all(|(to, x)| *to == 3.0 * x + x), "{instructions:?} {to:?}");
            }
        }
    }
}
