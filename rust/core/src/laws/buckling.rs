//! Shortening of an edge of the membrane up to buckling, eq. (2), by Euler's critical strain of a slender column:
//!
//!     L - l_cr = alpha pi^2 h^2 / (12 L)        [m]   with the length L of the edge: the form of the paper
//!     L - l_cr = alpha pi^2 h^2 L / (12 l0^2)   [m]   with a physical length l0: one critical strain on every edge
//!
//! The first form belongs to one mesh: at half L the critical strain is four times as large. The second has one
//! critical strain on every mesh. On edges of length l0 the two agree.
//!
//! A crease has its own alpha_c in place of alpha. It is a line, but the film beside it is an area. At one critical
//! strain the buckling force of an edge, k (L - l_cr), is proportional to the width of film of the edge, so that the
//! force of a crease tends to zero on finer meshes. With a length l_c the crease has a force of its own in addition to
//! that of the film, equal on every mesh, since k does not depend on L:
//!
//!     L - l_cr = (L - l_cr of the film) + (alpha_c - alpha) pi^2 h^2 / (12 l_c)   [m]
//!
//! On creases of length l_c = l0 all forms agree.

use std::f64::consts::PI;

use crate::assembly::Assembly;
use crate::error::Result;
use crate::model::checks::{non_negative, positive};
use crate::model::mesh;

/// Parameters of eq. (2).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Buckling {
    /// alpha.
    pub(super) parameter: f64,
    /// alpha on edges that are creases.
    pub(super) on_creases: f64,
    /// l0 [m]; `None`: the length of each edge.
    pub(super) length: Option<f64>,
    /// l_c [m]; `None`: a crease differs from the film by its alpha only.
    pub(super) crease_length: Option<f64>,
}

impl Buckling {
    /// Reference length and L - l_cr of each edge of the mesh [m].
    ///
    /// # Errors
    /// `OutOfRange` for a parameter.
    pub(super) fn shortenings(self, assembly: &Assembly) -> Result<Vec<(f64, f64)>> {
        non_negative("buckling parameter", self.parameter)?;
        non_negative("buckling parameter on creases", self.on_creases)?;
        for (what, length) in [("buckling length [m]", self.length), ("crease length [m]", self.crease_length)] {
            if let Some(length) = length {
                positive(what, length)?;
            }
        }
        let mut is_crease = vec![false; assembly.mesh.edges.len()];
        for hinge in &assembly.hinges {
            is_crease[hinge.edge as usize] = true;
        }
        let thickness = assembly.model.film.map_or(0.0, |film| film.thickness);
        let unit = PI * PI * thickness * thickness / 12.0;
        let shortenings = assembly.mesh.edges.iter().zip(is_crease).map(|(nodes, is_crease)| {
            let [a, b] = nodes.map(|node| assembly.mesh.reference[node as usize]);
            let span = mesh::sub(b, a);
            let length = mesh::dot(span, span).sqrt();
            let of = |alpha: f64| {
                let own = alpha * unit / length;
                self.length.map_or(own, |l0| own * (length / l0) * (length / l0))
            };
            let shortening = match self.crease_length {
                _ if !is_crease => of(self.parameter),
                None => of(self.on_creases),
                Some(line) => (of(self.parameter) + (self.on_creases - self.parameter) * unit / line).max(0.0),
            };
            (length, shortening)
        });
        Ok(shortenings.collect())
    }
}
