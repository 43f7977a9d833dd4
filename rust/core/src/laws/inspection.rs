//! Readings of the elements of a law.

use super::Instant;

/// A law with elements that have readings or bounds.
pub trait Inspection {
    /// The first element beyond its bound.
    fn first_excess(&self, _at: Instant<'_>) -> Option<Excess> {
        None
    }

    /// Readings of each element, in external order.
    fn readings(&self, _at: Instant<'_>) -> Readings {
        Readings::None
    }

    /// Number of elements of its own, and number of their lanes including padding lanes.
    fn lanes(&self) -> [usize; 2] {
        [0, 0]
    }

    /// Share of the elements in contiguous or split batches.
    fn contiguous_share(&self) -> f64;
}

/// An element beyond its bound.
#[derive(Debug, Clone, PartialEq)]
pub struct Excess {
    /// Two nodes of the element, internal numbers.
    pub nodes: [u32; 2],
    /// The message, with value and bound.
    pub what: String,
}

/// One number or two per element, in external order.
#[derive(Debug, Clone, PartialEq)]
pub enum Readings {
    /// No readings.
    None,
    /// Springs: engineering strain, and whether the spring is buckled (shorter than its critical length).
    Springs {
        /// Engineering strain.
        strain: Vec<f64>,
        /// Shorter than the critical length.
        buckled: Vec<bool>,
    },
    /// Triangles of film: principal strains, and state of the film.
    Triangles {
        /// Principal Green strains, larger first.
        strain: Vec<[f64; 2]>,
        /// 0 taut, 1 wrinkled, 2 slack.
        state: Vec<u8>,
    },
    /// Creases: the crease angle, pi flat, 0 shut \[rad\].
    Creases {
        /// Crease angle \[rad\].
        angle: Vec<f64>,
    },
}
