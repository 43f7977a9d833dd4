//! Largest eigenvalues of symmetric operators scaled by masses, M^-1/2 A M^-1/2, by Lanczos's method (1950).
//!
//! The basis is stored for the mode where it is small enough; otherwise a second recurrence forms it.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use crate::arrays::state::NodeVectors;
use crate::error::{Error, Result};

/// Largest number of Lanczos steps: the error of the largest eigenvalue is then 1e-3 on meshes of a million nodes.
const MOST_ITERATIONS: usize = 120;
/// Relative change of the eigenvalue over `PERIOD` iterations at which it has converged.
const TOLERANCE: f64 = 1e-6;
const PERIOD: usize = 8;
/// Least number of iterations, and iterations between two checks, of a search up to a residual. A mode of a few nodes
/// that is stiffer than all others has a small component in the start, so that it appears only after some iterations.
const LEAST_ITERATIONS: usize = 12;
const RESIDUAL_PERIOD: usize = 4;
/// Largest storage of a basis \[bytes\].
const STORAGE: usize = 256_000_000;

/// A function that adds the product of a matrix and the first argument to the second.
pub(crate) type Product<'a> = &'a dyn Fn(&NodeVectors, &mut NodeVectors);

/// The accuracy at which a search ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Goal {
    /// The eigenvalue has converged to about 1e-6.
    Convergence,
    /// The residual is at most this share of the eigenvalue.
    Residual(f64),
}

/// The largest eigenvalue and its mode, as far as a search has found them.
#[derive(Debug, Clone)]
pub(crate) struct Eigenpair {
    /// The Rayleigh quotient of the mode, at most the eigenvalue.
    pub(crate) value: f64,
    /// The norm of the residual, A q - value q, where the search ended at one; otherwise 0. An eigenvalue is within it
    /// of `value`.
    pub(crate) residual: f64,
    /// The unit mode y = M^1/2 x.
    pub(crate) mode: NodeVectors,
}

impl Eigenpair {
    /// The eigenvalue, or an estimate from above where the search ended at a residual.
    pub(crate) fn upper(&self) -> f64 {
        self.value + self.residual
    }
}

/// y += a x
fn add_scaled(y: &mut NodeVectors, a: f64, x: &NodeVectors) {
    y.as_mut_slice().iter_mut().zip(x.as_slice()).for_each(|(y, x)| *y += a * x);
}

/// Multiplies each row by a number.
fn scale_rows(vectors: &mut NodeVectors, factors: &[f64]) {
    for mut column in vectors.column_iter_mut() {
        column.iter_mut().zip(factors).for_each(|(value, factor)| *value *= factor);
    }
}

/// out = M^-1/2 A M^-1/2 q, with a work array.
fn apply_into(
    product: Product<'_>,
    inverse_sqrt_masses: &[f64],
    q: &NodeVectors,
    scaled: &mut NodeVectors,
    out: &mut NodeVectors,
) {
    scaled.copy_from(q);
    scale_rows(scaled, inverse_sqrt_masses);
    out.fill(0.0);
    product(scaled, out);
    scale_rows(out, inverse_sqrt_masses);
}

/// M^-1/2 A M^-1/2 q
pub(crate) fn apply(product: Product<'_>, inverse_sqrt_masses: &[f64], q: &NodeVectors) -> NodeVectors {
    let (mut scaled, mut out) = (NodeVectors::zeros(q.nrows()), NodeVectors::zeros(q.nrows()));
    apply_into(product, inverse_sqrt_masses, q, &mut scaled, &mut out);
    out
}

/// q . (M^-1/2 A M^-1/2) q for a unit vector q.
pub(crate) fn quotient(product: Product<'_>, inverse_sqrt_masses: &[f64], q: &NodeVectors) -> f64 {
    q.dot(&apply(product, inverse_sqrt_masses, q))
}

/// The largest eigenvalue of M^-1/2 A M^-1/2. The search begins at `fixed_start`, or at its sum with a unit vector
/// `near` that is like the mode: so modes that `near` lacks are found too.
pub(crate) fn largest(
    product: Product<'_>,
    inverse_sqrt_masses: &[f64],
    near: Option<&NodeVectors>,
    goal: Goal,
) -> Result<Eigenpair> {
    largest_within(STORAGE, product, inverse_sqrt_masses, near, goal)
}

