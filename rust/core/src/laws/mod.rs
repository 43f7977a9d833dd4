//! The laws of force, one per file, and the one list of them.

mod air_drag;
mod bridges;
mod buckling;
mod creases;
mod gravity;
mod mass_damping;
mod rotating_frame;
mod spool_contact;
pub(crate) mod spring_damping;
pub(crate) mod springs;
mod triangle_damping;
mod triangles;

use std::ops::Range;

use crate::arrays::blocks::{rows_of, tiles};
use crate::arrays::jacobian::JacobianBlocks;
use crate::arrays::state::{Instant, NodeVectors, rows_mut};
use crate::assembly::Assembly;
use crate::error::Result;
use spring_damping::SpringDamping;
use springs::Springs;

pub use air_drag::{AirDragParameters, AirMotion};
pub use creases::CreaseParameters;
pub use rotating_frame::Spin;
pub use spool_contact::SpoolContactParameters;
pub use spring_damping::DampingParameters;
pub use springs::SpringParameters;
pub use triangles::TriangleParameters;

/// A law: what it does to nodes that are where they are and move as they move.
///
/// All arrays are in the core's numbering.
pub trait Law: Send + Sync {
    /// The name that scenes, errors and energies use.
    fn name(&self) -> &'static str;

    /// Adds the forces \[N\], and returns the rate at which the law changes the mechanical energy \[W\]: the power
    /// of forces without a potential, plus the partial time derivative of a potential that depends on time.
    fn add_forces(&self, at: Instant<'_>, forces: &mut NodeVectors) -> f64 {
        tiles(at.positions.nrows()).map(|tile| self.add_to_tile(tile, at, forces)).sum()
    }

