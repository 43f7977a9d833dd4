//! The largest frequency of a scene, the stable step that follows from it, and the part that sets it.
//!
//! The stiffness matrix K is the sum of what every law can show at its stiffest at the current positions: all springs
//! taut, all creases in contact, all contacts closed. The largest eigenvalues of M^-1/2 K M^-1/2 and M^-1/2 C M^-1/2 come
//! from Lanczos's method (1950) with a fixed start; the mode is formed in a second pass, so that memory stays small.

mod damped;

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use crate::error::{Error, Result};
use crate::forces::Law;
use crate::integrators::Integrator;
use crate::state::{Instant, Vectors};

/// Lanczos steps: enough for 1e-3 of the largest eigenvalue on meshes of a million nodes.
const MOST_ITERATIONS: usize = 120;
/// Relative change of the eigenvalue over eight iterations at which it counts as found.
const TOLERANCE: f64 = 1e-6;

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

/// An oscillator's numbers: x'' = -omega^2 x - c x'.
#[derive(Debug, Clone, Copy)]
struct Mode {
    omega: f64,
    damping: f64,
}

/// A product with a matrix: adds it to the second argument.
type Product<'a> = &'a dyn Fn(&Vectors, &mut Vectors);

/// A scene as a linear system, y'' = -K y - C y' with y = M^1/2 x.
struct Linear<'a> {
    stiffness: Product<'a>,
    damping: Product<'a>,
    /// The roots of the inverse masses.
    roots: &'a [f64],
    /// By how much the frame's turning can shift a frequency \[rad/s\].
    turning: f64,
}

/// The limit of `integrator` for these laws at this instant.
///
/// Without damping the mode of the largest frequency sets it. With damping it may be a mode that is neither the
/// stiffest nor the most damped one; see `damped`.
///
/// # Errors
/// `NotFinite` where an eigenvalue is not, which takes coordinates that are not.
pub fn limit(integrator: &dyn Integrator, laws: &[&dyn Law], at: Instant<'_>, inverse_masses: &[f64]) -> Result<Limit> {
    let stiffness = |p: &Vectors, out: &mut Vectors| laws.iter().for_each(|law| law.add_stiffness_product(at, p, out));
    let damping = |p: &Vectors, out: &mut Vectors| laws.iter().for_each(|law| law.add_damping_product(at, p, out));
    let roots: Vec<f64> = inverse_masses.iter().map(|inverse| inverse.sqrt()).collect();
    let (square, stiffest) = largest(&stiffness, &roots)?;
    let (rate, most_damped) = largest(&damping, &roots)?;
    // Coriolis acts with 2 Omega; what turns against the frame turns faster by Omega.
    let turning_of = |law: &dyn Law| 0.5 * law.gyration(at.time).abs();
    let turning = laws.iter().map(|law| turning_of(*law)).fold(0.0, f64::max);
    let omega = square.max(0.0).sqrt();
    let system = Linear { stiffness: &stiffness, damping: &damping, roots: &roots, turning };
    let (dt, mode, pace) = if integrator.is_implicit() {
        (f64::INFINITY, stiffest, omega)
    } else if rate > 0.0 {
        let start = [stiffest, most_damped];
        match integrator.damping_weight() {
            Some(weight) => damped::worst_of_sum(integrator, &system, start, weight)?,
            None => damped::worst(integrator, &system, start, omega.max(rate))?,
        }
    } else {
        (largest_step(integrator, Mode { omega: omega + turning, damping: 0.0 }), stiffest, omega)
    };
    // The law with the largest share of the mode's stiffness and damping; the frame's, where its turning is faster.
    let share = |law: &dyn Law| {
        let elastic = quotient(&|p, out| law.add_stiffness_product(at, p, out), &roots, &mode);
        let viscous = quotient(&|p, out| law.add_damping_product(at, p, out), &roots, &mode);
        elastic + pace * viscous + turning_of(law).powi(2)
    };
    let law = laws.iter().max_by(|a, b| share(**a).total_cmp(&share(**b))).map_or("nothing", |law| law.name());
    let node = (0..mode.nrows())
        .max_by(|&i, &j| mode.row(i).norm_squared().total_cmp(&mode.row(j).norm_squared()))
        .unwrap_or(0);
    Ok(Limit { dt, largest_frequency: omega, law, node })
}

