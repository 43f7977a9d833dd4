//! The embedded pair of orders 5 and 4 of Dormand and Prince (1980), DOPRI5, with the continuous extension of Shampine
//! (1986) as given by Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, section II.6:
//!
//!     y(t + theta dt) = y0 + theta (D + (1 - theta) (B + theta (C + (1 - theta) E)))
//!     D = y1 - y0,   B = dt k1 - D,   C = D - dt k7 - B,   E = dt sum d_i k_i
//!
//! Six evaluations a step: the seventh stage is the first of the next step. Order 5, between steps 4.
//! R(z) = 1 + z + z^2/2 + z^3/6 + z^4/24 + z^5/120 + z^6/600; stable to 3.307 on the negative real axis, and to 1.0
//! only on the imaginary one.
//! The step is constant if given; otherwise the difference of the two orders controls it (`controller`).
//! Storage: 19 vectors per node beside the state, and four more for the continuous extension.

use nalgebra::Complex;

use super::{Embedded, Endpoint, Integrator, Options, Properties, System, Tolerance, amplification_of, saved_works};
use crate::arrays::history::History;
use crate::arrays::state::{NodeVectors, PhasePoint, State, columns};
use crate::simd::dispatch::{InstructionSet, Sweep};

const NODES: [f64; 7] = [0.0, 1.0 / 5.0, 3.0 / 10.0, 4.0 / 5.0, 8.0 / 9.0, 1.0, 1.0];
/// Row k: coefficients of stage k + 1. The last row holds the weights of order 5.
const MATRIX: [&[f64]; 6] = [
    &[1.0 / 5.0],
    &[3.0 / 40.0, 9.0 / 40.0],
    &[44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0],
    &[19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0],
    &[9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0],
    &[35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0],
];
/// Weights of order 5 minus those of order 4.
const ERROR: [f64; 7] =
    [71.0 / 57600.0, 0.0, -71.0 / 16695.0, 71.0 / 1920.0, -17253.0 / 339200.0, 22.0 / 525.0, -1.0 / 40.0];
/// d_i of the continuous extension.
const EXTENSION: [f64; 7] = [
    -12715105075.0 / 11282082432.0,
    0.0,
    87487479700.0 / 32700410799.0,
    -10690763975.0 / 1880347072.0,
    701980252875.0 / 199316789632.0,
    -1453857185.0 / 822651844.0,
    69997945.0 / 29380423.0,
];

/// The method and its stages.
struct Dopri5 {
    /// Velocity and acceleration at each stage, and the power of each law.
    velocities: [NodeVectors; 7],
    accelerations: [NodeVectors; 7],
    powers: [Vec<f64>; 7],
    /// Position of the present stage, at last that at the end of the step, with the velocity of the last stage.
    position: NodeVectors,
    error: [NodeVectors; 2],
    /// Whether the last stage is the derivative at the present state.
    is_fresh: bool,
    is_started: bool,
    time: f64,
    dt: f64,
    extension: Option<Extension>,
    instructions: InstructionSet,
}

/// Data of the continuous extension beside the states and derivatives at both ends.
struct Extension {
    time: f64,
    dt: f64,
    start: State,
    acceleration: NodeVectors,
    /// E for position and velocity.
    e: [NodeVectors; 2],
    /// For each work: work and power at the start, and E.
    works: Vec<[f64; 3]>,
}

/// The method for a scene.
pub(super) fn make(options: &Options) -> Box<dyn Integrator> {
    Box::new(Dopri5::new(options))
}

impl Dopri5 {
    fn new(&Options { nodes, works, instructions, .. }: &Options) -> Self {
        let zeros = || std::array::from_fn(|_| NodeVectors::zeros(nodes));
        Self {
            velocities: zeros(),
            accelerations: zeros(),
            powers: std::array::from_fn(|_| vec![0.0; works]),
            position: NodeVectors::zeros(nodes),
            error: std::array::from_fn(|_| NodeVectors::zeros(nodes)),
            is_fresh: false,
            is_started: false,
            time: 0.0,
            dt: 0.0,
            extension: None,
            instructions,
        }
    }

