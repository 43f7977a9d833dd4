//! Parameters of contact between layers.

use serde::Deserialize;

use super::{Scheme, SelfContact};
use crate::error::Result;
use crate::laws::{Context, Law, LawParameters};

/// Parameters of contact between layers.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SelfContactParameters {
    /// d0 of two layers; `None`: the film's thickness \[m\].
    pub thickness: Option<f64>,
    /// Diameter of the cords: d0 of a cord and a layer is half of the sum \[m\].
    pub cord_thickness: f64,
    /// Whether cords and film feel each other.
    pub cords: bool,
    /// Coulomb's coefficient.
    pub friction: f64,
    /// Ratio of the speeds of separation and approach.
    pub restitution: f64,
    /// Steps between two checks for crossings.
    pub crossing_interval: f64,
    /// Choices of the scheme, which scenes leave as they are.
    #[serde(default)]
    pub scheme: Scheme,
}

impl LawParameters for SelfContactParameters {
    fn build(&self, context: &Context<'_>) -> Result<Box<dyn Law>> {
        Ok(Box::new(SelfContact::new(self, context)?))
    }

    fn example() -> Self {
        Self {
            thickness: None,
            cord_thickness: 1e-5,
            cords: true,
            friction: 0.2,
            restitution: 0.3,
            crossing_interval: 100.0,
            scheme: Scheme::USUAL,
        }
    }
}