/// The largest step up to which `integrator` lets no solution of the oscillator grow \[s\].
fn largest_step(integrator: &dyn Integrator, mode: Mode) -> f64 {
    if integrator.is_implicit() {
        return f64::INFINITY;
    }
    let Mode { omega, damping } = mode;
    // The larger of the roots of lambda^2 + damping lambda + omega^2.
    let half = 0.5 * damping;
    let size = if half > omega { half + (half * half - omega * omega).sqrt() } else { omega };
    if size == 0.0 {
        return f64::INFINITY;
    }
    let stable = |z: f64| integrator.growth(omega, damping, z / size) <= 1.0 + 1e-12;
    // Out from zero to the first unstable point, then bisect: beyond it may lie stable islands that no one should use.
    let mut high = 0.01;
    while stable(high) && high < 1e3 {
        high += 0.01;
    }
    let mut low = high - 0.01;
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        if stable(middle) { low = middle } else { high = middle }
    }
    low / size
}

/// The limits of `integrator` on the imaginary axis, in omega dt, and on the negative real one, in damping dt.
pub fn axis_limits(integrator: &dyn Integrator) -> [f64; 2] {
    [Mode { omega: 1.0, damping: 0.0 }, Mode { omega: 0.0, damping: 1.0 }].map(|mode| largest_step(integrator, mode))
}

/// out = M^-1/2 A M^-1/2 q
fn apply(product: Product<'_>, roots: &[f64], q: &Vectors) -> Vectors {
    let scaled = |mut v: Vectors| {
        for mut column in v.column_iter_mut() {
            column.iter_mut().zip(roots).for_each(|(value, root)| *value *= root);
        }
        v
    };
    let mut out = Vectors::zeros(q.nrows());
    product(&scaled(q.clone()), &mut out);
    scaled(out)
}

/// q . (M^-1/2 A M^-1/2) q for a unit vector q.
fn quotient(product: Product<'_>, roots: &[f64], q: &Vectors) -> f64 {
    q.dot(&apply(product, roots, q))
}

/// The largest eigenvalue of M^-1/2 A M^-1/2 and its unit eigenvector.
fn largest(product: Product<'_>, roots: &[f64]) -> Result<(f64, Vectors)> {
    let (mut diagonal, mut beside) = (Vec::new(), Vec::new());
    let mut found: f64 = 0.0;
    let mut weights = DVector::from_element(1, 1.0);
    let mut before = f64::NAN;
    walk(product, roots, |_, alpha, beta| {
        diagonal.push(alpha);
        let k = diagonal.len();
        if k % 8 == 0 || k == MOST_ITERATIONS || beta.is_nan() || beta <= 1e-12 * found.abs() {
            let matrix = DMatrix::from_fn(k, k, |i, j| match i.abs_diff(j) {
                0 => diagonal[i],
                1 => beside[i.min(j)],
                _ => 0.0,
            });
            let eigen = SymmetricEigen::new(matrix);
            let top = eigen.eigenvalues.imax();
            (found, weights) = (eigen.eigenvalues[top], eigen.eigenvectors.column(top).into_owned());
            if (found - before).abs() <= TOLERANCE * found.abs() {
                return false;
            }
            before = found;
        }
        beside.push(beta);
        beta > 1e-12 * found.abs() && k < MOST_ITERATIONS
    });
    if !found.is_finite() {
        return Err(Error::NotFinite { what: "the stiffness", node: 0, value: found });
    }
    let mut mode = Vectors::zeros(roots.len());
    let mut k = 0;
    walk(product, roots, |q, _, _| {
        mode += q * weights[k];
        k += 1;
        k < weights.len()
    });
    let norm = mode.norm();
    Ok((found, if norm > 0.0 { mode / norm } else { mode }))
}