    /// The part of `add_forces` that belongs to one tile: all elements whose lowest node is there. Tiles come in order. After
    /// a tile and those before it, nothing more acts on its nodes, and nothing more is read of them.
    fn add_to_tile(&self, tile: usize, at: Instant<'_>, forces: &mut NodeVectors) -> f64;

    /// Asks a law without a potential to caches_forces of each evaluation what `power_at` needs. Whether it does.
    fn caches_forces(&mut self) -> bool {
        false
    }

    /// The power \[W\] of the forces of the last evaluation on the velocities of `at`, whose positions are those of that
    /// evaluation; of a law that remembers.
    fn power_at(&self, _at: Instant<'_>) -> f64 {
        0.0
    }

    /// The law as one that acts on each node by itself.
    fn nodal(&self) -> Option<&dyn NodalLaw> {
        None
    }

    /// The rate w \[1/s\] where the law's forces hold m w (v_y, -v_x, 0), which does no work; methods may treat it apart.
    fn coriolis_rate(&self, _time: f64) -> f64 {
        0.0
    }

    /// Whether the law's forces derive from a potential (which may depend on time).
    fn is_conservative(&self) -> bool;

    /// The potential energy \[J\]; 0 for a law that has none.
    fn energy(&self, _at: Instant<'_>) -> f64 {
        0.0
    }

    /// Adds K p, with K the stiffest linearisation that the law can show at these positions \[N\].
    fn add_stiffness_product(&self, _at: Instant<'_>, _p: &NodeVectors, _out: &mut NodeVectors) {}

    /// Adds C p, with C the damping matrix \[N\] for velocities p \[m/s\].
    fn add_damping_product(&self, _at: Instant<'_>, _p: &NodeVectors, _out: &mut NodeVectors) {}

    /// Visits the nodes of each element through which its nodes can act on each other.
    fn visit_couplings(&self, _visit: &mut dyn FnMut(&[u32])) {}

    /// Adds the jacobian of the forces by positions and velocities, exactly, as the law is at this instant.
    fn add_jacobian(&self, _at: Instant<'_>, _slopes: &mut dyn JacobianBlocks) {}

    /// The first element that is beyond the bound its user set.
    fn first_excess(&self, _at: Instant<'_>) -> Option<Excess> {
        None
    }

    /// What there is to read off each element, in the caller's order.
    fn readings(&self, _at: Instant<'_>) -> Readings {
        Readings::None
    }

    /// The law as springs, and as dashpots: the two go through one pass where a scene has both.
    #[doc(hidden)]
    fn springs(&self) -> Option<&Springs> {
        None
    }

    /// See `springs`.
    #[doc(hidden)]
    fn dashpots(&self) -> Option<&SpringDamping> {
        None
    }

    /// The law's elements, and the lanes that they take up, fillers included; `None` for a law without its own elements.
    fn lanes(&self) -> Option<[usize; 2]> {
        None
    }

    /// Share of the law's elements that kernels reach in straight runs; `None` for a law without elements.
    fn contiguous_share(&self) -> Option<f64> {
        None
    }

    /// What a user can do when this law lets a run fail.
    fn remedy(&self) -> &'static str;
}

/// A law whose force on a node depends on that node alone, or on a sum over its neighbours that is worked out before: so
/// that it can be added stretch by stretch, in the pass of a method that has the nodes in the cache.
pub trait NodalLaw {
    /// Works out what depends on neighbours; once for each tile, in order, before `add_to_rows` goes over its nodes. One
    /// evaluation at a time: what is worked out is kept in the law.
    fn prepare(&self, _tile: usize, _at: Instant<'_>) {}

    /// Adds the forces \[N\] on `rows` to three columns of as many, and returns the power as `add_forces` does.
    fn add_to_rows(&self, rows: Range<usize>, at: Instant<'_>, forces: [&mut [f64]; 3]) -> f64;

    /// Adds the forces on the nodes of a tile.
    fn add_to_nodes(&self, tile: usize, at: Instant<'_>, forces: &mut NodeVectors) -> f64 {
        self.prepare(tile, at);
        let rows = rows_of(tile, forces.nrows());
        self.add_to_rows(rows.clone(), at, rows_mut(forces, rows))
    }
}

/// An element beyond its bound: nodes in the core's numbering, and what happened.
#[derive(Debug, Clone, PartialEq)]
pub struct Excess {
    /// The ends of the element.
    pub nodes: [u32; 2],
    /// In words and numbers.
    pub what: String,
}

/// One number (or two) per element, in the caller's order.
#[derive(Debug, Clone, PartialEq)]
pub enum Readings {
    /// Nothing to read.
    None,
    /// Springs: engineering strain, and whether the spring is buckled (shorter than its critical length).
    Springs {
        /// Engineering strain.
        strain: Vec<f64>,
        /// Shorter than the critical length.
        buckled: Vec<bool>,
    },
    /// Triangles of film: principal strains, and what the film does.
    Triangles {
        /// Principal Green strains, larger first.
        strain: Vec<[f64; 2]>,
        /// 0 taut, 1 wrinkled, 2 slack.
        state: Vec<u8>,
    },
    /// Creases: the crease angle, pi flat, 0 shut \[rad\].
    Creases {
        /// Crease angle \[rad\].
        angle: Vec<f64>,
    },
}

/// A law with its parameters, before it meets a mesh. This is the one list of laws that a scene chooses from.
#[derive(Debug, Clone, PartialEq)]
pub enum LawSpec {
    /// In-plane elasticity with buckling, eqs. (1) and (2).
    Springs(SpringParameters),
    /// In-plane elasticity by triangles that wrinkle, in place of springs.
    Triangles(TriangleParameters),
    /// Dashpots along all springs, or the same in triangles where there are those.
    SpringDamping(DampingParameters),
    /// Crease stiffness and contact of the facets, eqs. (3) and (4).
    Creases(CreaseParameters),
    /// Drag of the residual air, eq. (5).
    AirDrag(AirDragParameters),
    /// The frame that turns with the hub.
    Spin(Spin),
    /// Weight, as an acceleration fixed in inertial space \[m/s2\].
    Gravity([f64; 3]),
    /// Nodes kept outside the spool.
    SpoolContact(SpoolContactParameters),
    /// Damping of all motion relative to the turning frame; the rate \[1/s\].
    MassDamping(f64),
}

/// How the hub of a scene turns: at rest without that law.
pub fn spin_of(specs: &[LawSpec]) -> Spin {
    let mut spins = specs.iter().filter_map(|spec| if let LawSpec::Spin(spin) = spec { Some(*spin) } else { None });
    spins.next_back().unwrap_or_default()
}

/// Builds the laws of a scene; tethers and bridges follow from the model's own parts.
///
/// # Errors
/// `OutOfRange` for a parameter, `LawTwice`, `DampingOnNegativeSpring`, `DegenerateTriangle`.
pub fn build(specs: &[LawSpec], assembly: &Assembly) -> Result<Vec<Box<dyn Law>>> {
    let spin = spin_of(specs);
    let has_triangles = specs.iter().any(|spec| matches!(spec, LawSpec::Triangles(_)));
    let networks = crate::elements::link::SpringNetworks::default();
    let mut laws: Vec<Box<dyn Law>> = Vec::new();
    for spec in specs {
        let law: Box<dyn Law> = match *spec {
            LawSpec::Springs(parameters) => Box::new(springs::Springs::membrane(parameters, assembly, &networks)?),
            LawSpec::Triangles(parameters) => Box::new(triangles::Triangles::new(parameters, assembly)?),
            LawSpec::SpringDamping(parameters) => {
                Box::new(spring_damping::SpringDamping::new(parameters, has_triangles, assembly, &networks)?)
            }
            LawSpec::Creases(parameters) => Box::new(creases::Creases::new(parameters, assembly)?),
            LawSpec::AirDrag(parameters) => Box::new(air_drag::AirDrag::new(parameters, spin, assembly)?),
            LawSpec::Spin(spin) => Box::new(rotating_frame::RotatingFrame::new(spin, assembly)?),
            LawSpec::Gravity(acceleration) => Box::new(gravity::Gravity::new(acceleration, spin, assembly)?),
            LawSpec::SpoolContact(parameters) => Box::new(spool_contact::SpoolContact::new(parameters, assembly)?),
            LawSpec::MassDamping(rate) => Box::new(mass_damping::MassDamping::new(rate, assembly)?),
        };
        if laws.iter().any(|other| other.name() == law.name()) {
            return Err(crate::error::Error::LawTwice { law: law.name() });
        }
        laws.push(law);
    }
    if !assembly.model.cords.is_empty() {
        laws.push(Box::new(springs::Springs::tethers(assembly, &networks)));
    }
    if !assembly.model.bridges.is_empty() {
        laws.push(Box::new(bridges::Bridges::new(assembly)));
    }
    Ok(laws)
}
