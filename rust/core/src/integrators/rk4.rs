//! The classical Runge-Kutta method of order four (Kutta 1901), for x' = v, v' = a(t, x, v):
//!
//!       0  |
//!      1/2 | 1/2
//!      1/2 |  0  1/2
//!       1  |  0   0   1
//!          | 1/6 1/3 1/3 1/6
//!
//! Four evaluations a step. The velocities of the stages, v1 = v_n, v2 = v_n + dt/2 a1, v3 = v_n + dt/2 a2 and
//! v4 = v_n + dt a3, determine their accelerations, which need no storage:
//!
//!     x_n+1 = x_n + dt/6 (v1 + 2 v2 + 2 v3 + v4)
//!     v_n+1 = v_n + ((v2 - v_n) + 2 (v3 - v_n) + (v4 - v_n))/3 + dt/6 a4
//!
//! R(z) = 1 + z + z^2/2 + z^3/6 + z^4/24; stable to 2 sqrt(2) on the imaginary axis and to 2.785 on the negative real
//! one. It is dissipative: the amplitude of an oscillator decreases by (omega dt)^6/144 per step.
//! Storage: three vectors per node beside the state. Each row block proceeds to its next stage as soon as its
//! accelerations are known.

use nalgebra::Complex;

use super::{Integrator, Options, Properties, System, amplification_of};
use crate::arrays::blocks::{ROW_BLOCK, row_blocks, rows_of, tiles};
use crate::arrays::state::{NodeVectors, PhasePoint, State, rows, rows_mut, shared};
use crate::simd::dispatch::InstructionSet;
use crate::simd::lanes::SimdF64;
use crate::simd::map::{Formula, on_axes};

/// Node of each stage in the step, and its weight.
pub(super) const NODES: [f64; 4] = [0.0, 0.5, 0.5, 1.0];
pub(super) const WEIGHTS: [f64; 4] = [1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0];

/// Properties of the method.
pub(super) const PROPERTIES: Properties = Properties::explicit("rk4", 4, 4, (1.0 / 120.0, 4));

/// The largest factor by which a step multiplies a solution, see `Integrator::amplification`.
pub(super) fn amplification(omega: f64, damping: f64, dt: f64) -> f64 {
    let one = Complex::new(1.0, 0.0);
    amplification_of(|z| one + z * (one + z / 2.0 * (one + z / 3.0 * (one + z / 4.0))), omega, damping, dt)
}

/// The method and its stages.
struct Rk4 {
    stage: State,
    /// Velocities of the second stage.
    second: NodeVectors,
    /// Accelerations of one row block.
    row_block: NodeVectors,
    powers: Vec<f64>,
    instructions: InstructionSet,
}

/// The method for a scene.
pub(super) fn make(options: &Options) -> Box<dyn Integrator> {
    let zeros = || NodeVectors::zeros(options.nodes);
    Box::new(Rk4 {
        stage: State { positions: zeros(), velocities: zeros() },
        second: zeros(),
        row_block: NodeVectors::zeros(ROW_BLOCK.min(options.nodes)),
        powers: vec![0.0; options.works],
        instructions: options.instructions,
    })
}

/// The second stage: x2 = x0 + h v0, v2 = v0 + h a1.
struct Second {
    h: f64,
}

impl Formula<3, 2> for Second {
    #[inline(always)]
    fn row<V: SimdF64>(&self, [a, x0, v0]: [V; 3], _: [V; 2]) -> [V; 2] {
        let h = V::all(self.h);
        [x0 + h * v0, v0 + h * a]
    }
}

/// The third stage: x3 = x0 + h v2, v3 = v0 + h a2.
struct Third {
    h: f64,
}

impl Formula<4, 2> for Third {
    #[inline(always)]
    fn row<V: SimdF64>(&self, [a2, x0, v0, v2]: [V; 4], _: [V; 2]) -> [V; 2] {
        let h = V::all(self.h);
        [x0 + h * v2, v0 + h * a2]
    }
}

/// The last stage: x4 = x0 + dt v3, v4 = v0 + dt a3. The state advances to the end of the step, but for a4.
struct Fourth {
    dt: f64,
}

impl Formula<2, 4> for Fourth {
    #[inline(always)]
    fn row<V: SimdF64>(&self, [a3, v2]: [V; 2], [_, v3, x0, v0]: [V; 4]) -> [V; 4] {
        let (dt, two) = (V::all(self.dt), V::all(2.0));
        let change = dt * a3;
        let sum = (v2 - v0) + two * (v3 - v0) + change;
        let displacement = dt * (v0 + V::all(1.0 / 6.0) * (sum + (v2 - v0)));
        [x0 + dt * v3, v0 + change, x0 + displacement, v0 + V::all(1.0 / 3.0) * sum]
    }
}

/// The end of the step: v += dt/6 a4.
struct End {
    sixth: f64,
}

impl Formula<1, 1> for End {
    #[inline(always)]
    fn row<V: SimdF64>(&self, [a]: [V; 1], [v]: [V; 1]) -> [V; 1] {
        [v + V::all(self.sixth) * a]
    }
}

impl Integrator for Rk4 {
    fn properties(&self) -> Properties {
        PROPERTIES
    }

    fn amplification(&self, omega: f64, damping: f64, dt: f64) -> f64 {
        amplification(omega, damping, dt)
    }

    fn step(&mut self, system: &mut dyn System, time: f64, dt: f64, state: &mut State, work: &mut [f64]) {
        let Self { stage, second, row_block, powers, instructions } = self;
        let (instructions, h, sixth, count) = (*instructions, 0.5 * dt, dt / 6.0, second.nrows());
        for k in 0..4 {
            let time = time + NODES[k] * dt;
            for tile in tiles(count) {
                system.accumulate_forces(tile, point(if k == 0 { state } else { stage }, second, k, time), powers);
                for range in row_blocks(rows_of(tile, count)) {
                    let at = point(if k == 0 { state } else { stage }, second, k, time);
                    system.accelerations(range.clone(), at, rows_mut(row_block, 0..range.len()), powers);
                    let (a, v2) = (rows(row_block, 0..range.len()), rows_mut(second, range.clone()));
                    let [x0, v0] =
                        [&mut state.positions, &mut state.velocities].map(|all| rows_mut(all, range.clone()));
                    let [x, v] = [&mut stage.positions, &mut stage.velocities].map(|all| rows_mut(all, range.clone()));
                    match k {
                        0 => on_axes(instructions, &Second { h }, [a, shared(&x0), shared(&v0)], [x, v2]),
                        1 => on_axes(instructions, &Third { h }, [a, shared(&x0), shared(&v0), shared(&v2)], [x, v]),
                        2 => on_axes(instructions, &Fourth { dt }, [a, shared(&v2)], [x, v, x0, v0]),
                        _ => on_axes(instructions, &End { sixth }, [a], [v0]),
                    }
                }
            }
            for (work, power) in work.iter_mut().zip(&*powers) {
                *work += WEIGHTS[k] * dt * power;
            }
        }
    }
}

/// The point of evaluation of stage `k`.
fn point<'a>(stage: &'a State, second: &'a NodeVectors, k: usize, time: f64) -> PhasePoint<'a> {
    PhasePoint { time, positions: &stage.positions, velocities: if k == 1 { second } else { &stage.velocities } }
}
