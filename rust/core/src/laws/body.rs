//! Contact with a rigid body of prescribed motion, by a penalty on nodes, edges or triangles.
//!
//!     U = k/2 sum of m d^2   [J]      over the contacts of all elements, depth d and share m by `bodies::shape`
//!     F_i = k m d w_i n - dm/dx_i (U_nearest - (U_a + U_b)/2)   [N]      second term: nearly parallel edges
//!
//! Every element is one contact: where a node is the nearest point of several edges, as in a corner that is bent round
//! the body, each of them presses it.
//!
//! U depends on time through the motion of the body. It does not change where the film moves with the body, hence
//!
//!     dU/dt at rest = sum of F_i . v(x_i)   [W]      v: velocity of the body at the node
//!
//! which is the power that the body puts in.
//!
//! Deep inside, the force might push a node out on the other side. So depth has a bound, half of the radius, and so has
//! the depth to which a step dips in that starts and ends outside, a twentieth of it: see `path`.
//!
//! Stiffness for the limit of the step: every element in contact with one copy at a time. For an edge k (w w^T) with
//! w1 + w2 = 1 is at most k on each of its nodes; a triangle may touch both ends of a cylinder. That the place of
//! contact moves with the nodes adds to this, for what is in contact: see `present`.

mod contacts;
mod parameters;
mod path;
mod present;

pub(super) use self::contacts::{Contacts, Visitor, corners};
pub use self::parameters::{BodyParameters, BodyShape, FeltBy};
use self::path::Path;
use self::present::Present;
use super::{
    Context, Excess, HistoryDependent, Inspection, Instant, Kernels, Law, LawParameters, Linearisation, Properties,
    WorkClass,
};
use crate::arrays::history::History;
use crate::arrays::jacobian::{Block, JacobianBlocks};
use crate::arrays::state::{NodeVectors, columns, columns_mut};
use crate::bodies::near::Candidates;
use crate::bodies::real::{Jet, Real, Vector, product, scaled, sum};
use crate::bodies::rigid_body::Pose;
use crate::bodies::shape::Shape;
use crate::error::Result;
use crate::model::names;

const REMEDY: &str =
    "use a smaller dt, a stiffer body where the film sinks into it, or a softer one where it sets the step";

impl LawParameters for BodyParameters {
    fn build(&self, context: &Context<'_>) -> Result<Box<dyn Law>> {
        let (name, contacts) = (names::kept(&self.name)?, self.contacts(context)?);
        let label = names::kept(&format!("the body {name}"))?;
        Ok(Box::new(BodyContact::new([name, label, REMEDY], contacts, self.stiffness)))
    }

    fn example() -> Self {
        Self::moving_cylinder()
    }
}

/// The law.
pub(super) struct BodyContact {
    name: &'static str,
    remedy: &'static str,
    contacts: Contacts,
    stiffness: f64,
    path: Path,
}

