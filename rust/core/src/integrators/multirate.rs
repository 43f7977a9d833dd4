//! Leapfrog with substeps, also called r-RESPA or the impulse method (Grubmueller et al. 1991; Tuckerman, Berne and
//! Martyna 1992): slow laws s are evaluated once a step of length h, fast laws f once a substep of length dt = h/m.
//! With b_k = f_k, and b_k = f_k + m s_k at the ends of the step,
//!
//!     v_k+1/2 = v_k + dt/2 b_k,    x_k+1 = x_k + dt v_k+1/2,    v_k+1 = v_k+1/2 + dt/2 b_k+1
//!
//! so that slow laws kick by h/2 s at both ends. Forces that depend on velocity are evaluated with the prediction
//! p = v_k+1/2 + dt/2 f_k, plus h/2 s_n at the end of the step. Its error is O(h^2), at which order 2 holds. The force
//! of Coriolis is taken at v_k+1 itself, as in `leapfrog`.
//!
//! `simulation::rate_groups` selects the slow laws: those that alone would allow a step many times as long.
//! Limits: m times those of leapfrog for fast laws. Beyond h omega = pi, half a period of a fast mode, the kicks of
//! slow laws can be in resonance with that mode and excite it unless damping dissipates more; the default
//! step stays below.
//! Storage: two vectors per node beside the state.

use super::kick_drift::{Drift, End, amplification, begin, energy_shift};
use super::{Integrator, Options, Properties, RateGroup, System, leapfrog, saved_works};
use crate::arrays::blocks::{ROW_BLOCK, row_blocks, rows_of, tiles};
use crate::arrays::history::History;
use crate::arrays::state::{NodeVectors, PhasePoint, State, rows, rows_mut};
use crate::simd::dispatch::InstructionSet;
use crate::simd::lanes::SimdF64;
use crate::simd::map::{Formula, each, on_axes};

/// The method and its history.
struct Multirate {
    /// m.
    count: u32,
    /// f_n and s_n, and the power of each law there.
    fast: NodeVectors,
    slow: NodeVectors,
    fast_powers: Vec<f64>,
    slow_powers: Vec<f64>,
    is_started: bool,
    /// Accelerations of one row block.
    row_block: NodeVectors,
    instructions: InstructionSet,
}

/// The method for a scene, with more than one substep.
pub(super) fn make(options: &Options) -> Box<dyn Integrator> {
    debug_assert!(options.substeps > 1, "one substep is leapfrog");
    Box::new(Multirate {
        count: options.substeps,
        fast: NodeVectors::zeros(options.nodes),
        slow: NodeVectors::zeros(options.nodes),
        fast_powers: vec![0.0; options.works],
        slow_powers: vec![0.0; options.works],
        is_started: false,
        row_block: NodeVectors::zeros(ROW_BLOCK.min(options.nodes)),
        instructions: options.instructions,
    })
}

impl Multirate {
    /// Evaluates the slow laws at the end of a step. f_k - m (s' - s) replaces f_k, so that the correction of the last
    /// substep is that by b.
    fn evaluate_slow(&mut self, system: &mut dyn System, at: PhasePoint<'_>) {
        let Self { fast, slow, slow_powers, row_block, instructions, .. } = self;
        let shift = Shift { count: f64::from(self.count) };
        system.select_rate_group(RateGroup::Slow);
        let count = slow.nrows();
        for tile in tiles(count) {
            system.accumulate_forces(tile, at, slow_powers);
            for range in row_blocks(rows_of(tile, count)) {
                system.accelerations(range.clone(), at, rows_mut(row_block, 0..range.len()), slow_powers);
                let changed = [rows_mut(fast, range.clone()), rows_mut(slow, range.clone())];
                on_axes(*instructions, &shift, [rows(row_block, 0..range.len())], changed);
            }
        }
        system.select_rate_group(RateGroup::Fast);
    }

    /// Evaluates the fast laws at the end of a substep, and corrects its velocities.
    fn evaluate_fast(&mut self, system: &mut dyn System, time: f64, half: f64, state: &mut State) {
        let Self { fast, fast_powers, row_block, instructions, .. } = self;
        End { time, half, accelerations: fast, powers: fast_powers, row_block, instructions: *instructions }
            .correct(system, state);
    }
}

/// Drift and prediction with a kick of the slow forces before or after them.
struct KickedDrift {
    dt: f64,
    before: f64,
    after: f64,
}

