//! The largest frequency of a scene, its largest stable step, and the law and node that set it.
//!
//! The stiffness matrix K is the sum of the stiffest linearisations of all laws at the current positions: all springs
//! taut, all creases in contact, all contacts closed. Lanczos's method gives the largest eigenvalues of M^-1/2 K M^-1/2
//! and, for damped scenes, of its combinations with M^-1/2 C M^-1/2.

use super::accuracy::Accuracy;
use super::oscillator::{Mode, largest_step};
use super::quadratic_eigenproblem::{self, LinearSystem};
use crate::arrays::state::NodeVectors;
use crate::error::Result;
use crate::integrators::Integrator;
use crate::laws::Instant;
use crate::laws::Law;
use crate::linear::lanczos::{Spare, apply, fixed_start, largest, scaled_by};

/// The limit of the step, and its cause.
#[derive(Debug, Clone, PartialEq)]
pub struct Limit {
    /// The largest stable step of the integrator \[s\]; infinite for a scene without stiffness.
    pub dt: f64,
    /// Largest frequency \[rad/s\].
    pub largest_frequency: f64,
    /// The law with the largest share of the limiting mode.
    pub law: &'static str,
    /// The node with the largest amplitude in this mode, internal number.
    pub node: usize,
}

/// The limit of `integrator` for these laws at this instant.
///
/// Without damping the mode of the largest frequency sets the limit. With damping it may be a mode that is neither the
/// stiffest nor the most damped one; see `quadratic_eigenproblem`.
///
/// # Errors
/// `NotFinite` for an eigenvalue that is not finite, as with coordinates that are not.
pub fn limit(integrator: &dyn Integrator, laws: &[&dyn Law], at: Instant<'_>, inverse_masses: &[f64]) -> Result<Limit> {
    limit_to(Accuracy::of(inverse_masses.len()), integrator, laws, at, inverse_masses)
}

/// As `limit`, to a given accuracy.
///
/// # Errors
/// As `limit`.
pub fn limit_to(
    accuracy: Accuracy,
    integrator: &dyn Integrator,
    laws: &[&dyn Law],
    at: Instant<'_>,
    inverse_masses: &[f64],
) -> Result<Limit> {
    let linearised = || laws.iter().filter_map(|law| law.linearisation());
    let stiffness =
        |p: &NodeVectors, out: &mut NodeVectors| linearised().for_each(|law| law.add_stiffness_product(at, p, out));
    let damping = |factor: f64, p: &NodeVectors, out: &mut NodeVectors| {
        linearised().for_each(|law| law.add_damping_product(factor, at, p, out));
    };
    let whole_damping = |p: &NodeVectors, out: &mut NodeVectors| damping(1.0, p, out);
    let inverse_sqrt_masses: Vec<f64> = inverse_masses.iter().map(|inverse| inverse.sqrt()).collect();
    let mut spare = Spare::default();
    let stiffest = largest(&stiffness, &inverse_sqrt_masses, None, accuracy.first(), &mut spare)?;
    // Omega from the rate 2 Omega of Coriolis: a motion that turns against the frame has a frequency larger by Omega.
    let frame_rate_of = |law: &dyn Law| law.linearisation().map_or(0.0, |law| 0.5 * law.coriolis_rate(at.frame).abs());
    let frame_rate = laws.iter().map(|law| frame_rate_of(*law)).fold(0.0, f64::max);
    let omega = stiffest.upper().max(0.0).sqrt();
    let system = LinearSystem {
        stiffness: &stiffness,
        damping: &damping,
        inverse_sqrt_masses: &inverse_sqrt_masses,
        frame_rate,
    };
    let properties = integrator.properties();
    // A vector with a component along every mode has a product with C unless C is zero.
    let is_damped = || {
        let product = apply(&whole_damping, &inverse_sqrt_masses, &fixed_start(&inverse_sqrt_masses));
        product.iter().any(|value| *value != 0.0)
    };
    let (dt, mode, root) = if properties.is_implicit {
        (f64::INFINITY, stiffest.mode, omega)
    } else if is_damped() {
        match properties.damping_weight {
            Some(weight) => {
                quadratic_eigenproblem::limit_by_quotients(integrator, &system, stiffest, weight, accuracy, &mut spare)?
            }
            None => {
                let most_damped = largest(&whole_damping, &inverse_sqrt_masses, None, accuracy.first(), &mut spare)?;
                let (start, scale) = ([stiffest.mode, most_damped.mode], omega.max(most_damped.value));
                quadratic_eigenproblem::limit_by_roots(integrator, &system, start, scale, accuracy, &mut spare)?
            }
        }
    } else {
        (largest_step(integrator, Mode { omega: omega + frame_rate, damping: 0.0 }), stiffest.mode, omega)
    };
    // The law with the largest share of the stiffness and damping of the mode, or of the frequency of the frame.
    let scaled = scaled_by(&inverse_sqrt_masses, &mode);
    let mut product = NodeVectors::zeros(mode.nrows());
    let mut share = |law: &dyn Law| {
        let Some(own) = law.linearisation() else { return 0.0 };
        product.fill(0.0);
        own.add_stiffness_product(at, &scaled, &mut product);
        own.add_damping_product(root, at, &scaled, &mut product);
        scaled.dot(&product) + frame_rate_of(law).powi(2)
    };
    let shares = laws.iter().map(|law| (share(*law), law.name()));
    let law = shares.max_by(|(a, _), (b, _)| a.total_cmp(b)).map_or("nothing", |(_, name)| name);
    let node = (0..mode.nrows())
        .max_by(|&i, &j| mode.row(i).norm_squared().total_cmp(&mode.row(j).norm_squared()))
        .unwrap_or(0);
    Ok(Limit { dt, largest_frequency: omega, law, node })
}
