//! What a film is made of.

use super::checks::{positive, within};
use crate::error::Result;

/// Material and thickness of the membrane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Film {
    /// Young's modulus E \[Pa\].
    pub youngs_modulus: f64,
    /// Poisson's ratio nu, in (-1, 0.5).
    pub poisson_ratio: f64,
    /// Density rho \[kg/m3\].
    pub density: f64,
    /// Thickness h \[m\].
    pub thickness: f64,
}

impl Film {
    /// Checks each value.
    ///
    /// # Errors
    /// `OutOfRange`.
    pub fn check(&self) -> Result<()> {
        positive("Young's modulus [Pa]", self.youngs_modulus)?;
        positive("density [kg/m3]", self.density)?;
        positive("thickness [m]", self.thickness)?;
        within(
            "Poisson's ratio",
            self.poisson_ratio,
            self.poisson_ratio > -1.0 && self.poisson_ratio < 0.5,
            "it lies between -1 and 0.5",
        )
    }

    /// D = E h^3 / (12 (1 - nu^2)), the bending stiffness of a plate per width \[N m\].
    pub fn bending_stiffness(&self) -> f64 {
        self.youngs_modulus * self.thickness.powi(3) / (12.0 * (1.0 - self.poisson_ratio * self.poisson_ratio))
    }
}
