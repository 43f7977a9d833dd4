//! Which pairs are due in a sweep: those with a node that has changed since their turn.

/// Nodes of a pair.
const CORNERS: usize = 4;

/// Pairs by their places, and those of each node.
#[derive(Default)]
pub(super) struct Due {
    /// Where the pairs of each node end in `pairs`, those of one node after those of the one before.
    ends: Vec<u32>,
    pairs: Vec<u32>,
    /// One bit a pair.
    bits: Vec<u64>,
}

impl Due {
    pub(super) fn new(nodes: usize) -> Self {
        Self { ends: vec![0; nodes + 1], ..Self::default() }
    }

    /// Takes up the pairs with these nodes, none of which is due.
    pub(super) fn take_up(&mut self, pairs: impl ExactSizeIterator<Item = [usize; CORNERS]> + Clone) {
        self.bits.clear();
        self.bits.resize(pairs.len().div_ceil(64), 0);
        self.pairs.resize(CORNERS * pairs.len(), 0);
        self.ends.fill(0);
        pairs.clone().flatten().for_each(|node| self.ends[node + 1] += 1);
        let mut end = 0;
        for count in &mut self.ends {
            end += *count;
            *count = end;
        }
        // The places where pairs of each node begin become those where they end.
        for (pair, nodes) in (0..).zip(pairs) {
            for node in nodes {
                let place = &mut self.ends[node];
                self.pairs[*place as usize] = pair;
                *place += 1;
            }
        }
    }

    /// Makes a pair due.
    pub(super) fn add(&mut self, pair: usize) {
        self.bits[pair / 64] |= 1 << (pair % 64);
    }

    /// Makes all pairs of a node due.
    pub(super) fn add_of(&mut self, node: usize) {
        let begin = node.checked_sub(1).map_or(0, |before| self.ends[before]);
        for &pair in &self.pairs[begin as usize..self.ends[node] as usize] {
            self.bits[pair as usize / 64] |= 1 << (pair % 64);
        }
    }

    /// Makes a pair due no more.
    pub(super) fn remove(&mut self, pair: usize) {
        self.bits[pair / 64] &= !(1 << (pair % 64));
    }

    /// The first pair that is due, at a place or behind it, which is due no more.
    pub(super) fn take_from(&mut self, place: usize) -> Option<usize> {
        let (first, mut mask) = (place / 64, u64::MAX << (place % 64));
        for word in first..self.bits.len() {
            let due = self.bits[word] & mask;
            if due != 0 {
                let pair = 64 * word + due.trailing_zeros() as usize;
                self.remove(pair);
                return Some(pair);
            }
            mask = u64::MAX;
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(due: &mut Due) -> Vec<usize> {
        let mut place = 0;
        std::iter::from_fn(|| due.take_from(place).inspect(|pair| place = pair + 1)).collect()
    }

    #[test]
    fn a_node_makes_its_pairs_due() {
        let mut due = Due::new(500);
        for shift in [0, 1] {
            due.take_up((0..130).map(|pair| [pair + shift, pair + 1 + shift, 200 + pair, 499]));
            assert_eq!(all(&mut due), []);
            due.add_of(64 + shift);
            due.remove(63);
            due.add_of(3 + shift);
            due.add(129);
            assert_eq!(all(&mut due), [2, 3, 64, 129]);
            due.add_of(499);
            due.remove(7);
            assert_eq!(due.take_from(128), Some(128));
            assert_eq!(all(&mut due).len(), 128);
            assert_eq!(all(&mut due), []);
        }
        due.take_up(std::iter::empty());
        due.add_of(499);
        assert_eq!(due.take_from(0), None);
    }
}
