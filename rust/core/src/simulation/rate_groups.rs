//! The limit of the step, and the slow laws of a method with rate groups.

use std::f64::consts::PI;

use super::Simulation;
use crate::error::Result;
use crate::integrators::RateGroup;
use crate::laws::Instant;
use crate::laws::Law;
use crate::stability::{self, Limit};

/// A law is slow if its own limit is this many times that of all laws: its stiffness may grow by the square of this
/// before it limits the step. Laws are classified at the start, where laws that depend on velocity, such as drag, have
/// no limit in a scene at rest; `limit_at` therefore includes the limit of the slow laws.
const RESERVE: f64 = 10.0;
/// Largest default step, relative to half a period of the fastest mode.
const SHARE_OF_HALF_PERIOD: f64 = 0.9;

impl Simulation {
    /// The slow laws, evaluated once a step by a method with substeps.
    pub fn slow_laws(&self) -> impl Iterator<Item = &'static str> {
        self.mechanics.laws_of(RateGroup::Slow).into_iter().map(Law::name)
    }

    /// Classifies the laws by their own limits at the start.
    pub(super) fn find_slow_laws(&mut self) -> Result<()> {
        let Some(method) = self.integrator.for_slow_laws() else { return Ok(()) };
        let (at, inverse_masses) = (self.instant(), &self.mechanics.inverse_masses);
        let least = RESERVE * self.limit()?.dt;
        let mut is_slow = Vec::new();
        for law in &self.mechanics.laws {
            // The force of Coriolis belongs to the substeps, which take it exactly. Its rate is linear in time, zero
            // throughout if zero at two instants, or that of a schedule.
            let spin = &self.mechanics.spin;
            let rate = |frame| law.linearisation().map_or(0.0, |law| law.coriolis_rate(frame));
            let frames = [spin.at(0.0), spin.at(1.0), spin.fastest(spin.at(0.0))];
            let has_coriolis = frames.into_iter().any(|frame| rate(frame) != 0.0);
            let own = stability::limit(method.as_ref(), &[law.as_ref()], at, inverse_masses)?;
            is_slow.push(!has_coriolis && own.dt >= least);
        }
        self.mechanics.set_slow(is_slow);
        Ok(())
    }

    /// The largest default step: slow laws kick each fast mode more often than twice a period.
    pub(super) fn resonance_bound(&self, limit: &Limit) -> f64 {
        let has_groups = self.integrator.for_slow_laws().is_some() && limit.largest_frequency > 0.0;
        if has_groups { SHARE_OF_HALF_PERIOD * PI / limit.largest_frequency } else { f64::INFINITY }
    }

    /// The largest rate of the frame from now on, where a schedule tells it, or else the present one \[rad/s\].
    pub(super) fn frame_rate(&self) -> f64 {
        self.mechanics.spin.fastest(self.instant().frame).rate.abs()
    }

    /// The limit of the step at an instant: the smaller of the limits of fast and slow laws.
    pub(super) fn limit_at(&self, at: Instant<'_>) -> Result<Limit> {
        let at = Instant { frame: self.mechanics.spin.fastest(at.frame), ..at };
        let inverse_masses = &self.mechanics.inverse_masses;
        let fast =
            stability::limit(self.integrator.as_ref(), &self.mechanics.laws_of(RateGroup::Fast), at, inverse_masses)?;
        let Some(method) = self.integrator.for_slow_laws() else { return Ok(fast) };
        let slow = stability::limit(method.as_ref(), &self.mechanics.laws_of(RateGroup::Slow), at, inverse_masses)?;
        Ok(if slow.dt < fast.dt { slow } else { fast })
    }
}
