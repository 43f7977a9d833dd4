//! The factor of a load as a function of time.

use serde::Deserialize;

use super::schedule::Schedule;

/// By what a load is multiplied: 1, or a schedule.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(transparent)]
pub struct Factor(Option<Schedule>);

impl From<Schedule> for Factor {
    fn from(schedule: Schedule) -> Self {
        Self(Some(schedule))
    }
}

impl Factor {
    /// One that changes with time, for tests.
    pub(crate) fn example() -> Self {
        Self(Schedule::new(vec![0.0, 1.0], vec![1.0, 1.5], 0.2).ok())
    }

    /// Its value at `time`.
    pub fn value(&self, time: f64) -> f64 {
        self.0.as_ref().map_or(1.0, |schedule| schedule.value(time))
    }

    /// The times at which it jumps \[s\].
    pub fn jumps(&self) -> Vec<f64> {
        self.0.iter().flat_map(Schedule::jumps).collect()
    }

    /// Whether it changes with time.
    pub fn varies(&self) -> bool {
        self.0.as_ref().is_some_and(Schedule::varies)
    }
}
