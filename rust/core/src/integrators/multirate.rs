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
//! Work: the trapezoidal rule, over substeps for fast laws and over steps for slow ones. The power of dashpots along
//! links on the velocities themselves, P_k, takes a second pass over the links; that on the predicted velocities, Q_k,
//! costs nothing. P is therefore evaluated at the ends of steps only:
//!
//!     W = dt sum' Q_k + h sum' D_n,    D_n = P_n - Q_n = O(dt^2)
//!
//! where each sum' takes its first and last term by half. At a start velocities are not predicted, so that D would be
//! 0: the first step has P_k throughout. The work lost by a mode of frequency omega and damping ratio zeta is wrong by
//! less than (omega dt)^2/4 of its energy, the oscillation of leapfrog's energy, for h omega up to 2, and by less than
//! zeta times that up to 1. Near h omega = pi, where all ends of steps meet the mode at one phase, it is wrong by up to
//! twice as much. The sign depends on the phase: over many modes the errors cancel. The motion is the same.
//!
//! Row blocks drift to the next substep in the pass that corrects their velocities.
//!
//! `simulation::rate_groups` selects the slow laws: those that alone would allow a step many times as long.
//! Limits: m times those of leapfrog for fast laws. Beyond h omega = pi, half a period of a fast mode, the kicks of
//! slow laws can be in resonance with that mode and excite it unless damping dissipates more; the default
//! step stays below.
//! Storage: two vectors per node beside the state.

use super::kick_drift::{Drift, End, RowDrift, add_work, amplification, begin, energy_shift};
use super::{Integrator, Kick, NetForces, Options, Properties, RateGroup, System, leapfrog, saved_works};
use crate::arrays::blocks::{row_blocks, rows_of, tiles};
use crate::arrays::history::History;
use crate::arrays::state::{NodeVectors, PhasePoint, State, rows, rows_mut};
use crate::simd::dispatch::InstructionSet;
use crate::simd::lanes::SimdF64;
use crate::simd::map::{Formula, on_axes};

/// Last number of a history before the first step.
const FIRST: f64 = 1.0;

/// The method and its history.
struct Multirate {
    /// m.
    count: u32,
    /// f_n and s_n.
    fast: NodeVectors,
    slow: NodeVectors,
    /// The power of each fast law in the last evaluation; the power that is integrated once a step, that of slow laws
    /// and the corrections; and the corrections D_n alone.
    fast_powers: Vec<f64>,
    step_powers: Vec<f64>,
    corrections: Vec<f64>,
    /// Work array for the power of laws along links with the corrected velocities.
    exact_powers: Vec<f64>,
    /// Whether the next step is the first since a start.
    is_first: bool,
    is_started: bool,
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
        step_powers: vec![0.0; options.works],
        corrections: vec![0.0; options.works],
        exact_powers: vec![0.0; options.works],
        is_first: false,
        is_started: false,
        instructions: options.instructions,
    })
}

impl Multirate {
    /// Evaluates the slow laws at the end of a step. f_k - m (s' - s) replaces f_k, so that the correction of the last
    /// substep is that by b.
    fn evaluate_slow(&mut self, system: &mut dyn System, at: PhasePoint<'_>) {
        let Self { fast, slow, step_powers, instructions, .. } = self;
        let shift = Shift { count: f64::from(self.count) };
        system.select_rate_group(RateGroup::Slow);
        let count = slow.nrows();
        for tile in tiles(count) {
            system.accumulate_forces(tile, at, step_powers);
            for range in row_blocks(rows_of(tile, count)) {
                let NetForces { forces, factors } = system.net_forces(range.clone(), at, step_powers);
                let changed = [rows_mut(fast, range.clone()), rows_mut(slow, range), forces];
                on_axes(*instructions, &shift, [[factors; 3]], changed);
            }
        }
        system.select_rate_group(RateGroup::Fast);
    }

    /// Evaluates the power of the slow laws and the corrections of the fast ones with the velocities at the end of a
    /// step.
    fn evaluate_step_powers(&mut self, system: &mut dyn System, at: PhasePoint<'_>) {
        let Self { fast_powers, step_powers, corrections, exact_powers, .. } = self;
        corrections.copy_from_slice(fast_powers);
        system.power_at(at, exact_powers, corrections);
        corrections.iter_mut().zip(fast_powers).for_each(|(exact, fast)| *exact -= *fast);
        system.select_rate_group(RateGroup::Slow);
        for range in row_blocks(0..at.velocities.nrows()) {
            system.row_power_at(range.clone(), rows(at.velocities, range), step_powers);
        }
        system.power_at(at, exact_powers, step_powers);
        add_work(step_powers, 1.0, corrections);
    }
}

impl Multirate {
    /// Gives the impulses for the drift of the next substep, with a kick of slow accelerations before it.
    fn give_impulses(
        &mut self,
        system: &mut dyn System,
        time: f64,
        [dt, before]: [f64; 2],
        state: &mut State,
        work: &mut [f64],
    ) {
        let rate = system.coriolis_rate(time);
        let Self { fast, slow, fast_powers, step_powers, .. } = self;
        let slow = Some((&*slow, before));
        if system.give_impulses(Kick { time, dt, rate, state: &mut *state, accelerations: fast, slow }, work) {
            system.select_rate_group(RateGroup::Fast);
            system.load_power_at(state.at(time), fast_powers);
            if before > 0.0 {
                system.select_rate_group(RateGroup::Slow);
                system.load_power_at(state.at(time), step_powers);
                system.select_rate_group(RateGroup::Fast);
            }
        }
    }
}