/// Lanczos's three-term recurrence; `visit` gets each basis vector, its diagonal entry and the next off-diagonal one.
fn walk(product: Product<'_>, roots: &[f64], mut visit: impl FnMut(&Vectors, f64, f64) -> bool) {
    // A fixed start with a part along every mode: the fractional parts of multiples of the golden ratio.
    let mut q =
        Vectors::from_fn(roots.len(), |i, axis| ((3 * i + axis + 1) as f64 * 0.618_033_988_749_894_9).fract() - 0.5);
    for mut column in q.column_iter_mut() {
        column.iter_mut().zip(roots).filter(|(_, root)| **root == 0.0).for_each(|(value, _)| *value = 0.0);
    }
    let norm = q.norm();
    if norm == 0.0 {
        visit(&q, 0.0, 0.0);
        return;
    }
    q /= norm;
    let (mut previous, mut beta) = (Vectors::zeros(roots.len()), 0.0);
    loop {
        let mut next = apply(product, roots, &q) - previous * beta;
        let alpha = q.dot(&next);
        next -= &q * alpha;
        beta = next.norm();
        let go_on = visit(&q, alpha, beta);
        if !go_on || beta.is_nan() || beta == 0.0 {
            return;
        }
        previous = q;
        q = next / beta;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrators::by_name;

    #[test]
    fn limits_on_the_axes_are_those_of_the_textbook() {
        let known =
            [("rk4", 8.0_f64.sqrt(), 2.785_293_563_4), ("leapfrog", 2.0, 1.0), ("dopri5", 0.997_189, 3.306_568)];
        for (name, on_imaginary_axis, on_real_axis) in known {
            let method = by_name(name, 1, 0, crate::width::Width::Baseline).unwrap();
            let [imaginary, real] = axis_limits(method.as_ref());
            assert!((imaginary - on_imaginary_axis).abs() < 1e-4, "{name}: {imaginary}");
            assert!((real - on_real_axis).abs() < 1e-4, "{name}: {real}");
        }
    }

    #[test]
    fn damping_shortens_the_step_of_leapfrog_by_the_closed_form() {
        let leapfrog = by_name("leapfrog", 1, 0, crate::width::Width::Baseline).unwrap();
        for ratio in [0.0, 0.02, 0.1, 0.5, 1.0, 2.0, 10.0] {
            let found = largest_step(leapfrog.as_ref(), Mode { omega: 3.0, damping: 6.0 * ratio });
            let exact = 2.0 * ((4.0 * ratio * ratio + 1.0).sqrt() - 2.0 * ratio) / 3.0;
            assert!((found / exact - 1.0).abs() < 1e-5, "zeta {ratio}: {found} {exact}");
        }
    }

    #[test]
    fn the_largest_eigenvalue_of_a_chain_is_four() {
        // Springs 0-1, 1-2, ... of unit stiffness along x between unit masses: 4 sin^2(pi (n-1) / (2 n)).
        let n = 30;
        let chain = |p: &Vectors, out: &mut Vectors| {
            for i in 0..n - 1 {
                let stretch = p[(i + 1, 0)] - p[(i, 0)];
                out[(i, 0)] -= stretch;
                out[(i + 1, 0)] += stretch;
            }
        };
        let exact = 4.0 * (std::f64::consts::FRAC_PI_2 * (n - 1) as f64 / n as f64).sin().powi(2);
        let (value, mode) = largest(&chain, &vec![1.0; n]).unwrap();
        assert!((value / exact - 1.0).abs() < 1e-5, "{value} {exact}");
        assert!((quotient(&chain, &vec![1.0; n], &mode) / exact - 1.0).abs() < 1e-4);
    }
}
