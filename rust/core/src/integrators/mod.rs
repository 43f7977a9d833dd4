//! The methods of time integration, one per file, and their list.
//!
//! A method knows a system that fills accelerations at (t, x, v), but neither laws nor a mesh.

mod controller;
mod dopri5;
mod free_hub;
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
pub(crate) use kick_drift::begin as evaluate;
pub use system::{Kick, NetForces, RateGroup, System};

/// Default spectral radius: unresolved vibrations decay within some dozens of steps.
pub const SPECTRAL_RADIUS: f64 = 0.8;

/// Input to the constructors of methods.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Number of nodes of the scene.
    pub nodes: usize,
    /// Number of works that it integrates: those of the laws, and the one behind them (see `Ledger::work`).
    pub works: usize,
    /// The instruction set of passes over nodes.
    pub instructions: InstructionSet,
    /// Amplification per step, from 0 to 1, of vibrations that the step of an implicit method does not resolve.
    pub spectral_radius: f64,
    /// Substeps in a step, for methods with substeps; slow laws are evaluated once a step.
    pub substeps: u32,
    /// Whether the hub is free, for methods that move it with the nodes.
    pub is_hub_free: bool,
}

impl Default for Options {
    /// Those of no scene, sufficient for the properties of a method.
    fn default() -> Self {
        let instructions = InstructionSet::Baseline;
        Self { nodes: 1, works: 0, instructions, spectral_radius: SPECTRAL_RADIUS, substeps: 1, is_hub_free: false }
    }
}

/// Properties of a method, independent of the system.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Properties {
    /// Name in the list.
    pub name: &'static str,
    /// Order of the global error.
    pub order: u32,
    /// c and p of the error c (omega dt)^p by which the frequency of x'' = -omega^2 x is wrong, relative to omega, for
    /// small omega dt.
    pub frequency_error: (f64, u8),
    /// Evaluations of the accelerations per step.
    pub evaluations_per_step: u32,
    /// Evaluations before the first step, and after a change of positions or velocities.
    pub evaluations_at_start: u32,
    /// Whether the energy error of an undamped motion is bounded for all times.
    pub conserves_energy: bool,
    /// Whether forces are evaluated with predicted velocities, which differ from those of their power.
    pub predicts_velocity: bool,
    /// Whether the method solves for the end of a step with the tangent; then no mode limits the step.
    pub is_implicit: bool,
    /// w of a method whose limit is dt^2 omega^2 + w dt damping = 4 with the Rayleigh quotients of any shape of the
    /// scene; `None` for a method that multiplies each solution exp(lambda t) by a function of lambda dt.
    pub damping_weight: Option<f64>,
}

impl Properties {
    /// Those of an explicit one-step method.
    const fn explicit(name: &'static str, order: u32, evaluations_per_step: u32, frequency_error: (f64, u8)) -> Self {
        Self {
            name,
            order,
            frequency_error,
            evaluations_per_step,
            evaluations_at_start: 0,
            conserves_energy: false,
            predicts_velocity: false,
            is_implicit: false,
            damping_weight: None,
        }
    }
}

/// A method with preallocated stages.
pub trait Integrator: Send + Sync {
    /// Its properties.
    fn properties(&self) -> Properties;
    /// The largest factor by which a step multiplies a solution of x'' = -omega^2 x - damping x'.
    fn amplification(&self, omega: f64, damping: f64, dt: f64) -> f64;
    /// Whether a step is possible without `start`.
    fn is_started(&self) -> bool {
        true
    }
    /// Evaluates the data of the first step, of length `dt`. Impulses for its drift change `state`, and add to `work`.
    fn start(&mut self, _system: &mut dyn System, _time: f64, _dt: f64, _state: &mut State, _work: &mut [f64]) {}
    /// Advances `state` from `time` by `dt`, and adds the integral of the power of each law to `work` \[J\].
    fn step(&mut self, system: &mut dyn System, time: f64, dt: f64, state: &mut State, work: &mut [f64]);
    /// The modified energy that the method conserves, minus the energy \[J\]; 0 where none is known.
    fn energy_shift(&self, _masses: &[f64], _dt: f64) -> f64 {
        0.0
    }
    /// Data kept from step to step.
    fn history(&self) -> History {
        History::default()
    }
    /// Continues from a history; an empty one requires a new start. Whether its sizes fit.
    fn restore_history(&mut self, history: History) -> bool {
        history == History::default()
    }
    /// The method whose limit bounds the step for slow laws, of a method with rate groups.
    fn for_slow_laws(&self) -> Option<Box<dyn Integrator>> {
        None
    }
    /// Whether laws may change velocities between its kicks.
    fn takes_impulses(&self) -> bool {
        false
    }
    /// Whether it moves a free hub with the nodes.
    fn moves_hub(&self) -> bool {
        false
    }
    /// The method as an implicit one.
    fn implicit(&self) -> Option<&dyn Implicit> {
        None
    }
    /// The method as an embedded pair.
    fn embedded(&mut self) -> Option<&mut dyn Embedded> {
        None
    }
}

