//! Choices of the scheme, for tests: how lists are made, which the motion does not depend on, and what it does without.

use serde::Deserialize;

use super::lists::{HORIZONS, LISTS, SKINS};

/// Choices of the scheme.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Scheme {
    /// Skins of the lists, relative to the distance at which layers touch, descending.
    pub skins: [f64; LISTS],
    /// Horizons of the lists at the start, in steps.
    pub horizons: [f64; LISTS],
    /// Whether there are pairs of two edges.
    pub has_edges: bool,
    /// beta: the share of the depth by which a pair that is too near is pushed apart in a step.
    pub share_of_depth: f64,
}

impl Scheme {
    /// That of every scene.
    pub const USUAL: Self = Self { skins: SKINS, horizons: HORIZONS, has_edges: true, share_of_depth: 0.02 };
}

impl Default for Scheme {
    fn default() -> Self {
        Self::USUAL
    }
}
