//! The classical Runge-Kutta method of order four (Kutta 1901), for x' = v, v' = a(t, x, v):
//!
//!       0  |
//!      1/2 | 1/2
//!      1/2 |  0  1/2
//!       1  |  0   0   1
//!          | 1/6 1/3 1/3 1/6
//!
//! Four evaluations a step. R(z) = 1 + z + z^2/2 + z^3/6 + z^4/24; stable to 2 sqrt(2) on the imaginary axis and to 2.785 on
//! the negative real one. It loses energy: on an oscillator the amplitude shrinks by (omega dt)^6/144 per step.
//! Storage: five vectors per node beside the state.

use nalgebra::Complex;

use super::{Integrator, System, growth_of};
use crate::state::{Instant, State, Vectors};
use crate::width::{Sweep, Width};

/// Node of each stage in the step, and its weight.
const NODES: [f64; 4] = [0.0, 0.5, 0.5, 1.0];
const WEIGHTS: [f64; 4] = [1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0];

/// The method and its stages.
pub(super) struct Rk4 {
    /// The stage's state and its acceleration.
    stage: State,
    acceleration: Vectors,
    /// Weighted sums of the stages' velocities and accelerations.
    velocity_sum: Vectors,
    acceleration_sum: Vectors,
    powers: Vec<f64>,
    width: Width,
}

impl Rk4 {
    pub(super) fn new(nodes: usize, laws: usize, width: Width) -> Self {
        let zeros = || Vectors::zeros(nodes);
        Self {
            stage: State { positions: zeros(), velocities: zeros() },
            acceleration: zeros(),
            velocity_sum: zeros(),
            acceleration_sum: zeros(),
            powers: vec![0.0; laws],
            width,
        }
    }
}

/// One pass per stage: adds the stage to the sums, and lays out the next one.
struct Combine<'a> {
    is_first: bool,
    weight: f64,
    ahead: f64,
    /// Positions and velocities at the start of the step.
    start: [&'a [f64]; 2],
    acceleration: &'a [f64],
    stage: [&'a mut [f64]; 2],
    sums: [&'a mut [f64]; 2],
}

impl Sweep for Combine<'_> {
    type Output = ();

    #[inline(always)]
    fn sweep(self) {
        let Combine { is_first, weight, ahead, start: [x0, v0], acceleration: a, stage: [x, v], sums: [dx, dv] } = self;
        let n = a.len();
        // Equal lengths, said once, so that the loops need no check.
        let (x0, v0, x, v, dx, dv) = (&x0[..n], &v0[..n], &mut x[..n], &mut v[..n], &mut dx[..n], &mut dv[..n]);
        if is_first {
            for i in 0..n {
                (dx[i], dv[i]) = (weight * v0[i], weight * a[i]);
                (x[i], v[i]) = (x0[i] + ahead * v0[i], v0[i] + ahead * a[i]);
            }
        } else {
            for i in 0..n {
                dx[i] += weight * v[i];
                dv[i] += weight * a[i];
                (x[i], v[i]) = (x0[i] + ahead * v[i], v0[i] + ahead * a[i]);
            }
        }
    }
}

impl Integrator for Rk4 {
    fn name(&self) -> &'static str {
        "rk4"
    }

    fn order(&self) -> u32 {
        4
    }

    fn evaluations_per_step(&self) -> u32 {
        4
    }

    fn growth(&self, omega: f64, damping: f64, dt: f64) -> f64 {
        let one = Complex::new(1.0, 0.0);
        growth_of(|z| one + z * (one + z / 2.0 * (one + z / 3.0 * (one + z / 4.0))), omega, damping, dt)
    }

    fn step(&mut self, system: &mut dyn System, time: f64, dt: f64, state: &mut State, work: &mut [f64]) {
        for k in 0..4 {
            let (before, weight) = (NODES[k] * dt, WEIGHTS[k] * dt);
            let velocities = if k == 0 { &state.velocities } else { &self.stage.velocities };
            let positions = if k == 0 { &state.positions } else { &self.stage.positions };
            let at = Instant { time: time + before, positions, velocities };
            system.accelerate(at, &mut self.acceleration, &mut self.powers);
            for (work, power) in work.iter_mut().zip(&self.powers) {
                *work += weight * power;
            }
            let ahead = if k < 3 { NODES[k + 1] * dt } else { 0.0 };
            self.width.run(Combine {
                is_first: k == 0,
                weight,
                ahead,
                start: [state.positions.as_slice(), state.velocities.as_slice()],
                acceleration: self.acceleration.as_slice(),
                stage: [self.stage.positions.as_mut_slice(), self.stage.velocities.as_mut_slice()],
                sums: [self.velocity_sum.as_mut_slice(), self.acceleration_sum.as_mut_slice()],
            });
        }
        state.positions += &self.velocity_sum;
        state.velocities += &self.acceleration_sum;
    }
}
