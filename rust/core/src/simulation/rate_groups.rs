//! The limit of the step; and which laws are slow, for a method that tells laws apart by their rate.

use std::f64::consts::PI;

use super::Simulation;
use crate::error::Result;
use crate::integrators::RateGroup;
use crate::laws::Instant;
use crate::laws::Law;
use crate::stability::{self, Limit};

/// A law is slow if alone it would allow a step so many times as long as the method's limit: its stiffness may grow by the
/// square of that before it limits the step. It is asked at the start: what depends on speed, such as drag, allows any step to
/// a scene at rest, and its own limit is looked at with every limit that is asked for later.
const RESERVE: f64 = 10.0;
/// Of half a period of the fastest mode, what a step takes at most where none is given.
const SHARE_OF_HALF_PERIOD: f64 = 0.9;

impl Simulation {
    /// The laws that are evaluated once a step by a method that takes others in substeps.
    pub fn slow_laws(&self) -> impl Iterator<Item = &'static str> {
        self.mechanics.laws_of(RateGroup::Slow).into_iter().map(Law::name)
    }

    /// Finds the slow laws by their own limits at the start.
    pub(super) fn find_slow_laws(&mut self) -> Result<()> {
        let Some(method) = self.integrator.for_slow_laws() else { return Ok(()) };
        let (at, inverse_masses) = (self.instant(), &self.mechanics.inverse_masses);
        let least = RESERVE * self.limit()?.dt;
        let mut is_slow = Vec::new();
        for law in &self.mechanics.laws {
            // The rate of Coriolis goes linearly with time: none at two instants is none at all. It is taken exactly, by the
            // substeps.
            let rate = |time| law.linearisation().map_or(0.0, |law| law.coriolis_rate(self.mechanics.spin.at(time)));
            let has_coriolis = [0.0, 1.0].into_iter().any(|time| rate(time) != 0.0);
            let own = stability::limit(method.as_ref(), &[law.as_ref()], at, inverse_masses)?;
            is_slow.push(!has_coriolis && own.dt >= least);
        }
        self.mechanics.set_slow(is_slow);
        Ok(())
    }

    /// The longest step that is taken unasked: slow laws kick each fast mode more often than twice a period.
    pub(super) fn resonance_bound(&self, limit: &Limit) -> f64 {
        let is_divided = self.integrator.for_slow_laws().is_some() && limit.largest_frequency > 0.0;
        if is_divided { SHARE_OF_HALF_PERIOD * PI / limit.largest_frequency } else { f64::INFINITY }
    }

    /// The limit of the step at an instant: the smaller of those of fast and of slow laws.
    pub(super) fn limit_at(&self, at: Instant<'_>) -> Result<Limit> {
        let inverse_masses = &self.mechanics.inverse_masses;
        let fast =
            stability::limit(self.integrator.as_ref(), &self.mechanics.laws_of(RateGroup::Fast), at, inverse_masses)?;
        let Some(method) = self.integrator.for_slow_laws() else { return Ok(fast) };
        let slow = stability::limit(method.as_ref(), &self.mechanics.laws_of(RateGroup::Slow), at, inverse_masses)?;
        Ok(if slow.dt < fast.dt { slow } else { fast })
    }
}
