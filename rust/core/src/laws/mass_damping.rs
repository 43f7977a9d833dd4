//! Damping of all motion relative to the turning frame, F = -rate m v \[N\]: a numerical means to bring a stowed sail
//! to rest, not a property of film or air.

use std::ops::Range;

use super::{Law, NodalLaw};
use crate::arrays::jacobian::{Block, JacobianBlocks};
use crate::arrays::state::{Instant, NodeVectors, columns, columns_mut, rows};
use crate::assembly::Assembly;
use crate::error::Result;
use crate::model::checks::non_negative;

/// The law.
pub(super) struct MassDamping {
    /// rate * m of each node [kg/s].
    coefficients: Vec<f64>,
}

impl MassDamping {
    pub(super) fn new(rate: f64, assembly: &Assembly) -> Result<Self> {
        non_negative("rate of mass damping [1/s]", rate)?;
        Ok(Self { coefficients: assembly.masses.iter().map(|mass| rate * mass).collect() })
    }
}

impl NodalLaw for MassDamping {
    fn add_to_rows(&self, range: Range<usize>, at: Instant<'_>, forces: [&mut [f64]; 3]) -> f64 {
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
    fn name(&self) -> &'static str {
        "mass_damping"
    }

    fn is_conservative(&self) -> bool {
        false
    }

    fn add_to_tile(&self, tile: usize, at: Instant<'_>, forces: &mut NodeVectors) -> f64 {
        self.add_to_nodes(tile, at, forces)
    }

    fn nodal(&self) -> Option<&dyn NodalLaw> {
        Some(self)
    }

    fn add_damping_product(&self, _at: Instant<'_>, p: &NodeVectors, out: &mut NodeVectors) {
        for (out, p) in columns_mut(out).into_iter().zip(columns(p)) {
            for ((out, p), c) in out.iter_mut().zip(p).zip(&self.coefficients) {
                *out += c * p;
            }
        }
    }

    fn add_jacobian(&self, _at: Instant<'_>, jacobian: &mut dyn JacobianBlocks) {
        for (node, &c) in self.coefficients.iter().enumerate() {
            jacobian.by_velocity(node as u32, node as u32, &(Block::identity() * -c));
        }
    }

    fn remedy(&self) -> &'static str {
        "use a smaller dt or a smaller rate of mass damping"
    }
}
