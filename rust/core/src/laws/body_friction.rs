//! Damping of approach and friction at the contacts of a body, beside its penalty.
//!
//! At each contact, with the depth d, the normal n and the shares w_i of the law "body", and the velocity of the film
//! relative to the surface, u = sum of w_i v_i - v_body - (w + spin U) x (p - X):
//!
//!     approach  s = max(0, -n.u),   F_n = m c s d/(d + s/omega) n
//!               c = 2 zeta sqrt(k m_r),   omega = sqrt(k/m_r),   1/m_r = sum of w_i^2/m_i
//!     friction  F_t = -mu N u_t / sqrt(u_t^2 + e^2),   N = m k d + |F_n|,   u_t = u - n (n.u)
//!
//! At first touch F_n grows with the depth, as Hunt and Crossley (1975) ask; once the depth has passed s/omega, that of
//! an impact without damping, it is nearly c s. It never exceeds 2 zeta k d.
//!
//! N is never negative: with the penalty, the contact never pulls. Coulomb's friction is regularised: below the speed e
//! it is viscous, so that what is held creeps. It keeps no data from step to step.
//!
//! Near rest friction is a dashpot of mu N/e: on a node of mass m it needs steps below about 2 m e/(mu N).

use serde::Deserialize;

use super::body::{BodyParameters, Contacts, Visitor, corners};
use super::{Context, Inspection, Instant, Kernels, Law, LawParameters, Linearisation, Properties, WorkClass};
use crate::arrays::jacobian::{Block, JacobianBlocks, at as node_vector};
use crate::arrays::state::{NodeVectors, columns, columns_mut};
use crate::bodies::near::Candidates;
use crate::bodies::real::{Jet, Real, Vector, constant, cross, difference, product, scaled, sum};
use crate::bodies::rigid_body::Pose;
use crate::error::Result;
use crate::model::names;

/// The end of the name of the law, after that of its body.
const SUFFIX: &str = "_friction";

/// Parameters: those of the body.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(transparent)]
pub struct BodyFrictionParameters(pub BodyParameters);

impl LawParameters for BodyFrictionParameters {
    fn build(&self, context: &Context<'_>) -> Result<Box<dyn Law>> {
        let BodyParameters { name, stiffness, damping, friction, friction_speed, .. } = &self.0;
        Ok(Box::new(BodyFriction {
            name: names::kept(&format!("{name}{SUFFIX}"))?,
            contacts: self.0.contacts(context)?,
            stiffness: *stiffness,
            ratio: *damping,
            friction: *friction,
            speed: *friction_speed,
            inverse_masses: context.assembly.inverse_masses.clone(),
        }))
    }

    fn example() -> Self {
        Self(BodyParameters::moving_cylinder())
    }
}

/// The law.
struct BodyFriction {
    name: &'static str,
    contacts: Contacts,
    /// k \[N/m\].
    stiffness: f64,
    /// zeta, mu and e \[m/s\].
    ratio: f64,
    friction: f64,
    speed: f64,
    inverse_masses: Vec<f64>,
}

impl BodyFriction {
    /// The forces on an element by one copy \[N\].
    #[inline(always)]
    fn forces<T: Real, const K: usize>(
        &self,
        pose: &Pose,
        nodes: [u32; K],
        x: &[Vector<T>; K],
        v: impl FnOnce() -> [Vector<T>; K],
    ) -> Option<[Vector<T>; K]> {
        let touches = self.contacts.shape.touches(pose, x);
        touches.all[0]?;
        let (zero, v) = (T::of(0.0), v());
        let mut forces = [[zero; 3]; K];
        for touch in touches.all.iter().flatten() {
            let (mut point, mut velocity, mut inverse_mass) = ([zero; 3], [zero; 3], zero);
            for k in 0..K {
                let weight = touch.weights[k];
                point = sum(point, scaled(weight, x[k]));
                velocity = sum(velocity, scaled(weight, v[k]));
                inverse_mass = inverse_mass + weight * weight * T::of(self.inverse_masses[nodes[k] as usize]);
            }
            let around = cross(constant(pose.surface_rotation()), difference(point, constant(pose.centre)));
            let slip = difference(difference(velocity, constant(pose.velocity)), around);
            let closing = -product(touch.normal, slip);
            let mut damping = zero;
            if closing.value() > 0.0 && inverse_mass.value() > 0.0 {
                // c = 2 zeta k/omega.
                let omega = (T::of(self.stiffness) * inverse_mass).sqrt();
                let depth_of_impact = closing / omega;
                let ramp = touch.depth / (touch.depth + depth_of_impact);
                damping = touch.share * T::of(2.0 * self.ratio * self.stiffness) * depth_of_impact * ramp;
            }
            let along = sum(slip, scaled(closing, touch.normal));
            let speed = (product(along, along) + T::of(self.speed * self.speed)).sqrt();
            let pressure = touch.share * T::of(self.stiffness) * touch.depth + damping;
            let friction = scaled(-T::of(self.friction) * pressure / speed, along);
            let force = sum(scaled(damping, touch.normal), friction);
            for (own, weight) in forces.iter_mut().zip(touch.weights) {
                *own = sum(*own, scaled(weight, force));
            }
        }
        Some(forces)
    }

