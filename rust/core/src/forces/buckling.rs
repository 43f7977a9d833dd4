//! How far an edge of the membrane shortens before it buckles, eq. (2): Euler's strain of a slender column,
//!
//!     L - l_cr = alpha pi^2 h^2 / (12 L)        [m]   with the edge's own length L, as the paper has it
//!     L - l_cr = alpha pi^2 h^2 L / (12 l0^2)   [m]   with a physical length l0: one critical strain on every edge
//!
//! The first form belongs to one mesh: halve L, and the critical strain is four times as large. In the second it is the
//! same on every mesh; on edges of length l0 the two agree.

use std::f64::consts::PI;

use crate::error::Result;
use crate::mesh;
use crate::model::{Assembly, non_negative, positive};

/// Parameters of eq. (2).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Buckling {
    /// alpha.
    pub(super) parameter: f64,
    /// alpha on edges that are creases.
    pub(super) on_creases: f64,
    /// l0 [m]; `None`: each edge's own length.
    pub(super) length: Option<f64>,
}

impl Buckling {
    /// Reference length and L - l_cr of each edge of the mesh [m].
    ///
    /// # Errors
    /// `OutOfRange` for a parameter.
    pub(super) fn shortenings(self, assembly: &Assembly) -> Result<Vec<(f64, f64)>> {
        non_negative("buckling parameter", self.parameter)?;
        non_negative("buckling parameter on creases", self.on_creases)?;
        if let Some(length) = self.length {
            positive("buckling length [m]", length)?;
        }
        let mut alpha = vec![self.parameter; assembly.mesh.edges.len()];
        for hinge in &assembly.hinges {
            alpha[hinge.edge as usize] = self.on_creases;
        }
        let thickness = assembly.model.film.map_or(0.0, |film| film.thickness);
        let shortenings = assembly.mesh.edges.iter().zip(alpha).map(|(nodes, alpha)| {
            let [a, b] = nodes.map(|node| assembly.mesh.reference[node as usize]);
            let span = mesh::sub(b, a);
            let length = mesh::dot(span, span).sqrt();
            let own = alpha * PI * PI * thickness * thickness / (12.0 * length);
            (length, self.length.map_or(own, |l0| own * (length / l0) * (length / l0)))
        });
        Ok(shortenings.collect())
    }
}
