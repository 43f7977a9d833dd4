//! Contact of nodes with the spool, a cylinder about z, by a penalty.
//!
//!     U = k/2 d^2   [J],   d = R - r the depth below the surface, where r < R
//!
//! With a half-height Z the cylinder ends at |z| = Z and d = min(R - r, Z - |z|), so that a node may also slip off an
//! end. A force F causes a penetration of F/k. The paper states contact, but not its form.

use serde::Deserialize;

use super::{Context, Instant, Kernels, Law, LawParameters, Linearisation, Properties, WorkClass};
use crate::arrays::blocks::rows_of;
use crate::arrays::jacobian::{Block, JacobianBlocks};
use crate::arrays::state::{NodeVectors, columns, columns_mut};
use crate::assembly::Assembly;
use crate::error::Result;
use crate::model::checks::positive;
use crate::model::mesh::dot;

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
        Ok(Box::new(SpoolContact::new(*self, context.assembly)?))
    }

    fn example() -> Self {
        Self { radius: 0.03, stiffness: 200.0, half_height: Some(0.02), membrane: true }
    }
}

/// The law.
struct SpoolContact {
    parameters: SpoolContactParameters,
    nodes: Vec<u32>,
}

impl SpoolContact {
    fn new(parameters: SpoolContactParameters, assembly: &Assembly) -> Result<Self> {
        positive("radius of the spool [m]", parameters.radius)?;
        positive("stiffness of the spool [N/m]", parameters.stiffness)?;
        if let Some(half_height) = parameters.half_height {
            positive("half-height of the spool [m]", half_height)?;
        }
        let membrane = if parameters.membrane { 0..assembly.mesh.reference.len() as u32 } else { 0..0 };
        let contacts = membrane.chain(assembly.model.contacts.nodes.iter().copied());
        let mut nodes: Vec<u32> = contacts.map(|node| assembly.numbering.to_internal([node])[0]).collect();
        nodes.sort_unstable();
        nodes.dedup();
        Ok(Self { parameters, nodes })
    }

    /// Depth below the nearest surface [m] and its outward unit normal, for a node inside.
    #[inline(always)]
    fn depth(&self, p: [f64; 3]) -> Option<(f64, [f64; 3])> {
        let (square, radius) = (p[0] * p[0] + p[1] * p[1], self.parameters.radius);
        if square >= radius * radius {
            return None;
        }
        let r = square.sqrt();
        let below_side = radius - r;
        let below_end = self.parameters.half_height.map_or(f64::INFINITY, |half| half - p[2].abs());
        if below_side <= 0.0 || below_end <= 0.0 {
            None
        } else if below_end < below_side {
            Some((below_end, [0.0, 0.0, 1.0_f64.copysign(p[2])]))
        } else {
            let r = r.max(f64::MIN_POSITIVE);
            Some((below_side, [p[0] / r, p[1] / r, 0.0]))
        }
    }
}

impl Law for SpoolContact {
    fn properties(&self) -> Properties {
        Properties {
            name: "spool_contact",
            work_class: WorkClass::Conservative,
            depends_on_velocity: false,
            is_internal: false,
        }
    }

    fn kernels(&self) -> Kernels {
        Kernels::of_elements()
    }

    fn add_to_tile(&mut self, tile: usize, at: Instant<'_>, forces: &mut NodeVectors) -> f64 {
        let rows = rows_of(tile, at.positions.nrows());
        let [start, end] = [rows.start, rows.end].map(|row| row as u32);
        // Most tiles have no such node.
        if self.nodes.last().is_none_or(|&last| last < start) || self.nodes[0] >= end {
            return 0.0;
        }
        let [start, end] = [start, end].map(|row| self.nodes.partition_point(|&node| node < row));
        let x = columns(at.positions);
        let mut f = columns_mut(forces);
        for &node in &self.nodes[start..end] {
            if let Some((depth, normal)) = self.depth(point(x, node)) {
                add(&mut f, node, scale(self.parameters.stiffness * depth, normal));
            }
        }
        0.0
    }

    fn energy(&self, at: Instant<'_>) -> f64 {
        let x = columns(at.positions);
        let squares = self.nodes.iter().filter_map(|&node| self.depth(point(x, node))).map(|(depth, _)| depth * depth);
        0.5 * self.parameters.stiffness * squares.sum::<f64>()
    }

    fn linearisation(&self) -> Option<&dyn Linearisation> {
        Some(self)
    }

    fn remedy(&self) -> &'static str {
        "use a smaller dt, a softer spool, or a start outside it"
    }
}

impl Linearisation for SpoolContact {
    /// The stiffness with every node in contact, radially or with an end.
    fn add_stiffness_product(&self, at: Instant<'_>, p: &NodeVectors, out: &mut NodeVectors) {
        let (x, p) = (columns(at.positions), columns(p));
        let mut out = columns_mut(out);
        for &node in &self.nodes {
            let [px, py, _] = point(x, node);
            let r = (px * px + py * py).sqrt().max(f64::MIN_POSITIVE);
            let normal = [px / r, py / r, 0.0];
            let direction = point(p, node);
            let mut product = scale(self.parameters.stiffness * dot(normal, direction), normal);
            if self.parameters.half_height.is_some() {
                product[2] += self.parameters.stiffness * direction[2];
            }
            add(&mut out, node, product);
        }
    }

    /// -k along the normal n; k d/r tangentially on the side, since the normal rotates with the azimuth.
    fn add_jacobian(&self, at: Instant<'_>, jacobian: &mut dyn JacobianBlocks) {
        let x = columns(at.positions);
        for &node in &self.nodes {
            let p = point(x, node);
            let Some((depth, normal)) = self.depth(p) else { continue };
            let n = nalgebra::Vector3::from(normal);
            let mut block = n * n.transpose() * -self.parameters.stiffness;
            if normal[2] == 0.0 {
                let r = (p[0] * p[0] + p[1] * p[1]).sqrt().max(f64::MIN_POSITIVE);
                let across = Block::from_diagonal(&nalgebra::Vector3::new(1.0, 1.0, 0.0)) - n * n.transpose();
                block += across * (self.parameters.stiffness * depth / r);
            }
            jacobian.by_position(node, node, &block);
        }
    }
}

fn point(columns: [&[f64]; 3], node: u32) -> [f64; 3] {
    columns.map(|column| column[node as usize])
}

fn scale(s: f64, a: [f64; 3]) -> [f64; 3] {
    a.map(|component| s * component)
}

fn add(columns: &mut [&mut [f64]; 3], node: u32, value: [f64; 3]) {
    for (column, value) in columns.iter_mut().zip(value) {
        column[node as usize] += value;
    }
}