    /// Adds the exact derivatives of the forces on an element; N is 6 K.
    fn add_jacobian_of<const K: usize, const N: usize>(
        &self,
        nodes: [u32; K],
        x: &[[f64; 3]; K],
        v: &[[f64; 3]; K],
        pose: &Pose,
        jacobian: &mut dyn JacobianBlocks,
    ) {
        let variables = |values: &[[f64; 3]; K], first: usize| -> [Vector<Jet<N>>; K] {
            std::array::from_fn(|node| {
                std::array::from_fn(|axis| Jet::variable(values[node][axis], first + 3 * node + axis))
            })
        };
        let Some(forces) = self.forces(pose, nodes, &variables(x, 0), || variables(v, 3 * K)) else { return };
        for (on, force) in nodes.iter().zip(&forces) {
            for (place, of) in nodes.iter().enumerate() {
                let block = |first: usize| Block::from_fn(|row, column| force[row].slope[first + 3 * place + column]);
                jacobian.by_position(*on, *of, &block(0));
                jacobian.by_velocity(*on, *of, &block(3 * K));
            }
        }
    }
}

/// Adds forces, and their power on the velocities of the film.
struct Rub<'a> {
    law: &'a BodyFriction,
    poses: &'a [Pose],
    velocities: [&'a [f64]; 3],
    forces: [&'a mut [f64]; 3],
    power: f64,
}

impl Visitor for Rub<'_> {
    #[inline(always)]
    fn visit<const K: usize>(&mut self, nodes: [u32; K], x: &[[f64; 3]; K], copy: usize) {
        let v = || corners(self.velocities, nodes);
        let Some(forces) = self.law.forces(&self.poses[copy], nodes, x, v) else { return };
        for (force, (node, v)) in forces.iter().zip(nodes.into_iter().zip(v())) {
            for (column, force) in self.forces.iter_mut().zip(force) {
                column[node as usize] += force;
            }
            self.power += product(*force, v);
        }
    }
}

/// Adds the Jacobian of each element.
struct Derive<'a> {
    law: &'a BodyFriction,
    poses: &'a [Pose],
    velocities: [&'a [f64]; 3],
    jacobian: &'a mut dyn JacobianBlocks,
}

impl Visitor for Derive<'_> {
    fn visit<const K: usize>(&mut self, nodes: [u32; K], x: &[[f64; 3]; K], copy: usize) {
        let (pose, v) = (&self.poses[copy], corners(self.velocities, nodes));
        match K {
            1 => self.law.add_jacobian_of::<K, 6>(nodes, x, &v, pose, self.jacobian),
            2 => self.law.add_jacobian_of::<K, 12>(nodes, x, &v, pose, self.jacobian),
            _ => self.law.add_jacobian_of::<K, 18>(nodes, x, &v, pose, self.jacobian),
        }
    }
}

/// Adds the product of the symmetric part of -dF/dv with a vector.
struct Damp<'a> {
    factor: f64,
    p: &'a NodeVectors,
    out: &'a mut NodeVectors,
}

impl JacobianBlocks for Damp<'_> {
    fn by_position(&mut self, _: u32, _: u32, _: &Block) {}

    fn by_velocity(&mut self, on: u32, of: u32, block: &Block) {
        for (to, from, block) in [(on, of, *block), (of, on, block.transpose())] {
            let product = block * node_vector(self.p, from) * (-0.5 * self.factor);
            for axis in 0..3 {
                self.out[(to as usize, axis)] += product[axis];
            }
        }
    }
}

impl Law for BodyFriction {
    fn properties(&self) -> Properties {
        Properties { name: self.name, work_class: WorkClass::External, depends_on_velocity: true, is_internal: false }
    }

    fn kernels(&self) -> Kernels {
        Kernels::of_elements()
    }

    fn add_to_tile(&mut self, tile: usize, at: Instant<'_>, forces: &mut NodeVectors) -> f64 {
        if tile == 0 {
            self.contacts.update(at);
        }
        let (law, poses) = (&*self, &self.contacts.poses[..]);
        let (velocities, forces) = (columns(at.velocities), columns_mut(forces));
        let mut rub = Rub { law, poses, velocities, forces, power: 0.0 };
        self.contacts.visit_tile(tile, at.positions, &mut rub);
        rub.power
    }

    fn jumps(&self) -> Vec<f64> {
        self.contacts.body.jumps()
    }

    fn linearisation(&self) -> Option<&dyn Linearisation> {
        Some(self)
    }

    fn inspection(&self) -> Option<&dyn Inspection> {
        Some(self)
    }

    fn remedy(&self) -> &'static str {
        "use a smaller dt, less friction or damping, or a larger friction_speed of the body"
    }
}

impl Inspection for BodyFriction {
    fn is_contact_with_hub(&self) -> bool {
        true
    }
}

impl Linearisation for BodyFriction {
    /// That of the present contacts.
    fn add_damping_product(&self, factor: f64, at: Instant<'_>, p: &NodeVectors, out: &mut NodeVectors) {
        self.add_jacobian(at, &mut Damp { factor, p, out });
    }

    fn visit_couplings(&self, visit: &mut dyn FnMut(&[u32])) {
        let Candidates { edges, triangles, .. } = self.contacts.candidates();
        edges.nodes.iter().for_each(|nodes| visit(nodes));
        triangles.nodes.iter().for_each(|nodes| visit(nodes));
    }

    fn add_jacobian(&self, at: Instant<'_>, jacobian: &mut dyn JacobianBlocks) {
        let poses = self.contacts.poses_at(at);
        let velocities = columns(at.velocities);
        let mut derive = Derive { law: self, poses: &poses, velocities, jacobian };
        self.contacts.visit_all(at.positions, &poses, &mut derive);
    }
}