    fn stages(&mut self, system: &mut dyn System, time: f64, dt: f64, state: &State) {
        if self.is_fresh {
            self.accelerations.swap(0, 6);
            self.powers.swap(0, 6);
            self.is_fresh = false;
        }
        (self.time, self.dt) = (time, dt);
        self.velocities[0].copy_from(&state.velocities);
        for (k, row) in MATRIX.iter().enumerate() {
            let (before, after) = self.velocities.split_at_mut(k + 1);
            let instructions = self.instructions;
            sum(instructions, Some(&state.positions), dt, row, before, &mut self.position);
            sum(instructions, Some(&state.velocities), dt, row, &self.accelerations, &mut after[0]);
            let at = PhasePoint { time: time + NODES[k + 1] * dt, positions: &self.position, velocities: &after[0] };
            system.accelerate(at, &mut self.accelerations[k + 1], &mut self.powers[k + 1]);
        }
    }

    fn finish(&mut self, state: &mut State, work: &mut [f64]) {
        state.positions.copy_from(&self.position);
        state.velocities.copy_from(&self.velocities[6]);
        for (law, work) in work.iter_mut().enumerate() {
            *work += self.dt * self.weighted_power(MATRIX[5], law);
        }
        self.is_fresh = true;
    }

    /// Weighted sum of the powers of a law over the stages [W].
    fn weighted_power(&self, weights: &[f64], law: usize) -> f64 {
        weights.iter().zip(&self.powers).map(|(weight, powers)| weight * powers[law]).sum()
    }
}

/// out = start + dt sum of weights times terms; zeros without `start`.
fn sum(
    instructions: InstructionSet,
    start: Option<&NodeVectors>,
    dt: f64,
    weights: &[f64],
    terms: &[NodeVectors],
    out: &mut NodeVectors,
) {
    let used: Vec<(f64, &[f64])> = weights
        .iter()
        .zip(terms)
        .filter(|(weight, _)| **weight != 0.0)
        .map(|(weight, term)| (dt * weight, term.as_slice()))
        .collect();
    if let Some(start) = start {
        out.copy_from(start);
    } else {
        out.fill(0.0);
    }
    for pair in used.chunks(2) {
        let out = out.as_mut_slice();
        match *pair {
            [first, second] => instructions.run(Add { terms: [first, second], out }),
            [first] => instructions.run(Add { terms: [first], out }),
            _ => {}
        }
    }
}

/// Adds weighted terms in their order.
struct Add<'a, const N: usize> {
    terms: [(f64, &'a [f64]); N],
    out: &'a mut [f64],
}

impl<const N: usize> Sweep for Add<'_, N> {
    type Output = ();

    #[inline(always)]
    fn sweep(self) {
        let n = self.out.len();
        let terms = self.terms.map(|(weight, term)| (weight, &term[..n]));
        for i in 0..n {
            let mut value = self.out[i];
            for (weight, term) in terms {
                value += weight * term[i];
            }
            self.out[i] = value;
        }
    }
}

/// The largest squared ratio of error to magnitude, over all nodes; not finite if one is not.
struct LargestRatio<'a> {
    error: [&'a [f64]; 3],
    value: [&'a [f64]; 3],
    floor: f64,
}

impl Sweep for LargestRatio<'_> {
    type Output = f64;

    #[inline(always)]
    fn sweep(self) -> f64 {
        let ([ex, ey, ez], [x, y, z]) = (self.error, self.value);
        let floor = self.floor * self.floor;
        let (mut largest, mut sum) = (0.0_f64, 0.0);
        for i in 0..ex.len() {
            let square = ex[i] * ex[i] + ey[i] * ey[i] + ez[i] * ez[i];
            let ratio = square / (floor + (x[i] * x[i] + y[i] * y[i] + z[i] * z[i]));
            largest = largest.max(ratio);
            // `max` ignores what is not a number; a sum does not.
            sum += ratio;
        }
        if sum.is_finite() { largest } else { f64::INFINITY }
    }
}

