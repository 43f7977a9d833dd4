//! Principal values and directions of the stress of a triangle.
//!
//! The stress is the second Piola-Kirchhoff stress S \[Pa\], per area of the reference. Its principal directions are
//! pushed forward to the present shape: d1 = F n1 / |F n1|, and d2 at right angles to it in the plane of the triangle.
//! In a film, whose strains are small, S differs from the Cauchy stress by the order of the strain. Unlike the latter
//! it remains bounded where a slack triangle collapses to a line.

use crate::model::mesh::{dot, sub};

/// Stress and deformation of a triangle of film, in a frame of its reference.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TriangleStress {
    /// S: 11, 22 and 12 \[Pa\].
    pub stress: [f64; 3],
    /// The columns of F.
    pub gradient: [[f64; 3]; 2],
}

impl TriangleStress {
    /// Principal values, the larger first \[Pa\].
    pub fn values(&self) -> [f64; 2] {
        principal_values(self.stress)
    }

    /// The principal directions in the present shape, unit vectors; zero where a collapsed triangle leaves them
    /// undefined.
    pub fn directions(&self) -> [[f64; 3]; 2] {
        let ([s11, s22, s12], [f1, f2]) = (self.stress, self.gradient);
        // Half the angle of (difference, s12) is that of the axis of the larger value.
        let (sine, cosine) = (0.5 * s12.atan2(0.5 * (s11 - s22))).sin_cos();
        let pushed = |x: f64, y: f64| [0, 1, 2].map(|axis| x * f1[axis] + y * f2[axis]);
        let first = unit(pushed(cosine, sine));
        let second = pushed(-sine, cosine);
        let along = dot(second, first);
        [first, unit(sub(second, first.map(|component| along * component)))]
    }
}

/// The largest principal value of stresses 11, 22 and 12, at least 0; `None` of no stress \[Pa\].
pub fn largest_principal(mut stresses: impl Iterator<Item = [f64; 3]>) -> Option<f64> {
    let first = stresses.next()?;
    Some(stresses.fold(principal_values(first)[0].max(0.0), |largest, stress| largest.max(principal_values(stress)[0])))
}

/// Principal values of a stress 11, 22 and 12, the larger first \[Pa\].
fn principal_values([s11, s22, s12]: [f64; 3]) -> [f64; 2] {
    let (mean, difference) = (0.5 * (s11 + s22), 0.5 * (s11 - s22));
    let spread = (difference * difference + s12 * s12).sqrt();
    [mean + spread, mean - spread]
}

fn unit(vector: [f64; 3]) -> [f64; 3] {
    let length = dot(vector, vector).sqrt();
    if length > 0.0 { vector.map(|component| component / length) } else { [0.0; 3] }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FLAT: [[f64; 3]; 2] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

    #[test]
    fn values_and_directions_rebuild_the_tensor() {
        for stress in [[3.0, 1.0, 0.7], [-2.0, 5.0, -4.0], [1.0, 1.0, 0.0], [-1.0, -6.0, 0.0], [0.0, 0.0, 2.0]] {
            let own = TriangleStress { stress, gradient: FLAT };
            let (values, directions) = (own.values(), own.directions());
            assert!(values[0] >= values[1]);
            let component =
                |i: usize, j: usize| (0..2).map(|k| values[k] * directions[k][i] * directions[k][j]).sum::<f64>();
            for (found, expected) in [component(0, 0), component(1, 1), component(0, 1)].into_iter().zip(stress) {
                assert!((found - expected).abs() < 1e-14 * 10.0, "{stress:?} {found}");
            }
        }
    }

    #[test]
    fn directions_turn_with_the_triangle_and_are_orthonormal_in_its_plane() {
        let gradient = [[0.0, 1.1, 0.2], [0.1, 0.0, 0.9]];
        let [a, b] = TriangleStress { stress: [2.0, 1.0, 0.3], gradient }.directions();
        let normal = crate::model::mesh::cross(gradient[0], gradient[1]);
        for (product, expected) in [(dot(a, a), 1.0), (dot(b, b), 1.0), (dot(a, b), 0.0)] {
            assert!((product - expected).abs() < 1e-15);
        }
        assert!(dot(a, normal).abs() < 1e-15 && dot(b, normal).abs() < 1e-15);
    }

    #[test]
    fn a_triangle_that_is_a_line_or_a_point_has_no_second_direction() {
        let directions = |gradient| TriangleStress { stress: [1.0, 0.0, 0.0], gradient }.directions();
        let line = directions([[1.0, 0.0, 0.0], [0.5, 0.0, 0.0]]);
        assert_eq!(line, [[1.0, 0.0, 0.0], [0.0; 3]]);
        assert_eq!(directions([[0.0; 3]; 2]), [[0.0; 3]; 2]);
    }
}
