//! What is simulated, in the caller's numbering, and its assembly in the core's.

use crate::error::{Error, Result};
use crate::layout::Layout;
use crate::mesh::{Hinge, Mesh, check_finite, check_indices};
use crate::width::Width;

/// What the membrane is made of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Film {
    /// Young's modulus E \[Pa\].
    pub youngs_modulus: f64,
    /// Poisson's ratio nu, in (-1, 0.5).
    pub poisson_ratio: f64,
    /// Density rho \[kg/m3\].
    pub density: f64,
    /// Thickness h \[m\].
    pub thickness: f64,
}

/// What to do with edges whose spring constants sum to less than zero.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum NegativeSprings {
    /// Refuse the mesh, by name.
    #[default]
    Refuse,
    /// Set them to zero: stable, but softer than the film.
    Clip,
    /// Keep them, to see the mesh fail.
    Keep,
    /// The film is no net of springs: leave all spring constants at zero.
    Unused,
}

/// A tension-only spring between two nodes: a piece of tether.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cord {
    /// Its ends.
    pub nodes: [u32; 2],
    /// Spring constant \[N/m\].
    pub stiffness: f64,
    /// Length without tension \[m\].
    pub rest_length: f64,
    /// Strain at which a run stops.
    pub strain_limit: f64,
}

/// Everything that a run starts from, in the caller's numbering: the nodes of the mesh first, then all others.
#[derive(Debug, Clone, Default)]
pub struct Model {
    /// Positions at the start \[m\].
    pub positions: Vec<[f64; 3]>,
    /// Velocities at the start, relative to the turning frame \[m/s\].
    pub velocities: Vec<[f64; 3]>,
    /// Stress-free positions of the mesh's nodes \[m\].
    pub reference: Vec<[f64; 3]>,
    /// Triangles of the mesh.
    pub triangles: Vec<[u32; 3]>,
    /// The film; needed where there are triangles.
    pub film: Option<Film>,
    /// What to do with negative springs.
    pub negative_springs: NegativeSprings,
    /// Node pairs of the creases.
    pub creases: Vec<[u32; 2]>,
    /// For each crease +1 (valley) or -1 (mountain).
    pub fold_signs: Vec<f64>,
    /// Mass of each node beside the film's \[kg\].
    pub extra_masses: Vec<f64>,
    /// Nodes held where they are.
    pub fixed: Vec<u32>,
    /// Pieces of tether.
    pub cords: Vec<Cord>,
    /// Node pairs joined by links of zero length.
    pub bridges: Vec<[u32; 2]>,
    /// Stiffness of those links \[N/m\].
    pub bridge_stiffness: f64,
    /// Nodes that the spool's surface holds outside (besides the membrane, if asked).
    pub contact_nodes: Vec<u32>,
}

/// A model with its connectivity, masses and numbering worked out: what laws are built from.
#[derive(Debug, Clone)]
pub struct Assembly {
    /// The model as given.
    pub model: Model,
    /// The mesh's connectivity.
    pub mesh: Mesh,
    /// Spring constant of each edge of the mesh, after the rule for negative ones \[N/m\].
    pub edge_stiffness: Vec<f64>,
    /// The creases' hinges, in the caller's numbering.
    pub hinges: Vec<Hinge>,
    /// The numbering inside.
    pub layout: Layout,
    /// Mass of each node, in the core's numbering \[kg\].
    pub masses: Vec<f64>,
    /// 1/mass, or 0 where a node is held, in the core's numbering \[1/kg\].
    pub inverse_masses: Vec<f64>,
    /// The instructions that kernels run with.
    pub width: Width,
}

