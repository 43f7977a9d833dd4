//! The assembled model: connectivity, masses, spring constants and internal order, from which laws are built.

use crate::error::{Error, Result};
use crate::layout::Renumbering;
use crate::model::input::{Model, NegativeSprings};
use crate::model::mesh::{Hinge, Mesh};
use crate::model::regions::FilmOfTriangles;
use crate::simd::dispatch::InstructionSet;

/// A model with connectivity, masses, spring constants and renumbering.
#[derive(Debug, Clone)]
pub struct Assembly {
    /// The input.
    pub model: Model,
    /// The connectivity of the mesh.
    pub mesh: Mesh,
    /// The film of each triangle; `None` without triangles or without a film.
    pub film: Option<FilmOfTriangles>,
    /// Spring constant of each edge of the mesh, after the treatment of negative ones \[N/m\].
    pub edge_stiffness: Vec<f64>,
    /// The parts of the triangles in these, before that treatment, side k opposite corner k; none without springs
    /// \[N/m\].
    pub side_stiffness: Vec<[f64; 3]>,
    /// The hinges of the creases, in external order.
    pub hinges: Vec<Hinge>,
    /// The renumbering.
    pub numbering: Renumbering,
    /// Mass of each node, in internal order \[kg\].
    pub masses: Vec<f64>,
    /// 1/mass, or 0 for a held node, in internal order \[1/kg\].
    pub inverse_masses: Vec<f64>,
    /// The instruction set of the kernels.
    pub instructions: InstructionSet,
}

impl Assembly {
    /// Checks and assembles a model.
    ///
    /// # Errors
    /// Any of `IndexOutOfRange`, `LengthMismatch`, `NotFinite`, `OutOfRange`, `DegenerateTriangle`,
    /// `SingularTriangle`, `NegativeSprings`, `NotAHinge`, `NoFilm`, `MasslessNode`, `RegionsOverlap`, `TiltedFilm`.
    pub fn new(model: Model, instructions: InstructionSet) -> Result<Self> {
        model.check()?;
        let n = model.positions.len();
        let mesh = Mesh::new(model.reference.clone(), model.triangles.clone())?;
        let mut masses = model.extra_masses.clone();
        let (mut edge_stiffness, mut side_stiffness) = (Vec::new(), Vec::new());
        let film = model.film.filter(|_| !mesh.triangles.is_empty());
        if film.is_none() && !mesh.triangles.is_empty() {
            return Err(Error::NoFilm { triangles: mesh.triangles.len() });
        }
        let film = film.map(|film| FilmOfTriangles::new(film, model.orthotropy, &model.regions, mesh.triangles.len()));
        let film = film.transpose()?;
        if let Some(film) = &film {
            for (mass, share) in masses.iter_mut().zip(mesh.lumped_masses(|row| film.of(row).areal_density())?) {
                *mass += share;
            }
            film.check_directions(&mesh)?;
            edge_stiffness = vec![0.0; mesh.edges.len()];
            if model.negative_springs != NegativeSprings::Unused {
                side_stiffness = mesh.all_side_constants(|row| film.of(row).film)?;
                edge_stiffness = mesh.sums_on_edges(&side_stiffness);
                treat_negative(&mut edge_stiffness, &mesh.edges, model.negative_springs)?;
            }
        }
        let hinges = mesh.hinges(&model.creases.nodes)?;
        let links = [&mesh.edges[..], &model.cord_nodes(), &model.bridges.nodes].concat();
        let numbering = Renumbering::new(n, mesh.reference.len(), &mesh.edges, &links);

        let mut held = vec![false; n];
        model.held().for_each(|node| held[node] = true);
        for (node, (&mass, &held)) in masses.iter().zip(&held).enumerate() {
            if !(mass.is_finite() && (mass > 0.0 || (held && mass == 0.0))) {
                let part = if node < mesh.reference.len() { "of the mesh" } else { "of the cords" };
                return Err(Error::MasslessNode { node, part, place: model.positions[node], mass });
            }
        }
        let inverse: Vec<f64> =
            masses.iter().zip(&held).map(|(&mass, &held)| if held { 0.0 } else { 1.0 / mass }).collect();
        let (masses, inverse_masses) = (numbering.internal_values(&masses), numbering.internal_values(&inverse));
        Ok(Self {
            model,
            mesh,
            film,
            edge_stiffness,
            side_stiffness,
            hinges,
            numbering,
            masses,
            inverse_masses,
            instructions,
        })
    }

    /// Mass of a square with side `length` of the film outside of all regions \[kg\].
    pub fn square_of_film(&self, length: Option<f64>) -> Option<f64> {
        length.zip(self.model.film).map(|(length, film)| film.density * film.thickness * length * length)
    }
}

fn treat_negative(stiffness: &mut [f64], edges: &[[u32; 2]], rule: NegativeSprings) -> Result<()> {
    let count = stiffness.iter().filter(|&&k| k < 0.0).count();
    match rule {
        NegativeSprings::Keep | NegativeSprings::Unused => Ok(()),
        NegativeSprings::Clip => {
            stiffness.iter_mut().for_each(|k| *k = k.max(0.0));
            Ok(())
        }
        NegativeSprings::Refuse if count == 0 => Ok(()),
        NegativeSprings::Refuse => {
            let worst = (0..edges.len()).min_by(|&a, &b| stiffness[a].total_cmp(&stiffness[b])).unwrap_or(0);
            let edge = edges[worst].map(|node| node as usize);
            Err(Error::NegativeSprings { count, spring_count: edges.len(), worst: stiffness[worst], edge })
        }
    }
}
