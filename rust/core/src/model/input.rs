//! What is simulated, in the caller's numbering, by components that check themselves.

use super::checks::{positive, within};
use super::mesh::{check_finite, check_indices};
use crate::error::{Error, Result};

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

/// Lines along which the film is folded.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Creases {
    /// The two nodes of each.
    pub nodes: Vec<[u32; 2]>,
    /// For each +1 (valley) or -1 (mountain).
    pub fold_signs: Vec<f64>,
}

/// Links of zero length that hold pairs of nodes together, all of one stiffness.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Bridges {
    /// The two nodes of each.
    pub nodes: Vec<[u32; 2]>,
    /// Of each link \[N/m\].
    pub stiffness: f64,
}

/// What the spool's surface keeps outside, beside the membrane, if that is asked for.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ContactSet {
    /// The nodes.
    pub nodes: Vec<u32>,
}

/// Everything that a run starts from, in the caller's numbering: the nodes of the mesh first, then all others.
#[derive(Debug, Clone, Default)]
pub struct Model {
    /// Positions at the start \[m\].
    pub positions: Vec<[f64; 3]>,
    /// Velocities at the start, relative to the turning frame \[m/s\].
    pub velocities: Vec<[f64; 3]>,
    /// Mass of each node beside the film's \[kg\].
    pub extra_masses: Vec<f64>,
    /// Nodes held where they are.
    pub fixed: Vec<u32>,
    /// Stress-free positions of the mesh's nodes \[m\].
    pub reference: Vec<[f64; 3]>,
    /// Triangles of the mesh.
    pub triangles: Vec<[u32; 3]>,
    /// The film; needed where there are triangles.
    pub film: Option<Film>,
    /// What to do with negative springs.
    pub negative_springs: NegativeSprings,
    /// Its creases.
    pub creases: Creases,
    /// Pieces of tether.
    pub cords: Vec<Cord>,
    /// Node pairs held together.
    pub bridges: Bridges,
    /// What touches the spool.
    pub contacts: ContactSet,
}

impl Model {
    /// Checks the nodes and each component.
    ///
    /// # Errors
    /// `LengthMismatch`, `NotFinite`, `IndexOutOfRange`, `OutOfRange`.
    pub fn check(&self) -> Result<()> {
        let n = self.positions.len();
        same_length("velocities", self.velocities.len(), n, "node")?;
        same_length("extra_masses", self.extra_masses.len(), n, "node")?;
        if self.reference.len() > n {
            let (found, expected) = (n, self.reference.len());
            return Err(Error::LengthMismatch { what: "positions", found, expected, per: "node of the mesh" });
        }
        check_finite("the position", &self.positions)?;
        check_finite("the velocity", &self.velocities)?;
        check_indices("fixed node", &each_alone(&self.fixed), n)?;
        self.creases.check()?;
        self.contacts.check(n)?;
        self.bridges.check(n)?;
        check_indices("cord", &self.cord_nodes(), n)?;
        self.cords.iter().try_for_each(Cord::check)
    }

    /// The two nodes of each piece of tether.
    pub fn cord_nodes(&self) -> Vec<[u32; 2]> {
        self.cords.iter().map(|cord| cord.nodes).collect()
    }
}

impl Creases {
    /// Whether each has its sign; their nodes are checked against the mesh.
    fn check(&self) -> Result<()> {
        same_length("fold_signs", self.fold_signs.len(), self.nodes.len(), "crease")
    }
}

impl Cord {
    fn check(&self) -> Result<()> {
        positive("stiffness of a cord [N/m]", self.stiffness)?;
        positive("rest length of a cord [m]", self.rest_length)?;
        positive("strain limit of a cord", self.strain_limit)
    }
}

impl Bridges {
    fn check(&self, node_count: usize) -> Result<()> {
        check_indices("bridge", &self.nodes, node_count)?;
        if self.nodes.is_empty() { Ok(()) } else { positive("stiffness of the bridges [N/m]", self.stiffness) }
    }
}

impl ContactSet {
    fn check(&self, node_count: usize) -> Result<()> {
        check_indices("contact node", &each_alone(&self.nodes), node_count)
    }
}

/// Nodes as elements of one node each.
fn each_alone(nodes: &[u32]) -> Vec<[u32; 1]> {
    nodes.iter().map(|&node| [node]).collect()
}

fn same_length(what: &'static str, found: usize, expected: usize, per: &'static str) -> Result<()> {
    if found == expected { Ok(()) } else { Err(Error::LengthMismatch { what, found, expected, per }) }
}

impl Film {
    /// Checks each value.
    ///
    /// # Errors
    /// `OutOfRange`.
    pub fn check(&self) -> Result<()> {
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
