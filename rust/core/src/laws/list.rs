//! The list of laws, each with its parameters.

use serde::Deserialize;

use super::{Law, bridges, moved, springs, winches};
use crate::assembly::Assembly;
use crate::elements::link::SpringNetworks;
use crate::error::{Error, Result};
use crate::model::frame::Spin;

/// Common data for the construction of the laws of a scene.
pub struct Context<'a> {
    /// The assembled model.
    pub assembly: &'a Assembly,
    /// The links of the scene in batches, common to all laws.
    pub networks: SpringNetworks,
    /// All laws of the scene.
    pub specs: &'a [LawSpec],
}

/// Elements of a law for the in-plane elasticity of the film; a scene has one such law.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FilmElements {
    /// Springs along the edges.
    Links,
    /// Triangles of uniform strain.
    Triangles,
    /// Springs along the sides and both diagonals of rectangles.
    Rectangles,
}

/// Parameters of a law, independent of a mesh: plain numbers in SI units, with the names of scenes.
pub trait LawParameters {
    /// Checks the parameters, and builds the law for a scene.
    ///
    /// # Errors
    /// `OutOfRange` for a parameter, and those in the file of the law.
    fn build(&self, context: &Context<'_>) -> Result<Box<dyn Law>>;

    /// Parameters with which every term of the law is active, for tests.
    fn example() -> Self
    where
        Self: Sized;

    /// The motion of the hub, from the law that prescribes it.
    fn spin(&self) -> Option<Spin> {
        None
    }

    /// The elements of the film, from a law for its elasticity.
    fn film(&self) -> Option<FilmElements> {
        None
    }

    /// The springs of the film, from the law that describes them, with the same checks as in `build`.
    fn springs(&self, _context: &Context<'_>) -> Option<Result<springs::Springs>> {
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
            /// One of each law in the list, with parameters with which every term is active.
            pub fn examples() -> Vec<Self> {
                vec![$(Self::$variant($parameters::example()),)*]
            }

            /// Name in scenes.
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

            /// The elements of the film, from a law for its elasticity.
            pub fn film(&self) -> Option<FilmElements> {
                self.parameters().film()
            }

            /// The springs of the film, from the law that describes them.
            pub(super) fn springs(&self, context: &Context<'_>) -> Option<Result<springs::Springs>> {
                self.parameters().springs(context)
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
    /// In-plane elasticity by triangles with wrinkling, in place of springs.
    "triangles" Triangles(triangles::TriangleParameters),
    /// In-plane elasticity by the sides and both diagonals of rectangles, in place of springs along the edges.
    "rectangles" Rectangles(rectangles::RectangleParameters),
    /// Dashpots along all springs; in triangles, damping of the strain rate.
    "spring_damping" SpringDamping(spring_damping::DampingParameters),
    /// Crease stiffness and contact between the two facets, eqs. (3) and (4).
    "creases" Creases(creases::CreaseParameters),
    /// Bending stiffness of the film between its creases.
    "bending" Bending(bending::BendingParameters),
    /// Drag of the residual air, eq. (5).
    "air_drag" AirDrag(air_drag::AirDragParameters),
    /// Drag of air across cords.
    "cord_drag" CordDrag(cord_drag::CordDragParameters),
    /// The frame that turns with the hub.
    "spin" Spin(rotating_frame::SpinParameters),
    /// Weight, fixed in inertial space.
    "gravity" Gravity(gravity::GravityParameters),
    /// Uniform pressure on the film, a follower load.
    "pressure" Pressure(pressure::PressureParameters),
    /// Pressure of sunlight on the film, by its optical properties.
    "solar_pressure" SolarPressure(solar_pressure::SolarPressureParameters),
    /// Forces on nodes, fixed in the turning frame or in inertial space.
    "point_forces" PointForces(point_forces::PointForcesParameters),
    /// Contact of nodes with the spool.
    "spool_contact" SpoolContact(spool_contact::SpoolContactParameters),
    /// Contact with a body of prescribed motion.
    "body" Body(body::BodyParameters),
    /// Damping of approach and friction at the contacts with a body.
    "body_friction" BodyFriction(body_friction::BodyFrictionParameters),
    /// Contact between layers, and of cords with them.
    "self_contact" SelfContact(self_contact::SelfContactParameters),
    /// Damping of all motion relative to the turning frame.
    "mass_damping" MassDamping(mass_damping::MassDampingParameters),
}

/// The motion of the hub of a scene: at rest without a law that prescribes it.
pub fn spin_of(specs: &[LawSpec]) -> Spin {
    specs.iter().filter_map(|spec| spec.parameters().spin()).next_back().unwrap_or_default()
}

/// Builds the laws of a scene, with those of the cords, winches, bridges and moved nodes of the model.
///
/// # Errors
/// `OutOfRange` for a parameter, `LawTwice`, `TwoFilms`, `DampingOnNegativeSpring`, `LimitWithoutSprings`,
/// `DegenerateTriangle`, `NotRectangles`, `SlenderRectangles`.
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
    let mut films = specs.iter().filter(|spec| spec.film().is_some()).map(LawSpec::kind);
    if let (Some(first), Some(second)) = (films.next(), films.next()) {
        return Err(Error::TwoFilms { first, second });
    }
    if !assembly.model.cords.is_empty() {
        laws.push(Box::new(springs::Springs::tethers(&context)));
    }
    if let Some(winches) = winches::Winches::new(assembly) {
        laws.push(Box::new(winches));
    }
    if !assembly.model.bridges.nodes.is_empty() {
        laws.push(Box::new(bridges::Bridges::new(assembly)));
    }
    if !assembly.model.motions.is_empty() {
        laws.push(Box::new(moved::Moved::new(assembly)));
    }
    Ok(laws)
}
