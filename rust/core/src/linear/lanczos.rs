//! Largest eigenvalues of symmetric operators scaled by masses, M^-1/2 A M^-1/2, by Lanczos's method (1950).
//!
//! The basis is stored for the mode where it is small enough; otherwise a second recurrence forms it.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use super::passes::{add_scaled, orthogonalise, reduce, scale_rows, scaled_into, start_product};
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
/// The same of a search for a first guess, and its largest residual.
const LEAST_OF_GUESS: usize = 4;
const PERIOD_OF_GUESS: usize = 2;
const RESIDUAL_OF_GUESS: f64 = 0.05;
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
    /// A guess, from which another search begins: a mode that the start hardly has may be missed.
    Guess,
}

impl Goal {
    /// Whether a search is to be checked after so many iterations.
    fn is_due(self, k: usize) -> bool {
        match self {
            Self::Convergence => k.is_multiple_of(PERIOD),
            Self::Residual(_) => k >= LEAST_ITERATIONS && k.is_multiple_of(RESIDUAL_PERIOD),
            Self::Guess => k >= LEAST_OF_GUESS && k.is_multiple_of(PERIOD_OF_GUESS),
        }
    }
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

/// Vectors that one search leaves to the next, so that their memory is not requested again.
#[derive(Debug, Default)]
pub(crate) struct Spare(Vec<NodeVectors>);

impl Spare {
    /// A vector of `nodes` nodes with any values.
    fn take(&mut self, nodes: usize) -> NodeVectors {
        self.0.pop().filter(|vector| vector.nrows() == nodes).unwrap_or_else(|| NodeVectors::zeros(nodes))
    }

