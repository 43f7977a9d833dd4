//! Contact of nodes with the spool, a cylinder about z, by a penalty.
//!
//!     U = k/2 d^2   [J],   d = R - r the depth below the surface, where r < R
//!
//! With a half-height Z the cylinder ends at |z| = Z and d = min(R - r, Z - |z|), so that a node may also slip off an
//! end. A force F causes a penetration of F/k. The paper states contact, but not its form.
//!
//! The force points to the nearest surface: a node beyond the axis would be pushed out on the other side. So d has a
//! bound, half of min(R, Z). Each step is checked on the straight path of each node: the path may not meet the core,
//! the cylinder in which d exceeds the bound, and may not dip in by more than a twentieth of min(R, Z) where the step
//! starts and ends outside, so that no evaluation need have felt the contact. A node that is in the core at a check
//! stops the run.

use serde::Deserialize;

use super::{
    Context, Excess, HistoryDependent, Inspection, Instant, Kernels, Law, LawParameters, Linearisation, Properties,
    WorkClass,
};
use crate::arrays::blocks::rows_of;
use crate::arrays::history::History;
use crate::arrays::jacobian::{Block, JacobianBlocks};
use crate::arrays::state::{NodeVectors, columns, columns_mut};
use crate::assembly::Assembly;
use crate::error::Result;
use crate::model::checks::positive;
use crate::model::mesh::{dot, sub};

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

/// The bound of the depth, as a share of R, or of Z where that is smaller.
const DEPTH_BOUND: f64 = 0.5;
/// The bound of the depth between the ends of a step that lie outside, likewise.
const UNFELT_BOUND: f64 = 0.05;

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
    /// The bounds of the depth, of all positions, and between the ends of a step that lie outside \[m\].
    bound: f64,
    unfelt_bound: f64,
    /// Position of each of the nodes at the start of the step; empty before the first step.
    last: Vec<[f64; 3]>,
    /// The first node that went beyond the bound, and its depth \[m\].
    passed: Option<(u32, f64)>,
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
        nodes.retain(|&node| assembly.inverse_masses[node as usize] > 0.0);
        nodes.sort_unstable();
        nodes.dedup();
        let size = parameters.half_height.map_or(parameters.radius, |half| half.min(parameters.radius));
        let (bound, unfelt_bound) = (DEPTH_BOUND * size, UNFELT_BOUND * size);
        let last = Vec::with_capacity(nodes.len());
        Ok(Self { parameters, nodes, bound, unfelt_bound, last, passed: None })
    }

    /// Depth of a step on a straight path \[m\] where it goes beyond its bound: that of all positions or, where the
    /// step starts and ends outside, that of steps which the contact has not felt.
    #[inline]
    fn excess(&self, from: [f64; 3], to: [f64; 3]) -> Option<f64> {
        let [square, half] = [dot_xy(sub(to, from), sub(to, from)), dot_xy(from, sub(to, from))];
        let outer = self.parameters.radius - self.unfelt_bound;
        let is_outside = |p: [f64; 3]| dot_xy(p, p) >= outer * outer;
        // Of a path that does not come nearer to the axis and then recede, the ends are its extremes.
        if is_outside(from) && is_outside(to) && (half >= 0.0 || half + square <= 0.0) {
            return None;
        }
        self.depth_in_core(from, to, self.bound).or_else(|| {
            let is_unfelt = self.depth(from).is_none() && self.depth(to).is_none();
            self.depth_in_core(from, to, self.unfelt_bound).filter(|_| is_unfelt)
        })
    }

    /// Depth of a straight path \[m\] in the middle of its part in a core, the cylinder with depths above a bound.
    fn depth_in_core(&self, from: [f64; 3], to: [f64; 3], bound: f64) -> Option<f64> {
        let (path, radius) = (sub(to, from), self.parameters.radius - bound);
        // The part lies between the roots of |p + s d|^2 = radius^2 across the axis, and of |z| = height.
        let [square, half] = [dot_xy(path, path), dot_xy(from, path)];
        let excess = dot_xy(from, from) - radius * radius;
        let mut range = [0.0, 1.0];
        if square > 0.0 {
            let discriminant = half * half - square * excess;
            if discriminant <= 0.0 {
                return None;
            }
            let root = discriminant.sqrt();
            range = [((-half - root) / square).max(0.0), ((-half + root) / square).min(1.0)];
        } else if excess >= 0.0 {
            return None;
        }
        if let Some(height) = self.parameters.half_height.map(|half_height| half_height - bound) {
            if path[2] == 0.0 {
                range[1] = if from[2].abs() < height { range[1] } else { -1.0 };
            } else {
                let [a, b] = [-height, height].map(|end| (end - from[2]) / path[2]);
                range = [range[0].max(a.min(b)), range[1].min(a.max(b))];
            }
        }
        let middle = 0.5 * (range[0] + range[1]);
        let point = [0, 1, 2].map(|axis| from[axis] + middle * path[axis]);
        if range[0] < range[1] { self.depth(point).map(|(depth, _)| depth) } else { None }
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

    fn inspection(&self) -> Option<&dyn Inspection> {
        Some(self)
    }

    fn history_dependent(&self) -> Option<&dyn HistoryDependent> {
        Some(self)
    }

    fn history_dependent_mut(&mut self) -> Option<&mut dyn HistoryDependent> {
        Some(self)
    }

    fn remedy(&self) -> &'static str {
        "use a smaller dt, a stiffer spool where nodes sink into it, or a softer one where it sets the step"
    }
}

