//! A film of two moduli, as one of fibres or of a textile, in plane stress.
//!
//! With axis 1 along a direction of the flat reference, nu the contraction across of a stretch along it, E that of the
//! axis, e = E_2/E and g = G/E, the stress over E is
//!
//!     S_11 = (E_11 + nu e E_22) / (1 - nu^2 e),   S_22 = e (E_22 + nu E_11) / (1 - nu^2 e),   S_12 = 2 g E_12
//!
//! Source: Jones, Mechanics of Composite Materials (1999), section 2.5.

use super::checks::{finite, positive, within};
use crate::error::Result;

/// The moduli over that of the first axis, and the axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Orthotropy {
    /// Of axis 1 in the reference, from x \[rad\].
    pub direction: f64,
    /// E_2/E.
    pub across: f64,
    /// G/E.
    pub shear: f64,
}

/// Components 11, 22 and 12 of a symmetric tensor in the axes of the film.
type Components = [f64; 3];

impl Orthotropy {
    /// Checks each value.
    ///
    /// # Errors
    /// `OutOfRange`.
    pub fn check(&self, poisson_ratio: f64) -> Result<()> {
        finite("direction of the film [rad]", self.direction)?;
        positive("modulus of the film across its direction over that along it", self.across)?;
        positive("shear modulus of the film over Young's modulus", self.shear)?;
        let product = poisson_ratio * poisson_ratio * self.across;
        within("nu^2 E_2/E_1 of the film", product, product < 1.0, "it must be below 1")
    }

    /// Components along and across of a vector of the reference.
    pub(crate) fn components(&self, [x, y, _]: [f64; 3]) -> [f64; 2] {
        let (sine, cosine) = self.direction.sin_cos();
        [x * cosine + y * sine, y * cosine - x * sine]
    }

    /// The stress of one strain times another strain, over E: a : C : b.
    pub(crate) fn product(&self, nu: f64, a: Components, b: Components) -> f64 {
        let Self { across, shear, .. } = *self;
        let normal = a[0] * b[0] + across * a[1] * b[1] + nu * across * (a[0] * b[1] + a[1] * b[0]);
        normal / (1.0 - nu * nu * across) + 4.0 * shear * a[2] * b[2]
    }
}

/// The symmetric product of two vectors.
pub(crate) fn symmetric([a1, a2]: [f64; 2], [b1, b2]: [f64; 2]) -> Components {
    [a1 * b1, a2 * b2, 0.5 * (a1 * b2 + a2 * b1)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn with_equal_moduli_it_is_the_law_of_hooke_in_every_direction() {
        let nu = 0.3;
        let isotropic = Orthotropy { direction: 0.4, across: 1.0, shear: 0.5 / (1.0 + nu) };
        for angle in [0.0, 0.3, 1.2, 2.5] {
            let (y, x) = f64::sin_cos(angle);
            let [along, across] = [[x, y, 0.0], [-y, x, 0.0]].map(|vector| isotropic.components(vector));
            let [a, b, mixed] = [symmetric(along, along), symmetric(across, across), symmetric(along, across)];
            let factor = 1.0 / (1.0 - nu * nu);
            for (found, known) in [
                (isotropic.product(nu, a, a), factor),
                (isotropic.product(nu, a, b), factor * nu),
                (isotropic.product(nu, a, mixed), 0.0),
                (isotropic.product(nu, mixed, mixed), 0.5 / (1.0 + nu)),
            ] {
                assert!((found - known).abs() < 1e-14, "{angle}: {found} {known}");
            }
        }
    }
}