    /// Keeps a vector that is no longer used.
    pub(crate) fn keep(&mut self, vector: NodeVectors) {
        self.0.push(vector);
    }
}

/// M^-1/2 q
pub(crate) fn scaled_by(inverse_sqrt_masses: &[f64], q: &NodeVectors) -> NodeVectors {
    let mut scaled = NodeVectors::zeros(q.nrows());
    scaled_into(inverse_sqrt_masses, q, &mut scaled);
    scaled
}

/// M^-1/2 A M^-1/2 q
pub(crate) fn apply(product: Product<'_>, inverse_sqrt_masses: &[f64], q: &NodeVectors) -> NodeVectors {
    let mut out = NodeVectors::zeros(q.nrows());
    product(&scaled_by(inverse_sqrt_masses, q), &mut out);
    scale_rows(&mut out, inverse_sqrt_masses);
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
    spare: &mut Spare,
) -> Result<Eigenpair> {
    largest_within(STORAGE, product, inverse_sqrt_masses, near, goal, spare)
}

/// The same with a largest storage of the basis \[bytes\], on which the result does not depend.
fn largest_within(
    storage: usize,
    product: Product<'_>,
    inverse_sqrt_masses: &[f64],
    near: Option<&NodeVectors>,
    goal: Goal,
    spare: &mut Spare,
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
    let most = storage / size_of_val(start.as_slice()).max(1);
    let (mut found, mut residual): (f64, f64) = (0.0, 0.0);
    let mut weights = DVector::from_element(1, 1.0);
    let mut before = f64::NAN;
    let basis = recurrence(product, inverse_sqrt_masses, start, most, spare, |_, alpha, beta| {
        diagonal.push(alpha);
        let k = diagonal.len();
        if goal.is_due(k) || k == MOST_ITERATIONS || beta.is_nan() || beta <= 1e-12 * found.abs() {
            let matrix = DMatrix::from_fn(k, k, |i, j| match i.abs_diff(j) {
                0 => diagonal[i],
                1 => off_diagonal[i.min(j)],
                _ => 0.0,
            });
            let eigen = SymmetricEigen::new(matrix);
            let top = eigen.eigenvalues.imax();
            (found, weights) = (eigen.eigenvalues[top], eigen.eigenvectors.column(top).into_owned());
            let mut is_within = |share: f64| {
                residual = (beta * weights[k - 1]).abs();
                residual <= share * found.abs()
            };
            let has_converged = match goal {
                Goal::Convergence => (found - before).abs() <= TOLERANCE * found.abs(),
                Goal::Residual(share) => is_within(share),
                Goal::Guess => is_within(RESIDUAL_OF_GUESS),
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
    let mut mode = spare.take(inverse_sqrt_masses.len());
    mode.fill(0.0);
    match basis {
        Basis::Whole(vectors) => {
            vectors.iter().zip(weights.iter()).for_each(|(q, weight)| add_scaled(&mut mode, *weight, q));
            vectors.into_iter().for_each(|vector| spare.keep(vector));
        }
        Basis::Start(start) => {
            let mut k = 0;
            recurrence(product, inverse_sqrt_masses, start, 0, spare, |q, _, _| {
                add_scaled(&mut mode, weights[k], q);
                k += 1;
                k < weights.len()
            });
        }
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

/// The vectors of a recurrence, or the first of them where they were too many to be stored.
enum Basis {
    Whole(Vec<NodeVectors>),
    Start(NodeVectors),
}

/// Lanczos's three-term recurrence from a unit vector. `visit` receives each basis vector, its diagonal entry and the
/// next off-diagonal one; the recurrence ends where it returns false. More than `most` vectors are not stored.
fn recurrence(
    product: Product<'_>,
    inverse_sqrt_masses: &[f64],
    start: NodeVectors,
    most: usize,
    spare: &mut Spare,
    mut visit: impl FnMut(&NodeVectors, f64, f64) -> bool,
) -> Basis {
    if start.iter().all(|value| *value == 0.0) {
        visit(&start, 0.0, 0.0);
        return Basis::Whole(vec![start]);
    }
    let nodes = inverse_sqrt_masses.len();
    let (mut next, mut scaled) = (spare.take(nodes), spare.take(nodes));
    scaled_into(inverse_sqrt_masses, &start, &mut scaled);
    next.fill(0.0);
    // The first vector, and at least the two last.
    let (mut most, mut is_whole) = (most.max(3), true);
    let (mut vectors, mut beta) = (vec![start], 0.0);
    loop {
        product(&scaled, &mut next);
        let last = vectors.len() - 1;
        let (q, previous) = (&vectors[last], &vectors[last.saturating_sub(1)]);
        let alpha = reduce(&mut next, inverse_sqrt_masses, beta, previous, q);
        beta = orthogonalise(&mut next, alpha, q);
        if !visit(q, alpha, beta) || beta.is_nan() || beta == 0.0 {
            break;
        }
        if vectors.len() >= most {
            let unused = vectors.drain(1..last);
            if is_whole {
                drop(unused)
            } else {
                unused.for_each(|vector| spare.keep(vector))
            }
            (most, is_whole) = (3, false);
        }
        let mut vector = spare.take(nodes);
        start_product(&mut next, beta, inverse_sqrt_masses, &mut vector, &mut scaled);
        vectors.push(vector);
    }
    [next, scaled].into_iter().for_each(|vector| spare.keep(vector));
    if is_whole { Basis::Whole(vectors) } else { Basis::Start(vectors.swap_remove(0)) }
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
        let Eigenpair { value, mode, .. } =
            largest(&chain, &vec![1.0; n], None, Goal::Convergence, &mut Spare::default()).unwrap();
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
        let Eigenpair { value, mode, .. } =
            largest(&spread, &vec![1.0; n], None, Goal::Convergence, &mut Spare::default()).unwrap();
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
            let spare = &mut Spare::default();
            let found = largest_within(storage, &spread, &vec![1.0; n], None, Goal::Convergence, spare).unwrap();
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
            let found = largest(&local, &vec![1.0; n], near, Goal::Residual(0.01), &mut Spare::default()).unwrap();
            assert!(found.residual <= 0.01 * found.value && found.residual > 0.0, "{found:?}");
            assert!(found.value <= 1.3 + 1e-12 && found.upper() >= 1.3, "{} {}", found.value, found.upper());
        }
    }
}
