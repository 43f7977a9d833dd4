//! The oracle: the forces of model 1 by plain loops over elements, in external order, as reference for the results of
//! the kernels and for their times.
//!
//! Careful scalar code: vectors of three contiguous numbers, the parameters of an element together, a spring and its
//! dashpot in one pass, nothing computed twice. It shares no arithmetic with the kernels.
#![allow(dead_code, missing_docs, unreachable_pub)]

mod creases;
mod drag;
mod springs;
pub mod steps;

use membrane_core::assembly::Assembly;
use membrane_core::laws::{DampingParameters, DashpotMass, LawSpec, Limited, RectangleParameters, spin_of};

pub type Vec3 = [f64; 3];

#[inline]
pub fn sub(a: Vec3, b: Vec3) -> Vec3 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline]
pub fn scale(s: f64, a: Vec3) -> Vec3 {
    [s * a[0], s * a[1], s * a[2]]
}

#[inline]
pub fn dot(a: Vec3, b: Vec3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline]
pub fn cross(a: Vec3, b: Vec3) -> Vec3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[inline]
pub fn add(to: &mut Vec3, s: f64, a: Vec3) {
    for axis in 0..3 {
        to[axis] += s * a[axis];
    }
}

/// Positions, velocities and forces of all nodes.
pub struct Motion {
    pub positions: Vec<Vec3>,
    pub velocities: Vec<Vec3>,
    pub forces: Vec<Vec3>,
}

impl Motion {
    /// The motion at the start of a scene.
    pub fn of(assembly: &Assembly) -> Self {
        let (positions, velocities) = (assembly.model.positions.clone(), assembly.model.velocities.clone());
        let forces = vec![[0.0; 3]; positions.len()];
        Self { positions, velocities, forces }
    }
}

/// A scene of springs, dashpots, creases, drag, a turning frame, tethers and a spool.
pub struct Oracle {
    pub springs: Vec<springs::Spring>,
    pub creases: Vec<creases::Crease>,
    pub crease_parameters: creases::Parameters,
    pub triangles: Vec<[u32; 3]>,
    pub masses: Vec<f64>,
    /// rho_air / 12, and angular velocity of the frame relative to the air.
    pub drag: (f64, f64),
    /// Omega and Omega'.
    pub spin: (f64, f64),
    /// Radius and stiffness, and the nodes in contact: held ones have none.
    pub spool: (f64, f64),
    pub contact_nodes: Vec<u32>,
}

/// A part of an evaluation: label, names of its laws, and function.
pub type Part = (&'static str, &'static [&'static str], fn(&Oracle, &mut Motion) -> f64);

impl Oracle {
    pub const PARTS: [Part; 5] = [
        ("springs, tethers and dashpots", &["springs", "tethers", "spring_damping"], Self::add_springs),
        ("creases", &["creases"], Self::add_creases),
        ("drag", &["air_drag"], Self::add_drag),
        ("frame", &["spin"], Self::add_frame),
        ("spool", &["spool_contact"], Self::add_spool),
    ];

    /// The scene of the kernels, with air at rest.
    pub fn new(laws: &[LawSpec], assembly: &Assembly) -> Self {
        let model = &assembly.model;
        let masses = assembly.numbering.external_values(&assembly.masses);
        let mut oracle = Self {
            springs: Vec::new(),
            creases: Vec::new(),
            crease_parameters: creases::Parameters::default(),
            triangles: Vec::new(),
            drag: (0.0, 0.0),
            spin: (0.0, 0.0),
            spool: (0.0, 0.0),
            contact_nodes: model.contacts.nodes.iter().copied().filter(|node| !model.fixed.contains(node)).collect(),
            masses,
        };
        let spin = spin_of(laws);
        (oracle.spin, oracle.drag.1) = ((spin.rate, spin.acceleration), spin.rate);
        let mut damping: DampingParameters = 0.0.into();
        for law in laws {
            match law {
                LawSpec::Springs(parameters) => oracle.springs = springs::film(parameters, assembly),
                LawSpec::Rectangles(RectangleParameters(own)) => oracle.springs = springs::rectangles(own, assembly),
                LawSpec::SpringDamping(parameters) => damping = *parameters,
                LawSpec::Creases(parameters) => {
                    oracle.crease_parameters = creases::Parameters::of(parameters);
                    oracle.creases = creases::all(parameters, assembly);
                }
                LawSpec::AirDrag(parameters) => {
                    oracle.drag.0 = parameters.pressure / (287.0 * parameters.temperature) / 12.0;
                    oracle.triangles.clone_from(&model.triangles);
                }
                LawSpec::Spin(_) => {}
                LawSpec::SpoolContact(parameters) => oracle.spool = (parameters.radius, parameters.stiffness),
                other => unreachable!("the oracle has the laws of model 1, not {other:?}"),
            }
        }
        let edges = oracle.springs.len();
        oracle.springs.extend(springs::cords(assembly));
        for (row, spring) in oracle.springs.iter_mut().enumerate() {
            let [i, j] = spring.nodes.map(|node| oracle.masses[node as usize]);
            let mass = match damping.mass {
                DashpotMass::Mean => 0.5 * (i + j),
                DashpotMass::Reduced => springs::reduced_mass(spring.nodes, [i, j], &model.fixed),
            };
            spring.damping = 2.0 * damping.ratio * (spring.stiffness * mass).sqrt();
            spring.is_limited = match damping.limited {
                Limited::None => false,
                Limited::Cords => row >= edges,
                Limited::All => true,
            };
        }
        oracle
    }

    /// All forces, and the power of dashpots and drag.
    pub fn evaluate(&self, motion: &mut Motion) -> f64 {
        motion.forces.fill([0.0; 3]);
        self.add_springs(motion)
            + self.add_creases(motion)
            + self.add_drag(motion)
            + self.add_frame(motion)
            + self.add_spool(motion)
    }

    /// The turning frame, without the power of its acceleration.
    fn add_frame(&self, motion: &mut Motion) -> f64 {
        let (rate, acceleration) = self.spin;
        let moving = motion.positions.iter().zip(&motion.velocities).zip(&self.masses);
        for ((([x, y, _], [u, v, _]), mass), force) in moving.zip(&mut motion.forces) {
            force[0] += mass * (rate * rate * x + 2.0 * rate * v + acceleration * y);
            force[1] += mass * (rate * rate * y - 2.0 * rate * u - acceleration * x);
        }
        0.0
    }

    /// An infinite spool.
    fn add_spool(&self, motion: &mut Motion) -> f64 {
        let (radius, stiffness) = self.spool;
        for &node in &self.contact_nodes {
            let [x, y, _] = motion.positions[node as usize];
            let r = (x * x + y * y).sqrt();
            if r < radius {
                add(&mut motion.forces[node as usize], stiffness * (radius - r) / r, [x, y, 0.0]);
            }
        }
        0.0
    }
}
