//! The generalised-alpha method (Chung and Hulbert, J. Appl. Mech. 60, 1993), implicit, for stiff and damped scenes and
//! for relaxation to rest:
//!
//!     (1 - am) a' + am a = F(t_f, x_f, v_f)/m,      (.)_f = (1 - af) (.)' + af (.)
//!     x' = x + h v + h^2 ((1/2 - b) a + b a'),      v' = v + h ((1 - g) a + g a')
//!     am = (2 r - 1)/(r + 1),   af = r/(r + 1),   g = 1/2 - am + af,   b = (1 - am + af)^2/4
//!
//! Order 2 and, for linear forces, stable at every step for every damping. r, the spectral radius at infinite
//! frequency, is the amplification per step of vibrations that the step does not resolve. r = 1 is the implicit
//! midpoint rule, in which they persist; r = 0 removes them in one step. Slow motion is hardly damped in between: at
//! omega h = 0.1 and r = 0.8, by 7e-8 of the amplitude per step. Hence this method and not the midpoint rule: springs
//! that buckle and contacts that close excite unresolved vibrations all the time.
//!
//! Newton's method finds a' with the symmetric part of the tangent (see `tangent`), from an initial guess of constant
//! velocity. A factor is reused while each correction is below `CONTRACTION` of the last. Corrections are compared, not
//! residuals, which the stiffest elements dominate (natural monotonicity test: Deuflhard, Newton Methods for Nonlinear
//! Problems, 2004, section 3.3). A correction that does not shrink is halved up to `HALVINGS` times. The iteration ends
//! where the next correction is below 1e-9 of the largest displacement of a node in the step, or below rounding. A
//! matrix that is not positive definite is factorised again with larger masses. If Newton's method fails the step is
//! halved, down to 2^-`LEVELS` of it, and each halving is counted. From 2^-`LEVELS_OF_NEWTON` on `descent` takes over
//! where it fails. If that fails too the step is `stalled`.
//!
//! The work of a law is the integral of its power at t_f, extrapolated to the middle of the step by the line through
//! the power of the step before: order 2, and bounded however stiff a dashpot is.
//! Storage: six vectors per node beside the state; the tangent and its factor.

mod descent;

use nalgebra::Matrix3;

use super::{Implicit, Integrator, Options, Properties, Stall, Statistics, System, saved_works};
use crate::arrays::history::History;
use crate::arrays::state::{NodeVectors, PhasePoint, State};
use crate::linear::tangent::Weights;

/// Largest number of corrections per attempt, and of halvings of one.
const ITERATIONS: u32 = 25;
const HALVINGS: u32 = 5;
/// Ratio of two corrections up to which a factor is reused.
const CONTRACTION: f64 = 0.25;
/// Number of times that the masses are increased, each time fourfold, for a matrix that is not positive definite.
const SHIFTS: i32 = 5;
/// Largest number of halvings of a step.
const LEVELS: u32 = 10;
/// Number of halvings after which a part of a step is found by descent where Newton's method fails.
const LEVELS_OF_NEWTON: u32 = 4;
/// Correction at which the iteration ends, over the largest displacement in the step, and over the size of the scene.
const TOLERANCE: [f64; 2] = [1e-9, 1e-14];
/// The same for corrections that no longer shrink because of rounding.
const ROUNDING: [f64; 2] = [1e-6, 1e-9];

/// The method, its history and its work arrays.
struct GeneralizedAlpha {
    alpha_m: f64,
    alpha_f: f64,
    beta: f64,
    gamma: f64,
    /// a, and the power of each law at the last evaluation, `lag` before the end of the last step [s].
    acceleration: NodeVectors,
    powers: Vec<f64>,
    lag: f64,
    is_started: bool,
    statistics: Statistics,
    stall: Option<Stall>,
    /// a' so far and with the present correction; then x_f, v_f.
    next: NodeVectors,
    trial: NodeVectors,
    position: NodeVectors,
    velocity: NodeVectors,
    /// The present correction; the residual, then the next correction.
    correction: NodeVectors,
    residual: NodeVectors,
    new_powers: Vec<f64>,
}

/// A step or a part of one: its start and its length h.
struct Interval<'a> {
    time: f64,
    h: f64,
    from: &'a State,
}

/// The method for a scene.
pub(super) fn make(options: &Options) -> Box<dyn Integrator> {
    Box::new(GeneralizedAlpha::new(options))
}

