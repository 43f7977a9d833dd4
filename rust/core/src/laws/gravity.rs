//! Weight: F = m g \[N\], U = -sum m g . x \[J\], with g fixed in inertial space.
//!
//! In the frame at the angle phi = integral of Omega, the components of g are rotated by -phi. Unless g lies along the
//! axis, U depends on time, and its partial derivative sum m (Omega x g) . x counts as power on the system.

use std::ops::Range;

use serde::Deserialize;

use super::{Context, Instant, Kernels, Law, LawParameters, NodalLaw, OF_AXIS_ALONE, Properties, WorkClass};
use crate::arrays::state::{NodeVectors, columns, rows};
use crate::error::Result;
use crate::model::checks::finite;
use crate::model::frame::Frame;

/// Parameters of weight.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GravityParameters {
    /// g in inertial space \[m/s2\].
    pub acceleration: [f64; 3],
}

impl LawParameters for GravityParameters {
    fn build(&self, context: &Context<'_>) -> Result<Box<dyn Law>> {
        for component in self.acceleration {
            finite("acceleration of gravity [m/s2]", component)?;
        }
        Ok(Box::new(Gravity { acceleration: self.acceleration, masses: context.assembly.masses.clone() }))
    }

    fn example() -> Self {
        Self { acceleration: [1.0, -2.0, -9.81] }
    }
}

/// The law.
struct Gravity {
    /// g in inertial space [m/s2].
    acceleration: [f64; 3],
    masses: Vec<f64>,
}

impl Gravity {
    /// g in the turning frame [m/s2].
    fn in_frame(&self, frame: Frame) -> [f64; 3] {
        frame.components_of(self.acceleration)
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
    fn add_to_rows(&mut self, range: Range<usize>, at: Instant<'_>, forces: [&mut [f64]; 3]) -> f64 {
        let (g, masses) = (self.in_frame(at.frame), &self.masses[range.clone()]);
        for (column, g) in forces.into_iter().zip(g) {
            for (force, mass) in column.iter_mut().zip(masses) {
                *force += mass * g;
            }
        }
        let rate = at.frame.angle_rate();
        if rate == 0.0 || (g[0] == 0.0 && g[1] == 0.0) {
            return 0.0;
        }
        let [x, y, _] = rows(at.positions, range);
        rate * (g[0] * moment(y, masses) - g[1] * moment(x, masses))
    }
}

impl Law for Gravity {
    fn properties(&self) -> Properties {
        Properties {
            name: "gravity",
            work_class: WorkClass::Conservative,
            depends_on_velocity: false,
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

    fn is_inertial(&self) -> bool {
        true
    }

    fn remedy_on_free_hub(&self, is_body: bool) -> Option<&'static str> {
        if is_body {
            return Some(OF_AXIS_ALONE);
        }
        let is_along_axis = self.acceleration[..2] == [0.0; 2];
        (!is_along_axis).then_some("a weight along the axis alone has no torque about it")
    }

    fn energy(&self, at: Instant<'_>) -> f64 {
        let (g, moment) = (self.in_frame(at.frame), self.moment(at.positions));
        -(g[0] * moment[0] + g[1] * moment[1] + g[2] * moment[2])
    }

    fn remedy(&self) -> &'static str {
        "check gravity, and that what should hang is held"
    }
}