impl Embedded for Dopri5 {
    fn attempt(&mut self, system: &mut dyn System, from: Endpoint<'_>, dt: f64, tolerance: &Tolerance) -> f64 {
        self.stages(system, from.time, dt, from.state);
        let [of_position, of_velocity] = &mut self.error;
        sum(self.instructions, None, dt, &ERROR, &self.velocities, of_position);
        sum(self.instructions, None, dt, &ERROR, &self.accelerations, of_velocity);
        let largest_ratio = |error: &NodeVectors, value: &NodeVectors, floor: f64| {
            self.instructions.run(LargestRatio { error: columns(error), value: columns(value), floor })
        };
        let end = PhasePoint { time: from.time + dt, positions: &self.position, velocities: &self.velocities[6] };
        let own = system.about_centres(end);
        let own = own.as_ref().map_or(end, |own| own.at(end.time));
        let ratios = [
            largest_ratio(of_position, own.positions, tolerance.length),
            largest_ratio(of_velocity, own.velocities, tolerance.speed),
        ];
        ratios[0].max(ratios[1]).sqrt() / tolerance.relative
    }

    fn accept(&mut self, state: &mut State, work: &mut [f64]) {
        let e = [&self.velocities, &self.accelerations].map(|terms| {
            let mut e = NodeVectors::zeros(self.position.nrows());
            sum(self.instructions, None, self.dt, &EXTENSION, terms, &mut e);
            e
        });
        let works = work.iter().enumerate();
        let works = works
            .map(|(law, work)| [*work, self.powers[0][law], self.dt * self.weighted_power(&EXTENSION, law)])
            .collect();
        self.extension = Some(Extension {
            time: self.time,
            dt: self.dt,
            start: state.clone(),
            acceleration: self.accelerations[0].clone(),
            e,
            works,
        });
        self.finish(state, work);
    }

    fn interpolate(&self, end: Endpoint<'_>, time: f64) -> (State, Vec<f64>) {
        let Some(extension) = &self.extension else {
            return (end.state.clone(), end.work.to_vec());
        };
        let Extension { dt, start, acceleration, e: [e_x, e_v], works, .. } = extension;
        let theta = (time - extension.time) / dt;
        let extend = |y0: f64, y1: f64, k1: f64, k7: f64, e: f64| {
            let d = y1 - y0;
            let b = dt * k1 - d;
            let c = d - dt * k7 - b;
            y0 + theta * (d + (1.0 - theta) * (b + theta * (c + (1.0 - theta) * e)))
        };
        let extend_all = |y0: &NodeVectors, y1: &NodeVectors, k1: &NodeVectors, k7: &NodeVectors, e: &NodeVectors| {
            NodeVectors::from_fn(y0.nrows(), |i, axis| {
                let at = (i, axis);
                extend(y0[at], y1[at], k1[at], k7[at], e[at])
            })
        };
        let last = &self.accelerations[6];
        let (x0, v0, x1, v1) = (&start.positions, &start.velocities, &end.state.positions, &end.state.velocities);
        let state = State {
            positions: extend_all(x0, x1, v0, v1, e_x),
            velocities: extend_all(v0, v1, acceleration, last, e_v),
        };
        let work =
            works.iter().enumerate().map(|(law, [w0, p0, e])| extend(*w0, end.work[law], *p0, self.powers[6][law], *e));
        (state, work.collect())
    }
}

impl Integrator for Dopri5 {
    fn properties(&self) -> Properties {
        Properties {
            evaluations_at_start: 1,
            ..Properties::explicit("dopri5", 5, 6, (1.0 / 600.0 - 1.0 / 720.0 + 1.0 / 5040.0, 6))
        }
    }

