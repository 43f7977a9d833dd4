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
//!
//! A region of the film has its own h, and may have its own alpha. An edge between two films buckles at the sum of the
//! forces of its triangles: its L - l_cr is the mean of theirs by their spring constants.

use std::f64::consts::PI;

use crate::assembly::Assembly;
use crate::error::Result;
use crate::model::checks::{non_negative, positive};
use crate::model::mesh;
use crate::model::regions::{FilmOfTriangles, RegionFilm};

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

/// An edge of the mesh.
#[derive(Debug, Clone, Copy)]
pub(super) struct Edge {
    /// In the reference [m].
    pub(super) length: f64,
    pub(super) is_crease: bool,
}

/// All edges of the mesh.
pub(super) fn edges(assembly: &Assembly) -> Vec<Edge> {
    let of_nodes = |nodes: &[u32; 2]| {
        let [a, b] = nodes.map(|node| assembly.mesh.reference[node as usize]);
        let span = mesh::sub(b, a);
        Edge { length: mesh::dot(span, span).sqrt(), is_crease: false }
    };
    let mut edges: Vec<Edge> = assembly.mesh.edges.iter().map(of_nodes).collect();
    assembly.hinges.iter().for_each(|hinge| edges[hinge.edge as usize].is_crease = true);
    edges
}

impl Buckling {
    /// Checks the parameters.
    ///
    /// # Errors
    /// `OutOfRange`.
    pub(super) fn check(self) -> Result<()> {
        non_negative("buckling parameter", self.parameter)?;
        non_negative("buckling parameter on creases", self.on_creases)?;
        for (what, length) in [("buckling length [m]", self.length), ("crease length [m]", self.crease_length)] {
            if let Some(length) = length {
                positive(what, length)?;
            }
        }
        Ok(())
    }

    /// L - l_cr of an edge of a film [m].
    pub(super) fn shortening(self, film: &RegionFilm, Edge { length, is_crease }: Edge) -> f64 {
        let unit = PI * PI * film.film.thickness * film.film.thickness / 12.0;
        let parameter = film.buckling.unwrap_or(self.parameter);
        let of = |alpha: f64| {
            let own = alpha * unit / length;
            self.length.map_or(own, |l0| own * (length / l0) * (length / l0))
        };
        match self.crease_length {
            _ if !is_crease => of(parameter),
            None => of(self.on_creases),
            Some(line) => (of(parameter) + (self.on_creases - parameter) * unit / line).max(0.0),
        }
    }

    /// Reference length and L - l_cr of each edge of the mesh [m].
    ///
    /// # Errors
    /// `OutOfRange` for a parameter.
    pub(super) fn shortenings(self, assembly: &Assembly) -> Result<Vec<(f64, f64)>> {
        self.check()?;
        let Some(films) = &assembly.film else { return Ok(Vec::new()) };
        let edges = edges(assembly);
        let mut shortenings: Vec<f64> = edges.iter().map(|&edge| self.shortening(films.of_no_region(), edge)).collect();
        if films.has_regions() {
            self.average(assembly, films, &edges, &mut shortenings);
        }
        Ok(edges.iter().map(|edge| edge.length).zip(shortenings).collect())
    }

    /// The mean over the triangles at each edge, by their shares of its spring constant.
    fn average(self, assembly: &Assembly, films: &FilmOfTriangles, edges: &[Edge], means: &mut [f64]) {
        let mut sums = vec![[0.0; 2]; edges.len()];
        let mut bounds = vec![[f64::INFINITY, 0.0]; edges.len()];
        for (triangle, sides) in assembly.mesh.triangle_edges.iter().enumerate() {
            let constants = assembly.side_stiffness.get(triangle).copied().unwrap_or([1.0; 3]);
            for (side, constant) in sides.iter().map(|&side| side as usize).zip(constants) {
                let (own, share) = (self.shortening(films.of(triangle), edges[side]), constant.max(0.0));
                bounds[side] = [bounds[side][0].min(own), bounds[side][1].max(own)];
                sums[side] = [sums[side][0] + share * own, sums[side][1] + share];
            }
        }
        for ((mean, [sum, shares]), [least, most]) in means.iter_mut().zip(sums).zip(bounds) {
            // Equal values to the last bit; between others within them.
            *mean = if shares > 0.0 { (sum / shares).clamp(least, most) } else { 0.5 * (least + most) };
        }
    }
}
