//! The limit of a damped scene: the quadratic eigenvalue problem (lambda^2 + lambda C + K) u = 0.
//!
//! K and C have different modes where masses or spring constants vary. The root that limits the step may belong to a
//! mode that is neither the stiffest nor the most damped: on random meshes near critical damping, the limit by these
//! two alone is too large by up to a third. Where damping increases the limit, as near the imaginary axis, a stiff
//! undamped mode may set it. The problem is therefore projected on a small subspace. It begins with the stiffest and
//! the most damped mode and with stiff, little damped modes, the largest of K - w C for some rates w. The residuals of
//! the roots that limit the step extend it (Davidson 1975).

use nalgebra::{Complex, DMatrix, DVector, Schur};

use super::accuracy::Accuracy;
use super::oscillator::{Mode, largest_step};
use crate::arrays::state::NodeVectors;
use crate::error::{Error, Result};
use crate::integrators::Integrator;
use crate::linear::lanczos::{Eigenpair, Goal, Product, Spare, apply, largest, quotient};

/// Largest size of the subspace, and its largest storage on a large mesh \[vectors x nodes\]: 240 MB.
const MOST_VECTORS: usize = 60;
const STORAGE: usize = 10_000_000;
/// Number of roots whose residuals extend the subspace in each iteration.
const EXTENDED: usize = 2;
/// Most steps of the QR iteration for each vector.
const QR_STEPS: usize = 60;
/// The rates w of K - w C, relative to the largest frequency.
const RELATIVE_RATES: [f64; 3] = [1.0, 10.0, 100.0];
/// Largest number of iterations of `limit_by_quotients`.
const MOST_ITERATIONS: usize = 20;
/// Relative change of the limit over `UNCHANGED` iterations at which it has converged.
const TOLERANCE: f64 = 1e-4;
const UNCHANGED: usize = 4;

/// A scene as a linear system, y'' = -K y - C y' with y = M^1/2 x.
pub(super) struct LinearSystem<'a> {
    pub(super) stiffness: Product<'a>,
    /// Adds a multiple of the product with C.
    pub(super) damping: &'a dyn Fn(f64, &NodeVectors, &mut NodeVectors),
    /// m^-1/2 of each node \[kg^-1/2\].
    pub(super) inverse_sqrt_masses: &'a [f64],
    /// Largest shift of a frequency by the turning frame \[rad/s\].
    pub(super) frame_rate: f64,
}

/// The projection of K and C on orthonormal vectors.
struct Subspace<'a> {
    system: &'a LinearSystem<'a>,
    basis: Vec<NodeVectors>,
    stiffness: DMatrix<f64>,
    damping: DMatrix<f64>,
}

