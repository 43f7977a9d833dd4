//! The input of a simulation in external order, as components with their checks.

use std::f64::consts::PI;

use super::checks::{finite, non_negative, positive, within};
use super::mesh::{check_finite, check_indices};
use super::orthotropy::Orthotropy;
use super::regions::Region;
use super::schedule::Schedule;
use crate::error::{Error, Result};

pub use super::film::Film;

/// Treatment of edges with a negative sum of spring constants.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum NegativeSprings {
    /// Refuse the mesh, with the worst edge.
    #[default]
    Refuse,
    /// Set them to zero: stable, but softer than the film.
    Clip,
    /// Keep them, for tests of unstable meshes.
    Keep,
    /// The film has no springs: all spring constants are zero.
    Unused,
}

/// A spring between two nodes that buckles: a segment of a cord.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Cord {
    /// Its ends.
    pub nodes: [u32; 2],
    /// Spring constant \[N/m\].
    pub stiffness: f64,
    /// Rest length \[m\].
    pub rest_length: f64,
    /// Strain at which a run stops.
    pub strain_limit: f64,
    /// Compressive strain at which it buckles, from 0 (tension alone) to 1 (never).
    pub critical_strain: f64,
    /// The winch of its cord, by its number in `Model::winches`; `None`: its length stays as it is.
    pub winch: Option<usize>,
}

impl Cord {
    /// The constant of the spring that it is \[N/m\]; 0 where a winch hauls it in, whose law has its force.
    pub fn spring_constant(&self) -> f64 {
        if self.winch.is_some() { 0.0 } else { self.stiffness }
    }
}

/// Edges along which the film is folded.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Creases {
    /// The two nodes of each.
    pub nodes: Vec<[u32; 2]>,
    /// For each +1 (valley) or -1 (mountain).
    pub fold_signs: Vec<f64>,
    /// By how much each is folded in the pattern, 0 flat, pi shut \[rad\]; empty: by pi.
    pub fold_angles: Vec<f64>,
    /// For each what it has of its own in place of the law's; empty: nothing.
    pub own: Vec<OwnCrease>,
}

/// What one crease has in place of the parameters of the law.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct OwnCrease {
    /// beta.
    pub stiffness: Option<f64>,
    /// gamma.
    pub contact_penalty: Option<f64>,
    /// theta0 \[rad\].
    pub natural_angle: Option<f64>,
}

/// Links of zero length that hold pairs of nodes together, all of one stiffness.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Bridges {
    /// The two nodes of each.
    pub nodes: Vec<[u32; 2]>,
    /// Of each link \[N/m\].
    pub stiffness: f64,
}

/// Nodes in contact with the spool, beside those of the membrane.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ContactSet {
    /// The nodes.
    pub nodes: Vec<u32>,
}

/// A motion in the turning frame that nodes follow, see `laws::moved`.
#[derive(Debug, Clone, PartialEq)]
pub struct Motion {
    /// The nodes; none follows two motions.
    pub nodes: Vec<u32>,
    /// Displacement along x, y and z \[m\].
    pub displacement: [Option<Schedule>; 3],
    /// Turn about the axis of the hub \[rad\].
    pub turn: Option<Schedule>,
}

/// The model at the start of a run, in external order: the nodes of the mesh first, then all others.
#[derive(Debug, Clone, Default)]
pub struct Model {
    /// Positions at the start \[m\].
    pub positions: Vec<[f64; 3]>,
    /// Velocities at the start, relative to the turning frame \[m/s\].
    pub velocities: Vec<[f64; 3]>,
    /// Mass of each node beside that of the film \[kg\].
    pub extra_masses: Vec<f64>,
    /// Held nodes.
    pub fixed: Vec<u32>,
    /// Nodes on which point forces act.
    pub loaded: Vec<u32>,
    /// Motions of nodes that move as prescribed, which are held otherwise.
    pub motions: Vec<Motion>,
    /// Stress-free positions of the mesh's nodes \[m\].
    pub reference: Vec<[f64; 3]>,
    /// Triangles of the mesh.
    pub triangles: Vec<[u32; 3]>,
    /// The film; required with triangles.
    pub film: Option<Film>,
    /// Of a film of two moduli; E is then that along its direction.
    pub orthotropy: Option<Orthotropy>,
    /// Regions whose film has properties of its own.
    pub regions: Vec<Region>,
    /// Treatment of negative spring constants.
    pub negative_springs: NegativeSprings,
    /// Its creases.
    pub creases: Creases,
    /// Segments of tethers.
    pub cords: Vec<Cord>,
    /// Schedules of winches: factors of the lengths of cords.
    pub winches: Vec<Schedule>,
    /// Node pairs held together.
    pub bridges: Bridges,
    /// Nodes in contact with the spool.
    pub contacts: ContactSet,
    /// Triangles in contact with each other and with tethers.
    pub layers: Vec<u32>,
}

