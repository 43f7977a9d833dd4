//! Drag of air on cords, across their segments alone:
//!
//!     F = -(1/2) rho C_d d l |w| w   [N],     w = V - (V . e) e   [m/s]
//!
//! with d the diameter of the cord, l the length of the segment and e its direction, V the mean velocity of its two
//! nodes relative to the air; half of F acts on each node. The flow along a segment exerts nothing. The air is at rest
//! in the chamber, so that V = v + Omega x r in the turning frame, or it turns with the hub, so that V = v. Segments
//! along edges of the film have none: the film is there.
//! Source: the cross-flow principle, S. F. Hoerner, Fluid-Dynamic Drag (1965), chapter 3.

use std::collections::BTreeSet;

use nalgebra::{Matrix3, Vector3};
use serde::Deserialize;

use super::air_drag::AirMotion;
use super::segments::{Ends, Segments};
use super::{Context, Instant, Kernels, Law, LawParameters, Linearisation, Properties, WorkClass};
use crate::arrays::jacobian::{Block, JacobianBlocks, at};
use crate::arrays::state::NodeVectors;
use crate::assembly::Assembly;
use crate::error::Result;
use crate::model::checks::{non_negative, positive};
use crate::model::frame::Frame;
use crate::model::load::Load;

/// Parameters of the air and of the cords.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CordDragParameters {
    /// d \[m\].
    pub diameter: f64,
    /// C_d.
    pub coefficient: f64,
    /// rho \[kg/m3\].
    pub density: f64,
    /// Motion of the air.
    pub air: AirMotion,
}

impl LawParameters for CordDragParameters {
    fn build(&self, context: &Context<'_>) -> Result<Box<dyn Law>> {
        positive("diameter of the cords [m]", self.diameter)?;
        non_negative("drag coefficient of the cords", self.coefficient)?;
        non_negative("density of the air [kg/m3]", self.density)?;
        Ok(Box::new(CordDrag::new(*self, context.assembly)))
    }

    fn example() -> Self {
        Self { diameter: 1e-3, coefficient: 1.1, density: 1.2, air: AirMotion::Still }
    }
}

/// The two nodes of a segment, the lower internal number first.
struct Segment([u32; 2]);

impl Ends for Segment {
    fn ends(&self) -> [u32; 2] {
        self.0
    }
}

/// The law.
struct CordDrag {
    segments: Segments<Segment>,
    /// rho C_d d / 2 \[kg/m2\].
    factor: f64,
    air: AirMotion,
    /// See `Law::outside_load`.
    outside: Load,
}

/// A segment in the air: d from end to end, its length, V, and w.
struct Flow {
    d: Vector3<f64>,
    length: f64,
    velocity: Vector3<f64>,
    across: Vector3<f64>,
}

impl Flow {
    /// The derivative of |w| w by w.
    fn slope(&self) -> Matrix3<f64> {
        let speed = self.across.norm();
        Matrix3::identity() * speed + self.across * self.across.transpose() / speed.max(f64::MIN_POSITIVE)
    }

    /// 1 - e e^T.
    fn projection(&self) -> Matrix3<f64> {
        Matrix3::identity() - self.d * self.d.transpose() / self.square()
    }

    /// l^2, above zero.
    fn square(&self) -> f64 {
        (self.length * self.length).max(f64::MIN_POSITIVE)
    }

    /// The derivative of l |w| w by V.
    fn by_velocity(&self) -> Matrix3<f64> {
        self.slope() * self.projection() * self.length
    }

    /// The derivative of l |w| w by d.
    fn by_span(&self) -> Matrix3<f64> {
        let (d, along) = (self.d, self.d.dot(&self.velocity));
        let outer = d * self.velocity.transpose() + Matrix3::identity() * along;
        let turned = d * d.transpose() * (2.0 * along / self.square()) - outer;
        let longer = self.across * d.transpose() * (self.across.norm() / self.square().sqrt());
        longer + self.slope() * turned * (self.length / self.square())
    }
}

impl CordDrag {
    fn new(parameters: CordDragParameters, assembly: &Assembly) -> Self {
        let CordDragParameters { diameter, coefficient, density, air } = parameters;
        let edges: BTreeSet<[u32; 2]> = assembly.mesh.edges.iter().map(|&[a, b]| [a.min(b), a.max(b)]).collect();
        let cords = assembly.model.cord_nodes().into_iter().filter(|&[a, b]| !edges.contains(&[a.min(b), a.max(b)]));
        let internal = |nodes: [u32; 2]| {
            let [a, b] = assembly.numbering.to_internal(nodes);
            Segment([a.min(b), a.max(b)])
        };
        let segments = Segments::new(cords.map(internal).collect(), assembly.masses.len());
        Self { segments, factor: 0.5 * density * coefficient * diameter, air, outside: Load::default() }
    }

