//! Optical properties of both sides of a film.

use super::checks::within;
use crate::error::Result;

/// What one side does with light, all from 0 to 1 \[-\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OpticalSide {
    /// r_s, the share that it reflects as a mirror.
    pub specular: f64,
    /// r_d, the share that it scatters by Lambert's law.
    pub diffuse: f64,
    /// e, its emissivity.
    pub emissivity: f64,
    /// B, the share of emitted momentum along the normal.
    pub lambert: f64,
}

/// The front, the side of the normals, and the back.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Optics {
    /// Of the front.
    pub front: OpticalSide,
    /// Of the back.
    pub back: OpticalSide,
}

impl Optics {
    /// Checks the shares.
    ///
    /// # Errors
    /// `OutOfRange`.
    pub fn check(&self) -> Result<()> {
        let Self { front, back } = self;
        let shares = [
            ("specular share of the front", front.specular),
            ("diffuse share of the front", front.diffuse),
            ("emissivity of the front", front.emissivity),
            ("Lambert coefficient of the front", front.lambert),
            ("specular share of the back", back.specular),
            ("diffuse share of the back", back.diffuse),
            ("emissivity of the back", back.emissivity),
            ("Lambert coefficient of the back", back.lambert),
        ];
        for (what, share) in shares {
            within(what, share, (0.0..=1.0).contains(&share), "it must be 0 to 1")?;
        }
        let both = [
            ("reflected share of the front", front.specular + front.diffuse),
            ("reflected share of the back", back.specular + back.diffuse),
        ];
        for (what, share) in both {
            within(what, share, share <= 1.0 + f64::EPSILON, "specular and diffuse share together are at most 1")?;
        }
        let emitted = front.emissivity + back.emissivity;
        within("emissivity of both sides", emitted, emitted > 0.0, "one must emit what the film absorbs")
    }
}