impl Formula<2, 2> for KickedDrift {
    #[inline(always)]
    fn row<V: SimdF64>(&self, [fast, slow]: [V; 2], [x, v]: [V; 2]) -> [V; 2] {
        let half = V::all(0.5 * self.dt);
        let kicked = v + half * fast + V::all(self.before) * slow;
        [x + V::all(self.dt) * kicked, kicked + half * fast + V::all(self.after) * slow]
    }
}

/// f - m (s' - s) replaces f, and s' replaces s.
struct Shift {
    count: f64,
}

impl Formula<1, 2> for Shift {
    #[inline(always)]
    fn row<V: SimdF64>(&self, [new]: [V; 1], [fast, slow]: [V; 2]) -> [V; 2] {
        [fast - V::all(self.count) * (new - slow), new]
    }
}

impl Integrator for Multirate {
    fn properties(&self) -> Properties {
        Properties {
            evaluations_per_step: self.count,
            damping_weight: Some(4.0 * f64::from(self.count)),
            ..leapfrog::PROPERTIES
        }
    }

    fn for_slow_laws(&self) -> Option<Box<dyn Integrator>> {
        Some(leapfrog::make(&Options { nodes: 0, instructions: self.instructions, ..Options::default() }))
    }

    fn amplification(&self, omega: f64, damping: f64, dt: f64) -> f64 {
        amplification(omega, damping, dt / f64::from(self.count)).powi(self.count as i32)
    }

    fn is_started(&self) -> bool {
        self.is_started
    }

    fn start(&mut self, system: &mut dyn System, time: f64, state: &State) {
        let at = state.at(time);
        let groups = [
            (RateGroup::Slow, &mut self.slow, &mut self.slow_powers),
            (RateGroup::Fast, &mut self.fast, &mut self.fast_powers),
        ];
        for (group, accelerations, powers) in groups {
            system.select_rate_group(group);
            begin(system, at, accelerations, powers);
        }
        self.is_started = true;
    }

    fn step(&mut self, system: &mut dyn System, time: f64, dt: f64, state: &mut State, work: &mut [f64]) {
        let (substep, kick) = (dt / f64::from(self.count), 0.5 * dt);
        let mut add_work = |weight: f64, powers: &[f64]| {
            work.iter_mut().zip(powers).for_each(|(work, power)| *work += weight * power);
        };
        system.select_rate_group(RateGroup::Fast);
        add_work(kick, &self.slow_powers);
        for k in 1..=self.count {
            let is_last = k == self.count;
            let now = if is_last { time + dt } else { time + f64::from(k) * substep };
            add_work(0.5 * substep, &self.fast_powers);
            let changed = [state.positions.as_mut_slice(), state.velocities.as_mut_slice()];
            if k == 1 || is_last {
                let (before, after) = if is_last { (0.0, kick) } else { (kick, 0.0) };
                let drift = KickedDrift { dt: substep, before, after };
                each(self.instructions, &drift, [self.fast.as_slice(), self.slow.as_slice()], changed);
            } else {
                each(self.instructions, &Drift { dt: substep }, [self.fast.as_slice()], changed);
            }
            if is_last {
                self.evaluate_slow(system, state.at(now));
            }
            self.evaluate_fast(system, now, 0.5 * substep, state);
            add_work(0.5 * substep, &self.fast_powers);
        }
        system.select_rate_group(RateGroup::Slow);
        for range in row_blocks(0..self.slow.nrows()) {
            system.row_power_at(range.clone(), rows(&state.velocities, range), &mut self.slow_powers);
        }
        system.power_at(state.at(time + dt), &mut self.slow_powers);
        add_work(kick, &self.slow_powers);
    }

    fn energy_shift(&self, masses: &[f64], dt: f64) -> f64 {
        energy_shift(&self.fast, masses, dt / f64::from(self.count))
    }

    fn history(&self) -> History {
        if !self.is_started {
            return History::default();
        }
        let numbers = self.fast_powers.iter().chain(&self.slow_powers).copied().collect();
        History { vectors: vec![self.fast.clone(), self.slow.clone()], numbers }
    }

    fn restore_history(&mut self, history: History) -> bool {
        self.is_started = !history.vectors.is_empty();
        if !self.is_started {
            return history.numbers.is_empty();
        }
        let Some(works) = saved_works(self.fast_powers.len(), history.numbers.len(), 2, 0) else { return false };
        let fits = history.vectors.len() == 2;
        if fits {
            self.fast.copy_from(&history.vectors[0]);
            self.slow.copy_from(&history.vectors[1]);
            let (fast, slow) = history.numbers.split_at(works);
            for (powers, saved) in [(&mut self.fast_powers, fast), (&mut self.slow_powers, slow)] {
                powers.fill(0.0);
                powers[..works].copy_from_slice(saved);
            }
        }
        fits
    }
}
