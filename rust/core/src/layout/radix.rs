//! Sorting by digits, from the lowest to the highest, without comparisons.

/// Bits of a digit, and of a word.
const DIGIT: usize = 11;
const WORD: usize = 32;
/// Number of values of a digit.
const VALUES: usize = 1 << DIGIT;

/// The places 0, 1, ... below `count` by ascending keys; those of equal keys ascend. A key is `words` words, of which
/// `word(k, place)` is the k-th, the lowest first.
pub(super) fn order_by(count: usize, words: usize, word: impl Fn(usize, usize) -> u32) -> Vec<u32> {
    let mut order: Vec<u32> = (0..count as u32).collect();
    let mut sorted = vec![0; count];
    let mut begins = [0; VALUES];
    for k in 0..words {
        // Digits that all keys have in common sort nothing.
        let (all, any) = (0..count).fold((u32::MAX, 0), |(all, any), place| {
            let word = word(k, place);
            (all & word, any | word)
        });
        for shift in (0..WORD).step_by(DIGIT) {
            let digit_of = |word: u32| (word >> shift) as usize % VALUES;
            if digit_of(all ^ any) == 0 {
                continue;
            }
            let digit = |place: u32| digit_of(word(k, place as usize));
            begins.fill(0);
            order.iter().for_each(|&place| begins[digit(place)] += 1);
            let mut begin: usize = 0;
            for count in &mut begins {
                begin += std::mem::replace(count, begin);
            }
            for &place in &order {
                let target = &mut begins[digit(place)];
                sorted[*target] = place;
                *target += 1;
            }
            std::mem::swap(&mut order, &mut sorted);
        }
    }
    order
}

/// The high word of a number; those of numbers in the order of `f64::total_cmp` ascend or are equal.
pub(super) fn high_word(value: f64) -> u32 {
    let high = (value.to_bits() >> WORD) as u32;
    high ^ (((high as i32 >> 31) as u32) | 1 << 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_of_several_words_are_sorted_as_by_comparisons() {
        let word = |k: usize, place: usize| match k {
            0 => (place as u32).wrapping_mul(2_654_435_761),
            1 => 7,
            _ => u32::MAX.wrapping_sub((place % 13) as u32).wrapping_mul(1 + 2 * (place as u32 % 2)),
        };
        for count in [0, 1, 2, 5000] {
            let mut expected: Vec<u32> = (0..count as u32).collect();
            expected.sort_by_key(|&place| [2, 1, 0].map(|k| word(k, place as usize)));
            assert_eq!(order_by(count, 3, word), expected);
            expected.sort_unstable();
            expected.sort_by_key(|&place| word(2, place as usize));
            assert_eq!(order_by(count, 1, |_, place| word(2, place)), expected);
        }
    }

    #[test]
    fn high_words_of_numbers_are_in_their_order() {
        let ascending = [f64::NEG_INFINITY, -2.0, -1.0, -1e-300, -0.0, 0.0, 1e-300, 1.0, 1.001, 1e300, f64::NAN];
        let words = ascending.map(high_word);
        assert!(words.is_sorted_by(|a, b| a < b), "{words:?}");
        assert_eq!(high_word(1.0), high_word(1.0 + f64::EPSILON));
    }
}