impl GeneralizedAlpha {
    fn new(&Options { nodes, works, spectral_radius: r, .. }: &Options) -> Self {
        let zeros = || NodeVectors::zeros(nodes);
        let (alpha_m, alpha_f) = ((2.0 * r - 1.0) / (r + 1.0), r / (r + 1.0));
        let shift = alpha_f - alpha_m;
        Self {
            alpha_m,
            alpha_f,
            beta: 0.25 * (1.0 + shift) * (1.0 + shift),
            gamma: 0.5 + shift,
            acceleration: zeros(),
            powers: vec![0.0; works],
            lag: 0.0,
            is_started: false,
            statistics: Statistics::default(),
            stall: None,
            next: zeros(),
            trial: zeros(),
            position: zeros(),
            velocity: zeros(),
            correction: zeros(),
            residual: zeros(),
            new_powers: vec![0.0; works],
        }
    }

    fn weights(&self, h: f64) -> Weights {
        let implicit = 1.0 - self.alpha_f;
        Weights {
            mass: 1.0 - self.alpha_m,
            damping: implicit * self.gamma * h,
            stiffness: implicit * self.beta * h * h,
        }
    }

    /// x_f and v_f with `trial` as a'.
    fn interpolate(&mut self, interval: &Interval<'_>) {
        let (h, kept) = (interval.h, self.alpha_f);
        let implicit = 1.0 - kept;
        let (of_old, of_new) = (implicit * h * h * (0.5 - self.beta), implicit * h * h * self.beta);
        let (v_old, v_new) = (implicit * h * (1.0 - self.gamma), implicit * h * self.gamma);
        let (x, v) = (interval.from.positions.as_slice(), interval.from.velocities.as_slice());
        let (a, next) = (self.acceleration.as_slice(), self.trial.as_slice());
        let (position, velocity) = (self.position.as_mut_slice(), self.velocity.as_mut_slice());
        for i in 0..x.len() {
            position[i] = x[i] + (implicit * h * v[i] + of_old * a[i] + of_new * next[i]);
            velocity[i] = v[i] + (v_old * a[i] + v_new * next[i]);
        }
    }

    /// The residual at `trial`, F/m - (1 - am) a' - am a, into `residual`.
    fn evaluate(&mut self, system: &mut dyn System, interval: &Interval<'_>) {
        self.interpolate(interval);
        let time = interval.time + (1.0 - self.alpha_f) * interval.h;
        let at = PhasePoint { time, positions: &self.position, velocities: &self.velocity };
        system.accelerate(at, &mut self.residual, &mut self.new_powers);
        let (new, old) = (1.0 - self.alpha_m, self.alpha_m);
        let (next, a) = (self.trial.as_slice(), self.acceleration.as_slice());
        for (i, residual) in self.residual.as_mut_slice().iter_mut().enumerate() {
            *residual -= new * next[i] + old * a[i];
        }
    }

    /// Factorises the tangent at the last evaluation, with the least masses that make it positive definite.
    fn factorise(&mut self, system: &mut dyn System, interval: &Interval<'_>) -> bool {
        let time = interval.time + (1.0 - self.alpha_f) * interval.h;
        let at = PhasePoint { time, positions: &self.position, velocities: &self.velocity };
        let weights = self.weights(interval.h);
        for shift in 0..=SHIFTS {
            self.statistics.factorisations += 1;
            let factor = if shift == 0 { 1.0 } else { 1.0 + 4.0_f64.powi(shift - 1) };
            if system.factorise(at, Weights { mass: factor * weights.mass, ..weights }) {
                return true;
            }
        }
        false
    }

    /// The initial guess, constant velocity, as `next` and as `trial`; prescribed motion at both ends of the step.
    fn guess(&mut self, system: &dyn System, interval: &Interval<'_>) {
        system.prescribed_accelerations(interval.time, &mut self.acceleration);
        self.next.copy_from(&self.acceleration);
        self.next *= (self.beta - 0.5) / self.beta;
        system.prescribed_accelerations(interval.time + interval.h, &mut self.next);
        self.trial.copy_from(&self.next);
    }

