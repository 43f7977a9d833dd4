//! The instant of an evaluation of laws: motion and frame.

use crate::arrays::state::{NodeVectors, PhasePoint};
use crate::model::frame::{Frame, Spin};

/// Motion and frame at a time.
#[derive(Debug, Clone, Copy)]
pub struct Instant<'a> {
    /// Time, or the instant at which the hub is frozen \[s\].
    pub time: f64,
    /// The frame that turns with the hub.
    pub frame: Frame,
    /// Positions \[m\].
    pub positions: &'a NodeVectors,
    /// Velocities relative to the frame \[m/s\].
    pub velocities: &'a NodeVectors,
}

impl<'a> Instant<'a> {
    /// The instant of a point, in the frame of a hub with this motion.
    #[inline]
    pub fn new(point: PhasePoint<'a>, spin: &Spin) -> Self {
        let PhasePoint { time, positions, velocities } = point;
        Self { time: spin.time_of(time), frame: spin.at(time), positions, velocities }
    }
}
