//! Damping of all motion relative to the turning frame, F = -rate m v \[N\]: a numerical means for relaxation, not a
//! property of film or air.

use std::ops::Range;

use serde::Deserialize;

use super::{Context, Instant, Kernels, Law, LawParameters, Linearisation, NodalLaw, Properties, WorkClass};
use crate::arrays::jacobian::{Block, JacobianBlocks};
use crate::arrays::state::{NodeVectors, columns, columns_mut, rows};
use crate::error::Result;
use crate::model::checks::non_negative;

/// Parameters of the damping.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MassDampingParameters {
    /// The rate at which velocities decay \[1/s\].
    pub rate: f64,
}

impl LawParameters for MassDampingParameters {
    fn build(&self, context: &Context<'_>) -> Result<Box<dyn Law>> {
        non_negative("rate of mass damping [1/s]", self.rate)?;
        Ok(Box::new(MassDamping {
            coefficients: context.assembly.masses.iter().map(|mass| self.rate * mass).collect(),
        }))
    }

    fn example() -> Self {
        Self { rate: 3.0 }
    }
}

/// The law.
struct MassDamping {
    /// rate * m of each node [kg/s].
    coefficients: Vec<f64>,
}

impl NodalLaw for MassDamping {
    fn add_to_rows(&mut self, range: Range<usize>, at: Instant<'_>, forces: [&mut [f64]; 3]) -> f64 {
        let mut power = 0.0;
        for (force, velocity) in forces.into_iter().zip(rows(at.velocities, range.clone())) {
            for ((f, v), c) in force.iter_mut().zip(velocity).zip(&self.coefficients[range.clone()]) {
                *f -= c * v;
                power -= c * v * v;
            }
        }
        power
    }
}

impl Law for MassDamping {
    fn properties(&self) -> Properties {
        Properties {
            name: "mass_damping",
            work_class: WorkClass::Dissipative,
            depends_on_velocity: true,
            is_internal: false,
        }
    }

    fn kernels(&self) -> Kernels {
        Kernels::default()
    }

    fn reach(&self, _tile: usize) -> usize {
        0
    }

    fn nodal(&mut self) -> Option<&mut dyn NodalLaw> {
        Some(self)
    }

    fn linearisation(&self) -> Option<&dyn Linearisation> {
        Some(self)
    }

    fn remedy(&self) -> &'static str {
        "use a smaller dt or a smaller rate of mass damping"
    }
}

impl Linearisation for MassDamping {
    fn add_damping_product(&self, factor: f64, _at: Instant<'_>, p: &NodeVectors, out: &mut NodeVectors) {
        for (out, p) in columns_mut(out).into_iter().zip(columns(p)) {
            for ((out, p), c) in out.iter_mut().zip(p).zip(&self.coefficients) {
                *out += factor * c * p;
            }
        }
    }

    fn add_jacobian(&self, _at: Instant<'_>, jacobian: &mut dyn JacobianBlocks) {
        for (node, &c) in self.coefficients.iter().enumerate() {
            jacobian.by_velocity(node as u32, node as u32, &(Block::identity() * -c));
        }
    }
}
