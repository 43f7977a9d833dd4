//! Leapfrog with a free hub, for u' = F/m, and of the hub M V' = F_h, L' = tau:
//!
//!     kick   dt/2    u += dt/2 F/m,   V += dt/2 F_h/M,   L += dt/2 tau
//!     drift  dt      x = c + D^T (x - c + dt (u - V)),   u = D^T u,   V = D^T V,   L = D^T L
//!     kick   dt/2
//!
//! c is the centre of mass of the hub, D its free rotation in dt, all components those along its axes. It is leapfrog
//! in inertial space, where forces depend on places alone: symmetric, symplectic, of order two. Neither centrifugal nor
//! Coriolis forces appear. Each kick and each drift keeps momentum and angular momentum of the whole to rounding. On an
//! axis V and c vanish, and L has one component; a driven hub is one of endless inertia.
//!
//! Forces that depend on velocity are evaluated with predicted velocities, u + dt/2 F_n/m and those of the hub too, as
//! in `leapfrog`, whose sweep serves here too: without Coriolis its correction is that of the second kick. The work
//! of laws and of the motor is integrated by the trapezoidal rule. The energy that is conserved under linear forces is
//! less than the energy by dt^2/8 (sum m a^2 + F_h^2/M + tau . I^-1 tau).
//! Storage: one vector per node beside the state.

use nalgebra::{RowVector3, Vector3};

use super::Affine;
use crate::arrays::history::History;
use crate::arrays::state::{NodeVectors, State, columns, columns_mut};
use crate::integrators::kick_drift::{End, add_work, amplification, begin, energy_shift};
use crate::integrators::{Integrator, Options, Properties, System, leapfrog};
use crate::model::load::Load;
use crate::simd::dispatch::InstructionSet;
use crate::simd::lanes::SimdF64;
use crate::simd::map::{Formula, each};

/// The method and its history.
struct FreeLeapfrog {
    /// a_n in space, the load on the hub, and the power of each law there.
    acceleration: NodeVectors,
    load: Load,
    powers: Vec<f64>,
    /// Work array for the power of laws along links with the corrected velocities.
    exact_powers: Vec<f64>,
    /// F_h^2/M + tau . I^-1 tau \[N2/kg\].
    hub_square: f64,
    /// Held nodes and their positions, while a drift moves all.
    held: Vec<(usize, RowVector3<f64>)>,
    is_started: bool,
    instructions: InstructionSet,
}

/// The method for a scene with a free hub.
pub(crate) fn make(options: &Options) -> Box<dyn Integrator> {
    Box::new(FreeLeapfrog {
        acceleration: NodeVectors::zeros(options.nodes),
        load: Load::default(),
        powers: vec![0.0; options.works],
        exact_powers: vec![0.0; options.works],
        hub_square: 0.0,
        held: Vec::new(),
        is_started: false,
        instructions: options.instructions,
    })
}

/// Half a kick, the drift, and the prediction: numbers x, v, a of a node; v is relative to the frame before, then to
/// the predicted frame.
struct Drift {
    half: f64,
    dt: f64,
    centre: Vector3<f64>,
    velocity: Vector3<f64>,
    /// D^T - 1.
    back: Affine,
    before: Affine,
    predicted: Affine,
}

impl Formula<0, 9> for Drift {
    #[inline(always)]
    fn row<V: SimdF64>(&self, _: [V; 0], [x, y, z, u, v, w, ax, ay, az]: [V; 9]) -> [V; 9] {
        let (half, dt) = (V::all(self.half), V::all(self.dt));
        let (old, a, carried) = ([x, y, z], [ax, ay, az], self.before.of([x, y, z]));
        let (mut speed, mut new, mut arm) = ([u, v, w], old, old);
        for k in 0..3 {
            speed[k] += carried[k] + half * a[k];
            new[k] += dt * (speed[k] - V::all(self.velocity[k]));
            arm[k] = new[k] - V::all(self.centre[k]);
        }
        let (by_turn, speed_by_turn, a_by_turn) = (self.back.of(arm), self.back.of(speed), self.back.of(a));
        for k in 0..3 {
            new[k] += by_turn[k];
        }
        let (carried, mut relative, mut turned) = (self.predicted.of(new), speed, a);
        for k in 0..3 {
            turned[k] += a_by_turn[k];
            relative[k] += speed_by_turn[k] + half * turned[k] - carried[k];
        }
        [new[0], new[1], new[2], relative[0], relative[1], relative[2], turned[0], turned[1], turned[2]]
    }
}

/// Velocities relative to another frame: v += W x + w.
struct Carry {
    change: Affine,
}

impl Formula<3, 3> for Carry {
    #[inline(always)]
    fn row<V: SimdF64>(&self, position: [V; 3], [u, v, w]: [V; 3]) -> [V; 3] {
        let [by_x, by_y, by_z] = self.change.of(position);
        [u + by_x, v + by_y, w + by_z]
    }
}

