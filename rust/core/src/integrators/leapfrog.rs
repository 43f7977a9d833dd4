//! Leapfrog, also called velocity Verlet (Verlet 1967; Swope et al. 1982), for x' = v, v' = a(t, x, v):
//!
//!     v_h = v_n + dt/2 a_n                           half a kick
//!     x_n+1 = x_n + dt v_h                           drift
//!     p = v_n + dt a_n                               a velocity to evaluate with, good to dt^2
//!     a_n+1 = a(t_n+1, x_n+1, p) + w J (v_n+1 - p)
//!     v_n+1 = v_h + dt/2 a_n+1                       half a kick
//!
//! One evaluation a step. Forces that depend on velocity see p, which keeps order 2: on x' = -c x the scheme is that of
//! Adams and Bashforth. The force of Coriolis, w J v with J v = (v_y, -v_x, 0), is instead taken at v_n+1 itself; the two
//! equations per node are solved in closed form, with h = w dt/2 and d = v_n+1 - p:
//!
//!     (1 - h J) d = v_h + dt/2 a(t_n+1, x_n+1, p) - p = r,    d = (r + h J r) / (1 + h^2)
//!
//! That is the method of Boris (1970): the force does no work on the mean of two half-step velocities, so the energy of
//! a turning scene stays bounded too (Hairer and Lubich 2018). With p in its place it would drift.
//!
//! Limits: 2 on the imaginary axis, 1 on the negative real one; with both, a damping ratio zeta leaves
//! omega dt <= 2 (sqrt(4 zeta^2 + 1) - 2 zeta), which is dt^2 omega^2 + 4 dt c = 4 with c = 2 zeta omega: there a step
//! turns a mode over, K u + 4/dt C u = 4/dt^2 u. Where forces are linear in x and without damping,
//!
//!     m/2 (v_n^2 - dt^2/4 a_n^2) + U(x_n) = m/2 v_n-1/2 . v_n+1/2 + U(x_n)
//!
//! is conserved: the energy swings about it by (omega dt)^2/4 of the potential energy, and does not drift.
//! The work of laws is integrated by the trapezoidal rule; that of a force evaluated with p is its product with v_n, which
//! is what the sum of kicks takes out of that quantity, step by step.
//! Storage: one vector per node beside the state, in which p takes the place of v_n until v_n+1 = p + d is known; r is
//! dt/2 (a(t_n+1, x_n+1, p) - a_n).

use nalgebra::Matrix3;

use super::multirate::Multirate;
use super::{History, Integrator, System};
use crate::arrays::blocks::{ROW_BLOCK, row_blocks, rows_of, tiles};
use crate::arrays::state::{Instant, NodeVectors, State, columns, rows, rows_mut};
use crate::simd::dispatch::InstructionSet;
use crate::simd::lanes::SimdF64;
use crate::simd::map::{Formula, each};

/// The method and what it keeps.
pub(super) struct Leapfrog {
    /// a_n, and each law's power with it.
    acceleration: NodeVectors,
    powers: Vec<f64>,
    is_started: bool,
    /// a_n+1 of one stretch of nodes.
    stretch: NodeVectors,
    width: InstructionSet,
}

impl Leapfrog {
    pub(super) fn new(nodes: usize, laws: usize, width: InstructionSet) -> Self {
        Self {
            acceleration: NodeVectors::zeros(nodes),
            powers: vec![0.0; laws],
            is_started: false,
            stretch: NodeVectors::zeros(ROW_BLOCK.min(nodes)),
            width,
        }
    }
}

/// The drift, and the prediction in place of the velocity.
pub(super) struct Drift {
    pub(super) dt: f64,
}

impl Formula<1, 2> for Drift {
    #[inline(always)]
    fn row<V: SimdF64>(&self, [a]: [V; 1], [x, v]: [V; 2]) -> [V; 2] {
        let (dt, half) = (V::all(self.dt), V::all(0.5 * self.dt));
        let kicked = v + half * a;
        [x + dt * kicked, kicked + half * a]
    }
}

/// The velocity from its prediction, without coriolis_rate: v = p + dt/2 (a' - a). Then a' stands in place of a.
struct Correct {
    half: f64,
}

impl Formula<1, 2> for Correct {
    #[inline(always)]
    fn row<V: SimdF64>(&self, [new]: [V; 1], [a, p]: [V; 2]) -> [V; 2] {
        [new, p + V::all(self.half) * (new - a)]
    }
}

/// The same with coriolis_rate, in x and y.
struct Boris {
    half: f64,
    rate: f64,
}

impl Formula<2, 4> for Boris {
    #[inline(always)]
    fn row<V: SimdF64>(&self, [new_x, new_y]: [V; 2], [ax, ay, px, py]: [V; 4]) -> [V; 4] {
        let h = self.rate * self.half;
        let (half, rate, scale, h) = (V::all(self.half), V::all(self.rate), V::all(1.0 / (1.0 + h * h)), V::all(h));
        let (rx, ry) = (half * (new_x - ax), half * (new_y - ay));
        let (dx, dy) = (scale * (rx + h * ry), scale * (ry - h * rx));
        [new_x + rate * dy, new_y - rate * dx, px + dx, py + dy]
    }
}

