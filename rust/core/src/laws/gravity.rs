//! Weight: F = m g \[N\], U = -sum m g . x \[J\], with g fixed in inertial space.
//!
//! In the frame of a driven hub at the angle phi = integral of Omega, the components of g are rotated by -phi. Unless g
//! lies along the axis, U depends on time, and its partial derivative sum m (Omega x g) . x counts as power on the
//! system. The angle of a free hub is a part of the motion: U does not depend on time.
//!
//! In six degrees of freedom the hub has the weight M g too, at the origin, and U is that in space, with the origin at
//! X: U = -g . (M X + sum m (X + x)).
//!
//! With a factor f of time, g = f g_1, it is a load from outside like any other that changes with time: its power is
//! that of the forces, and it has no potential. (The power of a potential would be -f' sum m g_1 . x, which jumps at
//! the knots of a schedule.)

use std::ops::Range;

use nalgebra::Vector3;
use serde::Deserialize;

use super::{Context, Instant, Kernels, Law, LawParameters, NodalLaw, Properties, WorkClass};
use crate::arrays::state::{NodeVectors, columns, rows};
use crate::error::Result;
use crate::model::checks::finite;
use crate::model::factor::Factor;
use crate::model::load::Load;

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
        Ok(Box::new(Gravity { acceleration: self.acceleration, masses, factor, outside: Load::default() }))
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
    /// See `Law::outside_load`.
    outside: Load,
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
        self.outside = Load::default();
        if let Some(body) = at.frame.body() {
            let g = Vector3::from(g);
            let weight = g * masses.iter().sum::<f64>();
            let moment = Vector3::from(places.map(|column| moment(column, masses)));
            // The hub counts once, with the first nodes.
            let of_hub = if range.start == 0 { g * body.mass } else { Vector3::zeros() };
            self.outside = Load { force: weight + of_hub, torque: moment.cross(&g) };
        } else if (rate != 0.0 || at.frame.hub.is_some()) && (g[0] != 0.0 || g[1] != 0.0) {
            let torque = g[0] * moment(places[1], masses) - g[1] * moment(places[0], masses);
            self.outside.torque.z = -torque;
            turning = if at.frame.hub.is_some() { 0.0 } else { rate * torque };
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

    fn outside_load(&self) -> Option<Load> {
        Some(self.outside)
    }

    fn jumps(&self) -> Vec<f64> {
        self.factor.jumps()
    }

    fn energy(&self, at: Instant<'_>) -> f64 {
        if self.factor.varies() {
            return 0.0;
        }
        let (g, moment) = (self.at(at), self.moment(at.positions));
        let in_frame = -(g[0] * moment[0] + g[1] * moment[1] + g[2] * moment[2]);
        at.frame.body().map_or(in_frame, |body| {
            let whole = body.mass + self.masses.iter().sum::<f64>();
            in_frame - whole * Vector3::from(self.acceleration).dot(&body.origin)
        })
    }

    fn remedy(&self) -> &'static str {
        "check gravity, and that what should hang is held"
    }
}