impl Model {
    /// Checks the nodes and each component.
    ///
    /// # Errors
    /// `LengthMismatch`, `NotFinite`, `IndexOutOfRange`, `TriangleOutOfRange`, `OutOfRange`.
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
        check_indices("loaded node", &each_alone(&self.loaded), n)?;
        self.check_motions()?;
        self.creases.check()?;
        self.contacts.check(n)?;
        self.check_layers()?;
        self.bridges.check(n)?;
        check_indices("cord", &self.cord_nodes(), n)?;
        self.cords.iter().try_for_each(Cord::check)?;
        self.check_winches()
    }

    /// Refuses winches that are not there, and lengths that are not above zero.
    fn check_winches(&self) -> Result<()> {
        for winch in self.cords.iter().filter_map(|cord| cord.winch) {
            let is_there = winch < self.winches.len();
            within("number of the winch of a cord", winch as f64, is_there, "it must be that of a schedule")?;
        }
        let mut factors = self.winches.iter().flat_map(Schedule::values);
        factors.try_for_each(|&factor| positive("factor of the length of a cord", factor))
    }

    /// Refuses layers of triangles that are not there.
    fn check_layers(&self) -> Result<()> {
        let triangle_count = self.triangles.len();
        for (row, triangle) in self.layers.iter().map(|&triangle| triangle as usize).enumerate() {
            if triangle >= triangle_count {
                return Err(Error::TriangleOutOfRange { what: "layer", row, triangle, triangle_count });
            }
        }
        Ok(())
    }

    /// Refuses moved nodes that are not there, or that follow two motions.
    fn check_motions(&self) -> Result<()> {
        let mut is_moved = vec![false; self.positions.len()];
        for motion in &self.motions {
            check_indices("moved node", &each_alone(&motion.nodes), self.positions.len())?;
            for &node in &motion.nodes {
                if std::mem::replace(&mut is_moved[node as usize], true) {
                    return Err(Error::MovedTwice { node: node as usize });
                }
            }
        }
        Ok(())
    }

    /// Held nodes, those that move as prescribed among them.
    pub fn held(&self) -> impl Iterator<Item = usize> {
        let moved = self.motions.iter().flat_map(|motion| &motion.nodes);
        self.fixed.iter().chain(moved).map(|&node| node as usize)
    }

    /// The two nodes of each segment of a tether.
    pub fn cord_nodes(&self) -> Vec<[u32; 2]> {
        self.cords.iter().map(|cord| cord.nodes).collect()
    }
}

impl Creases {
    /// Checks that each has a sign; `Mesh::hinges` checks the nodes.
    fn check(&self) -> Result<()> {
        same_length("fold_signs", self.fold_signs.len(), self.nodes.len(), "crease")?;
        for (what, count) in [("fold_angles", self.fold_angles.len()), ("own creases", self.own.len())] {
            if count > 0 {
                same_length(what, count, self.nodes.len(), "crease")?;
            }
        }
        self.fold_angles.iter().try_for_each(|&angle| finite("fold angle of a crease [rad]", angle))?;
        self.own.iter().try_for_each(OwnCrease::check)
    }

    /// By how much a crease is folded in the pattern \[rad\].
    pub fn fold_angle(&self, row: usize) -> f64 {
        self.fold_angles.get(row).copied().unwrap_or(PI)
    }

    /// What a crease has of its own.
    pub fn own(&self, row: usize) -> OwnCrease {
        self.own.get(row).copied().unwrap_or_default()
    }
}

impl OwnCrease {
    fn check(&self) -> Result<()> {
        self.stiffness.map_or(Ok(()), |beta| non_negative("stiffness of a crease", beta))?;
        self.contact_penalty.map_or(Ok(()), |gamma| non_negative("contact penalty of a crease", gamma))?;
        self.natural_angle.map_or(Ok(()), |angle| finite("natural angle of a crease [rad]", angle))
    }
}

impl Cord {
    fn check(&self) -> Result<()> {
        positive("stiffness of a cord [N/m]", self.stiffness)?;
        positive("rest length of a cord [m]", self.rest_length)?;
        positive("strain limit of a cord", self.strain_limit)?;
        let is_share = (0.0..=1.0).contains(&self.critical_strain);
        within("critical strain of a cord", self.critical_strain, is_share, "it lies between 0 and 1")
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
