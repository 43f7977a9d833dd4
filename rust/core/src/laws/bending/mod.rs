//! Bending stiffness of the film between its creases.
//!
//!     D = E h^3 / (12 (1 - nu^2))   [N m]
//!
//! In the form `hinges` each edge of the film is a hinge of a constant of its own, a function of the fold angle phi:
//!
//!     U = w_C w_D k phi^2 / 2   [J]
//!
//! In the form `curvature` the fold angles of its three edges give the curvature of a triangle of area A,
//!
//!     kappa = sum over its edges of s phi |e| / A  n n^T,   U = A D/2 [(1 - nu) kappa : kappa + nu (tr kappa)^2]
//!
//! with n the normal of the edge in the plane of the triangle, the weighted angle w_C w_D phi in place of phi, and
//! s = 1/2: the other half of the angle belongs to the triangle on the other side. In products of two edges sin phi
//! stands in place of phi. A region of natural curvature has phi less its natural fold angle in place of phi, see
//! `edges`; each has its own D. Every force is -dU/dx. The weights w are those of `elements::hinge`. The fold angle has
//! its cut where the hinge is shut, where its energy is continuous.
//!
//! Sources: hinges of constant stiffness on equilateral triangles, Seung and Nelson, Phys. Rev. A 38 (1988); the
//! curvature of a triangle from those beside it, Onate and Cervera, Eng. Comput. 10 (1993).

mod curvature;
mod edges;
mod hinges;

use std::f64::consts::PI;

use serde::Deserialize;

use self::curvature::CurvatureBending;
use self::hinges::HingeBending;
use super::{Context, Law, LawParameters, Properties, WorkClass};
use crate::error::Result;
use crate::model::checks::{non_negative, within};

/// Parameters of bending.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BendingParameters {
    /// The elements.
    pub form: BendingForm,
    /// Factor of D.
    pub stiffness: f64,
    /// Edges whose fold angle at the start is larger have no bending stiffness \[rad\].
    pub fold_limit: f64,
    /// c: the area of a facet, relative to its reference area, at which w is half its value for a large area.
    pub collapse: f64,
}

/// The elements of bending.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum BendingForm {
    /// Hinges of constants of their own.
    Hinges,
    /// Triangles with the curvature of their three edges.
    Curvature,
}

impl LawParameters for BendingParameters {
    fn build(&self, context: &Context<'_>) -> Result<Box<dyn Law>> {
        non_negative("stiffness of bending", self.stiffness)?;
        let limit = self.fold_limit;
        within("fold limit of bending [rad]", limit, (0.0..=PI).contains(&limit), "it lies between 0 and pi")?;
        non_negative("collapse of bending", self.collapse)?;
        Ok(match self.form {
            BendingForm::Hinges => Box::new(HingeBending::new(*self, context.assembly)?),
            BendingForm::Curvature => Box::new(CurvatureBending::new(*self, context.assembly)?),
        })
    }

    fn example() -> Self {
        Self { form: BendingForm::Curvature, stiffness: 1.0, fold_limit: PI, collapse: 0.05 }
    }
}

/// Common to both forms.
const PROPERTIES: Properties =
    Properties { name: "bending", work_class: WorkClass::Conservative, depends_on_velocity: false, is_internal: true };

/// Common to both forms; `is_singular`: c is zero.
fn remedy(is_singular: bool) -> &'static str {
    if is_singular {
        "without collapse the force grows without bound as a facet collapses: set collapse to 0.05, or use a smaller dt"
    } else {
        "use a smaller dt or a smaller bending stiffness"
    }
}
