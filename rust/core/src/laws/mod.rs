//! The laws of force, one per file, and the one list of them.
//!
//! Every law is a `Law`; what only some have stands in traits of its own: `NodalLaw` (forces node by node), `LinkForce` (forces
//! along links, which may share a pass), `Linearisation`, `Inspection`.

mod air_drag;
mod bridges;
mod buckling;
mod creases;
mod gravity;
mod inspection;
mod instant;
mod linearisation;
mod list;
mod mass_damping;
mod nodal;
mod pressure;
mod rotating_frame;
mod spool_contact;
pub(crate) mod spring_damping;
pub(crate) mod springs;
mod triangle_damping;
mod triangles;

use std::sync::Arc;

use crate::arrays::history::History;
use crate::arrays::state::NodeVectors;
use crate::elements::link::Links;
use crate::simd::lanes::F64x8;

pub use air_drag::AirMotion;
pub use inspection::{Excess, Inspection, Readings};
pub use instant::Instant;
pub use linearisation::Linearisation;
pub use list::*;
pub use nodal::NodalLaw;

/// What a law's work means for the energy balance.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WorkClass {
    /// The forces have a potential, which may depend on time; so may forces that do no work, such as Coriolis's.
    Conservative,
    /// The power of the forces is never positive.
    Dissipative,
    /// A load without potential, whose work has either sign.
    External,
}

/// What is known of a law, wherever nodes are and however they move.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Properties {
    /// The name that scenes, errors and energies use.
    pub name: &'static str,
    /// What its work means for the energy balance.
    pub work_class: WorkClass,
    /// Whether its forces depend on velocities.
    pub depends_on_velocity: bool,
    /// Whether nodes act on each other, so that neither a force nor a torque on the whole is left.
    pub is_internal: bool,
}

/// By which kernels the forces of a law are evaluated: what the evaluation plan is made of.
#[derive(Default)]
pub struct Kernels {
    /// Whether `Law::add_to_tile` adds forces on elements of the law's own.
    pub elements: bool,
    /// Forces along links, which the plan evaluates, with those of another law on the same links in one pass.
    pub links: Vec<LinkForce>,
}

impl Kernels {
    /// Those of a law with elements of its own.
    pub fn of_elements() -> Self {
        Self { elements: true, links: Vec::new() }
    }
}

/// The force of a law along a set of links; one entry of its parameters per batch.
#[derive(Clone)]
pub struct LinkForce {
    /// The links. Laws on the same links hold the same ones.
    pub links: Arc<Links>,
    /// How the force follows from length and rate of change of length.
    pub(crate) response: LinkResponse,
}

/// See `LinkForce`.
#[derive(Clone)]
pub(crate) enum LinkResponse {
    /// A tension that goes with the length, see `springs`.
    Elastic(Arc<Vec<springs::Parameters>>),
    /// A resistance to lengthening, see `spring_damping`: c \[N s/m\].
    Viscous(Arc<Vec<F64x8>>),
}

/// A law: what it does to nodes that are where they are and move as they move.
///
/// All arrays are in the core's numbering. A law may keep state: it is evaluated by `&mut self`, and what it keeps between
/// evaluations is its `history`, saved and restored with the run.
pub trait Law: Send + Sync {
    /// What is known of it, wherever nodes are.
    fn properties(&self) -> Properties;

    /// The name that scenes, errors and energies use.
    fn name(&self) -> &'static str {
        self.properties().name
    }

    /// By which kernels its forces are evaluated; a law that has `nodal` needs no others.
    fn kernels(&self) -> Kernels;

    /// Adds the forces \[N\] of all elements whose lowest node is in a tile, and returns the rate at which the law changes the
    /// mechanical energy \[W\]: the power of forces without a potential, plus the partial time derivative of a potential that
    /// depends on time. Tiles come in order. After a tile and those before it, nothing more acts on its nodes, and nothing
    /// more is read of them.
    fn add_to_tile(&mut self, _tile: usize, _at: Instant<'_>, _forces: &mut NodeVectors) -> f64 {
        0.0
    }

    /// The law as one that acts on each node by itself.
    fn nodal(&mut self) -> Option<&mut dyn NodalLaw> {
        None
    }

    /// The potential energy \[J\]; 0 for a law that has none.
    fn energy(&self, _at: Instant<'_>) -> f64 {
        0.0
    }

    /// The law linearised; `None` for forces that depend on neither positions nor velocities.
    fn linearisation(&self) -> Option<&dyn Linearisation> {
        None
    }

    /// The law as one whose elements can be read.
    fn inspection(&self) -> Option<&dyn Inspection> {
        None
    }

    /// What it keeps from evaluation to evaluation.
    fn history(&self) -> History {
        History::default()
    }

    /// Goes on from a history; an empty one is that of the start. Whether it fits.
    fn restore_history(&mut self, history: History) -> bool {
        history == History::default()
    }

    /// What a user can do when this law lets a run fail.
    fn remedy(&self) -> &'static str;
}
