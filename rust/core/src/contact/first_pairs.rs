//! The first of many pairs, in memory for some.

/// Pairs that are kept at least before those beyond the limit are dropped.
const LEAST_KEPT: usize = 1024;

/// Pairs in any order, of which the first in lexicographic order are kept.
pub(super) struct FirstPairs {
    limit: usize,
    kept: Vec<[u32; 2]>,
    /// The last of the first pairs, once there are as many as the limit.
    last: Option<[u32; 2]>,
}

impl FirstPairs {
    /// None yet.
    pub(super) fn new(limit: usize) -> Self {
        Self { limit, kept: Vec::new(), last: None }
    }

    /// Takes a pair of two indices, the lower one first in what is kept.
    pub(super) fn push(&mut self, a: u32, b: u32) {
        let pair = [a.min(b), a.max(b)];
        if self.limit == 0 || self.last.is_some_and(|last| pair > last) {
            return;
        }
        self.kept.push(pair);
        if self.kept.len() >= self.limit.saturating_mul(2).max(LEAST_KEPT) {
            let (_, &mut last, _) = self.kept.select_nth_unstable(self.limit - 1);
            self.kept.truncate(self.limit);
            self.last = Some(last);
        }
    }

    /// The first pairs, in order.
    pub(super) fn sorted(mut self) -> Vec<[u32; 2]> {
        self.kept.sort_unstable();
        self.kept.truncate(self.limit);
        self.kept
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_of_many_are_kept_in_order() {
        // All pairs of indices below 100, in an order that is neither ascending nor descending.
        let all: Vec<[u32; 2]> = (0..100).flat_map(|a| (a + 1..100).map(move |b| [a, b])).collect();
        for limit in [0, 1, 700, 3000, 4950, usize::MAX] {
            let mut first = FirstPairs::new(limit);
            for k in 0..all.len() {
                let [a, b] = all[k * 1009 % all.len()];
                first.push(b, a);
                assert!(first.kept.len() <= limit.saturating_mul(2).max(LEAST_KEPT));
            }
            assert_eq!(first.sorted(), all[..limit.min(all.len())]);
        }
    }
}
