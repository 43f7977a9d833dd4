//! The methods of time integration, one per file, and the one list of them.
//!
//! A method sees a system that fills accelerations at (t, x, v), and nothing else: no law, no mesh.

mod controller;
mod dopri5;
mod generalized_alpha;
mod leapfrog;
mod multirate;
mod rk4;

use std::ops::Range;

use nalgebra::Complex;

use crate::arrays::blocks::{row_blocks, rows_of, tiles};
use crate::arrays::state::{Instant, NodeVectors, State, rows_mut};
use crate::error::{Error, Result};
use crate::linear::tangent::Weights;
use crate::simd::dispatch::InstructionSet;

pub use controller::Controller;

/// Which laws a method takes that tells them apart by their pace.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RateGroup {
    /// Those that ask for short steps.
    Fast,
    /// The others.
    Slow,
}

/// What is integrated: x'' = a(t, x, v).
pub trait System {
    /// Says which laws the following evaluations take; all, where nothing is said. For methods that tell laws apart.
    fn select_rate_group(&mut self, group: RateGroup);
    /// Works out what nodes do to each other at this instant, as far as it concerns the rows of a tile; the first tile starts
    /// the power of each law anew. Tiles come in order.
    fn accumulate_forces(&mut self, tile: usize, at: Instant<'_>, powers: &mut [f64]);
    /// Fills the accelerations \[m/s2\] of `rows`, a stretch of the tile of the last `accumulate_forces`, and adds to the
    /// power by which each law changes the mechanical energy \[W\]. Each row is asked for once, but
    /// what is known of it may be changed as soon as it is done: so methods can use a stretch while it is in the cache.
    fn accelerations(
        &mut self,
        rows: Range<usize>,
        at: Instant<'_>,
        accelerations: [&mut [f64]; 3],
        powers: &mut [f64],
    );
    /// Fills all accelerations \[m/s2\], and the power of each law \[W\].
    fn accelerate(&mut self, at: Instant<'_>, accelerations: &mut NodeVectors, powers: &mut [f64]) {
        let count = at.positions.nrows();
        for tile in tiles(count) {
            self.accumulate_forces(tile, at, powers);
            for rows in row_blocks(rows_of(tile, count)) {
                self.accelerations(rows.clone(), at, rows_mut(accelerations, rows), powers);
            }
        }
    }
    /// The rate w \[1/s\] of the part w (v_y, -v_x, 0) of the accelerations: that of Coriolis, w = 2 Omega.
    fn coriolis_rate(&self, time: f64) -> f64;
    /// For methods that say `evaluates_elsewhere`: laws without a potential leave their power out of `accumulate_forces` and `accelerations`,
    /// and it is added here. That of laws which act on each node by itself: after each `accelerations`, the power of these forces on
    /// the `velocities` of these rows.
    fn row_power_at(&mut self, rows: Range<usize>, velocities: [&[f64]; 3], powers: &mut [f64]);
    /// That of laws between nodes: after all rows, the power of the forces of the last `accumulate_forces` on the velocities of `at`,
    /// whose positions are the same.
    fn power_at(&mut self, at: Instant<'_>, powers: &mut [f64]);
    /// Factorises the symmetric part of a M - b dF/dv - c dF/dx, for methods that say `is_implicit`. Whether it is positive
    /// definite.
    fn factorise(&mut self, at: Instant<'_>, weights: Weights) -> bool;
    /// Replaces accelerations r by the u that the matrix factorised last takes to M r; 0 for nodes that are held.
    fn solve(&mut self, accelerations: &mut NodeVectors);
}

/// The spectral radius that is taken where none is given: what a step cannot resolve is gone after some dozens.
pub const SPECTRAL_RADIUS: f64 = 0.8;

/// What an implicit method has spent.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Statistics {
    /// Corrections of Newton's method.
    pub iterations: u64,
    /// Factorisations of the tangent.
    pub factorisations: u64,
    /// Steps, or parts of steps, that were halved because Newton's method failed.
    pub fallbacks: u64,
}

/// A step that could not be taken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stall {
    /// From when \[s\].
    pub time: f64,
    /// The smallest part of the step that was tried \[s\].
    pub dt: f64,
    /// The node whose correction was the largest, in the core's numbering.
    pub node: usize,
}

/// What a method keeps from one step to the next beside the state; empty before its first step.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct History {
    /// One vector per node each, in the core's numbering.
    pub vectors: Vec<NodeVectors>,
    /// Whatever else.
    pub numbers: Vec<f64>,
}