impl FreeLeapfrog {
    /// Evaluates the load on the hub, moves the hub by half a kick, and adds the power of its turning.
    fn end(&mut self, system: &mut dyn System, time: f64, kick: f64, state: &State) {
        self.load = system.hub_load(state.at(time), &self.acceleration);
        let Some(mut hub) = system.hub().cloned() else { return };
        hub.kick(&self.load, kick);
        self.hub_square = hub.square_of(&self.load);
        system.set_hub(hub.motion);
        system.hub_power(time, &mut self.powers);
    }
}

impl Integrator for FreeLeapfrog {
    fn properties(&self) -> Properties {
        leapfrog::PROPERTIES
    }

    fn amplification(&self, omega: f64, damping: f64, dt: f64) -> f64 {
        amplification(omega, damping, dt)
    }

    fn is_started(&self) -> bool {
        self.is_started
    }

    fn start(&mut self, system: &mut dyn System, time: f64, _dt: f64, state: &mut State, _work: &mut [f64]) {
        begin(system, state.at(time), &mut self.acceleration, &mut self.powers);
        self.end(system, time, 0.0, state);
        self.is_started = true;
    }

    fn step(&mut self, system: &mut dyn System, time: f64, dt: f64, state: &mut State, work: &mut [f64]) {
        let Some(mut hub) = system.hub().cloned() else { return };
        let half = 0.5 * dt;
        add_work(work, half, &self.powers);
        let before = Affine::carried(&hub.rates(), &hub.velocity_of_origin());
        hub.kick(&self.load, half);
        let velocity = hub.motion.velocity;
        let turn = hub.drift(dt);
        let motion = hub.motion;
        hub.kick(&Load { force: turn.back(self.load.force), torque: turn.back(self.load.torque) }, half);
        let (rates, of_origin) = (hub.rates(), hub.velocity_of_origin());
        let predicted = Affine::carried(&rates, &of_origin);
        let back = Affine { matrix: turn.excess.transpose(), offset: Vector3::zeros() };
        let drift = Drift { half, dt, centre: hub.centre(), velocity, back, before, predicted };
        self.held.clear();
        self.held.extend(system.held().iter().map(|&node| (node, state.positions.row(node).into_owned())));
        let ([x, y, z], [u, v, w]) = (columns_mut(&mut state.positions), columns_mut(&mut state.velocities));
        let [ax, ay, az] = columns_mut(&mut self.acceleration);
        each(self.instructions, &drift, [], [x, y, z, u, v, w, ax, ay, az]);
        for (node, position) in &self.held {
            state.positions.set_row(*node, position);
            state.velocities.row_mut(*node).fill(0.0);
        }
        system.set_hub(hub.motion);
        let Self { acceleration, powers, exact_powers, instructions, .. } = self;
        let end = End { time: time + dt, half, accelerations: acceleration, powers, instructions: *instructions };
        end.correct(system, state, None, None, Some(exact_powers));
        // The evaluation had the predicted hub; the kick begins from the end of the drift.
        system.set_hub(motion);
        self.end(system, time + dt, half, state);
        let Some(hub) = system.hub() else { return };
        let change = Affine::carried(&(rates - hub.rates()), &(of_origin - hub.velocity_of_origin()));
        let changed = columns_mut(&mut state.velocities);
        each(self.instructions, &Carry { change }, columns(&state.positions), changed);
        self.held.iter().for_each(|(node, _)| state.velocities.row_mut(*node).fill(0.0));
        add_work(work, half, &self.powers);
    }

    fn energy_shift(&self, masses: &[f64], dt: f64) -> f64 {
        energy_shift(&self.acceleration, masses, dt) - 0.125 * dt * dt * self.hub_square
    }

    fn moves_hub(&self) -> bool {
        true
    }

    fn history(&self) -> History {
        if !self.is_started {
            return History::default();
        }
        let Load { force, torque } = self.load;
        let mut numbers = self.powers.clone();
        numbers.extend(force.iter().chain(&torque).chain([&self.hub_square]));
        History { vectors: vec![self.acceleration.clone()], numbers }
    }

    fn restore_history(&mut self, history: History) -> bool {
        self.is_started = !history.vectors.is_empty();
        if !self.is_started {
            return history.numbers.is_empty();
        }
        let works = self.powers.len();
        if history.vectors.len() != 1 || history.numbers.len() != works + 7 {
            return false;
        }
        let (powers, of_hub) = history.numbers.split_at(works);
        self.acceleration.copy_from(&history.vectors[0]);
        self.powers.copy_from_slice(powers);
        self.load =
            Load { force: Vector3::from_column_slice(&of_hub[..3]), torque: Vector3::from_column_slice(&of_hub[3..6]) };
        self.hub_square = of_hub[6];
        true
    }
}
