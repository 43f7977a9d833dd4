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

use super::facet_load::{FacetLoad, FacetLoadLaw, LoadedFacets};
use super::{Context, Instant, Law, LawParameters};
use crate::arrays::jacobian::Block;
use crate::elements::facet::FacetSet;
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
        let load = Pressure { sixth: self.pressure / 6.0, factor: self.factor.clone() };
        Ok(Box::new(LoadedFacets::new(load, FacetSet::new(context.assembly), context.assembly)))
    }

    fn example() -> Self {
        Self { pressure: 2.0, factor: Factor::example() }
    }
}

/// The load as a function of time.
struct Pressure {
    /// p/6 [Pa].
    sixth: f64,
    factor: Factor,
}

impl FacetLoadLaw for Pressure {
    type Load<'a> = Load;
    const NAME: &'static str = "pressure";
    const REMEDY: &'static str = "use a smaller dt or a smaller pressure";

    fn at(&self, at: Instant<'_>) -> Load {
        Load { sixth: self.sixth * self.factor.value(at.time) }
    }

    fn factor(&self) -> &Factor {
        &self.factor
    }
}

/// The load at an instant.
struct Load {
    /// p/6 [Pa].
    sixth: f64,
}

impl FacetLoad for Load {
    #[inline(always)]
    fn on_node<V: SimdF64>(&self, _place: usize, presence: V, normal: Vec3<V>) -> Vec3<V> {
        scale(V::all(self.sixth) * presence, normal)
    }

    fn change(&self, _place: (usize, usize), _normal: &Vector3<f64>, by: &Block) -> Block {
        by * self.sixth
    }
}