/// A method with its stages preallocated.
pub trait Integrator: Send + Sync {
    /// The name in the list.
    fn name(&self) -> &'static str;
    /// Order of the error after a given time.
    fn order(&self) -> u32;
    /// Evaluations of the accelerations per step.
    fn evaluations_per_step(&self) -> u32;
    /// Evaluations before the first step, and after positions or velocities were set.
    fn evaluations_at_start(&self) -> u32 {
        0
    }
    /// Whether the energy of an undamped motion stays bounded, however long it lasts.
    fn keeps_energy(&self) -> bool {
        false
    }
    /// Whether forces are evaluated with velocities that differ from those they work on.
    fn evaluates_elsewhere(&self) -> bool {
        false
    }
    /// The method by which slow laws move nodes, one step at a time, of a method that tells laws apart by their pace.
    fn for_slow_laws(&self) -> Option<Box<dyn Integrator>> {
        None
    }
    /// Whether it solves for the end of a step with the tangent: then no mode limits the step.
    fn is_implicit(&self) -> bool {
        false
    }
    /// Sets by what factor vibrations shrink that the step cannot resolve, for methods that have such a choice.
    fn set_spectral_radius(&mut self, _spectral_radius: f64) {}
    /// The same method with `count` short steps in a step, between which slow laws rest, where it has such a form.
    fn in_substeps(&self, _count: u32) -> Option<Box<dyn Integrator>> {
        None
    }
    /// What is spent on Newton's method.
    fn statistics(&self) -> Statistics {
        Statistics::default()
    }
    /// The last step, where it could not be taken; the state is then somewhere within it.
    fn stalled(&self) -> Option<Stall> {
        None
    }
    /// The largest factor by which a step multiplies a solution of x'' = -omega^2 x - damping x'.
    fn amplification(&self, omega: f64, damping: f64, dt: f64) -> f64;
    /// The w of a method that is stable as long as dt^2 omega^2 + w dt damping is below the same bound for every shape that a
    /// scene can take, 4 for leapfrog;
    /// `None` for one that multiplies each solution exp(lambda t) by a function of lambda dt.
    fn damping_weight(&self) -> Option<f64> {
        None
    }

    /// Whether a step can be taken without `start`.
    fn is_started(&self) -> bool {
        true
    }
    /// Evaluates what the first step needs.
    fn start(&mut self, _system: &mut dyn System, _time: f64, _state: &State) {}
    /// Advances `state` from `time` by `dt`, and adds to `work` the integral of each law's power \[J\].
    fn step(&mut self, system: &mut dyn System, time: f64, dt: f64, state: &mut State, work: &mut [f64]);

    /// What the method conserves in place of the energy, minus the energy, as far as it is known \[J\].
    fn energy_shift(&self, _masses: &[f64], _dt: f64) -> f64 {
        0.0
    }
    /// What is kept from step to step.
    fn history(&self) -> History {
        History::default()
    }
    /// Takes up a history; an empty one asks for a new start. Whether it fits.
    fn restore_history(&mut self, history: History) -> bool {
        history == History::default()
    }
    /// The method as one that knows its own error.
    fn embedded(&mut self) -> Option<&mut dyn Embedded> {
        None
    }
}

/// A method that estimates the error of its step, and knows the motion within it.
pub trait Embedded {
    /// Tries a step from `state`, and gives its error; 1 is what `tolerance` allows. Not finite where the step blew up.
    fn attempt(&mut self, system: &mut dyn System, from: Start<'_>, dt: f64, tolerance: &Tolerance) -> f64;
    /// Takes the step that was tried last.
    fn accept(&mut self, state: &mut State, work: &mut [f64]);
    /// The motion and the work at `time` within the last accepted step, which ended at `end`.
    fn between(&self, end: Start<'_>, time: f64) -> (State, Vec<f64>);
}

/// Where a step starts or ends.
#[derive(Debug, Clone, Copy)]
pub struct Start<'a> {
    /// Time \[s\].
    pub time: f64,
    /// Motion.
    pub state: &'a State,
    /// Work of each law so far \[J\].
    pub work: &'a [f64],
}

/// The error that one step may make on any node: `relative` (length^2 + |x|^2)^1/2 in position, `relative` (speed^2 +
/// |v|^2)^1/2 in velocity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerance {
    /// Without dimension.
    pub relative: f64,
    /// Distance from the origin below which the tolerance is absolute \[m\].
    pub length: f64,
    /// Speed below which it is \[m/s\].
    pub speed: f64,
}

/// The larger |R(lambda dt)| of the two solutions exp(lambda t) of x'' = -omega^2 x - damping x'.
fn amplification_of(
    stability_function: impl Fn(Complex<f64>) -> Complex<f64>,
    omega: f64,
    damping: f64,
    dt: f64,
) -> f64 {
    let root = Complex::new(0.25 * damping * damping - omega * omega, 0.0).sqrt();
    let size = |lambda: Complex<f64>| stability_function(lambda * dt).norm();
    size(root - 0.5 * damping).max(size(-root - 0.5 * damping))
}

type Maker = fn(nodes: usize, laws: usize, width: InstructionSet) -> Box<dyn Integrator>;

/// The one list: name and maker.
const INTEGRATORS: &[(&str, Maker)] = &[
    ("rk4", |nodes, laws, width| Box::new(rk4::Rk4::new(nodes, laws, width))),
    ("leapfrog", |nodes, laws, width| Box::new(leapfrog::Leapfrog::new(nodes, laws, width))),
    ("dopri5", |nodes, laws, width| Box::new(dopri5::Dopri5::new(nodes, laws, width))),
    ("generalized_alpha", |nodes, laws, _| Box::new(generalized_alpha::GeneralizedAlpha::new(nodes, laws))),
];

/// The names in the list.
pub fn names() -> impl Iterator<Item = &'static str> {
    INTEGRATORS.iter().map(|(name, _)| *name)
}

/// The method called `name`, with stages for `nodes` nodes and `laws` laws.
///
/// # Errors
/// `UnknownName`, with the names there are.
pub fn by_name(name: &str, nodes: usize, laws: usize, width: InstructionSet) -> Result<Box<dyn Integrator>> {
    let found = INTEGRATORS.iter().find(|(known, _)| *known == name);
    let known = || names().collect::<Vec<_>>().join(", ");
    found.map(|(_, make)| make(nodes, laws, width)).ok_or_else(|| Error::UnknownName {
        what: "integrator",
        name: name.to_owned(),
        known: known(),
    })
}
