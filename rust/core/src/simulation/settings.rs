//! The input of a simulation: its constituents, and the settings of monitor, step and kernels.

use crate::assembly::Assembly;
use crate::error::{Error, Result};
use crate::integrators::{self, Integrator, Method, Tolerance};
use crate::laws::Law;
use crate::model::frame::Spin;
use crate::simd::dispatch::InstructionSet;
use crate::stability::Limit;

/// Settings of the monitor, of the choice of the step, and of the kernels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Default step, relative to the stability limit.
    pub margin: f64,
    /// Number of steps between two regular checks of the monitor.
    pub check_interval: u64,
    /// Largest spurious gain, relative to the reference energy.
    pub energy_tolerance: f64,
    /// Largest residual of the energy balance, of either sign, relative to the reference energy.
    pub loss_tolerance: f64,
    /// Allowed error of a step, for a method with an error estimate and without a given step.
    pub tolerance: Tolerance,
    /// Amplification per step, from 0 to 1, of vibrations that the step of an implicit method does not resolve.
    pub spectral_radius: f64,
    /// Substeps in a step of leapfrog; slow laws are evaluated once a step.
    pub substeps: u32,
    /// The time at which everything that depends on time is frozen, for relaxation \[s\]; `None`: time passes.
    pub frozen_at: Option<f64>,
    /// The instruction set of the kernels; results have the same bits with each.
    pub instructions: InstructionSet,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            margin: 0.4,
            check_interval: 32,
            energy_tolerance: 1e-2,
            loss_tolerance: 0.05,
            tolerance: Tolerance { relative: 1e-5, length: 0.1, speed: 1.0 },
            spectral_radius: integrators::SPECTRAL_RADIUS,
            substeps: 1,
            frozen_at: None,
            instructions: InstructionSet::widest(),
        }
    }
}

impl Settings {
    /// Refuses what a free hub does not go with.
    ///
    /// # Errors
    /// `FreeHub`.
    pub(super) fn check_free_hub(&self, spin: &Spin, method: &dyn Integrator, laws: &[Box<dyn Law>]) -> Result<()> {
        if spin.hub.is_none() {
            return Ok(());
        }
        let refuse = |what: String, remedy| Err(Error::FreeHub { what, remedy });
        if self.substeps > 1 {
            return refuse(format!("substeps = {}", self.substeps), "take one substep");
        }
        if !method.moves_hub() {
            return refuse(format!("the method {}", method.properties().name), "take leapfrog or rk4");
        }
        if self.frozen_at.is_some() {
            return refuse("a frozen time".to_owned(), "drive the hub while the scene is relaxed");
        }
        let mut unfit = laws.iter().filter_map(|law| Some((law.name(), law.remedy_on_free_hub()?)));
        unfit.next().map_or(Ok(()), |(name, remedy)| refuse(format!("the law {name}"), remedy))
    }
}

/// Refuses what laws that act by impulses do not go with.
///
/// # Errors
/// `Impulses`.
pub(super) fn check_impulses(settings: &Settings, method: &dyn Integrator, laws: &[Box<dyn Law>]) -> Result<()> {
    let Some(law) = laws.iter().find(|law| law.has_impulses()).map(|law| law.name()) else { return Ok(()) };
    if !method.takes_impulses() {
        let what = format!("the method {}", method.properties().name);
        return Err(Error::Impulses { what, law, remedy: "take leapfrog" });
    }
    if settings.frozen_at.is_some() {
        let what = "a frozen time".to_owned();
        return Err(Error::Impulses { what, law, remedy: "relax the scene without it" });
    }
    Ok(())
}

/// The constituents of a simulation.
pub struct Setup {
    /// The assembled model.
    pub assembly: Assembly,
    /// The laws, in the order of the energy terms.
    pub laws: Vec<Box<dyn Law>>,
    /// The motion of the hub.
    pub spin: Spin,
    /// The method.
    pub method: Method,
    /// The step \[s\]; see `Simulation::new`.
    pub dt: Option<f64>,
    /// The limit of the step at the start, if known; its computation takes as long as some hundred steps.
    pub limit: Option<Limit>,
}