/// The largest factor by which a step multiplies a solution of x'' = -omega^2 x - damping x'.
pub(super) fn amplification(omega: f64, damping: f64, dt: f64) -> f64 {
    // One step of (x, dt v, dt^2 a).
    let (z, c) = ((omega * dt).powi(2), damping * dt);
    let step = Matrix3::new(
        1.0,
        1.0,
        0.5,
        -0.5 * z,
        1.0 - 0.5 * z - 0.5 * c,
        0.5 - 0.25 * z - 0.5 * c,
        -z,
        -z - c,
        -0.5 * z - c,
    );
    step.complex_eigenvalues().iter().map(|value| value.norm()).fold(0.0, f64::max)
}

/// Accelerations at the first instant, and each law's power with them.
pub(super) fn begin(system: &mut dyn System, at: Instant<'_>, accelerations: &mut NodeVectors, powers: &mut [f64]) {
    let count = accelerations.nrows();
    for tile in tiles(count) {
        system.accumulate_forces(tile, at, powers);
        for range in row_blocks(rows_of(tile, count)) {
            system.accelerations(range.clone(), at, rows_mut(accelerations, range.clone()), powers);
            system.row_power_at(range.clone(), rows(at.velocities, range), powers);
        }
    }
    system.power_at(at, powers);
}

/// The end of a step: the state stands at `time`, its velocities as predicted.
pub(super) struct End<'a> {
    pub(super) time: f64,
    /// Half of the step.
    pub(super) half: f64,
    /// Those at its start; then those at its end, and each law's power with them.
    pub(super) accelerations: &'a mut NodeVectors,
    pub(super) powers: &'a mut [f64],
    /// Room for accelerations of one stretch of nodes.
    pub(super) stretch: &'a mut NodeVectors,
    pub(super) width: InstructionSet,
}

impl End<'_> {
    /// Evaluates the accelerations, and corrects the velocities.
    pub(super) fn correct(self, system: &mut dyn System, state: &mut State) {
        let End { time, half, accelerations, powers, stretch, width } = self;
        let (rate, count) = (system.coriolis_rate(time), accelerations.nrows());
        for tile in tiles(count) {
            system.accumulate_forces(tile, instant(state, time), powers);
            for range in row_blocks(rows_of(tile, count)) {
                system.accelerations(range.clone(), instant(state, time), rows_mut(stretch, 0..range.len()), powers);
                let [new_x, new_y, new_z] = rows(stretch, 0..range.len());
                let [ax, ay, az] = rows_mut(accelerations, range.clone());
                let [vx, vy, vz] = rows_mut(&mut state.velocities, range.clone());
                if rate == 0.0 {
                    each(width, &Correct { half }, [new_x], [ax, vx]);
                    each(width, &Correct { half }, [new_y], [ay, vy]);
                } else {
                    each(width, &Boris { half, rate }, [new_x, new_y], [ax, ay, vx, vy]);
                }
                each(width, &Correct { half }, [new_z], [az, vz]);
                system.row_power_at(range.clone(), rows(&state.velocities, range), powers);
            }
        }
        system.power_at(instant(state, time), powers);
    }
}

pub(super) fn instant(state: &State, time: f64) -> Instant<'_> {
    Instant { time, positions: &state.positions, velocities: &state.velocities }
}

impl Integrator for Leapfrog {
    fn name(&self) -> &'static str {
        "leapfrog"
    }

    fn order(&self) -> u32 {
        2
    }

    fn evaluations_per_step(&self) -> u32 {
        1
    }

    fn evaluations_at_start(&self) -> u32 {
        1
    }

    fn keeps_energy(&self) -> bool {
        true
    }

    fn evaluates_elsewhere(&self) -> bool {
        true
    }

    fn in_substeps(&self, count: u32) -> Option<Box<dyn Integrator>> {
        Some(Box::new(Multirate::new(self.acceleration.nrows(), self.powers.len(), count, self.width)))
    }

    fn damping_weight(&self) -> Option<f64> {
        Some(4.0)
    }

    fn amplification(&self, omega: f64, damping: f64, dt: f64) -> f64 {
        amplification(omega, damping, dt)
    }

    fn is_started(&self) -> bool {
        self.is_started
    }

    fn start(&mut self, system: &mut dyn System, time: f64, state: &State) {
        begin(system, instant(state, time), &mut self.acceleration, &mut self.powers);
        self.is_started = true;
    }

    fn step(&mut self, system: &mut dyn System, time: f64, dt: f64, state: &mut State, work: &mut [f64]) {
        let half = 0.5 * dt;
        let Self { acceleration, powers, stretch, width, .. } = self;
        let width = *width;
        let mut add_work = |powers: &[f64]| work.iter_mut().zip(powers).for_each(|(work, power)| *work += half * power);
        add_work(powers);
        let (x, v) = (state.positions.as_mut_slice(), state.velocities.as_mut_slice());
        each(width, &Drift { dt }, [acceleration.as_slice()], [x, v]);
        let time = time + dt;
        End { time, half, accelerations: acceleration, stretch, powers, width }.correct(system, state);
        add_work(powers);
    }

    fn energy_shift(&self, masses: &[f64], dt: f64) -> f64 {
        let [x, y, z] = columns(&self.acceleration);
        let squares = (0..masses.len()).map(|i| masses[i] * (x[i] * x[i] + y[i] * y[i] + z[i] * z[i]));
        -0.125 * dt * dt * squares.sum::<f64>()
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
        let fits = history.vectors.len() == 1 && history.numbers.len() == self.powers.len();
        if fits {
            self.acceleration.copy_from(&history.vectors[0]);
            self.powers = history.numbers;
        }
        fits
    }
}
