//! Weight: F = m g \[N\], U = -sum m g . x \[J\], with g fixed in inertial space.
//!
//! In the frame at the angle phi = integral of Omega, the components of g are rotated by -phi. Unless g lies along the
//! axis, U depends on time, and its partial derivative sum m (Omega x g) . x counts as power on the system.
//!
//! With a factor f of time, g = f g_1, it is a load from outside like any other that changes with time: its power is
//! that of the forces, its torque about the axis is named beside it, and it has no potential. (The power of a potential
//! would be -f' sum m g_1 . x, which jumps at the knots of a schedule.)

use std::ops::Range;

use serde::Deserialize;

use super::{Context, Instant, Kernels, Law, LawParameters, NodalLaw, OF_AXIS_ALONE, Properties, WorkClass};
use crate::arrays::state::{NodeVectors, columns, rows};
use crate::error::Result;
use crate::model::checks::finite;
use crate::model::factor::Factor;

/// Parameters of weight.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GravityParameters {
    /// g in inertial space \[m/s2\].
    pub acceleration: [f64; 3],
    /// Of g.
    #[serde(default)]
    pub factor: Factor,
}

impl LawParameters for GravityParameters {
    fn build(&self, context: &Context<'_>) -> Result<Box<dyn Law>> {
        for component in self.acceleration {
            finite("acceleration of gravity [m/s2]", component)?;
        }
        let (masses, factor) = (context.assembly.masses.clone(), self.factor.clone());
        Ok(Box::new(Gravity { acceleration: self.acceleration, masses, factor, torque: 0.0 }))
    }

    fn example() -> Self {
        Self { acceleration: [1.0, -2.0, -9.81], factor: Factor::example() }
    }
}

/// The law.
struct Gravity {
    /// g in inertial space [m/s2].
    acceleration: [f64; 3],
    masses: Vec<f64>,
    factor: Factor,
    /// See `Law::outside_torque`.
    torque: f64,
}

impl Gravity {
    /// g in the turning frame [m/s2].
    fn at(&self, at: Instant<'_>) -> [f64; 3] {
        let factor = self.factor.value(at.time);
        at.frame.components_of(self.acceleration).map(|g| g * factor)
    }

    /// sum m x [kg m].
    fn moment(&self, positions: &NodeVectors) -> [f64; 3] {
        columns(positions).map(|column| moment(column, &self.masses))
    }
}

/// sum m x along one axis [kg m], of positions or of velocities [kg m/s].
fn moment(column: &[f64], masses: &[f64]) -> f64 {
    column.iter().zip(masses).map(|(x, m)| m * x).sum()
}

impl NodalLaw for Gravity {
    fn add_to_rows(&mut self, range: Range<usize>, at: Instant<'_>, forces: [&mut [f64]; 3]) -> f64 {
        let (g, masses) = (self.at(at), &self.masses[range.clone()]);
        for (column, g) in forces.into_iter().zip(g) {
            for (force, mass) in column.iter_mut().zip(masses) {
                *force += mass * g;
            }
        }
        let places = rows(at.positions, range.clone());
        let rate = at.frame.angle_rate();
        let mut turning = 0.0;
        self.torque = 0.0;
        if rate != 0.0 && (g[0] != 0.0 || g[1] != 0.0) {
            let torque = g[0] * moment(places[1], masses) - g[1] * moment(places[0], masses);
            (self.torque, turning) = (-torque, rate * torque);
        }
        if self.factor.varies() {
            let momentum = rows(at.velocities, range).map(|column| moment(column, masses));
            return g.iter().zip(momentum).map(|(g, p)| g * p).sum();
        }
        turning
    }
}

impl Law for Gravity {
    fn properties(&self) -> Properties {
        Properties {
            name: "gravity",
            work_class: if self.factor.varies() { WorkClass::External } else { WorkClass::Conservative },
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

    fn outside_torque(&self) -> Option<f64> {
        self.factor.varies().then_some(self.torque)
    }

    fn jumps(&self) -> Vec<f64> {
        self.factor.jumps()
    }

    fn energy(&self, at: Instant<'_>) -> f64 {
        if self.factor.varies() {
            return 0.0;
        }
        let (g, moment) = (self.at(at), self.moment(at.positions));
        -(g[0] * moment[0] + g[1] * moment[1] + g[2] * moment[2])
    }

    fn remedy(&self) -> &'static str {
        "check gravity, and that what should hang is held"
    }
}