impl BodyContact {
    /// Of a name, the words for the body in messages, and a remedy.
    pub(super) fn new([name, label, remedy]: [&'static str; 3], contacts: Contacts, stiffness: f64) -> Self {
        Self { name, remedy, path: Path::new(label, &contacts.shape), contacts, stiffness }
    }

    /// The forces on an element by one copy \[N\].
    #[inline(always)]
    fn forces<T: Real, const K: usize>(&self, pose: &Pose, x: &[Vector<T>; K]) -> Option<[Vector<T>; K]> {
        let touches = self.contacts.shape.touches(pose, x);
        touches.all[0]?;
        let (zero, stiffness) = (T::of(0.0), T::of(self.stiffness));
        let mut forces = [[zero; 3]; K];
        for touch in touches.all.iter().flatten() {
            let size = touch.share * stiffness * touch.depth;
            for (force, weight) in forces.iter_mut().zip(touch.weights) {
                *force = sum(*force, scaled(size * weight, touch.normal));
            }
        }
        if let Some(slope) = touches.share_slope {
            let square = |k: usize| touches.all[k].map_or(zero, |touch| touch.depth * touch.depth);
            let half = T::of(0.5);
            let excess = half * stiffness * (square(0) - half * (square(1) + square(2)));
            forces[0] = sum(forces[0], scaled(excess, slope));
            forces[K - 1] = sum(forces[K - 1], scaled(-excess, slope));
        }
        Some(forces)
    }

    /// The forces on an element by one copy, with their derivatives by the coordinates of its nodes; N is 3 K.
    fn derived_forces<const K: usize, const N: usize>(
        &self,
        pose: &Pose,
        corners: &[[f64; 3]; K],
    ) -> Option<[Vector<Jet<N>>; K]> {
        self.forces(
            pose,
            &std::array::from_fn(|node| {
                std::array::from_fn(|axis| Jet::variable(corners[node][axis], 3 * node + axis))
            }),
        )
    }

    /// Adds the exact derivatives of the forces on an element; N is 3 K.
    fn add_jacobian_of<const K: usize, const N: usize>(
        &self,
        nodes: [u32; K],
        corners: &[[f64; 3]; K],
        pose: &Pose,
        jacobian: &mut dyn JacobianBlocks,
    ) {
        let Some(forces) = self.derived_forces::<K, N>(pose, corners) else { return };
        for (on, force) in nodes.iter().zip(&forces) {
            for (place, of) in nodes.iter().enumerate() {
                let block = Block::from_fn(|row, column| force[row].slope[3 * place + column]);
                jacobian.by_position(*on, *of, &block);
            }
        }
    }
}

/// Adds forces, and their power on the velocities of the body.
struct Press<'a> {
    law: &'a BodyContact,
    poses: &'a [Pose],
    forces: [&'a mut [f64]; 3],
    power: f64,
    is_moving: bool,
}

impl Visitor for Press<'_> {
    #[inline(always)]
    fn visit<const K: usize>(&mut self, nodes: [u32; K], corners: &[[f64; 3]; K], copy: usize) {
        let pose = &self.poses[copy];
        let Some(forces) = self.law.forces(pose, corners) else { return };
        for (k, &node) in nodes.iter().enumerate() {
            for (column, force) in self.forces.iter_mut().zip(forces[k]) {
                column[node as usize] += force;
            }
            if self.is_moving {
                self.power += product(forces[k], pose.velocity_at(corners[k]));
            }
        }
    }
}

/// The sum of m d^2.
struct Squares<'a> {
    shape: Shape,
    poses: &'a [Pose],
    sum: f64,
}

impl Visitor for Squares<'_> {
    fn visit<const K: usize>(&mut self, _: [u32; K], corners: &[[f64; 3]; K], copy: usize) {
        let touches = self.shape.touches(&self.poses[copy], corners);
        for touch in touches.all.iter().flatten() {
            self.sum += touch.share * (touch.depth * touch.depth);
        }
    }
}

/// Adds the Jacobian of each element.
struct Derive<'a> {
    law: &'a BodyContact,
    poses: &'a [Pose],
    jacobian: &'a mut dyn JacobianBlocks,
}

impl Visitor for Derive<'_> {
    fn visit<const K: usize>(&mut self, nodes: [u32; K], corners: &[[f64; 3]; K], copy: usize) {
        let pose = &self.poses[copy];
        match K {
            1 => {
                if let Some(block) = self.law.contacts.shape.derivative_at(pose, corners[0], self.law.stiffness) {
                    self.jacobian.by_position(nodes[0], nodes[0], &block);
                }
            }
            2 => self.law.add_jacobian_of::<K, 6>(nodes, corners, pose, self.jacobian),
            _ => self.law.add_jacobian_of::<K, 9>(nodes, corners, pose, self.jacobian),
        }
    }
}

impl Law for BodyContact {
    fn properties(&self) -> Properties {
        Properties {
            name: self.name,
            work_class: WorkClass::Conservative,
            depends_on_velocity: false,
            is_internal: false,
        }
    }