/// The same with a largest storage of the basis \[bytes\], on which the result does not depend.
fn largest_within(
    storage: usize,
    product: Product<'_>,
    inverse_sqrt_masses: &[f64],
    near: Option<&NodeVectors>,
    goal: Goal,
) -> Result<Eigenpair> {
    let mut start = fixed_start(inverse_sqrt_masses);
    if let Some(near) = near {
        start += near;
        let norm = start.norm();
        if norm > 0.0 {
            start /= norm;
        }
    }
    let (mut diagonal, mut off_diagonal) = (Vec::new(), Vec::new());
    let (mut basis, most) = (Vec::new(), storage / size_of_val(start.as_slice()).max(1));
    let (mut found, mut residual): (f64, f64) = (0.0, 0.0);
    let mut weights = DVector::from_element(1, 1.0);
    let mut before = f64::NAN;
    recurrence(product, inverse_sqrt_masses, start.clone(), |q, alpha, beta| {
        diagonal.push(alpha);
        let k = diagonal.len();
        if k <= most {
            basis.push(q.clone());
        } else {
            basis = Vec::new();
        }
        let is_due = match goal {
            Goal::Convergence => k % PERIOD == 0,
            Goal::Residual(_) => k >= LEAST_ITERATIONS && k % RESIDUAL_PERIOD == 0,
        };
        if is_due || k == MOST_ITERATIONS || beta.is_nan() || beta <= 1e-12 * found.abs() {
            let matrix = DMatrix::from_fn(k, k, |i, j| match i.abs_diff(j) {
                0 => diagonal[i],
                1 => off_diagonal[i.min(j)],
                _ => 0.0,
            });
            let eigen = SymmetricEigen::new(matrix);
            let top = eigen.eigenvalues.imax();
            (found, weights) = (eigen.eigenvalues[top], eigen.eigenvectors.column(top).into_owned());
            let has_converged = match goal {
                Goal::Convergence => (found - before).abs() <= TOLERANCE * found.abs(),
                Goal::Residual(share) => {
                    residual = (beta * weights[k - 1]).abs();
                    residual <= share * found.abs()
                }
            };
            if has_converged {
                return false;
            }
            before = found;
        }
        off_diagonal.push(beta);
        beta > 1e-12 * found.abs() && k < MOST_ITERATIONS
    });
    if !found.is_finite() {
        return Err(Error::NotFinite { what: "the stiffness", node: 0, value: found });
    }
    let mut mode = NodeVectors::zeros(inverse_sqrt_masses.len());
    if basis.len() >= weights.len() {
        basis.iter().zip(weights.iter()).for_each(|(q, weight)| add_scaled(&mut mode, *weight, q));
    } else {
        let mut k = 0;
        recurrence(product, inverse_sqrt_masses, start, |q, _, _| {
            add_scaled(&mut mode, weights[k], q);
            k += 1;
            k < weights.len()
        });
    }
    let norm = mode.norm();
    if norm > 0.0 {
        mode /= norm;
    }
    Ok(Eigenpair { value: found, residual, mode })
}

/// A fixed unit vector with a component along every mode: the fractional parts of multiples of the golden ratio; zero
/// where all nodes are held.
pub(crate) fn fixed_start(inverse_sqrt_masses: &[f64]) -> NodeVectors {
    let mut q = NodeVectors::from_fn(inverse_sqrt_masses.len(), |i, axis| {
        ((3 * i + axis + 1) as f64 * 0.618_033_988_749_894_9).fract() - 0.5
    });
    for mut column in q.column_iter_mut() {
        column
            .iter_mut()
            .zip(inverse_sqrt_masses)
            .filter(|(_, root)| **root == 0.0)
            .for_each(|(value, _)| *value = 0.0);
    }
    let norm = q.norm();
    if norm > 0.0 {
        q /= norm;
    }
    q
}