/// A method that finds the end of a step by Newton's method.
pub trait Implicit {
    /// Counts so far.
    fn statistics(&self) -> Statistics;
    /// The last step, if Newton's method failed; the state is then at the last part that converged.
    fn stalled(&self) -> Option<Stall>;
}

/// Counts of an implicit method.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Statistics {
    /// Corrections of Newton's method.
    pub iterations: u64,
    /// Factorisations of the tangent.
    pub factorisations: u64,
    /// Halvings of steps or parts of steps after a failure of Newton's method.
    pub fallbacks: u64,
}

/// A step in which Newton's method failed at every halving.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stall {
    /// Its start \[s\].
    pub time: f64,
    /// The smallest part attempted \[s\].
    pub dt: f64,
    /// The node with the largest correction, internal number.
    pub node: usize,
}

/// A method with an error estimate and a continuous extension.
pub trait Embedded {
    /// Attempts a step, and returns its estimated error over that of `tolerance`; not finite where the step diverges.
    fn attempt(&mut self, system: &mut dyn System, from: Endpoint<'_>, dt: f64, tolerance: &Tolerance) -> f64;
    /// Accepts the last attempt.
    fn accept(&mut self, state: &mut State, work: &mut [f64]);
    /// Motion and work at `time` within the last accepted step, which ended at `end`.
    fn interpolate(&self, end: Endpoint<'_>, time: f64) -> (State, Vec<f64>);
}

/// The start or the end of a step.
#[derive(Debug, Clone, Copy)]
pub struct Endpoint<'a> {
    /// Time \[s\].
    pub time: f64,
    /// Motion.
    pub state: &'a State,
    /// Work of each law since the start \[J\].
    pub work: &'a [f64],
}

/// The allowed error of a step on each node: `relative` (length^2 + |x|^2)^1/2 in position, `relative` (speed^2 +
/// |v|^2)^1/2 in velocity, with x and v of pieces that nothing holds relative to their centres of mass.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerance {
    /// Relative tolerance.
    pub relative: f64,
    /// Distance from the origin below which the tolerance is absolute \[m\].
    pub length: f64,
    /// Speed below which the tolerance is absolute \[m/s\].
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
    let modulus = |lambda: Complex<f64>| stability_function(lambda * dt).norm();
    modulus(root - 0.5 * damping).max(modulus(-root - 0.5 * damping))
}

/// An entry of the list: name and constructor.
#[derive(Debug, Clone, Copy)]
pub struct Method {
    /// Name in scenes.
    pub name: &'static str,
    /// Constructor for a scene.
    pub make: fn(&Options) -> Box<dyn Integrator>,
}

/// The list of methods.
pub const METHODS: &[Method] = &[
    Method { name: "rk4", make: make_rk4 },
    Method { name: "leapfrog", make: make_leapfrog },
    Method { name: "dopri5", make: dopri5::make },
    Method { name: "generalized_alpha", make: generalized_alpha::make },
];

/// Leapfrog, with a free hub, or with substeps where more than one is set.
fn make_leapfrog(options: &Options) -> Box<dyn Integrator> {
    match options {
        Options { is_hub_free: true, .. } => free_hub::leapfrog::make(options),
        Options { substeps: 2.., .. } => multirate::make(options),
        _ => leapfrog::make(options),
    }
}

/// The method of Runge and Kutta, with a free hub or without.
fn make_rk4(options: &Options) -> Box<dyn Integrator> {
    if options.is_hub_free { free_hub::rk4::make(options) } else { rk4::make(options) }
}

/// The method called `name`.
///
/// # Errors
/// `UnknownName`, with the known names.
pub fn by_name(name: &str) -> Result<Method> {
    let known = || METHODS.iter().map(|method| method.name).collect::<Vec<_>>().join(", ");
    METHODS.iter().find(|method| method.name == name).copied().ok_or_else(|| Error::UnknownName {
        what: "integrator",
        name: name.to_owned(),
        known: known(),
    })
}

/// The number of works in a saved history of so many `numbers`, `each` for every work and `others` beside them: that of
/// the scene, or one less in states of earlier versions, which lack the one behind those of the laws.
fn saved_works(works: usize, numbers: usize, each: usize, others: usize) -> Option<usize> {
    [works, works.saturating_sub(1)].into_iter().find(|count| numbers == each * count + others)
}