    /// Of the frame relative to the air: its rates \[rad/s\] as a matrix, and the velocity of its origin \[m/s\].
    fn carried(&self, frame: Frame) -> (Matrix3<f64>, Vector3<f64>) {
        match self.air {
            AirMotion::Still => {
                let (rates, velocity) = frame.carried();
                (rates.cross_matrix(), velocity)
            }
            AirMotion::Turning => (Matrix3::zeros(), Vector3::zeros()),
        }
    }

    fn flow(&self, [a, b]: [u32; 2], instant: Instant<'_>) -> Flow {
        let (x, v) = ([a, b].map(|node| at(instant.positions, node)), [a, b].map(|node| at(instant.velocities, node)));
        let (turning, of_origin) = self.carried(instant.frame);
        let (d, velocity) = (x[1] - x[0], 0.5 * (v[0] + v[1] + turning * (x[0] + x[1])) + of_origin);
        let length = d.norm();
        let across = velocity - d * (d.dot(&velocity) / (length * length).max(f64::MIN_POSITIVE));
        Flow { d, length, velocity, across }
    }
}

impl Law for CordDrag {
    fn properties(&self) -> Properties {
        // As that on the film, see `air_drag`.
        let work_class = match self.air {
            AirMotion::Still => WorkClass::External,
            AirMotion::Turning => WorkClass::Dissipative,
        };
        Properties { name: "cord_drag", work_class, depends_on_velocity: true, is_internal: false }
    }

    fn kernels(&self) -> Kernels {
        Kernels::of_elements()
    }

    fn reach(&self, tile: usize) -> usize {
        self.segments.reach(tile)
    }

    fn add_to_tile(&mut self, tile: usize, instant: Instant<'_>, forces: &mut NodeVectors) -> f64 {
        let (mut power, mut outside) = (0.0, Load::default());
        for segment in self.segments.of_tile(tile) {
            let flow = self.flow(segment.0, instant);
            let force = flow.across * (-0.5 * self.factor * flow.length * flow.across.norm());
            for node in segment.0 {
                for k in 0..3 {
                    forces[(node as usize, k)] += force[k];
                }
                let place = at(instant.positions, node);
                power += force.dot(&at(instant.velocities, node));
                outside += Load::at(place, force);
            }
        }
        let is_still = matches!(instant.frame, Frame { rate: 0.0, hub: None, .. });
        self.outside = if is_still { Load::default() } else { outside };
        power
    }

    fn outside_load(&self) -> Option<Load> {
        (self.air == AirMotion::Still).then_some(self.outside)
    }

    fn linearisation(&self) -> Option<&dyn Linearisation> {
        Some(self)
    }

    fn remedy(&self) -> &'static str {
        "use a smaller dt, thinner cords or thinner air"
    }
}

impl Linearisation for CordDrag {
    fn add_damping_product(&self, factor: f64, instant: Instant<'_>, p: &NodeVectors, out: &mut NodeVectors) {
        for segment in self.segments.all() {
            let [a, b] = segment.0;
            let mean = 0.5 * (at(p, a) + at(p, b));
            let product = self.flow(segment.0, instant).by_velocity() * mean * (0.5 * factor * self.factor);
            for node in segment.0 {
                for k in 0..3 {
                    out[(node as usize, k)] += product[k];
                }
            }
        }
    }

    fn visit_couplings(&self, visit: &mut dyn FnMut(&[u32])) {
        self.segments.all().iter().for_each(|segment| visit(&segment.0));
    }

    fn add_jacobian(&self, instant: Instant<'_>, jacobian: &mut dyn JacobianBlocks) {
        let (turning, _) = self.carried(instant.frame);
        for segment in self.segments.all() {
            let flow = self.flow(segment.0, instant);
            let by_velocity: Block = flow.by_velocity() * (-0.25 * self.factor);
            let by_span: Block = flow.by_span() * (-0.5 * self.factor);
            for i in segment.0 {
                for (j, sign) in segment.0.into_iter().zip([-1.0, 1.0]) {
                    jacobian.by_velocity(i, j, &by_velocity);
                    jacobian.by_position(i, j, &(by_velocity * turning + by_span * sign));
                }
            }
        }
    }
}