/// f - m (s' - s) replaces f, s' = F/m replaces s, and zero replaces F.
struct Shift {
    count: f64,
}

impl Formula<1, 3> for Shift {
    #[inline(always)]
    fn row<V: SimdF64>(&self, [factor]: [V; 1], [fast, slow, force]: [V; 3]) -> [V; 3] {
        let new = force * factor;
        [fast - V::all(self.count) * (new - slow), new, V::zero()]
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

    fn takes_impulses(&self) -> bool {
        true
    }

    fn start(&mut self, system: &mut dyn System, time: f64, dt: f64, state: &mut State, work: &mut [f64]) {
        let at = state.at(time);
        let groups = [
            (RateGroup::Slow, &mut self.slow, &mut self.step_powers),
            (RateGroup::Fast, &mut self.fast, &mut self.fast_powers),
        ];
        for (group, accelerations, powers) in groups {
            system.select_rate_group(group);
            begin(system, at, accelerations, powers);
        }
        (self.is_started, self.is_first) = (true, true);
        self.give_impulses(system, time, [dt / f64::from(self.count), 0.5 * dt], state, work);
    }

    fn step(&mut self, system: &mut dyn System, time: f64, dt: f64, state: &mut State, work: &mut [f64]) {
        let (substep, kick) = (dt / f64::from(self.count), 0.5 * dt);
        let (is_first, has_impulses) = (std::mem::take(&mut self.is_first), system.has_impulses());
        system.select_rate_group(RateGroup::Fast);
        add_work(work, kick, &self.step_powers);
        for k in 1..=self.count {
            let is_last = k == self.count;
            let now = if is_last { time + dt } else { time + f64::from(k) * substep };
            add_work(work, 0.5 * substep, &self.fast_powers);
            system.expect_power_at(is_first || is_last);
            if is_last {
                self.evaluate_slow(system, state.at(now));
            }
            let Self { fast, slow, fast_powers, exact_powers, instructions, .. } = self;
            let (accelerations, powers, instructions) = (&mut *fast, &mut *fast_powers, *instructions);
            let alone = Drift::alone(substep);
            let kicked = |drift| RowDrift { drift, slow: Some(&*slow) };
            let first = (k == 1).then(|| kicked(Drift { before: kick, ..alone }));
            let is_next_last = k + 1 == self.count;
            let next = if is_next_last {
                kicked(Drift { after: kick, ..alone })
            } else {
                RowDrift { drift: alone, slow: None }
            };
            let end = End { time: now, half: 0.5 * substep, accelerations, powers, instructions };
            let is_apart = is_first || has_impulses;
            end.correct(system, state, first.as_ref(), (!is_apart && !is_last).then_some(&next), None);
            if is_first && !is_last {
                system.power_at(state.at(now), exact_powers, fast_powers);
            }
            add_work(work, 0.5 * substep, &self.fast_powers);
            if has_impulses && !is_last {
                self.give_impulses(system, now, [substep, 0.0], state, work);
            }
            if is_apart && !is_last {
                let next = if is_next_last {
                    RowDrift { drift: Drift { after: kick, ..alone }, slow: Some(&self.slow) }
                } else {
                    RowDrift { drift: alone, slow: None }
                };
                row_blocks(0..self.fast.nrows()).for_each(|range| next.run(instructions, range, &self.fast, state));
            }
        }
        self.evaluate_step_powers(system, state.at(time + dt));
        add_work(work, kick, &self.step_powers);
        if has_impulses {
            self.give_impulses(system, time + dt, [substep, kick], state, work);
        }
        if is_first {
            add_work(work, 0.5 * substep - kick, &self.corrections);
        }
    }

    fn energy_shift(&self, masses: &[f64], dt: f64) -> f64 {
        energy_shift(&self.fast, masses, dt / f64::from(self.count))
    }

    fn history(&self) -> History {
        if !self.is_started {
            return History::default();
        }
        let powers = self.fast_powers.iter().chain(&self.step_powers).copied();
        let numbers = powers.chain(self.is_first.then_some(FIRST)).collect();
        History { vectors: vec![self.fast.clone(), self.slow.clone()], numbers }
    }

    fn restore_history(&mut self, history: History) -> bool {
        self.is_started = !history.vectors.is_empty();
        if !self.is_started {
            return history.numbers.is_empty();
        }
        self.is_first = history.numbers.len() % 2 == 1;
        let others = usize::from(self.is_first);
        let Some(works) = saved_works(self.fast_powers.len(), history.numbers.len(), 2, others) else { return false };
        let fits = history.vectors.len() == 2;
        if fits {
            self.fast.copy_from(&history.vectors[0]);
            self.slow.copy_from(&history.vectors[1]);
            let (fast, step) = history.numbers[..2 * works].split_at(works);
            for (powers, saved) in [(&mut self.fast_powers, fast), (&mut self.step_powers, step)] {
                powers.fill(0.0);
                powers[..works].copy_from_slice(saved);
            }
        }
        fits
    }
}