impl Inspection for SpoolContact {
    fn first_excess(&self, at: Instant<'_>) -> Option<Excess> {
        let x = columns(at.positions);
        let now = || {
            let depth = |node| self.depth_in_core(point(x, node), point(x, node), self.bound);
            self.nodes.iter().find_map(|&node| Some((node, depth(node)?)))
        };
        let (node, depth) = self.passed.or_else(now)?;
        let what = format!(
            "a node goes {depth:.4e} m deep into the spool, over its bound of {:.4e} m for a node in contact and \
             {:.4e} m within a step, and may come out on another side",
            self.bound, self.unfelt_bound
        );
        Some(Excess { nodes: vec![node], what })
    }

    fn is_contact_with_hub(&self) -> bool {
        true
    }
}

impl HistoryDependent for SpoolContact {
    fn begin(&mut self, at: Instant<'_>) {
        if self.last.is_empty() {
            let x = columns(at.positions);
            self.last.extend(self.nodes.iter().map(|&node| point(x, node)));
        }
    }

    fn accept(&mut self, at: Instant<'_>) {
        let x = columns(at.positions);
        for k in 0..self.last.len() {
            let to = point(x, self.nodes[k]);
            let from = std::mem::replace(&mut self.last[k], to);
            if self.passed.is_none()
                && let Some(depth) = self.excess(from, to)
            {
                self.passed = Some((self.nodes[k], depth));
            }
        }
    }

    fn is_at_fault(&self) -> bool {
        self.passed.is_some()
    }

    /// The node that went beyond the bound, until the next check; positions are those of the state.
    fn history(&self) -> History {
        let numbers = self.passed.map_or_else(Vec::new, |(node, depth)| vec![f64::from(node), depth]);
        History { vectors: Vec::new(), numbers }
    }

    fn restore_history(&mut self, history: History) -> bool {
        self.last.clear();
        self.passed = match history.numbers[..] {
            [node, depth] => self.nodes.iter().find(|&&own| f64::from(own) == node).map(|&own| (own, depth)),
            _ => None,
        };
        history.vectors.is_empty() && history.numbers.len() == 2 * usize::from(self.passed.is_some())
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

/// The product of the components across the axis.
#[inline(always)]
fn dot_xy(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

fn scale(s: f64, a: [f64; 3]) -> [f64; 3] {
    a.map(|component| s * component)
}

fn add(columns: &mut [&mut [f64]; 3], node: u32, value: [f64; 3]) {
    for (column, value) in columns.iter_mut().zip(value) {
        column[node as usize] += value;
    }
}
