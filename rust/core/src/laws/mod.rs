//! The laws, one per file, and their list.
//!
//! Every law implements `Law`. Optional features are separate: `NodalLaw` (forces node by node), `LinkForce` (forces
//! along links, which may share a pass), `Impulses`, `Linearisation`, `Inspection`, `HistoryDependent`.

mod air_drag;
mod bending;
mod body;
mod body_friction;
mod bridges;
mod buckling;
mod cord_drag;
mod creases;
mod facet_load;
mod gravity;
mod history_dependent;
mod impulses;
mod inspection;
mod instant;
mod linearisation;
mod list;
mod mass_damping;
mod moved;
mod nodal;
mod point_forces;
mod pressure;
mod rectangles;
mod rotating_frame;
mod segments;
mod self_contact;
mod solar_pressure;
mod spool_contact;
pub(crate) mod spring_damping;
pub(crate) mod springs;
mod triangle_damping;
mod triangles;
mod winches;

use std::sync::Arc;

use crate::arrays::state::NodeVectors;
use crate::elements::link::Links;
use crate::error::Result;
use crate::layout::Coded;
use crate::model::load::Load;

pub use air_drag::AirMotion;
pub use bending::BendingForm;
pub use body::{BodyShape, FeltBy};
pub use history_dependent::HistoryDependent;
pub use impulses::Impulses;
pub use inspection::{Excess, FilmStates, Inspection, LinkReadings};
pub use instant::Instant;
pub use linearisation::Linearisation;
pub use list::*;
pub use moved::Moved;
pub(crate) use moved::Prescribed;
pub use nodal::NodalLaw;
pub use point_forces::ForceFrame;
pub use self_contact::{ContactStatistics, Scheme, SelfContact};
pub use spring_damping::{DashpotMass, Limited};

/// The role of the work of a law in the energy balance.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WorkClass {
    /// The forces have a potential, which may depend on time, or do no work, as the force of Coriolis.
    Conservative,
    /// The power of the forces is never positive.
    Dissipative,
    /// A load without potential, whose work has either sign.
    External,
}

/// Properties of a law, independent of the motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Properties {
    /// Name in scenes, errors and energies.
    pub name: &'static str,
    /// The role of its work in the energy balance.
    pub work_class: WorkClass,
    /// Whether its forces depend on velocities.
    pub depends_on_velocity: bool,
    /// Whether the forces act between nodes, so that their sum and their total torque vanish.
    pub is_internal: bool,
}

/// The kernels of a law, from which the evaluation plan is composed.
#[derive(Default)]
pub struct Kernels {
    /// Whether `Law::add_to_tile` adds forces of elements of its own.
    pub elements: bool,
    /// Forces along links, evaluated by the plan, in one pass with those of another law on the same links.
    pub links: Vec<LinkForce>,
}

impl Kernels {
    /// The kernels of a law with elements of its own.
    pub fn of_elements() -> Self {
        Self { elements: true, links: Vec::new() }
    }
}

/// The force of a law along a set of links, with one entry of parameters per batch.
#[derive(Clone)]
pub struct LinkForce {
    /// The links; laws on the same links share them.
    pub links: Arc<Links>,
    /// The force as a function of the length and its rate.
    pub(crate) response: LinkResponse,
}

/// See `LinkForce`.
#[derive(Clone)]
pub(crate) enum LinkResponse {
    /// A tension as a function of the length, see `springs`.
    Elastic(Arc<Coded<springs::Parameters>>),
    /// A resistance to the rate of the length, see `spring_damping`.
    Viscous(Arc<spring_damping::Dashpots>),
}

/// A law: forces on nodes as functions of their motion.
///
/// All arrays are in internal order. Evaluations take `&mut self` for work arrays.
pub trait Law: Send + Sync {
    /// Its properties.
    fn properties(&self) -> Properties;

    /// Name in scenes, errors and energies.
    fn name(&self) -> &'static str {
        self.properties().name
    }

    /// The kernels of its forces; a law with `nodal` has none.
    fn kernels(&self) -> Kernels;

    /// Adds the forces \[N\] of the elements of a tile, those whose lowest node is in it. Returns the rate at which the
    /// law changes the mechanical energy \[W\]: the power of forces without potential, plus the partial time derivative
    /// of a potential that depends on time. Tiles come in order. After a tile no element uses its nodes.
    fn add_to_tile(&mut self, _tile: usize, _at: Instant<'_>, _forces: &mut NodeVectors) -> f64 {
        0.0
    }

    /// Bound above the nodes whose motion `add_to_tile` or `prepare` reads for a tile and the tiles before it; by
    /// default all nodes. Methods move the nodes of a tile just before it is evaluated. None before the tile is read,
    /// since methods may have moved those on.
    fn reach(&self, _tile: usize) -> usize {
        usize::MAX
    }

    /// The law as a nodal one.
    fn nodal(&mut self) -> Option<&mut dyn NodalLaw> {
        None
    }

    /// Whether its forces are those of a uniform field or of the frame: they act on a free piece as a whole, and leave
    /// its motion about its centre of mass, in inertial space, as it is.
    fn is_inertial(&self) -> bool {
        false
    }

    /// Why it does not go with a free hub, as a remedy.
    fn remedy_on_free_hub(&self) -> Option<&'static str> {
        None
    }

    /// Whether it is the law of the frame.
    fn is_frame(&self) -> bool {
        false
    }

    /// Of a load from outside, such as that of air at rest: the sum of what the last `add_to_tile` or `add_to_rows`
    /// added, about the origin \[N, N m\]. Where the hub is not free in six degrees of freedom, the torque about the
    /// axis alone. Its power as the frame moves counts beside that of the law, unless the law is conservative. `None`
    /// for forces between nodes, for those that the hub or what turns with it exerts, and for those of the frame.
    fn outside_load(&self) -> Option<Load> {
        None
    }

    /// The potential energy \[J\]; 0 for a law without potential.
    fn energy(&self, _at: Instant<'_>) -> f64 {
        0.0
    }

    /// The linearisation; `None` for forces that depend on neither positions nor velocities.
    fn linearisation(&self) -> Option<&dyn Linearisation> {
        None
    }

    /// Readings and bounds of the elements.
    fn inspection(&self) -> Option<&dyn Inspection> {
        None
    }

    /// The law as one with a history, to be read.
    fn history_dependent(&self) -> Option<&dyn HistoryDependent> {
        None
    }

    /// The law as one with a history, to be changed.
    fn history_dependent_mut(&mut self) -> Option<&mut dyn HistoryDependent> {
        None
    }

    /// The times at which its schedules jump \[s\], in any order.
    fn jumps(&self) -> Vec<f64> {
        Vec::new()
    }

    /// The law as one that acts by impulses.
    fn impulses(&mut self) -> Option<&mut dyn Impulses> {
        None
    }

    /// Whether it is one.
    fn has_impulses(&self) -> bool {
        false
    }

    /// Refuses a shape from which it cannot start.
    ///
    /// # Errors
    /// `StartsCrossed`.
    fn check_start(&self, _positions: &NodeVectors) -> Result<()> {
        Ok(())
    }

    /// The law as that of nodes that move as prescribed.
    fn moved(&self) -> Option<&Moved> {
        None
    }

    /// The same, to anchor them.
    fn moved_mut(&mut self) -> Option<&mut Moved> {
        None
    }

    /// The remedy for a fault by this law.
    fn remedy(&self) -> &'static str;
}
