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
//! Storage: two vectors per node beside the state.

use nalgebra::Matrix3;

use super::{Integrator, Memory, System};
use crate::state::{Instant, State, Vectors, columns, columns_mut};
use crate::width::{Sweep, Width};

/// The method and what it keeps.
pub(super) struct Leapfrog {
    /// a_n, and each law's power with it.
    acceleration: Vectors,
    powers: Vec<f64>,
    is_started: bool,
    /// p.
    prediction: Vectors,
    width: Width,
}

impl Leapfrog {
    pub(super) fn new(nodes: usize, laws: usize, width: Width) -> Self {
        Self {
            acceleration: Vectors::zeros(nodes),
            powers: vec![0.0; laws],
            is_started: false,
            prediction: Vectors::zeros(nodes),
            width,
        }
    }
}

/// Half a kick, the drift, and the prediction.
struct KickAndDrift<'a> {
    dt: f64,
    x: &'a mut [f64],
    v: &'a mut [f64],
    p: &'a mut [f64],
    a: &'a [f64],
}

impl Sweep for KickAndDrift<'_> {
    type Output = ();

    #[inline(always)]
    fn sweep(self) {
        let KickAndDrift { dt, x, v, p, a } = self;
        let n = a.len();
        // Equal lengths, said once, so that the loop needs no check.
        let (x, v, p) = (&mut x[..n], &mut v[..n], &mut p[..n]);
        let half = 0.5 * dt;
        for i in 0..n {
            let kicked = v[i] + half * a[i];
            v[i] = kicked;
            x[i] += dt * kicked;
            p[i] = kicked + half * a[i];
        }
    }
}

/// Half a kick without gyration.
struct Kick<'a> {
    half: f64,
    v: &'a mut [f64],
    a: &'a [f64],
}

impl Sweep for Kick<'_> {
    type Output = ();

    #[inline(always)]
    fn sweep(self) {
        self.v.iter_mut().zip(self.a).for_each(|(v, a)| *v += self.half * a);
    }
}

/// Half a kick with gyration, in x and y.
struct Gyrate<'a> {
    half: f64,
    rate: f64,
    v: [&'a mut [f64]; 2],
    p: [&'a [f64]; 2],
    a: [&'a mut [f64]; 2],
}

impl Sweep for Gyrate<'_> {
    type Output = ();

    #[inline(always)]
    fn sweep(self) {
        let Gyrate { half, rate, v: [vx, vy], p: [px, py], a: [ax, ay] } = self;
        let n = vx.len();
        let (vy, px, py, ax, ay) = (&mut vy[..n], &px[..n], &py[..n], &mut ax[..n], &mut ay[..n]);
        let h = rate * half;
        let scale = 1.0 / (1.0 + h * h);
        for i in 0..n {
            let (rx, ry) = (vx[i] + half * ax[i] - px[i], vy[i] + half * ay[i] - py[i]);
            let (dx, dy) = (scale * (rx + h * ry), scale * (ry - h * rx));
            (ax[i], ay[i]) = (ax[i] + rate * dy, ay[i] - rate * dx);
            (vx[i], vy[i]) = (px[i] + dx, py[i] + dy);
        }
    }
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

    fn damping_weight(&self) -> Option<f64> {
        Some(4.0)
    }

    fn growth(&self, omega: f64, damping: f64, dt: f64) -> f64 {
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

    fn is_started(&self) -> bool {
        self.is_started
    }

    fn start(&mut self, system: &mut dyn System, time: f64, state: &State) {
        let at = Instant { time, positions: &state.positions, velocities: &state.velocities };
        system.accelerate(at, &mut self.acceleration, &mut self.powers);
        self.is_started = true;
    }

    fn step(&mut self, system: &mut dyn System, time: f64, dt: f64, state: &mut State, work: &mut [f64]) {
        let half = 0.5 * dt;
        let Self { acceleration, powers, prediction, width, .. } = self;
        let mut add_work = |powers: &[f64]| work.iter_mut().zip(powers).for_each(|(work, power)| *work += half * power);
        add_work(powers);
        width.run(KickAndDrift {
            dt,
            x: state.positions.as_mut_slice(),
            v: state.velocities.as_mut_slice(),
            p: prediction.as_mut_slice(),
            a: acceleration.as_slice(),
        });
        let at = Instant { time: time + dt, positions: &state.positions, velocities: prediction };
        system.accelerate(at, acceleration, powers);
        let rate = system.gyration(time + dt);
        if rate == 0.0 {
            width.run(Kick { half, v: state.velocities.as_mut_slice(), a: acceleration.as_slice() });
        } else {
            let ([vx, vy, vz], [px, py, _]) = (columns_mut(&mut state.velocities), columns(prediction));
            let [ax, ay, az] = columns_mut(acceleration);
            width.run(Gyrate { half, rate, v: [vx, vy], p: [px, py], a: [ax, ay] });
            width.run(Kick { half, v: vz, a: az });
        }
        system.rework(&state.velocities, powers);
        add_work(powers);
    }

    fn energy_shift(&self, masses: &[f64], dt: f64) -> f64 {
        let [x, y, z] = columns(&self.acceleration);
        let squares = (0..masses.len()).map(|i| masses[i] * (x[i] * x[i] + y[i] * y[i] + z[i] * z[i]));
        -0.125 * dt * dt * squares.sum::<f64>()
    }

    fn memory(&self) -> Memory {
        if !self.is_started {
            return Memory::default();
        }
        Memory { vectors: vec![self.acceleration.clone()], numbers: self.powers.clone() }
    }

    fn recall(&mut self, memory: Memory) -> bool {
        self.is_started = !memory.vectors.is_empty();
        if !self.is_started {
            return memory.numbers.is_empty();
        }
        let fits = memory.vectors.len() == 1 && memory.numbers.len() == self.powers.len();
        if fits {
            self.acceleration.copy_from(&memory.vectors[0]);
            self.powers = memory.numbers;
        }
        fits
    }
}
