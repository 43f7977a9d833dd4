//! Layers of film that come near each other, and what is measured of them.
#![allow(dead_code, missing_docs, unreachable_pub, clippy::panic)]

use std::convert::Infallible;
use std::ops::{ControlFlow, Range};

use membrane_core::assembly::Assembly;
use membrane_core::contact::{Crossings, crossings};
use membrane_core::elements::link::SpringNetworks;
use membrane_core::error::Result;
use membrane_core::integrators::by_name;
use membrane_core::laws::{Context, LawSpec, Scheme, SelfContact, SelfContactParameters, build, spin_of};
use membrane_core::model::input::Model;
use membrane_core::simulation::{Settings, Setup, Simulation};
use nalgebra::Vector3;

use crate::common::FILM;

pub type Points = Vec<[f64; 3]>;

/// Contact without friction, restitution and regular checks.
pub const PLAIN: SelfContactParameters = SelfContactParameters {
    thickness: None,
    cord_thickness: 1e-5,
    cords: true,
    friction: 0.0,
    restitution: 0.0,
    crossing_interval: 1e9,
    scheme: Scheme::USUAL,
};

/// A scene with contact.
#[derive(Clone)]
pub struct Scene {
    pub model: Model,
    pub specs: Vec<LawSpec>,
    pub contact: SelfContactParameters,
    pub method: &'static str,
    pub dt: Option<f64>,
    pub settings: Settings,
}

impl Scene {
    /// Film without elasticity, in free flight, in steps of 1 us.
    pub fn new() -> Self {
        let settings = Settings { margin: 0.8, ..Settings::default() };
        Self {
            model: Model { film: Some(FILM), ..Model::default() },
            specs: Vec::new(),
            contact: PLAIN,
            method: "leapfrog",
            dt: Some(1e-6),
            settings,
        }
    }

    /// Adds a piece of film that feels the others; its nodes.
    pub fn add(&mut self, points: &[[f64; 3]], triangles: &[[u32; 3]], velocity: [f64; 3]) -> Range<usize> {
        let model = &mut self.model;
        let (first, count) = (model.positions.len() as u32, model.triangles.len());
        model.positions.extend(points);
        model.reference.extend(points);
        model.velocities.extend(points.iter().map(|_| velocity));
        model.extra_masses.extend(points.iter().map(|_| 0.0));
        model.triangles.extend(triangles.iter().map(|nodes| nodes.map(|node| first + node)));
        model.layers.extend(count as u32..model.triangles.len() as u32);
        first as usize..model.positions.len()
    }

    pub fn hold(&mut self, nodes: Range<usize>) {
        self.model.fixed.extend(nodes.map(|node| node as u32));
    }

    /// The simulation; the law of contact is the last but those of cords, bridges and moved nodes.
    pub fn start(&self) -> Result<Simulation> {
        let assembly = Assembly::new(self.model.clone(), self.settings.instructions)?;
        let context = Context { assembly: &assembly, networks: SpringNetworks::default(), specs: &self.specs };
        let law = SelfContact::new(&self.contact, &context)?;
        let mut laws = build(&self.specs, &assembly)?;
        laws.insert(self.specs.len(), Box::new(law));
        let (method, spin) = (by_name(self.method)?, spin_of(&self.specs));
        Simulation::with(Setup { assembly, laws, spin, method, dt: self.dt, limit: None }, self.settings)
    }

    pub fn started(&self) -> Simulation {
        match self.start() {
            Ok(simulation) => simulation,
            Err(error) => panic!("{error}"),
        }
    }

    /// Pairs of layers that cross.
    pub fn crossings(&self, simulation: &Simulation) -> u64 {
        count_crossings(&simulation.positions(), &self.model.triangles)
    }
}

pub fn count_crossings(positions: &[[f64; 3]], triangles: &[[u32; 3]]) -> u64 {
    let pause = || ControlFlow::<Infallible>::Continue(());
    match crossings(positions, triangles, 1, pause) {
        Ok(ControlFlow::Continue(Crossings { count, .. })) => count,
        Err(error) => panic!("{error}"),
    }
}

/// A sheet of cells about the origin, with alternating diagonals.
pub fn square(columns: usize, rows: usize, size: f64) -> (Points, Vec<[u32; 3]>) {
    let sheet = crate::common::sheet(columns, rows, size);
    let (x, y) = (0.5 * size * columns as f64, 0.5 * size * rows as f64);
    (sheet.reference.iter().map(|p| [p[0] - x, p[1] - y, p[2]]).collect(), sheet.triangles)
}

/// An equilateral triangle of a side about the origin.
pub fn triangle(side: f64) -> (Points, Vec<[u32; 3]>) {
    let radius = side / 3.0_f64.sqrt();
    let corner = |k: u32| {
        let angle = std::f64::consts::TAU / 3.0 * f64::from(k);
        [radius * angle.cos(), radius * angle.sin(), 0.0]
    };
    ((0..3).map(corner).collect(), vec![[0, 1, 2]])
}

