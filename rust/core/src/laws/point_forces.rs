//! Forces on nodes, the same on each of some nodes: F = f(t) F_1 \[N\], with F_1 fixed in the turning frame or in
//! inertial space; from there, their components in the frame turn as it turns.
//!
//! They act from outside, also where they turn with the hub. Their work is external, also where a potential exists: in
//! a frame at rest, of forces that do not change.

use std::ops::Range;

use nalgebra::Vector3;
use serde::Deserialize;

use super::{Context, Instant, Kernels, Law, LawParameters, NodalLaw, Properties, WorkClass};
use crate::arrays::state::rows;
use crate::error::Result;
use crate::model::checks::finite;
use crate::model::factor::Factor;
use crate::model::frame::Frame;
use crate::model::load::Load;

/// In which frame forces keep their direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ForceFrame {
    /// In that which turns with the hub.
    #[default]
    Turning,
    /// In inertial space.
    Inertial,
}

/// Parameters of the forces; the nodes are those of the model (`Model::loaded`).
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PointForcesParameters {
    /// The force on each node \[N\].
    pub force: [f64; 3],
    /// In which frame it keeps its direction.
    #[serde(default)]
    pub frame: ForceFrame,
    /// Of the force.
    #[serde(default)]
    pub factor: Factor,
}

impl LawParameters for PointForcesParameters {
    fn build(&self, context: &Context<'_>) -> Result<Box<dyn Law>> {
        for component in self.force {
            finite("force on a node [N]", component)?;
        }
        let assembly = context.assembly;
        let internal = |&node: &u32| assembly.numbering.to_internal([node])[0];
        let mut nodes: Vec<u32> = assembly.model.loaded.iter().map(internal).collect();
        nodes.sort_unstable();
        Ok(Box::new(PointForces { parameters: self.clone(), nodes, outside: Load::default() }))
    }

    fn example() -> Self {
        Self { force: [3e-5, -2e-5, 5e-5], frame: ForceFrame::Inertial, factor: Factor::example() }
    }
}

/// The law.
struct PointForces {
    parameters: PointForcesParameters,
    /// Internal numbers, ascending.
    nodes: Vec<u32>,
    /// See `Law::outside_load`.
    outside: Load,
}

impl PointForces {
    /// The force on each node in the turning frame [N].
    fn at(&self, at: Instant<'_>) -> [f64; 3] {
        let PointForcesParameters { force, frame, factor } = &self.parameters;
        let force = match frame {
            ForceFrame::Turning => *force,
            ForceFrame::Inertial => at.frame.components_of(*force),
        };
        force.map(|component| component * factor.value(at.time))
    }
}

impl NodalLaw for PointForces {
    fn add_to_rows(&mut self, range: Range<usize>, at: Instant<'_>, [fx, fy, fz]: [&mut [f64]; 3]) -> f64 {
        self.outside = Load::default();
        let first = self.nodes.partition_point(|&node| (node as usize) < range.start);
        let end = self.nodes.partition_point(|&node| (node as usize) < range.end);
        if first == end {
            return 0.0;
        }
        let [x, y, z] = self.at(at);
        let (places, velocities) = (rows(at.positions, range.clone()), rows(at.velocities, range.clone()));
        let mut power = 0.0;
        for node in self.nodes[first..end].iter().map(|&node| node as usize - range.start) {
            (fx[node], fy[node], fz[node]) = (fx[node] + x, fy[node] + y, fz[node] + z);
            power += x * velocities[0][node] + y * velocities[1][node] + z * velocities[2][node];
            let place = places.map(|column| column[node]);
            self.outside += Load::at(place.into(), Vector3::new(x, y, z));
        }
        if let Frame { rate: 0.0, hub: None, .. } = at.frame {
            self.outside = Load::default();
        }
        power
    }
}

impl Law for PointForces {
    fn properties(&self) -> Properties {
        let work_class = WorkClass::External;
        Properties { name: "point_forces", work_class, depends_on_velocity: false, is_internal: false }
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

    fn outside_load(&self) -> Option<Load> {
        Some(self.outside)
    }

    fn jumps(&self) -> Vec<f64> {
        self.parameters.factor.jumps()
    }

    fn remedy(&self) -> &'static str {
        "use a smaller dt or smaller forces"
    }
}
