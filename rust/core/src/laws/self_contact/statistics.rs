//! What contact has spent.

use std::time::{Duration, Instant};

/// Pairs, steps, and elapsed time, over all steps since the law was made.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ContactStatistics {
    /// Pairs of the lists that were looked at.
    pub looked_at: u64,
    /// Pairs that would have come too near.
    pub near: u64,
    /// Pairs with an impulse.
    pub pressed: u64,
    /// Steps in which nodes moved as a rigid body.
    pub rigid: u64,
    /// Exact checks for crossings.
    pub checks: u64,
    /// Time spent on lists of pairs.
    pub list_time: Duration,
    /// Time spent on looking at pairs.
    pub look_time: Duration,
    /// Time spent on impulses, and on all that is not listed.
    pub impulse_time: Duration,
    /// Time spent on exact checks.
    pub check_time: Duration,
}

impl ContactStatistics {
    /// Adds what a step has spent since it began, but for what lists and looks have had since they had had `others`.
    pub(super) fn add_impulses(&mut self, began: Instant, others: Duration) {
        self.impulse_time += began.elapsed().saturating_sub(self.others().saturating_sub(others));
    }

    /// Time spent on lists and looks.
    pub(super) fn others(&self) -> Duration {
        self.list_time + self.look_time
    }
}
