//! Largest eigenvalues of symmetric operators scaled by masses, M^-1/2 A M^-1/2, by Lanczos's method (1950) with a
//! fixed start. A second pass forms the mode, so that storage remains small.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use crate::arrays::state::NodeVectors;
use crate::error::{Error, Result};

/// Largest number of Lanczos steps: the error of the largest eigenvalue is then 1e-3 on meshes of a million nodes.
const MOST_ITERATIONS: usize = 120;
/// Relative change of the eigenvalue over eight iterations at which it has converged.
const TOLERANCE: f64 = 1e-6;

/// A function that adds the product of a matrix and the first argument to the second.
pub(crate) type Product<'a> = &'a dyn Fn(&NodeVectors, &mut NodeVectors);

/// out = M^-1/2 A M^-1/2 q
pub(crate) fn apply(product: Product<'_>, inverse_sqrt_masses: &[f64], q: &NodeVectors) -> NodeVectors {
    let scaled = |mut v: NodeVectors| {
        for mut column in v.column_iter_mut() {
            column.iter_mut().zip(inverse_sqrt_masses).for_each(|(value, root)| *value *= root);
        }
        v
    };
    let mut out = NodeVectors::zeros(q.nrows());
    product(&scaled(q.clone()), &mut out);
    scaled(out)
}

/// q . (M^-1/2 A M^-1/2) q for a unit vector q.
pub(crate) fn quotient(product: Product<'_>, inverse_sqrt_masses: &[f64], q: &NodeVectors) -> f64 {
    q.dot(&apply(product, inverse_sqrt_masses, q))
}

/// The largest eigenvalue of M^-1/2 A M^-1/2 and its unit eigenvector.
pub(crate) fn largest(product: Product<'_>, inverse_sqrt_masses: &[f64]) -> Result<(f64, NodeVectors)> {
    let (mut diagonal, mut off_diagonal) = (Vec::new(), Vec::new());
    let mut found: f64 = 0.0;
    let mut weights = DVector::from_element(1, 1.0);
    let mut before = f64::NAN;
    recurrence(product, inverse_sqrt_masses, |_, alpha, beta| {
        diagonal.push(alpha);
        let k = diagonal.len();
        if k % 8 == 0 || k == MOST_ITERATIONS || beta.is_nan() || beta <= 1e-12 * found.abs() {
            let matrix = DMatrix::from_fn(k, k, |i, j| match i.abs_diff(j) {
                0 => diagonal[i],
                1 => off_diagonal[i.min(j)],
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
        off_diagonal.push(beta);
        beta > 1e-12 * found.abs() && k < MOST_ITERATIONS
    });
    if !found.is_finite() {
        return Err(Error::NotFinite { what: "the stiffness", node: 0, value: found });
    }
    let mut mode = NodeVectors::zeros(inverse_sqrt_masses.len());
    let mut k = 0;
    recurrence(product, inverse_sqrt_masses, |q, _, _| {
        mode += q * weights[k];
        k += 1;
        k < weights.len()
    });
    let norm = mode.norm();
    Ok((found, if norm > 0.0 { mode / norm } else { mode }))
}

/// Lanczos's three-term recurrence. `visit` receives each basis vector, its diagonal entry and the next off-diagonal
/// one; the recurrence ends where it returns false.
pub(crate) fn recurrence(
    product: Product<'_>,
    inverse_sqrt_masses: &[f64],
    mut visit: impl FnMut(&NodeVectors, f64, f64) -> bool,
) {
    // A fixed start with a component along every mode: the fractional parts of multiples of the golden ratio.
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
    if norm == 0.0 {
        visit(&q, 0.0, 0.0);
        return;
    }
    q /= norm;
    let (mut previous, mut beta) = (NodeVectors::zeros(inverse_sqrt_masses.len()), 0.0);
    loop {
        let mut next = apply(product, inverse_sqrt_masses, &q) - previous * beta;
        let alpha = q.dot(&next);
        next -= &q * alpha;
        beta = next.norm();
        let continues = visit(&q, alpha, beta);
        if !continues || beta.is_nan() || beta == 0.0 {
            return;
        }
        previous = q;
        q = next / beta;
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
        let (value, mode) = largest(&chain, &vec![1.0; n]).unwrap();
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
        let (value, mode) = largest(&spread, &vec![1.0; n]).unwrap();
        assert!((value / 1.2e4 - 1.0).abs() < 1e-9, "{value}");
        assert!((mode.norm() - 1.0).abs() < 1e-14, "{:e}", mode.norm() - 1.0);
    }
}
