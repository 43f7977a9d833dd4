//! Readings of the elements of a law: each from the equations of the law itself.

use super::{ContactStatistics, Instant};
use crate::elements::stress::{TriangleStress, largest_principal};

/// A law with elements that have readings or bounds. It gives the readings that it has, in external order.
pub trait Inspection {
    /// The first element beyond its bound.
    fn first_excess(&self, _at: Instant<'_>) -> Option<Excess> {
        None
    }

    /// Readings of each link.
    fn links(&self, _at: Instant<'_>) -> Option<LinkReadings> {
        None
    }

    /// Stress of each triangle of the film.
    fn film_stress(&self, _at: Instant<'_>) -> Option<Vec<TriangleStress>> {
        None
    }

    /// The largest principal stress of the film, at least 0; `None` without triangles \[Pa\].
    fn largest_film_stress(&self, at: Instant<'_>) -> Option<f64> {
        largest_principal(self.film_stress(at)?.iter().map(|triangle| triangle.stress))
    }

    /// State of each triangle of the film.
    fn film_states(&self, _at: Instant<'_>) -> Option<FilmStates> {
        None
    }

    /// Angle of each crease, pi flat, 0 shut \[rad\].
    fn crease_angles(&self, _at: Instant<'_>) -> Option<Vec<f64>> {
        None
    }

    /// Whether the hub exerts the forces of the law, by contact: their reaction acts on the hub.
    fn is_contact_with_hub(&self) -> bool {
        false
    }

    /// What contact between layers has spent.
    fn contact_statistics(&self) -> Option<ContactStatistics> {
        None
    }

    /// Number of elements of its own, and number of their lanes including padding lanes.
    fn lanes(&self) -> [usize; 2] {
        [0, 0]
    }

    /// Share of the elements in contiguous or split batches; `None` without batches.
    fn contiguous_share(&self) -> Option<f64> {
        None
    }
}

/// An element beyond its bound.
#[derive(Debug, Clone, PartialEq)]
pub struct Excess {
    /// One node or two of the element, internal numbers.
    pub nodes: Vec<u32>,
    /// The message, with value and bound.
    pub what: String,
}

/// Readings of links, one entry per link.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LinkReadings {
    /// Engineering strain.
    pub strain: Vec<f64>,
    /// Elastic tension, negative in compression; that of dashpots is not included \[N\].
    pub tension: Vec<f64>,
    /// Whether the link is buckled: shorter than its critical length.
    pub buckled: Vec<bool>,
}

/// State of a film of triangles.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FilmStates {
    /// Of each triangle: principal Green strains, larger first.
    pub strain: Vec<[f64; 2]>,
    /// Of each triangle: 0 taut, 1 wrinkled, 2 slack.
    pub state: Vec<u8>,
    /// Of each edge: whether it is shorter than its reference, beside a triangle that is wrinkled or slack.
    pub buckled: Vec<bool>,
}