impl Assembly {
    /// Checks the model and works out what laws need.
    ///
    /// # Errors
    /// Any of `IndexOutOfRange`, `LengthMismatch`, `NotFinite`, `OutOfRange`, `DegenerateTriangle`,
    /// `SingularTriangle`, `NegativeSprings`, `NotAHinge`, `MasslessNode`.
    pub fn new(model: Model, width: Width) -> Result<Self> {
        let n = model.positions.len();
        same_length("velocities", model.velocities.len(), n, "node")?;
        same_length("extra_masses", model.extra_masses.len(), n, "node")?;
        same_length("fold_signs", model.fold_signs.len(), model.creases.len(), "crease")?;
        if model.reference.len() > n {
            return Err(Error::LengthMismatch {
                what: "positions",
                found: n,
                expected: model.reference.len(),
                per: "node of the mesh",
            });
        }
        check_finite("the position", &model.positions)?;
        check_finite("the velocity", &model.velocities)?;
        check_indices("fixed node", &wrap(&model.fixed), n)?;
        check_indices("contact node", &wrap(&model.contact_nodes), n)?;
        check_indices("bridge", &model.bridges, n)?;
        let ends: Vec<[u32; 2]> = model.cords.iter().map(|cord| cord.nodes).collect();
        check_indices("cord", &ends, n)?;
        for cord in &model.cords {
            positive("stiffness of a cord [N/m]", cord.stiffness)?;
            positive("rest length of a cord [m]", cord.rest_length)?;
            positive("strain limit of a cord", cord.strain_limit)?;
        }
        if !model.bridges.is_empty() {
            positive("stiffness of the bridges [N/m]", model.bridge_stiffness)?;
        }

        let mesh = Mesh::new(model.reference.clone(), model.triangles.clone())?;
        let mut masses = model.extra_masses.clone();
        let mut edge_stiffness = Vec::new();
        if let (Some(film), false) = (model.film, mesh.triangles.is_empty()) {
            film.check()?;
            for (mass, share) in masses.iter_mut().zip(mesh.lumped_masses(film.density * film.thickness)?) {
                *mass += share;
            }
            edge_stiffness = vec![0.0; mesh.edges.len()];
            if model.negative_springs != NegativeSprings::Unused {
                edge_stiffness = mesh.spring_constants(film.youngs_modulus, film.poisson_ratio, film.thickness)?;
                treat_negative(&mut edge_stiffness, &mesh.edges, model.negative_springs)?;
            }
        }
        let hinges = mesh.hinges(&model.creases)?;
        let links = [&mesh.edges[..], &ends, &model.bridges].concat();
        let layout = Layout::new(n, mesh.reference.len(), &mesh.edges, &links);

        let mut held = vec![false; n];
        for &node in &model.fixed {
            held[node as usize] = true;
        }
        for (node, (&mass, &held)) in masses.iter().zip(&held).enumerate() {
            if !(mass.is_finite() && (mass > 0.0 || (held && mass == 0.0))) {
                return Err(Error::MasslessNode { node, mass });
            }
        }
        let inverse: Vec<f64> =
            masses.iter().zip(&held).map(|(&mass, &held)| if held { 0.0 } else { 1.0 / mass }).collect();
        let (masses, inverse_masses) = (layout.gather(&masses), layout.gather(&inverse));
        Ok(Self { model, mesh, edge_stiffness, hinges, layout, masses, inverse_masses, width })
    }

    /// Mass of a square of film of side `length` \[kg\].
    pub fn square_of_film(&self, length: Option<f64>) -> Option<f64> {
        length.zip(self.model.film).map(|(length, film)| film.density * film.thickness * length * length)
    }
}

impl Film {
    fn check(&self) -> Result<()> {
        positive("Young's modulus [Pa]", self.youngs_modulus)?;
        positive("density [kg/m3]", self.density)?;
        positive("thickness [m]", self.thickness)?;
        within(
            "Poisson's ratio",
            self.poisson_ratio,
            self.poisson_ratio > -1.0 && self.poisson_ratio < 0.5,
            "it lies between -1 and 0.5",
        )
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

fn wrap(nodes: &[u32]) -> Vec<[u32; 1]> {
    nodes.iter().map(|&node| [node]).collect()
}

fn same_length(what: &'static str, found: usize, expected: usize, per: &'static str) -> Result<()> {
    if found == expected { Ok(()) } else { Err(Error::LengthMismatch { what, found, expected, per }) }
}

/// Refuses what is not finite and above zero.
///
/// # Errors
/// `OutOfRange`.
pub fn positive(what: &'static str, value: f64) -> Result<()> {
    within(what, value, value > 0.0, "it must be finite and above zero")
}

/// Refuses what is not finite or is below zero.
///
/// # Errors
/// `OutOfRange`.
pub fn non_negative(what: &'static str, value: f64) -> Result<()> {
    within(what, value, value >= 0.0, "it must be finite and not negative")
}

/// Refuses what is not finite.
///
/// # Errors
/// `OutOfRange`.
pub fn finite(what: &'static str, value: f64) -> Result<()> {
    within(what, value, true, "it must be finite")
}

/// Refuses what is not finite or not `inside` its range.
///
/// # Errors
/// `OutOfRange`.
pub fn within(what: &'static str, value: f64, inside: bool, range: &'static str) -> Result<()> {
    if value.is_finite() && inside { Ok(()) } else { Err(Error::OutOfRange { what, value, range }) }
}