    fn amplification(&self, omega: f64, damping: f64, dt: f64) -> f64 {
        let one = Complex::new(1.0, 0.0);
        let r = |z: Complex<f64>| {
            one + z * (one + z / 2.0 * (one + z / 3.0 * (one + z / 4.0 * (one + z / 5.0 * (one + z / 5.0)))))
        };
        amplification_of(r, omega, damping, dt)
    }

    fn is_started(&self) -> bool {
        self.is_started
    }

    fn start(&mut self, system: &mut dyn System, time: f64, _dt: f64, state: &mut State, _work: &mut [f64]) {
        system.accelerate(state.at(time), &mut self.accelerations[6], &mut self.powers[6]);
        (self.is_started, self.is_fresh, self.extension) = (true, true, None);
    }

    fn step(&mut self, system: &mut dyn System, time: f64, dt: f64, state: &mut State, work: &mut [f64]) {
        self.stages(system, time, dt, state);
        self.finish(state, work);
    }

    fn history(&self) -> History {
        if !self.is_started {
            return History::default();
        }
        let mut history = History { vectors: vec![self.accelerations[6].clone()], numbers: self.powers[6].clone() };
        if let Some(Extension { time, dt, start, acceleration, e: [e_x, e_v], works }) = &self.extension {
            let saved = [&start.positions, &start.velocities, acceleration, e_x, e_v];
            history.vectors.extend(saved.map(Clone::clone));
            history.numbers.extend([time, dt]);
            history.numbers.extend(works.iter().flatten());
        }
        history
    }

    fn restore_history(&mut self, history: History) -> bool {
        let History { mut vectors, numbers } = history;
        self.extension = None;
        (self.is_started, self.is_fresh) = (!vectors.is_empty(), true);
        if !self.is_started {
            return numbers.is_empty();
        }
        let (all, has_extension) = (self.powers[6].len(), vectors.len() == 6);
        let (each, others) = if has_extension { (4, 2) } else { (1, 0) };
        let Some(works) = saved_works(all, numbers.len(), each, others) else { return false };
        if !(has_extension || vectors.len() == 1) {
            return false;
        }
        self.powers[6].fill(0.0);
        self.powers[6][..works].copy_from_slice(&numbers[..works]);
        let extended =
            numbers.get(works + 2..).unwrap_or_default().chunks_exact(3).map(|three| [three[0], three[1], three[2]]);
        let mut saved = vectors.drain(1..);
        if let (Some(positions), Some(velocities), Some(acceleration), Some(e_x), Some(e_v)) =
            (saved.next(), saved.next(), saved.next(), saved.next(), saved.next())
        {
            self.extension = Some(Extension {
                time: numbers[works],
                dt: numbers[works + 1],
                start: State { positions, velocities },
                acceleration,
                e: [e_x, e_v],
                works: extended.chain(std::iter::repeat([0.0; 3])).take(all).collect(),
            });
        }
        drop(saved);
        self.accelerations[6].copy_from(&vectors[0]);
        true
    }

    fn embedded(&mut self) -> Option<&mut dyn Embedded> {
        Some(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_error_ratio_of_a_node_is_that_of_two_vectors_above_the_floor() {
        let of = |error: [f64; 3], value: [f64; 3], floor: f64| {
            let [e, v] = [error, value].map(|vector| vector.map(|component| [0.0, component]));
            LargestRatio { error: e.each_ref().map(|c| &c[..]), value: v.each_ref().map(|c| &c[..]), floor }.sweep()
        };
        assert_eq!(of([3.0, 4.0, 12.0], [1.0, 2.0, 2.0], 4.0), 169.0 / 25.0);
        assert_eq!(of([2.0, 0.0, 0.0], [0.0, 3.0, 0.0], 1.0), 0.4);
        for bad in [f64::NAN, f64::INFINITY] {
            assert_eq!(of([bad, 0.0, 0.0], [1.0; 3], 1.0), f64::INFINITY);
        }
    }
}