    /// Finds a' by Newton's method; a failure gives the node with the largest last correction.
    fn newton(&mut self, system: &mut dyn System, interval: &Interval<'_>) -> Result<(), usize> {
        let size = interval.from.positions.amax();
        self.guess(system, interval);
        self.evaluate(system, interval);
        if !self.residual.sum().is_finite() || !self.factorise(system, interval) {
            return Err(largest(&self.residual).0);
        }
        let mut is_fresh = true;
        system.solve(&mut self.residual);
        self.correction.copy_from(&self.residual);
        for _ in 0..ITERATIONS {
            self.statistics.iterations += 1;
            let before = self.correction.norm();
            let mut share = 1.0;
            let mut ratio;
            loop {
                self.trial.copy_from(&self.next);
                self.trial.zip_apply(&self.correction, |a, correction| *a += share * correction);
                self.evaluate(system, interval);
                system.solve(&mut self.residual);
                ratio = self.residual.norm() / before;
                if before == 0.0 || ratio <= 1.0 - 0.25 * share || share < 0.5_f64.powi(HALVINGS as i32) {
                    break;
                }
                share *= 0.5;
            }
            let scale = self.beta * interval.h * interval.h;
            let (node, of_present) = largest(&self.correction);
            let (_, of_next) = largest(&self.residual);
            let displacement = self.largest_displacement(interval);
            if before == 0.0 || scale * of_next <= TOLERANCE[0] * displacement + TOLERANCE[1] * size {
                self.next.copy_from(&self.trial);
                return Ok(());
            }
            let has_shrunk = ratio <= 1.0 - 0.25 * share;
            if !has_shrunk {
                if scale * of_present.max(of_next) <= ROUNDING[0] * displacement + ROUNDING[1] * size {
                    self.next.copy_from(&self.trial);
                    return Ok(());
                }
                if is_fresh {
                    return Err(node);
                }
                // The factor belongs to an earlier iterate: back to the present one, for its factor.
                self.trial.copy_from(&self.next);
                self.evaluate(system, interval);
            } else {
                self.next.copy_from(&self.trial);
                if share == 1.0 && ratio <= CONTRACTION {
                    std::mem::swap(&mut self.correction, &mut self.residual);
                    is_fresh = false;
                    continue;
                }
                // The residual was overwritten by the next correction.
                self.evaluate(system, interval);
            }
            if !self.factorise(system, interval) {
                return Err(node);
            }
            is_fresh = true;
            system.solve(&mut self.residual);
            self.correction.copy_from(&self.residual);
        }
        Err(largest(&self.correction).0)
    }

    /// The largest displacement of any node in the step with `trial` [m].
    fn largest_displacement(&self, interval: &Interval<'_>) -> f64 {
        let (h, nodes) = (interval.h, self.trial.nrows());
        let (of_old, of_new) = (h * h * (0.5 - self.beta), h * h * self.beta);
        let (v, a, next) = (&interval.from.velocities, &self.acceleration, &self.trial);
        let squares = (0..nodes)
            .map(|i| (0..3).map(|k| (h * v[(i, k)] + of_old * a[(i, k)] + of_new * next[(i, k)]).powi(2)).sum::<f64>());
        squares.fold(0.0, f64::max).sqrt()
    }

    /// Advances the state to the end of the step.
    fn accept(&mut self, h: f64, state: &mut State, work: &mut [f64]) {
        let (x, v) = (state.positions.as_mut_slice(), state.velocities.as_mut_slice());
        let (a, next) = (self.acceleration.as_slice(), self.next.as_slice());
        for i in 0..x.len() {
            x[i] += h * v[i] + h * h * ((0.5 - self.beta) * a[i] + self.beta * next[i]);
            v[i] += h * ((1.0 - self.gamma) * a[i] + self.gamma * next[i]);
        }
        self.acceleration.copy_from(&self.next);
        // Extrapolation from the last two evaluations to the middle of the step.
        let extrapolation = (self.alpha_f - 0.5) * h / ((1.0 - self.alpha_f) * h + self.lag);
        for (work, (power, last)) in work.iter_mut().zip(self.new_powers.iter().zip(&mut self.powers)) {
            *work += h * (power + extrapolation * (power - *last));
            *last = *power;
        }
        self.lag = self.alpha_f * h;
    }
}

/// The node with the largest vector, and its length.
fn largest(vectors: &NodeVectors) -> (usize, f64) {
    let mut largest = (0, 0.0);
    for (node, vector) in vectors.row_iter().enumerate() {
        let square = vector.norm_squared();
        if square > largest.1 || square.is_nan() {
            largest = (node, square);
        }
    }
    (largest.0, largest.1.sqrt())
}

