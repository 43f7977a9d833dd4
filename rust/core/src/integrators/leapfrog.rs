//! Leapfrog, also called velocity Verlet (Verlet 1967; Swope et al. 1982), for x' = v, v' = a(t, x, v):
//!
//!     v_h = v_n + dt/2 a_n                           half a kick
//!     x_n+1 = x_n + dt v_h                           drift
//!     p = v_n + dt a_n                               predicted velocity, error O(dt^2)
//!     a_n+1 = a(t_n+1, x_n+1, p) + w J (v_n+1 - p)
//!     v_n+1 = v_h + dt/2 a_n+1                       half a kick
//!
//! One evaluation a step. Forces that depend on velocity are evaluated with p, at order 2: on x' = -c x the scheme is
//! that of Adams and Bashforth. The acceleration of Coriolis, w J v with J v = (v_y, -v_x, 0), is instead taken at
//! v_n+1 itself. The two equations per node have a closed solution, with h = w dt/2 and d = v_n+1 - p:
//!
//!     (1 - h J) d = v_h + dt/2 a(t_n+1, x_n+1, p) - p = r,    d = (r + h J r) / (1 + h^2)
//!
//! This is the method of Boris (1970): the force does no work on the mean of two half-step velocities, so that the
//! energy in a turning frame remains bounded too (Hairer and Lubich 2018). Evaluated with p it would drift.
//!
//! Limits: 2 on the imaginary axis, 1 on the negative real one. With both, a damping ratio zeta leaves
//! omega dt <= 2 (sqrt(4 zeta^2 + 1) - 2 zeta), that is dt^2 omega^2 + 4 dt c = 4 with c = 2 zeta omega. At this limit
//! a mode changes sign from step to step: K u + 4/dt C u = 4/dt^2 u. For forces linear in x and without damping
//!
//!     m/2 (v_n^2 - dt^2/4 a_n^2) + U(x_n) = m/2 v_n-1/2 . v_n+1/2 + U(x_n)
//!
//! is conserved (the modified energy). The energy oscillates about it by (omega dt)^2/4 of the potential energy,
//! without drift. The work of laws is integrated by the trapezoidal rule. The power of a force evaluated with p is its
//! product with v_n: its sum is the change of the modified energy by the kicks, step by step.
//! Impulses, of laws that have them, change v_n before the drift, at the end of the step before.
//!
//! Storage: one vector per node beside the state. p replaces v_n until v_n+1 = p + d is known;
//! r is dt/2 (a(t_n+1, x_n+1, p) - a_n).

use super::kick_drift::{Drift, End, RowDrift, add_work, amplification, begin, energy_shift};
use super::{Integrator, Kick, Options, Properties, System, saved_works};
use crate::arrays::history::History;
use crate::arrays::state::{NodeVectors, State};
use crate::simd::dispatch::InstructionSet;

/// The method and its history.
struct Leapfrog {
    /// a_n, and the power of each law there.
    acceleration: NodeVectors,
    powers: Vec<f64>,
    /// Work array for the power of laws along links with the corrected velocities.
    exact_powers: Vec<f64>,
    is_started: bool,
    instructions: InstructionSet,
}

/// Properties of leapfrog without substeps.
pub(super) const PROPERTIES: Properties = Properties {
    evaluations_at_start: 1,
    conserves_energy: true,
    predicts_velocity: true,
    damping_weight: Some(4.0),
    ..Properties::explicit("leapfrog", 2, 1, (1.0 / 24.0, 2))
};

/// The method for a scene, without substeps.
pub(super) fn make(options: &Options) -> Box<dyn Integrator> {
    Box::new(Leapfrog {
        acceleration: NodeVectors::zeros(options.nodes),
        powers: vec![0.0; options.works],
        exact_powers: vec![0.0; options.works],
        is_started: false,
        instructions: options.instructions,
    })
}

impl Leapfrog {
    /// Gives the impulses for the drift of the next step; powers are then those on the velocities after them.
    fn give_impulses(&mut self, system: &mut dyn System, time: f64, dt: f64, state: &mut State, work: &mut [f64]) {
        if !system.has_impulses() {
            return;
        }
        let Self { acceleration, powers, exact_powers, .. } = self;
        let rate = system.coriolis_rate(time);
        let kick = Kick { time, dt, rate, state: &mut *state, accelerations: acceleration, slow: None };
        if system.give_impulses(kick, work) {
            system.power_at(state.at(time), exact_powers, powers);
            system.load_power_at(state.at(time), powers);
        }
    }
}

impl Integrator for Leapfrog {
    fn properties(&self) -> Properties {
        PROPERTIES
    }

    fn amplification(&self, omega: f64, damping: f64, dt: f64) -> f64 {
        amplification(omega, damping, dt)
    }

    fn is_started(&self) -> bool {
        self.is_started
    }

    fn start(&mut self, system: &mut dyn System, time: f64, dt: f64, state: &mut State, work: &mut [f64]) {
        begin(system, state.at(time), &mut self.acceleration, &mut self.powers);
        self.is_started = true;
        self.give_impulses(system, time, dt, state, work);
    }

    fn takes_impulses(&self) -> bool {
        true
    }

    fn step(&mut self, system: &mut dyn System, time: f64, dt: f64, state: &mut State, work: &mut [f64]) {
        let half = 0.5 * dt;
        let Self { acceleration, powers, exact_powers, instructions, .. } = self;
        add_work(work, half, powers);
        let end = End { time: time + dt, half, accelerations: acceleration, powers, instructions: *instructions };
        let drift = RowDrift { drift: Drift::alone(dt), slow: None };
        end.correct(system, state, Some(&drift), None, Some(exact_powers));
        add_work(work, half, powers);
        self.give_impulses(system, time + dt, dt, state, work);
    }

    fn energy_shift(&self, masses: &[f64], dt: f64) -> f64 {
        energy_shift(&self.acceleration, masses, dt)
    }

    fn history(&self) -> History {
        if !self.is_started {
            return History::default();
        }
        History { vectors: vec![self.acceleration.clone()], numbers: self.powers.clone() }
    }

    fn restore_history(&mut self, history: History) -> bool {
        self.is_started = !history.vectors.is_empty();
        if !self.is_started {
            return history.numbers.is_empty();
        }
        let Some(works) = saved_works(self.powers.len(), history.numbers.len(), 1, 0) else { return false };
        let fits = history.vectors.len() == 1;
        if fits {
            self.acceleration.copy_from(&history.vectors[0]);
            self.powers.fill(0.0);
            self.powers[..works].copy_from_slice(&history.numbers);
        }
        fits
    }
}
