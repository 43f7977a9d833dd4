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
//! forces of its triangles: its L - l_cr is the mean of theirs by their spring constants. So is its rest length where
//! films are free of stress at a strain of their own.

use std::f64::consts::PI;

use crate::assembly::Assembly;
use crate::error::Result;
use crate::model::checks::{non_negative, positive};
use crate::model::mesh;
use crate::model::regions::RegionFilm;

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

    /// Rest length and L - l_cr of each edge of the mesh [m], by the part of each triangle in the spring constants of
    /// its sides, side k opposite corner k.
    ///
    /// # Errors
    /// `OutOfRange` for a parameter.
    pub(super) fn shortenings(self, assembly: &Assembly, parts: &[[f64; 3]]) -> Result<Vec<(f64, f64)>> {
        self.check()?;
        let Some(films) = &assembly.film else { return Ok(Vec::new()) };
        let edges = edges(assembly);
        if !films.has_regions() {
            let whole = films.of_no_region();
            return Ok(edges.iter().map(|&edge| (edge.length, self.shortening(whole, edge))).collect());
        }
        let mut means = vec![[Mean::default(); 2]; edges.len()];
        for (triangle, sides) in assembly.mesh.triangle_edges.iter().enumerate() {
            let film = films.of(triangle);
            let constants = parts.get(triangle).copied().unwrap_or([1.0; 3]);
            for (side, constant) in sides.iter().map(|&side| side as usize).zip(constants) {
                let [length, shortening] = &mut means[side];
                length.add(self.rest_length(assembly, film, side, edges[side].length), constant.max(0.0));
                shortening.add(self.shortening(film, edges[side]), constant.max(0.0));
            }
        }
        Ok(means.iter().map(|[length, shortening]| (length.value(), shortening.value())).collect())
    }

    /// Length of an edge in the film free of stress [m].
    fn rest_length(self, assembly: &Assembly, film: &RegionFilm, edge: usize, length: f64) -> f64 {
        if film.natural_strain == [0.0; 3] {
            return length;
        }
        let [a, b] = assembly.mesh.edges[edge].map(|node| assembly.mesh.reference[node as usize]);
        let span = film.natural(mesh::sub(b, a));
        mesh::dot(span, span).sqrt()
    }
}

/// A weighted mean: of equal values that value, to the last bit.
#[derive(Debug, Clone, Copy)]
pub(super) struct Mean {
    sum: f64,
    shares: f64,
    least: f64,
    most: f64,
}

impl Default for Mean {
    fn default() -> Self {
        Self { sum: 0.0, shares: 0.0, least: f64::INFINITY, most: f64::NEG_INFINITY }
    }
}

impl Mean {
    pub(super) fn add(&mut self, value: f64, share: f64) {
        self.sum += share * value;
        self.shares += share;
        self.least = self.least.min(value);
        self.most = self.most.max(value);
    }

    pub(super) fn value(&self) -> f64 {
        let middle = 0.5 * (self.least + self.most);
        if self.shares > 0.0 { (self.sum / self.shares).clamp(self.least, self.most) } else { middle }
    }
}