impl Subspace<'_> {
    /// Adds the part of `v` orthogonal to the subspace; false where it vanishes.
    fn add(&mut self, mut v: NodeVectors) -> bool {
        let before = v.norm();
        for _ in 0..2 {
            for q in &self.basis {
                v -= q * q.dot(&v);
            }
        }
        let norm = v.norm();
        if norm.is_nan() || norm <= 1e-8 * before || norm == 0.0 {
            return false;
        }
        v /= norm;
        let k = self.basis.len();
        self.basis.push(v);
        let damping = |p: &NodeVectors, out: &mut NodeVectors| (self.system.damping)(1.0, p, out);
        let products: [(_, Product<'_>); 2] =
            [(&mut self.stiffness, self.system.stiffness), (&mut self.damping, &damping)];
        for (matrix, product) in products {
            let image = apply(product, self.system.inverse_sqrt_masses, &self.basis[k]);
            let mut grown = std::mem::replace(matrix, DMatrix::zeros(0, 0)).resize(k + 1, k + 1, 0.0);
            for (i, q) in self.basis.iter().enumerate() {
                let value = q.dot(&image);
                (grown[(i, k)], grown[(k, i)]) = (value, value);
            }
            *matrix = grown;
        }
        true
    }

    /// Eigenvalues of the projected problem with imaginary part >= 0 \[1/s\].
    fn ritz_values(&self, scale: f64) -> Vec<Complex<f64>> {
        let k = self.basis.len();
        let mut companion = DMatrix::zeros(2 * k, 2 * k);
        companion.view_mut((0, k), (k, k)).fill_diagonal(1.0);
        companion.view_mut((k, 0), (k, k)).copy_from(&(&self.stiffness / -(scale * scale)));
        companion.view_mut((k, k), (k, k)).copy_from(&(&self.damping / -scale));
        let all: Vec<Complex<f64>> = match Schur::try_new(companion, f64::EPSILON, QR_STEPS * k) {
            Some(schur) => schur.complex_eigenvalues().iter().copied().collect(),
            // No convergence, as may happen with damping far above all stiffness: the roots of each vector alone.
            None => (0..k).flat_map(|i| self.roots_of(i, scale)).collect(),
        };
        all.iter().filter(|value| value.im >= 0.0).map(|value| value * scale).collect()
    }

    /// The two roots of one vector alone, divided by `scale`.
    fn roots_of(&self, i: usize, scale: f64) -> [Complex<f64>; 2] {
        let (square, half) = (self.stiffness[(i, i)] / (scale * scale), 0.5 * self.damping[(i, i)] / scale);
        let root = Complex::new(half * half - square, 0.0).sqrt();
        [root - half, -root - half]
    }

    /// The eigenvector of a root in the subspace, by inverse iteration.
    fn eigenvector(&self, root: Complex<f64>) -> DVector<Complex<f64>> {
        let k = self.basis.len();
        let shifted = root * Complex::new(1.0 + 1e-10, 1e-10);
        let matrix = DMatrix::from_fn(k, k, |i, j| {
            let inertia = if i == j { shifted * shifted } else { Complex::new(0.0, 0.0) };
            inertia + shifted * self.damping[(i, j)] + self.stiffness[(i, j)]
        });
        let lu = matrix.lu();
        let mut y = DVector::from_fn(k, |i, _| Complex::new(1.0 / (i + 1) as f64, 0.0));
        for _ in 0..3 {
            match lu.solve(&y) {
                Some(solved) if solved.norm().is_finite() && solved.norm() > 0.0 => {
                    let norm = solved.norm();
                    y = solved.unscale(norm);
                }
                _ => break,
            }
        }
        y
    }

    /// Real and imaginary part on all nodes of a vector in the subspace.
    fn ritz_vector(&self, y: &DVector<Complex<f64>>) -> [NodeVectors; 2] {
        let part = |take: fn(&Complex<f64>) -> f64| {
            let mut sum = NodeVectors::zeros(self.basis[0].nrows());
            self.basis.iter().zip(y.iter()).for_each(|(q, weight)| sum += q * take(weight));
            sum
        };
        [part(|weight| weight.re), part(|weight| weight.im)]
    }

    /// Real and imaginary part of (root^2 + root C + K) u.
    fn residual(&self, root: Complex<f64>, [re, im]: &[NodeVectors; 2]) -> [NodeVectors; 2] {
        let square = root * root;
        let [k_re, k_im] = [re, im].map(|part| apply(self.system.stiffness, self.system.inverse_sqrt_masses, part));
        let damping = |p: &NodeVectors, out: &mut NodeVectors| (self.system.damping)(1.0, p, out);
        let [c_re, c_im] = [re, im].map(|part| apply(&damping, self.system.inverse_sqrt_masses, part));
        [
            re * square.re - im * square.im + &c_re * root.re - &c_im * root.im + k_re,
            re * square.im + im * square.re + c_re * root.im + c_im * root.re + k_im,
        ]
    }
}

/// An oscillator with this root: its conjugate, or for a real one a root that is not amplified, is the other.
fn mode_of(root: Complex<f64>, frame_rate: f64) -> Mode {
    let decay = -root.re.min(0.0);
    if root.im == 0.0 {
        Mode { omega: frame_rate, damping: decay }
    } else {
        Mode { omega: root.norm() + frame_rate, damping: 2.0 * decay }
    }
}

/// As `limit_by_roots`, for a method whose limit is dt^2 k + w dt c = 4 with the Rayleigh quotients k and c of any
/// vector, not of solutions alone. The largest eigenvalue of K + w/dt C sets it. Its eigenvector gives the next dt; the
/// iteration converges from above, from any first mode. A residual of a mode counts as stiffness.
///
/// With u the largest eigenvalue at dt, that of dt'^2 K + w dt' C is at most dt dt' u for every shorter dt' where K and
/// C are positive semidefinite. All steps up to 4/(dt u) are then stable, and a search within 1 % ends where this is
/// near.
pub(super) fn limit_by_quotients(
    integrator: &dyn Integrator,
    system: &LinearSystem<'_>,
    first: Eigenpair,
    weight: f64,
    accuracy: Accuracy,
    spare: &mut Spare,
) -> Result<(f64, NodeVectors, f64)> {
    let LinearSystem { stiffness, damping, inverse_sqrt_masses, frame_rate } = *system;
    let step_of =
        |k: f64, c: f64| largest_step(integrator, Mode { omega: k.max(0.0).sqrt() + frame_rate, damping: c.max(0.0) });
    let quotients = |pair: &Eigenpair| {
        let of = |product: Product<'_>| quotient(product, inverse_sqrt_masses, &pair.mode);
        [of(stiffness), of(&|p, out| damping(1.0, p, out))]
    };
    let limit_of = |pair: &Eigenpair| {
        let [k, c] = quotients(pair);
        step_of(k + pair.residual, c)
    };
    let search = |dt: f64, near: &NodeVectors, goal: Goal, spare: &mut Spare| {
        let sum = |p: &NodeVectors, out: &mut NodeVectors| {
            stiffness(p, out);
            damping(weight / dt, p, out);
        };
        largest(&sum, inverse_sqrt_masses, Some(near), goal, spare)
    };
    let (mut dt, mut pair) = (limit_of(&first), first);
    if let Some(goal) = accuracy.guess() {
        // The quotients of any vector give a step that is not too short.
        let found = search(dt, &pair.mode, goal, spare)?;
        let [k, c] = quotients(&found);
        let next = step_of(k, c);
        let (nearer, other) = if next < dt { (found, pair) } else { (pair, found) };
        (dt, pair) = (next.min(dt), nearer);
        spare.keep(other.mode);
    }
    for _ in 0..MOST_ITERATIONS {
        let found = search(dt, &pair.mode, accuracy.last(), spare)?;
        let (next, before) = (limit_of(&found), dt);
        let stable = step_of(0.0, found.upper() * before / weight).min(next);
        if next < dt {
            (dt, pair) = (next, found);
        }
        let least = 1.0 - accuracy.unchanged_step();
        if next.is_nan() || next >= before * least {
            break;
        }
        if accuracy == Accuracy::Percent && stable >= next * least {
            dt = stable;
            break;
        }
    }
    Ok((dt, pair.mode, weight / dt))
}

/// The largest stable step \[s\], the mode that sets it, and the modulus of its root \[1/s\].
pub(super) fn limit_by_roots(
    integrator: &dyn Integrator,
    system: &LinearSystem<'_>,
    start: [NodeVectors; 2],
    scale: f64,
    accuracy: Accuracy,
    spare: &mut Spare,
) -> Result<(f64, NodeVectors, f64)> {
    let empty = || DMatrix::zeros(0, 0);
    let mut space = Subspace { system, basis: Vec::new(), stiffness: empty(), damping: empty() };
    let most = (STORAGE / system.inverse_sqrt_masses.len().max(1)).clamp(8, MOST_VECTORS);
    for v in start {
        space.add(v);
    }
    let largest_frequency = quotient(system.stiffness, system.inverse_sqrt_masses, &space.basis[0]).max(0.0).sqrt();
    for relative_rate in RELATIVE_RATES {
        let difference = |p: &NodeVectors, out: &mut NodeVectors| {
            let mut damped = NodeVectors::zeros(p.nrows());
            (system.damping)(1.0, p, &mut damped);
            (system.stiffness)(p, out);
            *out -= damped * (relative_rate * largest_frequency);
        };
        space.add(largest(&difference, system.inverse_sqrt_masses, None, accuracy.first(), spare)?.mode);
    }
    let mut limits: Vec<f64> = Vec::new();
    loop {
        if !space.stiffness.iter().chain(space.damping.iter()).all(|value| value.is_finite()) {
            return Err(Error::NotFinite { what: "the stiffness", node: 0, value: f64::NAN });
        }
        let mut steps: Vec<(f64, Complex<f64>)> = space
            .ritz_values(scale)
            .into_iter()
            .map(|root| (largest_step(integrator, mode_of(root, system.frame_rate)), root))
            .collect();
        steps.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (dt, root) = steps[0];
        let ritz_pairs: Vec<_> = steps
            .iter()
            .take(EXTENDED)
            .map(|(_, root)| (*root, space.ritz_vector(&space.eigenvector(*root))))
            .collect();
        let has_converged = limits.len() >= UNCHANGED
            && limits[limits.len() - UNCHANGED..].iter().all(|last| (last / dt - 1.0).abs() < TOLERANCE);
        limits.push(dt);
        let mut has_grown = false;
        if !has_converged {
            for (root, shape) in &ritz_pairs {
                for part in space.residual(*root, shape) {
                    has_grown |= space.basis.len() < most && space.add(part);
                }
            }
        }
        if !has_grown {
            let [re, im] = &ritz_pairs[0].1;
            let mode = if re.norm() >= im.norm() { re } else { im };
            let norm = mode.norm();
            return Ok((dt, mode / norm.max(f64::MIN_POSITIVE), root.norm()));
        }
    }
}
