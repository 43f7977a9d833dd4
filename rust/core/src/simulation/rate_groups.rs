//! The limit of the step, and the slow laws of a method with rate groups.

use std::f64::consts::PI;

use super::Simulation;
use crate::error::Result;
use crate::integrators::{Integrator, RateGroup};
use crate::laws::Instant;
use crate::laws::Law;
use crate::stability::{Accuracy, Limit, limit_to};

/// A law is slow if its own limit is this many times that of all laws: its stiffness may grow by the square of this
/// before it limits the step. Laws are classified at the start, where laws that depend on velocity, such as drag, have
/// no limit in a scene at rest; `limit_at` therefore includes the limit of the slow laws.
const RESERVE: f64 = 10.0;
/// A limit within 1 % tells whether a law is slow, or whether slow laws limit the step, where it is as many times
/// beyond the bound; otherwise the search is repeated to all digits.
const DECISIVE: f64 = 1.5;
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
        let (mut least, mut limits) = self.limits_of_laws(method.as_ref(), Accuracy::Percent)?;
        if limits.iter().any(|limit| !is_decisive(*limit, least)) {
            (least, limits) = self.limits_of_laws(method.as_ref(), self.accuracy())?;
        }
        let mut is_slow = Vec::new();
        for (law, limit) in self.mechanics.laws.iter().zip(limits) {
            // The force of Coriolis belongs to the substeps, which take it exactly. Its rate is linear in time, zero
            // throughout if zero at two instants, or that of a schedule.
            let spin = &self.mechanics.spin;
            let rate = |frame| law.linearisation().map_or(0.0, |law| law.coriolis_rate(frame));
            let frames = [spin.at(0.0), spin.at(1.0), spin.fastest(spin.at(0.0))];
            let has_coriolis = frames.into_iter().any(|frame| rate(frame) != 0.0);
            is_slow.push(!has_coriolis && limit >= least);
        }
        self.mechanics.set_slow(is_slow);
        Ok(())
    }

    /// The least limit of a slow law, and that of each law alone by their method \[s\].
    fn limits_of_laws(&self, method: &dyn Integrator, accuracy: Accuracy) -> Result<(f64, Vec<f64>)> {
        let (at, inverse_masses) = (self.instant(), &self.mechanics.inverse_masses);
        let fastest = Instant { frame: self.mechanics.spin.fastest(at.frame), ..at };
        let laws: Vec<&dyn Law> = self.mechanics.laws.iter().map(Box::as_ref).collect();
        let all = limit_to(accuracy, self.integrator.as_ref(), &laws, fastest, inverse_masses)?;
        let own = |law: &&dyn Law| Ok(limit_to(accuracy, method, &[*law], at, inverse_masses)?.dt);
        Ok((RESERVE * all.dt, laws.iter().map(own).collect::<Result<_>>()?))
    }

    /// The accuracy of a limit of this scene.
    fn accuracy(&self) -> Accuracy {
        Accuracy::of(self.mechanics.inverse_masses.len())
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
        let inverse_masses = &self.mechanics.inverse_masses_of_bounds(at.positions);
        let of = |method: &dyn Integrator, group, accuracy| {
            limit_to(accuracy, method, &self.mechanics.laws_of(group), at, inverse_masses)
        };
        let fast = of(self.integrator.as_ref(), RateGroup::Fast, self.accuracy())?;
        let Some(method) = self.integrator.for_slow_laws() else { return Ok(fast) };
        let slow = of(method.as_ref(), RateGroup::Slow, Accuracy::Percent)?;
        if slow.dt >= DECISIVE * fast.dt {
            return Ok(fast);
        }
        let slow = of(method.as_ref(), RateGroup::Slow, self.accuracy())?;
        Ok(if slow.dt < fast.dt { slow } else { fast })
    }
}

/// Whether a limit within 1 % tells on which side of a bound the limit itself is.
fn is_decisive(limit: f64, bound: f64) -> bool {
    limit >= DECISIVE * bound || limit * DECISIVE <= bound
}
