//! What contact has spent.

use std::time::{Duration, Instant};

/// Pairs, and processor time while nothing else runs, over all steps since the law was made.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ContactStatistics {
    /// Pairs of the lists that were looked at.
    pub looked_at: u64,
    /// Pairs that would have come too near.
    pub near: u64,
    /// Pairs with an impulse.
    pub pressed: u64,
    /// Time spent on lists of pairs.
    pub lists: Duration,
    /// Time spent on looking at pairs.
    pub looks: Duration,
    /// Time spent on impulses.
    pub impulses: Duration,
}

impl ContactStatistics {
    /// Adds a step that began at some time, with its pairs. Its time is that of impulses, but for what lists and looks
    /// have had since: `others` is what they had had before.
    pub(super) fn add_step(&mut self, began: Instant, others: Duration, near: usize, pressed: usize) {
        self.near += near as u64;
        self.pressed += pressed as u64;
        self.impulses += began.elapsed().saturating_sub(self.others().saturating_sub(others));
    }

    /// Time spent on lists and looks.
    pub(super) fn others(&self) -> Duration {
        self.lists + self.looks
    }
}
