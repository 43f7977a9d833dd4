//! The methods of time integration, one per file, and the one list of them.
//!
//! A method sees a system that fills accelerations at (t, x, v), and nothing else: no law, no mesh.

mod controller;
mod dopri5;
mod generalized_alpha;
mod kick_drift;
mod leapfrog;
mod multirate;
mod rk4;
mod system;

use nalgebra::Complex;

use crate::arrays::history::History;
use crate::arrays::state::State;
use crate::error::{Error, Result};
use crate::simd::dispatch::InstructionSet;

pub use controller::Controller;
pub use system::{RateGroup, System};

/// The spectral radius that is taken where none is given: what a step cannot resolve is gone after some dozens.
pub const SPECTRAL_RADIUS: f64 = 0.8;

/// What a method's maker is given.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Nodes of the scene.
    pub nodes: usize,
    /// Its laws.
    pub laws: usize,
    /// The instructions that passes over nodes run with.
    pub instructions: InstructionSet,
    /// By what factor an implicit method shrinks, per step, vibrations that it cannot resolve; from 0 to 1.
    pub spectral_radius: f64,
    /// Substeps in a step, between which slow laws rest, of a method that has such a form.
    pub substeps: u32,
}

impl Default for Options {
    /// Of no scene: enough to ask a method for its properties.
    fn default() -> Self {
        let instructions = InstructionSet::Baseline;
        Self { nodes: 1, laws: 0, instructions, spectral_radius: SPECTRAL_RADIUS, substeps: 1 }
    }
}

/// What is known of a method, whatever it integrates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Properties {
    /// The name in the list.
    pub name: &'static str,
    /// Order of the error after a given time.
    pub order: u32,
    /// Evaluations of the accelerations per step.
    pub evaluations_per_step: u32,
    /// Evaluations before the first step, and after positions or velocities were set.
    pub evaluations_at_start: u32,
    /// Whether the energy of an undamped motion stays bounded, however long it lasts.
    pub conserves_energy: bool,
    /// Whether forces are evaluated with predicted velocities, other than those on which they do work.
    pub predicts_velocity: bool,
    /// Whether it solves for the end of a step with the tangent: then no mode limits the step.
    pub is_implicit: bool,
    /// The w of a method that is stable as long as dt^2 omega^2 + w dt damping is below the same bound for every shape that
    /// a scene can take, 4 for leapfrog; `None` for one that multiplies each solution exp(lambda t) by a function of
    /// lambda dt.
    pub damping_weight: Option<f64>,
}

impl Properties {
    /// Those of an explicit one-step method of this order that evaluates so often per step.
    const fn explicit(name: &'static str, order: u32, evaluations_per_step: u32) -> Self {
        Self {
            name,
            order,
            evaluations_per_step,
            evaluations_at_start: 0,
            conserves_energy: false,
            predicts_velocity: false,
            is_implicit: false,
            damping_weight: None,
        }
    }
}

/// A method with its stages preallocated.
pub trait Integrator: Send + Sync {
    /// What is known of it.
    fn properties(&self) -> Properties;
    /// The largest factor by which a step multiplies a solution of x'' = -omega^2 x - damping x'.
    fn amplification(&self, omega: f64, damping: f64, dt: f64) -> f64;
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
    /// Goes on from a history; an empty one asks for a new start. Whether it fits.
    fn restore_history(&mut self, history: History) -> bool {
        history == History::default()
    }
    /// The method by which slow laws move nodes, one step at a time, of a method that tells laws apart by their rate.
    fn for_slow_laws(&self) -> Option<Box<dyn Integrator>> {
        None
    }
    /// The method as one that solves equations.
    fn implicit(&self) -> Option<&dyn Implicit> {
        None
    }
    /// The method as one that knows its own error.
    fn embedded(&mut self) -> Option<&mut dyn Embedded> {
        None
    }
}

/// A method that solves for the end of a step by Newton's method.
pub trait Implicit {
    /// What was spent so far.
    fn statistics(&self) -> Statistics;
    /// The last step, where it could not be taken; the state is then somewhere within it.
    fn stalled(&self) -> Option<Stall>;
}

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

/// A method by its name: what makes it for a scene.
#[derive(Debug, Clone, Copy)]
pub struct Method {
    /// The name that scenes use.
    pub name: &'static str,
    /// Makes it.
    pub make: fn(&Options) -> Box<dyn Integrator>,
}

/// The one list.
pub const METHODS: &[Method] = &[
    Method { name: "rk4", make: rk4::make },
    Method { name: "leapfrog", make: leapfrog::make },
    Method { name: "dopri5", make: dopri5::make },
    Method { name: "generalized_alpha", make: generalized_alpha::make },
];

/// The method called `name`.
///
/// # Errors
/// `UnknownName`, with the names there are.
pub fn by_name(name: &str) -> Result<Method> {
    let known = || METHODS.iter().map(|method| method.name).collect::<Vec<_>>().join(", ");
    METHODS.iter().find(|method| method.name == name).copied().ok_or_else(|| Error::UnknownName {
        what: "integrator",
        name: name.to_owned(),
        known: known(),
    })
}
