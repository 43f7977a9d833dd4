//! Weight: F = m g \[N\], U = -sum m g . x \[J\], with g fixed in inertial space.
//!
//! In the frame that has turned by phi = integral of Omega, g's components turn by -phi; unless g lies along the axis, U
//! then depends on time, and its partial derivative sum m (Omega x g) . x counts as work done on the system.

use std::ops::Range;

use super::{Law, NodalLaw, Spin};
use crate::arrays::state::{Instant, NodeVectors, columns, rows};
use crate::assembly::Assembly;
use crate::error::Result;
use crate::model::checks::finite;

/// The law.
pub(super) struct Gravity {
    /// g in inertial space [m/s2].
    acceleration: [f64; 3],
    spin: Spin,
    masses: Vec<f64>,
}

impl Gravity {
    pub(super) fn new(acceleration: [f64; 3], spin: Spin, assembly: &Assembly) -> Result<Self> {
        for component in acceleration {
            finite("acceleration of gravity [m/s2]", component)?;
        }
        Ok(Self { acceleration, spin, masses: assembly.masses.clone() })
    }

    /// g in the turning frame [m/s2].
    fn turned(&self, time: f64) -> [f64; 3] {
        let (sine, cosine) = self.spin.angle_at(time).sin_cos();
        let [x, y, z] = self.acceleration;
        [cosine * x + sine * y, cosine * y - sine * x, z]
    }

    /// sum m x [kg m].
    fn moment(&self, positions: &NodeVectors) -> [f64; 3] {
        columns(positions).map(|column| moment(column, &self.masses))
    }
}

/// sum m x along one axis [kg m].
fn moment(column: &[f64], masses: &[f64]) -> f64 {
    column.iter().zip(masses).map(|(x, m)| m * x).sum()
}

impl NodalLaw for Gravity {
    fn add_to_rows(&self, range: Range<usize>, at: Instant<'_>, forces: [&mut [f64]; 3]) -> f64 {
        let (g, masses) = (self.turned(at.time), &self.masses[range.clone()]);
        for (column, g) in forces.into_iter().zip(g) {
            for (force, mass) in column.iter_mut().zip(masses) {
                *force += mass * g;
            }
        }
        let rate = self.spin.rate_at(at.time);
        if rate == 0.0 || (g[0] == 0.0 && g[1] == 0.0) {
            return 0.0;
        }
        let [x, y, _] = rows(at.positions, range);
        rate * (g[0] * moment(y, masses) - g[1] * moment(x, masses))
    }
}

impl Law for Gravity {
    fn name(&self) -> &'static str {
        "gravity"
    }

    fn is_conservative(&self) -> bool {
        true
    }

    fn add_to_tile(&self, tile: usize, at: Instant<'_>, forces: &mut NodeVectors) -> f64 {
        self.add_to_nodes(tile, at, forces)
    }

    fn nodal(&self) -> Option<&dyn NodalLaw> {
        Some(self)
    }

    fn energy(&self, at: Instant<'_>) -> f64 {
        let (g, moment) = (self.turned(at.time), self.moment(at.positions));
        -(g[0] * moment[0] + g[1] * moment[1] + g[2] * moment[2])
    }

    fn remedy(&self) -> &'static str {
        "check gravity, and that what should hang is held"
    }
}
