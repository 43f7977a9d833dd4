//! Passes over node vectors, of several operations each: on large meshes all of them wait for memory.
//!
//! Sums are taken as nalgebra takes them, by eight partial sums, so that a pass gives the bits of its operations.

use crate::arrays::state::NodeVectors;

/// Number of partial sums.
const PARTS: usize = 8;

/// A sum, and what partial sums add to it.
fn with_parts(sum: f64, parts: [f64; PARTS]) -> f64 {
    (0..PARTS / 2).fold(sum, |sum, k| sum + (parts[k] + parts[k + PARTS / 2]))
}

/// The columns of vectors.
fn columns(vectors: &NodeVectors) -> impl Iterator<Item = &[f64]> {
    vectors.as_slice().chunks_exact(vectors.nrows().max(1))
}

/// The same, to be changed.
fn columns_mut(vectors: &mut NodeVectors) -> impl Iterator<Item = &mut [f64]> {
    let rows = vectors.nrows().max(1);
    vectors.as_mut_slice().chunks_exact_mut(rows)
}

/// y += a x
pub(super) fn add_scaled(y: &mut NodeVectors, a: f64, x: &NodeVectors) {
    y.as_mut_slice().iter_mut().zip(x.as_slice()).for_each(|(y, x)| *y += a * x);
}

/// Multiplies each row by a number.
pub(super) fn scale_rows(vectors: &mut NodeVectors, factors: &[f64]) {
    for column in columns_mut(vectors) {
        column.iter_mut().zip(factors).for_each(|(value, factor)| *value *= factor);
    }
}

/// Each row of `q`, multiplied by a number.
pub(super) fn scaled_into(factors: &[f64], q: &NodeVectors, scaled: &mut NodeVectors) {
    for (scaled, q) in columns_mut(scaled).zip(columns(q)) {
        scaled.iter_mut().zip(q).zip(factors).for_each(|((scaled, q), factor)| *scaled = q * factor);
    }
}

/// out = D out - beta previous with the factors D of the rows, and q . out.
pub(super) fn reduce(
    out: &mut NodeVectors,
    factors: &[f64],
    beta: f64,
    previous: &NodeVectors,
    q: &NodeVectors,
) -> f64 {
    let mut sum = 0.0;
    for ((out, previous), q) in columns_mut(out).zip(columns(previous)).zip(columns(q)) {
        let row = |out: &mut f64, factor: f64, previous: f64, q: f64| {
            *out = *out * factor - beta * previous;
            q * *out
        };
        let whole = out.len() - out.len() % PARTS;
        let mut parts = [0.0; PARTS];
        let chunks = out.chunks_exact_mut(PARTS).zip(factors.chunks_exact(PARTS));
        for (((out, factors), previous), q) in chunks.zip(previous.chunks_exact(PARTS)).zip(q.chunks_exact(PARTS)) {
            for k in 0..PARTS {
                parts[k] += row(&mut out[k], factors[k], previous[k], q[k]);
            }
        }
        sum = with_parts(sum, parts);
        for k in whole..out.len() {
            sum += row(&mut out[k], factors[k], previous[k], q[k]);
        }
    }
    sum
}

/// out -= alpha q, and the norm of out.
pub(super) fn orthogonalise(out: &mut NodeVectors, alpha: f64, q: &NodeVectors) -> f64 {
    let mut square = 0.0;
    for (out, q) in columns_mut(out).zip(columns(q)) {
        let row = |out: &mut f64, q: f64| {
            *out -= alpha * q;
            *out * *out
        };
        let whole = out.len() - out.len() % PARTS;
        let mut parts = [0.0; PARTS];
        for (out, q) in out.chunks_exact_mut(PARTS).zip(q.chunks_exact(PARTS)) {
            for k in 0..PARTS {
                parts[k] += row(&mut out[k], q[k]);
            }
        }
        let mut sum = with_parts(0.0, parts);
        for k in whole..out.len() {
            sum += row(&mut out[k], q[k]);
        }
        square += sum;
    }
    square.sqrt()
}

/// q = next / beta, scaled = D q with the factors D of the rows, next = 0.
pub(super) fn start_product(
    next: &mut NodeVectors,
    beta: f64,
    factors: &[f64],
    q: &mut NodeVectors,
    scaled: &mut NodeVectors,
) {
    for ((next, q), scaled) in columns_mut(next).zip(columns_mut(q)).zip(columns_mut(scaled)) {
        for (((next, q), scaled), factor) in next.iter_mut().zip(q).zip(scaled).zip(factors) {
            *q = *next / beta;
            *scaled = *q * factor;
            *next = 0.0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Vectors of any numbers.
    fn vectors(seed: f64) -> NodeVectors {
        NodeVectors::from_fn(37, |i, axis| (seed + 0.37 * (3 * i + axis) as f64).sin())
    }

    #[test]
    fn a_pass_has_the_bits_of_its_operations() {
        let (factors, beta, alpha) = (vectors(0.1).column(0).iter().copied().collect::<Vec<f64>>(), 0.7, -1.3);
        let (before, previous, q) = (vectors(1.0), vectors(2.0), vectors(3.0));
        let mut expected = before.clone();
        scale_rows(&mut expected, &factors);
        expected -= &previous * beta;
        let mut out = before;
        assert_eq!(reduce(&mut out, &factors, beta, &previous, &q), q.dot(&expected));
        assert_eq!(out, expected);
        expected -= &q * alpha;
        assert_eq!(orthogonalise(&mut out, alpha, &q), expected.norm());
        assert_eq!(out, expected);
        let (mut next, mut scaled) = (vectors(4.0), vectors(5.0));
        start_product(&mut out, beta, &factors, &mut next, &mut scaled);
        expected /= beta;
        assert_eq!((&next, out), (&expected, NodeVectors::zeros(37)));
        scale_rows(&mut expected, &factors);
        assert_eq!(scaled, expected);
        scaled_into(&factors, &next, &mut scaled);
        assert_eq!(scaled, expected);
    }
}
