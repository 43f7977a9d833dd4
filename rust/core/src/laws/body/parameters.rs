//! Parameters of a body, by the names of scenes.

use serde::Deserialize;

use super::contacts::{Contacts, candidates_of};
use crate::bodies::rigid_body::{Motion, RigidBody};
use crate::bodies::shape::{Ends, Shape};
use crate::error::Result;
use crate::laws::Context;
use crate::model::checks::{non_negative, positive};
use crate::model::schedule::Schedule;

/// The shapes of scenes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum BodyShape {
    /// A cylinder about its direction.
    Cylinder,
    /// The half-space below its direction, the normal.
    Plane,
}

/// The elements that feel a body.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum FeltBy {
    /// Nodes alone.
    Nodes,
    /// Edges of the film and segments of cords.
    Edges,
    /// Edges and triangles of the film and segments of cords.
    Triangles,
}

/// Parameters of a body.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BodyParameters {
    /// Its name, which is that of the law.
    pub name: String,
    /// Its shape.
    pub shape: BodyShape,
    /// Of a cylinder \[m\].
    pub radius: Option<f64>,
    /// Of a cylinder with round ends \[m\]; `None`: endless.
    pub half_length: Option<f64>,
    /// A point of the axis, the middle of a cylinder with ends, or a point of the plane \[m\].
    pub centre: [f64; 3],
    /// Of the axis, or of the normal.
    pub direction: [f64; 3],
    /// Number of equal bodies, turned evenly about the axis of the hub.
    pub copies: f64,
    /// About the axis of the hub \[rad\].
    pub turn: Option<Schedule>,
    /// Along x, before the turn \[m\].
    pub travel_x: Option<Schedule>,
    /// Along y \[m\].
    pub travel_y: Option<Schedule>,
    /// Along z \[m\].
    pub travel_z: Option<Schedule>,
    /// Away from the axis of the hub \[m\].
    pub travel_radial: Option<Schedule>,
    /// About the horizontal through the centre, across its azimuth \[rad\].
    pub tilt: Option<Schedule>,
    /// About its own axis \[rad\].
    pub spin: Option<Schedule>,
    /// k of each element \[N/m\].
    pub stiffness: f64,
    /// Damping ratio of an approach.
    pub damping: f64,
    /// Friction coefficient.
    pub friction: f64,
    /// e, the speed of sliding at which friction is 0.7 of its full value \[m/s\].
    pub friction_speed: f64,
    /// What feels it.
    pub felt_by: FeltBy,
    /// Whether the membrane feels it.
    pub membrane: bool,
    /// Whether cords feel it.
    pub cords: bool,
}

impl BodyParameters {
    /// A cylinder of radius 1 cm just below z = 0, which moves in all ways, for tests.
    pub(in crate::laws) fn moving_cylinder() -> Self {
        let schedule = |values: [f64; 2]| Schedule::new(vec![0.0, 1.0], values.to_vec(), 0.2).ok();
        Self {
            name: "body".to_owned(),
            shape: BodyShape::Cylinder,
            radius: Some(0.01),
            half_length: Some(0.03),
            centre: [0.02, 0.015, -0.0095],
            direction: [0.1, 1.0, 0.01],
            copies: 2.0,
            turn: schedule([-0.02, 0.02]),
            travel_x: schedule([0.0, 0.002]),
            travel_y: schedule([0.001, 0.0]),
            travel_z: schedule([0.0, 0.0004]),
            travel_radial: schedule([-0.001, 0.001]),
            tilt: schedule([0.0, 0.01]),
            spin: schedule([0.0, 5.0]),
            stiffness: 200.0,
            damping: 0.1,
            friction: 0.3,
            friction_speed: 0.1,
            felt_by: FeltBy::Edges,
            membrane: true,
            cords: true,
        }
    }

    /// The elements: a half-space is felt exactly by nodes.
    pub(super) fn elements(&self) -> FeltBy {
        if self.shape == BodyShape::Plane { FeltBy::Nodes } else { self.felt_by }
    }

    /// Checks the parameters, and gives body and elements.
    pub(in crate::laws) fn contacts(&self, context: &Context<'_>) -> Result<Contacts> {
        positive("stiffness of a body [N/m]", self.stiffness)?;
        non_negative("damping ratio of a body", self.damping)?;
        non_negative("friction coefficient of a body", self.friction)?;
        positive("friction speed of a body [m/s]", self.friction_speed)?;
        let shape = match self.shape {
            BodyShape::Plane => Shape::Plane,
            BodyShape::Cylinder => {
                let radius = self.radius.unwrap_or_default();
                positive("radius of a body [m]", radius)?;
                self.half_length.map_or(Ok(()), |half| positive("half-length of a body [m]", half))?;
                Shape::Cylinder { radius, ends: self.half_length.map_or(Ends::None, Ends::Round) }
            }
        };
        let body = RigidBody::new(Motion {
            centre: self.centre,
            direction: self.direction,
            copies: self.copies,
            turn: self.turn.clone(),
            travel: [self.travel_x.clone(), self.travel_y.clone(), self.travel_z.clone()],
            travel_radial: self.travel_radial.clone(),
            tilt: self.tilt.clone(),
            spin: self.spin.clone(),
        })?;
        let candidates = candidates_of(self, context.assembly);
        Ok(Contacts::new(shape, body, candidates, context.assembly))
    }
}