/// Lanczos's three-term recurrence from a unit vector. `visit` receives each basis vector, its diagonal entry and the
/// next off-diagonal one; the recurrence ends where it returns false.
fn recurrence(
    product: Product<'_>,
    inverse_sqrt_masses: &[f64],
    start: NodeVectors,
    mut visit: impl FnMut(&NodeVectors, f64, f64) -> bool,
) {
    let mut q = start;
    if q.iter().all(|value| *value == 0.0) {
        visit(&q, 0.0, 0.0);
        return;
    }
    let zeros = || NodeVectors::zeros(inverse_sqrt_masses.len());
    let (mut previous, mut next, mut scaled, mut beta) = (zeros(), zeros(), zeros(), 0.0);
    loop {
        apply_into(product, inverse_sqrt_masses, &q, &mut scaled, &mut next);
        add_scaled(&mut next, -beta, &previous);
        let alpha = q.dot(&next);
        add_scaled(&mut next, -alpha, &q);
        beta = next.norm();
        let continues = visit(&q, alpha, beta);
        if !continues || beta.is_nan() || beta == 0.0 {
            return;
        }
        std::mem::swap(&mut previous, &mut q);
        std::mem::swap(&mut q, &mut next);
        q /= beta;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_eigenvalue_of_a_chain_is_four() {
        // Springs 0-1, 1-2, ... of unit stiffness along x between unit masses: 4 sin^2(pi (n-1) / (2 n)).
        let n = 30;
        let chain = |p: &NodeVectors, out: &mut NodeVectors| {
            for i in 0..n - 1 {
                let stretch = p[(i + 1, 0)] - p[(i, 0)];
                out[(i, 0)] -= stretch;
                out[(i + 1, 0)] += stretch;
            }
        };
        let exact = 4.0 * (std::f64::consts::FRAC_PI_2 * (n - 1) as f64 / n as f64).sin().powi(2);
        let Eigenpair { value, mode, .. } = largest(&chain, &vec![1.0; n], None, Goal::Convergence).unwrap();
        assert!((value / exact - 1.0).abs() < 1e-5, "{value} {exact}");
        assert!((quotient(&chain, &vec![1.0; n], &mode) / exact - 1.0).abs() < 1e-4);
    }

    #[test]
    fn a_mode_has_unit_length_where_its_basis_is_no_longer_orthogonal() {
        // One large eigenvalue far from the others, found early, makes later basis vectors lean on it.
        let n = 200;
        let spread = |p: &NodeVectors, out: &mut NodeVectors| {
            for i in 0..n {
                let value = if i == 0 { 1e4 } else { 1.0 + i as f64 / n as f64 };
                (0..3).for_each(|axis| out[(i, axis)] += value * (1.0 + 0.1 * axis as f64) * p[(i, axis)]);
            }
        };
        let Eigenpair { value, mode, .. } = largest(&spread, &vec![1.0; n], None, Goal::Convergence).unwrap();
        assert!((value / 1.2e4 - 1.0).abs() < 1e-9, "{value}");
        assert!((mode.norm() - 1.0).abs() < 1e-14, "{:e}", mode.norm() - 1.0);
    }

    #[test]
    fn a_mode_has_the_same_bits_with_and_without_a_stored_basis() {
        let n = 50;
        let spread = |p: &NodeVectors, out: &mut NodeVectors| {
            (0..n).for_each(|i| (0..3).for_each(|axis| out[(i, axis)] += (1.0 + i as f64).sqrt() * p[(i, axis)]));
        };
        let [whole, part, none] = [STORAGE, 10 * 24 * n, 0].map(|storage| {
            let found = largest_within(storage, &spread, &vec![1.0; n], None, Goal::Convergence).unwrap();
            (found.value, found.mode)
        });
        assert!(whole == part && whole == none, "{} {} {}", whole.0, part.0, none.0);
        assert!((whole.1.norm() - 1.0).abs() < 1e-14);
    }

    #[test]
    fn a_search_up_to_a_residual_encloses_the_eigenvalue_near_any_start() {
        // One stiff node among many: the start near a mode of another node has hardly a component along it.
        let n = 3000;
        let local = |p: &NodeVectors, out: &mut NodeVectors| {
            for i in 0..n {
                let value = if i == 7 { 1.3 } else { (i as f64 / n as f64).sqrt() };
                (0..3).for_each(|axis| out[(i, axis)] += value * p[(i, axis)]);
            }
        };
        let mut other = NodeVectors::zeros(n);
        other[(n - 1, 2)] = 1.0;
        for near in [None, Some(&other)] {
            let found = largest(&local, &vec![1.0; n], near, Goal::Residual(0.01)).unwrap();
            assert!(found.residual <= 0.01 * found.value && found.residual > 0.0, "{found:?}");
            assert!(found.value <= 1.3 + 1e-12 && found.upper() >= 1.3, "{} {}", found.value, found.upper());
        }
    }
}
