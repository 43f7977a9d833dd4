//! The one list of the laws that a scene chooses from, each with its parameters.

use serde::Deserialize;

use super::{Law, bridges, springs};
use crate::assembly::Assembly;
use crate::elements::link::SpringNetworks;
use crate::error::{Error, Result};
use crate::model::frame::Spin;

/// What the laws of one scene have in common while they are built.
pub struct Context<'a> {
    /// The model in the core's numbering.
    pub assembly: &'a Assembly,
    /// The links of the scene, arranged once for all laws.
    pub networks: SpringNetworks,
    /// All laws of the scene.
    pub specs: &'a [LawSpec],
}

/// By which elements a law models the in-plane elasticity of the film; a scene has one such law.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FilmElements {
    /// Springs along the edges.
    Links,
    /// Triangles of uniform strain.
    Triangles,
}

/// Parameters of a law, before it meets a mesh: plain numbers in SI units, by the names that scenes use.
pub trait LawParameters {
    /// Checks the parameters, and builds the law for a scene.
    ///
    /// # Errors
    /// `OutOfRange` for a parameter, and those of the law's own file.
    fn build(&self, context: &Context<'_>) -> Result<Box<dyn Law>>;

    /// Parameters with which every term of the law acts, for tests of laws as such.
    fn example() -> Self
    where
        Self: Sized;

    /// How the hub turns, of the law that says so.
    fn spin(&self) -> Option<Spin> {
        None
    }

    /// By which elements the law models the film, of a law that does.
    fn film(&self) -> Option<FilmElements> {
        None
    }
}

macro_rules! laws {
    ($($(#[$doc:meta])* $kind:literal $variant:ident($module:ident::$parameters:ident),)*) => {
        $(pub use super::$module::$parameters;)*

        /// A law with its parameters.
        #[derive(Debug, Clone, PartialEq, Deserialize)]
        #[serde(tag = "kind")]
        pub enum LawSpec {
            $($(#[$doc])* #[serde(rename = $kind)] $variant($parameters),)*
        }

        impl LawSpec {
            /// One of each law in the list, with parameters with which every term of it acts.
            pub fn examples() -> Vec<Self> {
                vec![$(Self::$variant($parameters::example()),)*]
            }

            /// The name that scenes use.
            pub fn kind(&self) -> &'static str {
                match self {
                    $(Self::$variant(_) => $kind,)*
                }
            }

            fn parameters(&self) -> &dyn LawParameters {
                match self {
                    $(Self::$variant(parameters) => parameters,)*
                }
            }

            /// By which elements the law models the film, of a law that does.
            pub fn film(&self) -> Option<FilmElements> {
                self.parameters().film()
            }
        }

        $(impl From<$parameters> for LawSpec {
            fn from(parameters: $parameters) -> Self {
                Self::$variant(parameters)
            }
        })*
    };
}

laws! {
    /// In-plane elasticity with buckling, eqs. (1) and (2).
    "springs" Springs(springs::SpringParameters),
    /// In-plane elasticity by triangles that wrinkle, in place of springs.
    "triangles" Triangles(triangles::TriangleParameters),
    /// Dashpots along all springs, or the same in triangles where there are those.
    "spring_damping" SpringDamping(spring_damping::DampingParameters),
    /// Crease stiffness and contact of the two facets, eqs. (3) and (4).
    "creases" Creases(creases::CreaseParameters),
    /// Drag of the residual air, eq. (5).
    "air_drag" AirDrag(air_drag::AirDragParameters),
    /// The frame that turns with the hub.
    "spin" Spin(rotating_frame::SpinParameters),
    /// Weight, fixed in inertial space.
    "gravity" Gravity(gravity::GravityParameters),
    /// Uniform pressure on the film, a load that follows it.
    "pressure" Pressure(pressure::PressureParameters),
    /// Nodes kept outside the spool.
    "spool_contact" SpoolContact(spool_contact::SpoolContactParameters),
    /// Damping of all motion relative to the turning frame.
    "mass_damping" MassDamping(mass_damping::MassDampingParameters),
}

/// How the hub of a scene turns: at rest without a law that says so.
pub fn spin_of(specs: &[LawSpec]) -> Spin {
    specs.iter().filter_map(|spec| spec.parameters().spin()).next_back().unwrap_or_default()
}

/// Builds the laws of a scene; tethers and bridges follow from the model's own parts.
///
/// # Errors
/// `OutOfRange` for a parameter, `LawTwice`, `DampingOnNegativeSpring`, `DegenerateTriangle`.
pub fn build(specs: &[LawSpec], assembly: &Assembly) -> Result<Vec<Box<dyn Law>>> {
    let context = Context { assembly, networks: SpringNetworks::default(), specs };
    let mut laws: Vec<Box<dyn Law>> = Vec::new();
    for spec in specs {
        let law = spec.parameters().build(&context)?;
        if laws.iter().any(|other| other.name() == law.name()) {
            return Err(Error::LawTwice { law: law.name() });
        }
        laws.push(law);
    }
    if !assembly.model.cords.is_empty() {
        laws.push(Box::new(springs::Springs::tethers(&context)));
    }
    if !assembly.model.bridges.nodes.is_empty() {
        laws.push(Box::new(bridges::Bridges::new(assembly)));
    }
    Ok(laws)
}