    fn kernels(&self) -> Kernels {
        Kernels::of_elements()
    }

    fn add_to_tile(&mut self, tile: usize, at: Instant<'_>, forces: &mut NodeVectors) -> f64 {
        if tile == 0 {
            self.contacts.update(at);
        }
        let is_moving = self.contacts.body.is_moving();
        let (law, poses, forces) = (&*self, &self.contacts.poses[..], columns_mut(forces));
        let mut press = Press { law, poses, forces, power: 0.0, is_moving };
        self.contacts.visit_tile(tile, at.positions, &mut press);
        press.power
    }

    fn jumps(&self) -> Vec<f64> {
        self.contacts.body.jumps()
    }

    fn energy(&self, at: Instant<'_>) -> f64 {
        let poses = self.contacts.poses_at(at);
        // From the zero of sums of numbers.
        let mut squares = Squares { shape: self.contacts.shape, poses: &poses, sum: -0.0 };
        self.contacts.visit_all(at.positions, &poses, &mut squares);
        0.5 * self.stiffness * squares.sum
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
        self.remedy
    }
}

impl Inspection for BodyContact {
    fn first_excess(&self, at: Instant<'_>) -> Option<Excess> {
        self.path.first_excess(&self.contacts, at)
    }

    fn is_contact_with_hub(&self) -> bool {
        true
    }
}

impl HistoryDependent for BodyContact {
    fn begin(&mut self, at: Instant<'_>) {
        self.path.begin(&self.contacts, at);
    }

    fn restart_paths(&mut self, at: Instant<'_>) {
        self.path.restart(&self.contacts, at);
    }

    fn accept(&mut self, at: Instant<'_>) {
        self.path.accept(&mut self.contacts, at);
    }

    fn is_at_fault(&self) -> bool {
        self.path.is_at_fault()
    }

    fn history(&self) -> History {
        self.path.history()
    }

    fn restore_history(&mut self, history: History) -> bool {
        self.path.restore(history)
    }
}

impl Linearisation for BodyContact {
    fn add_stiffness_product(&self, at: Instant<'_>, p: &NodeVectors, out: &mut NodeVectors) {
        let poses = self.contacts.poses_at(at);
        let (x, p, mut out) = (columns(at.positions), columns(p), columns_mut(out));
        let Candidates { points, edges, triangles } = self.contacts.candidates();
        let shape = &self.contacts.shape;
        let mut add = |node: u32, value: [f64; 3]| {
            for (column, value) in out.iter_mut().zip(value) {
                column[node as usize] += value;
            }
        };
        for &nodes @ [node] in &points.nodes {
            let ([from], [direction]) = (corners(x, nodes), corners(p, nodes));
            add(node, shape.stiffest_product(&poses, from, direction, self.stiffness));
        }
        let mut bound = |nodes: &[u32], stiffness: f64| {
            for &node in nodes {
                let [direction] = corners(p, [node]);
                add(node, scaled(stiffness, shape.bound_of_product(&poses, direction)));
            }
        };
        bound(edges.nodes.as_flattened(), self.stiffness);
        if shape.has_round_ends() {
            bound(triangles.nodes.as_flattened(), 2.0 * self.stiffness);
        }
        self.contacts.visit_all(at.positions, &poses, &mut Present { law: self, poses: &poses, p, out });
    }

    fn visit_couplings(&self, visit: &mut dyn FnMut(&[u32])) {
        let Candidates { edges, triangles, .. } = self.contacts.candidates();
        edges.nodes.iter().for_each(|nodes| visit(nodes));
        triangles.nodes.iter().for_each(|nodes| visit(nodes));
    }

    fn add_jacobian(&self, at: Instant<'_>, jacobian: &mut dyn JacobianBlocks) {
        let poses = self.contacts.poses_at(at);
        self.contacts.visit_all(at.positions, &poses, &mut Derive { law: self, poses: &poses, jacobian });
    }
}
