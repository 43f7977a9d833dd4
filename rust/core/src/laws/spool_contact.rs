//! Contact of nodes with the spool: a body at rest, a cylinder about z, by the law of `body`.
//!
//!     U = k/2 d^2   [J],   d = R - r the depth below the surface, where r < R
//!
//! With a half-height Z the cylinder has flat ends at |z| = Z and d = min(R - r, Z - |z|), so that a node may also slip
//! off an end. A force F causes a penetration of F/k. The paper states contact, but not its form.

use serde::Deserialize;

use super::body::{BodyContact, Contacts};
use super::{Context, Law, LawParameters};
use crate::bodies::near::{Candidates, Elements};
use crate::bodies::rigid_body::{Motion, RigidBody};
use crate::bodies::shape::{Ends, Shape};
use crate::error::Result;
use crate::model::checks::positive;

/// Parameters of the spool.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpoolContactParameters {
    /// R \[m\].
    pub radius: f64,
    /// k \[N/m\].
    pub stiffness: f64,
    /// Z; `None`: an infinite cylinder \[m\].
    pub half_height: Option<f64>,
    /// Whether the nodes of the membrane have contact too.
    pub membrane: bool,
}

impl LawParameters for SpoolContactParameters {
    fn build(&self, context: &Context<'_>) -> Result<Box<dyn Law>> {
        positive("radius of the spool [m]", self.radius)?;
        positive("stiffness of the spool [N/m]", self.stiffness)?;
        if let Some(half_height) = self.half_height {
            positive("half-height of the spool [m]", half_height)?;
        }
        let assembly = context.assembly;
        let membrane = if self.membrane { 0..assembly.mesh.reference.len() as u32 } else { 0..0 };
        let nodes = membrane.chain(assembly.model.contacts.nodes.iter().copied());
        let points = Elements::new(nodes.map(|node| assembly.numbering.to_internal([node])));
        let ends = self.half_height.map_or(Ends::None, Ends::Flat);
        let body = RigidBody::new(Motion { direction: [0.0, 0.0, 1.0], copies: 1.0, ..Motion::default() })?;
        let shape = Shape::Cylinder { radius: self.radius, ends };
        let contacts = Contacts::new(shape, body, Candidates { points, ..Candidates::default() }, assembly);
        let remedy =
            "use a smaller dt, a stiffer spool where nodes sink into it, or a softer one where it sets the step";
        Ok(Box::new(BodyContact::new(["spool_contact", "the spool", remedy], contacts, self.stiffness)))
    }

    fn example() -> Self {
        Self { radius: 0.03, stiffness: 200.0, half_height: Some(0.02), membrane: true }
    }
}
