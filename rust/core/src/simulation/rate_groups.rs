//! The limit of the step; and which laws are slow, for a method that tells laws apart by their pace.

use std::f64::consts::PI;

use super::Simulation;
use crate::arrays::state::Instant;
use crate::error::Result;
use crate::laws::Law;
use crate::stability::{self, Limit};

/// A law is slow if alone it would allow a step so many times as long as the method's limit: its stiffness may grow by the
/// square of that before it limits the step. It is asked at the start: what depends on speed, such as drag, allows any step to
/// a scene at rest, and its own limit is looked at with every limit that is asked for later.
const RESERVE: f64 = 10.0;
/// Of half a period of the fastest mode, what a step takes at most where none is given.
const SHARE_OF_HALF_PERIOD: f64 = 0.9;

impl Simulation {
    /// The laws that are evaluated once a step by a method that takes others at shorter steps.
    pub fn slow_laws(&self) -> impl Iterator<Item = &'static str> {
        self.laws_of_pace(true).into_iter().map(Law::name)
    }

    /// Finds the slow laws by their own limits at the start.
    pub(super) fn tell_apart(&mut self) -> Result<()> {
        let Some(method) = self.integrator.for_slow_laws() else { return Ok(()) };
        let (laws, at, inverse_masses) = (&self.mechanics.laws, self.instant(), &self.mechanics.inverse_masses);
        let least = RESERVE * self.limit()?.dt;
        let mut is_slow = Vec::new();
        for law in laws {
            // Gyration goes linearly with time: none at two instants is none at all. What has_coriolis is taken exactly, by
            // the short steps.
            let has_coriolis = [0.0, 1.0].iter().any(|time| law.coriolis_rate(*time) != 0.0);
            let own = stability::limit(method.as_ref(), &[law.as_ref()], at, inverse_masses)?;
            is_slow.push(!has_coriolis && own.dt >= least);
        }
        // Springs and dashpots go through one pass.
        let is_net = |law: &dyn Law| law.springs().is_some() || law.dashpots().is_some();
        let networks: Vec<usize> = (0..laws.len()).filter(|&row| is_net(laws[row].as_ref())).collect();
        if networks.iter().any(|&row| !is_slow[row]) {
            networks.iter().for_each(|&row| is_slow[row] = false);
        }
        self.mechanics.is_slow = is_slow;
        Ok(())
    }

    /// The longest step that is taken unasked: slow laws kick each fast mode more often than twice a period.
    pub(super) fn in_rest(&self, limit: &Limit) -> f64 {
        let is_divided = self.integrator.for_slow_laws().is_some() && limit.largest_frequency > 0.0;
        if is_divided { SHARE_OF_HALF_PERIOD * PI / limit.largest_frequency } else { f64::INFINITY }
    }

    fn laws_of_pace(&self, slow: bool) -> Vec<&dyn Law> {
        let laws = self.mechanics.laws.iter().zip(&self.mechanics.is_slow);
        laws.filter(|(_, is_slow)| **is_slow == slow).map(|(law, _)| law.as_ref()).collect()
    }

    /// The limit of the step at an instant: the smaller of those of fast and of slow laws.
    pub(super) fn limit_at(&self, at: Instant<'_>) -> Result<Limit> {
        let inverse_masses = &self.mechanics.inverse_masses;
        let fast = stability::limit(self.integrator.as_ref(), &self.laws_of_pace(false), at, inverse_masses)?;
        let Some(method) = self.integrator.for_slow_laws() else { return Ok(fast) };
        let slow = stability::limit(method.as_ref(), &self.laws_of_pace(true), at, inverse_masses)?;
        Ok(if slow.dt < fast.dt { slow } else { fast })
    }
}
