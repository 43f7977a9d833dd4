//! The largest frequency of a scene, the stable step that follows from it, and the part that sets it.
//!
//! The stiffness matrix K is the sum of what every law can show at its stiffest at the current positions: all springs
//! taut, all creases in contact, all contacts closed. The largest eigenvalues of M^-1/2 K M^-1/2 and M^-1/2 C M^-1/2 come
//! from Lanczos's method.

use super::oscillator::{Mode, largest_step};
use super::quadratic_eigenproblem::{self, Linear};
use crate::arrays::state::NodeVectors;
use crate::error::Result;
use crate::integrators::Integrator;
use crate::laws::Instant;
use crate::laws::Law;
use crate::linear::lanczos::{largest, quotient};

/// What limits the step.
#[derive(Debug, Clone, PartialEq)]
pub struct Limit {
    /// The largest stable step of the integrator that was asked for \[s\]; infinite where nothing is stiff.
    pub dt: f64,
    /// Largest frequency \[rad/s\].
    pub largest_frequency: f64,
    /// The law that is stiffest in the limiting mode.
    pub law: &'static str,
    /// The node that moves most in it, in the core's numbering.
    pub node: usize,
}

/// The limit of `integrator` for these laws at this instant.
///
/// Without damping the mode of the largest frequency sets it. With damping it may be a mode that is neither the
/// stiffest nor the most damped one; see `quadratic_eigenproblem`.
///
/// # Errors
/// `NotFinite` where an eigenvalue is not, which takes coordinates that are not.
pub fn limit(integrator: &dyn Integrator, laws: &[&dyn Law], at: Instant<'_>, inverse_masses: &[f64]) -> Result<Limit> {
    let linearised = || laws.iter().filter_map(|law| law.linearisation());
    let stiffness =
        |p: &NodeVectors, out: &mut NodeVectors| linearised().for_each(|law| law.add_stiffness_product(at, p, out));
    let damping =
        |p: &NodeVectors, out: &mut NodeVectors| linearised().for_each(|law| law.add_damping_product(at, p, out));
    let roots: Vec<f64> = inverse_masses.iter().map(|inverse| inverse.sqrt()).collect();
    let (square, stiffest) = largest(&stiffness, &roots)?;
    let (rate, most_damped) = largest(&damping, &roots)?;
    // Coriolis acts with 2 Omega; what turns against the frame turns faster by Omega.
    let turning_of = |law: &dyn Law| law.linearisation().map_or(0.0, |law| 0.5 * law.coriolis_rate(at.frame).abs());
    let turning = laws.iter().map(|law| turning_of(*law)).fold(0.0, f64::max);
    let omega = square.max(0.0).sqrt();
    let system = Linear { stiffness: &stiffness, damping: &damping, roots: &roots, turning };
    let properties = integrator.properties();
    let (dt, mode, pace) = if properties.is_implicit {
        (f64::INFINITY, stiffest, omega)
    } else if rate > 0.0 {
        let start = [stiffest, most_damped];
        match properties.damping_weight {
            Some(weight) => quadratic_eigenproblem::worst_of_sum(integrator, &system, start, weight)?,
            None => quadratic_eigenproblem::worst(integrator, &system, start, omega.max(rate))?,
        }
    } else {
        (largest_step(integrator, Mode { omega: omega + turning, damping: 0.0 }), stiffest, omega)
    };
    // The law with the largest share of the mode's stiffness and damping; the frame's, where its turning is faster.
    let share = |law: &dyn Law| {
        let Some(own) = law.linearisation() else { return 0.0 };
        let elastic = quotient(&|p, out| own.add_stiffness_product(at, p, out), &roots, &mode);
        let viscous = quotient(&|p, out| own.add_damping_product(at, p, out), &roots, &mode);
        elastic + pace * viscous + turning_of(law).powi(2)
    };
    let law = laws.iter().max_by(|a, b| share(**a).total_cmp(&share(**b))).map_or("nothing", |law| law.name());
    let node = (0..mode.nrows())
        .max_by(|&i, &j| mode.row(i).norm_squared().total_cmp(&mode.row(j).norm_squared()))
        .unwrap_or(0);
    Ok(Limit { dt, largest_frequency: omega, law, node })
}
