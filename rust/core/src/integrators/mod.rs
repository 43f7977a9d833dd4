//! The methods of time integration, one per file, and the one list of them.
//!
//! A method sees a system that fills accelerations at (t, x, v), and nothing else: no law, no mesh.

mod rk4;

use nalgebra::Complex;

use crate::error::{Error, Result};
use crate::state::{Instant, State, Vectors};
use crate::width::Width;

/// What is integrated: x'' = a(t, x, v).
pub trait System {
    /// Fills the accelerations \[m/s2\], and for each law the power by which it changes the mechanical energy \[W\].
    fn accelerate(&mut self, at: Instant<'_>, accelerations: &mut Vectors, powers: &mut [f64]);
}

/// A method with its stages preallocated.
pub trait Integrator: Send + Sync {
    /// The name in the list.
    fn name(&self) -> &'static str;
    /// Order of the error after a given time.
    fn order(&self) -> u32;
    /// Evaluations of the accelerations per step.
    fn evaluations_per_step(&self) -> u32;
    /// |R(z)|, the factor by which a step multiplies a solution exp(lambda t), z = lambda dt.
    fn amplification(&self, z: Complex<f64>) -> f64;
    /// Advances `state` from `time` by `dt`, and adds to `work` the integral of each law's power \[J\].
    fn step(&mut self, system: &mut dyn System, time: f64, dt: f64, state: &mut State, work: &mut [f64]);
}

type Maker = fn(nodes: usize, laws: usize, width: Width) -> Box<dyn Integrator>;

/// The one list: name and maker.
const INTEGRATORS: &[(&str, Maker)] = &[("rk4", |nodes, laws, width| Box::new(rk4::Rk4::new(nodes, laws, width)))];

/// The names in the list.
pub fn names() -> impl Iterator<Item = &'static str> {
    INTEGRATORS.iter().map(|(name, _)| *name)
}

/// The method called `name`, with stages for `nodes` nodes and `laws` laws.
///
/// # Errors
/// `UnknownName`, with the names there are.
pub fn by_name(name: &str, nodes: usize, laws: usize, width: Width) -> Result<Box<dyn Integrator>> {
    let found = INTEGRATORS.iter().find(|(known, _)| *known == name);
    let known = || names().collect::<Vec<_>>().join(", ");
    found.map(|(_, make)| make(nodes, laws, width)).ok_or_else(|| Error::UnknownName {
        what: "integrator",
        name: name.to_owned(),
        known: known(),
    })
}