/// Points turned about x by `tilt`, then about z by `turn`, then moved.
pub fn placed(points: &[[f64; 3]], tilt: f64, turn: f64, shift: [f64; 3]) -> Points {
    let (s, c) = tilt.sin_cos();
    let (sz, cz) = turn.sin_cos();
    let place = |&[x, y, z]: &[f64; 3]| {
        let (y, z) = (c * y - s * z, s * y + c * z);
        [cz * x - sz * y + shift[0], sz * x + cz * y + shift[1], z + shift[2]]
    };
    points.iter().map(place).collect()
}

/// The row of the law of contact.
pub fn row(simulation: &Simulation) -> usize {
    simulation.laws().iter().position(|law| law.name() == "self_contact").unwrap_or(usize::MAX)
}

/// The work of contact \[J\].
pub fn work(simulation: &Simulation) -> f64 {
    simulation.ledger().work[row(simulation)]
}

/// Momentum \[kg m/s\] and angular momentum about the origin \[kg m2/s\].
pub fn momenta(simulation: &Simulation) -> [Vector3<f64>; 2] {
    let (masses, positions, velocities) = (simulation.masses(), simulation.positions(), simulation.velocities());
    let mut sums = [Vector3::zeros(); 2];
    for (mass, (x, v)) in masses.iter().zip(positions.iter().zip(velocities)) {
        let momentum = *mass * Vector3::from(v);
        sums[0] += momentum;
        sums[1] += Vector3::from(*x).cross(&momentum);
    }
    sums
}

/// The mean velocity of some nodes, by mass \[m/s\].
pub fn mean_velocity(simulation: &Simulation, nodes: Range<usize>) -> Vector3<f64> {
    let (masses, velocities) = (simulation.masses(), simulation.velocities());
    let total: f64 = masses[nodes.clone()].iter().sum();
    nodes.map(|node| masses[node] * Vector3::from(velocities[node])).sum::<Vector3<f64>>() / total
}

/// The smallest distance of two groups of triangles, at most `beyond` \[m\].
pub fn least_distance(positions: &[[f64; 3]], first: &[[u32; 3]], second: &[[u32; 3]], beyond: f64) -> f64 {
    let corners = |nodes: &[u32; 3]| nodes.map(|node| Vector3::from(positions[node as usize]));
    let mut least = beyond;
    for one in first.iter().map(corners) {
        let [low, high] = bounds(&one);
        for other in second.iter().map(corners) {
            let [low_of, high_of] = bounds(&other);
            if (0..3).any(|axis| low[axis] - least > high_of[axis] || low_of[axis] - least > high[axis]) {
                continue;
            }
            least = least.min(of_triangles(&one, &other));
        }
    }
    least
}

fn bounds([a, b, c]: &[Vector3<f64>; 3]) -> [Vector3<f64>; 2] {
    [a.inf(b).inf(c), a.sup(b).sup(c)]
}

/// The distance of two triangles that do not cross.
fn of_triangles(first: &[Vector3<f64>; 3], second: &[Vector3<f64>; 3]) -> f64 {
    let mut least = f64::INFINITY;
    for k in 0..3 {
        least = least.min(of_point(first[k], second)).min(of_point(second[k], first));
        for l in 0..3 {
            least = least.min(of_segments([first[k], first[(k + 1) % 3]], [second[l], second[(l + 1) % 3]]));
        }
    }
    least
}

/// The distance of a point and a triangle.
pub fn of_point(point: Vector3<f64>, [a, b, c]: &[Vector3<f64>; 3]) -> f64 {
    let normal = (b - a).cross(&(c - a));
    let is_inside =
        [(a, b), (b, c), (c, a)].iter().all(|(from, to)| (*to - *from).cross(&(point - *from)).dot(&normal) >= 0.0);
    if is_inside && normal.norm() > 0.0 {
        return (point - a).dot(&normal).abs() / normal.norm();
    }
    let side = |from: &Vector3<f64>, to: &Vector3<f64>| of_segments([point, point], [*from, *to]);
    side(a, b).min(side(b, c)).min(side(c, a))
}

/// The distance of two segments: of the lines where that is within both, else of an end and the other segment.
pub fn of_segments([a, b]: [Vector3<f64>; 2], [c, d]: [Vector3<f64>; 2]) -> f64 {
    let of_end = |p: Vector3<f64>, from: Vector3<f64>, to: Vector3<f64>| {
        let along = to - from;
        let share = (p - from).dot(&along) / along.norm_squared();
        (p - from - along * if share.is_finite() { share.clamp(0.0, 1.0) } else { 0.0 }).norm()
    };
    let ends = of_end(a, c, d).min(of_end(b, c, d)).min(of_end(c, a, b)).min(of_end(d, a, b));
    let normal = (b - a).cross(&(d - c));
    let square = normal.norm_squared();
    if square <= 1e-24 * (b - a).norm_squared() * (d - c).norm_squared() {
        return ends;
    }
    let s = (c - a).cross(&(d - c)).dot(&normal) / square;
    let t = (c - a).cross(&(b - a)).dot(&normal) / square;
    let is_inside = (0.0..=1.0).contains(&s) && (0.0..=1.0).contains(&t);
    if is_inside { (c - a).dot(&normal).abs() / square.sqrt() } else { ends }
}