impl Integrator for GeneralizedAlpha {
    fn properties(&self) -> Properties {
        // Two evaluations for linear forces, one more for each further iteration.
        let shift = self.alpha_f - self.alpha_m;
        let frequency_error = (1.0 / 12.0 + 0.375 * shift * shift, 2);
        let explicit = Properties::explicit("generalized_alpha", 2, 2, frequency_error);
        Properties { evaluations_at_start: 1, is_implicit: true, ..explicit }
    }

    fn amplification(&self, omega: f64, damping: f64, dt: f64) -> f64 {
        // The amplification matrix of (x, dt v, dt^2 a).
        let (z, c) = ((omega * dt).powi(2), damping * dt);
        let (implicit, late, slow) = (1.0 - self.alpha_f, 1.0 - self.gamma, 0.5 - self.beta);
        let own = 1.0 - self.alpha_m + implicit * (self.gamma * c + self.beta * z);
        let a = [-z, -c - implicit * z, -self.alpha_m - implicit * (late * c + slow * z)].map(|value| value / own);
        let row = |start: [f64; 3], weight: f64| [0, 1, 2].map(|k| start[k] + weight * a[k]);
        let rows = [row([1.0, 1.0, slow], self.beta), row([0.0, 1.0, late], self.gamma), a];
        let step = Matrix3::from_fn(|i, j| rows[i][j]);
        step.complex_eigenvalues().iter().map(|value| value.norm()).fold(0.0, f64::max)
    }

    fn is_started(&self) -> bool {
        self.is_started
    }

    fn start(&mut self, system: &mut dyn System, time: f64, _dt: f64, state: &mut State, _work: &mut [f64]) {
        system.accelerate(state.at(time), &mut self.acceleration, &mut self.powers);
        (self.lag, self.is_started) = (0.0, true);
    }

    fn step(&mut self, system: &mut dyn System, time: f64, dt: f64, state: &mut State, work: &mut [f64]) {
        self.stall = None;
        // In parts of 2^-LEVELS of the step.
        let whole = 1_u32 << LEVELS;
        let (mut done, mut part) = (0, whole);
        while done < whole {
            let share = |parts: u32| f64::from(parts) / f64::from(whole);
            let interval = Interval { time: time + dt * share(done), h: dt * share(part), from: state };
            let found = self.newton(system, &interval).or_else(|node| {
                let is_short = part << LEVELS_OF_NEWTON <= whole;
                if is_short { self.descend(system, &interval) } else { Err(node) }
            });
            match found {
                Ok(()) => {
                    let h = interval.h;
                    self.accept(h, state, work);
                    done += part;
                    if part < whole && done.is_multiple_of(2 * part) {
                        part *= 2;
                    }
                }
                Err(node) if part == 1 => {
                    self.stall = Some(Stall { time: interval.time, dt: interval.h, node });
                    return;
                }
                Err(_) => {
                    part /= 2;
                    self.statistics.fallbacks += 1;
                }
            }
        }
    }

    fn implicit(&self) -> Option<&dyn Implicit> {
        Some(self)
    }

    fn history(&self) -> History {
        if !self.is_started {
            return History::default();
        }
        let Statistics { iterations, factorisations, fallbacks } = self.statistics;
        let mut numbers = self.powers.clone();
        numbers.push(self.lag);
        numbers.extend([iterations, factorisations, fallbacks].map(|count| count as f64));
        History { vectors: vec![self.acceleration.clone()], numbers }
    }

    /// Counts continue from the larger ones: a run that returns to an earlier state has spent them.
    fn restore_history(&mut self, history: History) -> bool {
        let History { vectors, numbers } = history;
        self.stall = None;
        self.is_started = !vectors.is_empty();
        if !self.is_started {
            return numbers.is_empty();
        }
        let Some(works) = saved_works(self.powers.len(), numbers.len(), 1, 4) else { return false };
        if vectors.len() != 1 {
            return false;
        }
        self.acceleration.copy_from(&vectors[0]);
        self.powers.fill(0.0);
        self.powers[..works].copy_from_slice(&numbers[..works]);
        self.lag = numbers[works];
        let Statistics { iterations, factorisations, fallbacks } = &mut self.statistics;
        for (count, saved) in [iterations, factorisations, fallbacks].into_iter().zip(&numbers[works + 1..]) {
            *count = (*count).max(*saved as u64);
        }
        true
    }
}

impl Implicit for GeneralizedAlpha {
    fn statistics(&self) -> Statistics {
        self.statistics
    }

    fn stalled(&self) -> Option<Stall> {
        self.stall
    }
}
