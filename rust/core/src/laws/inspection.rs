//! What can be read off the elements of a law.

use super::Instant;

/// A law whose elements can be read.
pub trait Inspection {
    /// The first element that is beyond the bound its user set.
    fn first_excess(&self, _at: Instant<'_>) -> Option<Excess> {
        None
    }

    /// Readings of each element, in the caller's order.
    fn readings(&self, _at: Instant<'_>) -> Readings {
        Readings::None
    }

    /// The law's elements of its own, and the lanes that they take up, padding included.
    fn lanes(&self) -> [usize; 2] {
        [0, 0]
    }

    /// Share of the elements that kernels reach in contiguous or split batches.
    fn contiguous_share(&self) -> f64;
}

/// An element beyond its bound: nodes in the core's numbering, and what happened.
#[derive(Debug, Clone, PartialEq)]
pub struct Excess {
    /// The ends of the element.
    pub nodes: [u32; 2],
    /// In words and numbers.
    pub what: String,
}

/// One number (or two) per element, in the caller's order.
#[derive(Debug, Clone, PartialEq)]
pub enum Readings {
    /// Nothing to read.
    None,
    /// Springs: engineering strain, and whether the spring is buckled (shorter than its critical length).
    Springs {
        /// Engineering strain.
        strain: Vec<f64>,
        /// Shorter than the critical length.
        buckled: Vec<bool>,
    },
    /// Triangles of film: principal strains, and what the film does.
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
