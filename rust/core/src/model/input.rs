//! What is simulated, in the caller's numbering, and its assembly in the core's.

use super::checks::{positive, within};
use crate::error::Result;

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
