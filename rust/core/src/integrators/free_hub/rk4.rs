//! The classical Runge-Kutta method of order four with a free hub, in relative velocities:
//!
//!     x' = v,   v' = F/m - (omega' x r + omega x (omega x r) + 2 omega x v + A),   y' = f(y, F_h, tau)
//!
//! y are the numbers of the motion of the hub, and A the acceleration of the origin, both by the load on the hub, which
//! needs the forces on all nodes: each stage takes two passes. Momentum and energy drift by the order of the method.
//! Storage: four vectors per node beside the state.

use nalgebra::Vector3;

use super::Affine;
use crate::arrays::state::{NodeVectors, State, columns, columns_mut};
use crate::integrators::rk4::{NODES, PROPERTIES, WEIGHTS, amplification};
use crate::integrators::{Integrator, Options, Properties, System};
use crate::model::hub_motion::{HubMotion, NUMBERS};
use crate::simd::dispatch::InstructionSet;
use crate::simd::lanes::SimdF64;
use crate::simd::map::{Formula, each, on_axes};

/// The method and its stages.
struct FreeRk4 {
    stage: State,
    /// Sums of the weighted derivatives.
    change: State,
    acceleration: NodeVectors,
    powers: Vec<f64>,
    held: Vec<usize>,
    instructions: InstructionSet,
}

/// The method for a scene with a free hub.
pub(crate) fn make(options: &Options) -> Box<dyn Integrator> {
    let zeros = || NodeVectors::zeros(options.nodes);
    let state = || State { positions: zeros(), velocities: zeros() };
    Box::new(FreeRk4 {
        stage: state(),
        change: state(),
        acceleration: zeros(),
        powers: vec![0.0; options.works],
        held: Vec::new(),
        instructions: options.instructions,
    })
}

/// a -= omega' x r + omega x (omega x r) + A + 2 omega x v.
struct Relative {
    of_place: Affine,
    of_speed: Affine,
}

impl Formula<6, 3> for Relative {
    #[inline(always)]
    fn row<V: SimdF64>(&self, [x, y, z, u, v, w]: [V; 6], mut a: [V; 3]) -> [V; 3] {
        let (of_place, of_speed) = (self.of_place.of([x, y, z]), self.of_speed.of([u, v, w]));
        for k in 0..3 {
            a[k] = a[k] - of_place[k] - of_speed[k];
        }
        a
    }
}

/// sum += weight rate.
struct Sum {
    weight: f64,
}

impl Formula<1, 1> for Sum {
    #[inline(always)]
    fn row<V: SimdF64>(&self, [rate]: [V; 1], [sum]: [V; 1]) -> [V; 1] {
        [sum + V::all(self.weight) * rate]
    }
}

/// The next stage: start + h rate.
struct Next {
    h: f64,
}

impl Formula<2, 1> for Next {
    #[inline(always)]
    fn row<V: SimdF64>(&self, [start, rate]: [V; 2], _: [V; 1]) -> [V; 1] {
        [start + V::all(self.h) * rate]
    }
}

impl Integrator for FreeRk4 {
    fn properties(&self) -> Properties {
        PROPERTIES
    }

    fn amplification(&self, omega: f64, damping: f64, dt: f64) -> f64 {
        amplification(omega, damping, dt)
    }

    fn moves_hub(&self) -> bool {
        true
    }

    fn step(&mut self, system: &mut dyn System, time: f64, dt: f64, state: &mut State, work: &mut [f64]) {
        let Some(start) = system.hub().map(|hub| hub.motion.numbers()) else { return };
        let Self { stage, change, acceleration, powers, held, instructions } = self;
        let instructions = *instructions;
        held.clear();
        held.extend_from_slice(system.held());
        let mut of_hub = [0.0; NUMBERS];
        stage.positions.copy_from(&state.positions);
        stage.velocities.copy_from(&state.velocities);
        [&mut change.positions, &mut change.velocities].into_iter().for_each(|vectors| vectors.fill(0.0));
        for k in 0..4 {
            let at = stage.at(time + NODES[k] * dt);
            system.accelerate(at, acceleration, powers);
            system.hub_power(at.time, powers);
            let load = system.hub_load(at, acceleration);
            let Some(hub) = system.hub() else { return };
            let (derivative, rates, [turning, _, of_origin]) =
                (hub.derivative(&load), hub.rates(), hub.accelerations(&load));
            let across = rates.cross_matrix();
            let relative = Relative {
                of_place: Affine { matrix: turning.cross_matrix() + across * across, offset: of_origin },
                of_speed: Affine { matrix: 2.0 * across, offset: Vector3::zeros() },
            };
            let ([x, y, z], [u, v, w]) = (columns(&stage.positions), columns(&stage.velocities));
            each(instructions, &relative, [x, y, z, u, v, w], columns_mut(acceleration));
            held.iter().for_each(|&node| acceleration.row_mut(node).fill(0.0));
            let weight = WEIGHTS[k] * dt;
            let sum = Sum { weight };
            on_axes(instructions, &sum, [columns(&stage.velocities)], [columns_mut(&mut change.positions)]);
            on_axes(instructions, &sum, [columns(acceleration)], [columns_mut(&mut change.velocities)]);
            of_hub.iter_mut().zip(derivative).for_each(|(sum, rate)| *sum += weight * rate);
            work.iter_mut().zip(&*powers).for_each(|(work, power)| *work += weight * power);
            if k < 3 {
                let h = NODES[k + 1] * dt;
                let moved = [columns(&state.positions), columns(&stage.velocities)];
                on_axes(instructions, &Next { h }, moved, [columns_mut(&mut stage.positions)]);
                let kicked = [columns(&state.velocities), columns(acceleration)];
                on_axes(instructions, &Next { h }, kicked, [columns_mut(&mut stage.velocities)]);
                system.set_hub(moved_by(&start, &derivative, h));
            }
        }
        let one = Sum { weight: 1.0 };
        on_axes(instructions, &one, [columns(&change.positions)], [columns_mut(&mut state.positions)]);
        on_axes(instructions, &one, [columns(&change.velocities)], [columns_mut(&mut state.velocities)]);
        let mut motion = moved_by(&start, &of_hub, 1.0);
        motion.attitude = motion.attitude.normalize();
        system.set_hub(motion);
    }
}

/// The motion of the hub after `h` times a derivative. One that is not finite shows in the nodes, which the monitor
/// checks.
fn moved_by(start: &[f64; NUMBERS], derivative: &[f64; NUMBERS], h: f64) -> HubMotion {
    let mut numbers = *start;
    numbers.iter_mut().zip(derivative).for_each(|(number, rate)| *number += h * rate);
    HubMotion::from_numbers(&numbers).unwrap_or_default()
}
