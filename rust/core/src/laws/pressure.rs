//! Uniform pressure on the film, in the direction of the normal of each triangle: a follower load.
//!
//!     F = (p/6) (x1 - x0) x (x2 - x0)   [N]   on each node of a triangle
//!
//! that is a third of p times the present vector area of the triangle. The normal points to the side from which the
//! nodes appear counterclockwise. On a closed surface the sum of the forces and their total torque vanish, as integrals
//! of p n over a surface without boundary. On a surface with an edge the load has no potential; its work is external.
//!
//! The load is lumped in thirds, as the masses are. Its derivatives are exact:
//!
//!     dF/dx1 = -(p/6) [x2 - x0]x,      dF/dx2 = (p/6) [x1 - x0]x,      dF/dx0 = -(dF/dx1 + dF/dx2)

use nalgebra::Vector3;
use serde::Deserialize;

use super::facet_load::{FacetLoad, LoadedFacets};
use super::{
    Context, Inspection, Instant, Kernels, Law, LawParameters, Linearisation, OF_AXIS_ALONE, Properties, WorkClass,
};
use crate::arrays::jacobian::{Block, JacobianBlocks};
use crate::arrays::state::NodeVectors;
use crate::error::Result;
use crate::model::checks::finite;
use crate::model::factor::Factor;
use crate::simd::lanes::{SimdF64, Vec3, scale};

/// Parameters of the load.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PressureParameters {
    /// p, the difference of the pressures on both sides; a negative one acts against the normal \[Pa\].
    pub pressure: f64,
    /// Of p.
    #[serde(default)]
    pub factor: Factor,
}

impl LawParameters for PressureParameters {
    fn build(&self, context: &Context<'_>) -> Result<Box<dyn Law>> {
        finite("pressure on the film [Pa]", self.pressure)?;
        let (film, sixth) = (LoadedFacets::new(context.assembly), self.pressure / 6.0);
        Ok(Box::new(Pressure { film, sixth, factor: self.factor.clone() }))
    }

    fn example() -> Self {
        Self { pressure: 2.0, factor: Factor::example() }
    }
}

/// The law.
struct Pressure {
    film: LoadedFacets,
    /// p/6 [Pa].
    sixth: f64,
    factor: Factor,
}

impl Pressure {
    fn at(&self, time: f64) -> Load {
        Load { sixth: self.sixth * self.factor.value(time) }
    }
}

/// The load at an instant.
struct Load {
    /// p/6 [Pa].
    sixth: f64,
}

impl FacetLoad for Load {
    #[inline(always)]
    fn on_node<V: SimdF64>(&self, presence: V, normal: Vec3<V>) -> Vec3<V> {
        scale(V::all(self.sixth) * presence, normal)
    }

    fn change(&self, _normal: &Vector3<f64>, by: &Block) -> Block {
        by * self.sixth
    }
}

impl Law for Pressure {
    fn properties(&self) -> Properties {
        let work_class = WorkClass::External;
        Properties { name: "pressure", work_class, depends_on_velocity: false, is_internal: false }
    }

    fn kernels(&self) -> Kernels {
        Kernels::of_elements()
    }

    fn reach(&self, tile: usize) -> usize {
        self.film.facets.elements.reach(tile)
    }

    fn add_to_tile(&mut self, tile: usize, at: Instant<'_>, forces: &mut NodeVectors) -> f64 {
        let load = self.at(at.time);
        self.film.add_to_tile(&load, tile, at, forces)
    }

    fn outside_torque(&self) -> Option<f64> {
        Some(self.film.torque)
    }

    fn remedy_on_free_hub(&self, is_body: bool) -> Option<&'static str> {
        is_body.then_some(OF_AXIS_ALONE)
    }

    fn jumps(&self) -> Vec<f64> {
        self.factor.jumps()
    }

    fn linearisation(&self) -> Option<&dyn Linearisation> {
        Some(self)
    }

    fn inspection(&self) -> Option<&dyn Inspection> {
        Some(self)
    }

    fn remedy(&self) -> &'static str {
        "use a smaller dt or a smaller pressure"
    }
}

/// Without stiffness: the limit of the step is that of the other laws.
impl Linearisation for Pressure {
    fn visit_couplings(&self, visit: &mut dyn FnMut(&[u32])) {
        self.film.visit_couplings(visit);
    }

    fn add_jacobian(&self, instant: Instant<'_>, jacobian: &mut dyn JacobianBlocks) {
        self.film.add_jacobian(&self.at(instant.time), instant, jacobian);
    }
}

impl Inspection for Pressure {
    fn lanes(&self) -> [usize; 2] {
        self.film.facets.elements.lanes()
    }

    fn contiguous_share(&self) -> Option<f64> {
        Some(self.film.facets.elements.contiguous_share())
    }
}
