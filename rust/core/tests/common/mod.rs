//! Models that the tests share.
#![allow(dead_code, missing_docs, unreachable_pub)]

pub mod sail;

use membrane_core::laws::{
    AirDragParameters, AirMotion, CreaseParameters, LawSpec, Spin, SpoolContactParameters, SpringParameters,
    TriangleParameters,
};
use membrane_core::model::input::{Cord, Film, Model};

/// A small deterministic generator of numbers in -1 .. 1.
pub struct Dice(pub u64);

impl Dice {
    pub fn roll(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    pub fn vectors(&mut self, count: usize, size: f64) -> Vec<[f64; 3]> {
        (0..count).map(|_| [0, 1, 2].map(|_| size * self.roll())).collect()
    }
}

pub const FILM: Film = Film { youngs_modulus: 3.2e9, poisson_ratio: 0.34, density: 1420.0, thickness: 7.5e-6 };

/// `columns` x `rows` squares of side `size`, alternating diagonals, all rows of inner edges creases; a tether, a bridge.
pub fn sheet(columns: usize, rows: usize, size: f64) -> Model {
    let node = |i: usize, j: usize| (j * (columns + 1) + i) as u32;
    let mut reference = Vec::new();
    for j in 0..=rows {
        for i in 0..=columns {
            reference.push([i as f64 * size, j as f64 * size, 0.0]);
        }
    }
    let mut triangles = Vec::new();
    for j in 0..rows {
        for i in 0..columns {
            let [a, b, c, d] = [node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)];
            triangles.extend(if (i + j) % 2 == 0 { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] });
        }
    }
    let creases: Vec<[u32; 2]> =
        (1..rows).flat_map(|j| (0..columns).map(move |i| (i, j))).map(|(i, j)| [node(i, j), node(i + 1, j)]).collect();
    let fold_signs = (0..creases.len()).map(|row| if (row / columns).is_multiple_of(2) { 1.0 } else { -1.0 }).collect();
    let last = reference.len() as u32;
    let mut positions = reference.clone();
    positions.push([-size, 0.0, 0.0]);
    let mut extra_masses = vec![0.0; positions.len()];
    extra_masses[last as usize] = 1e-6;
    Model {
        velocities: vec![[0.0; 3]; positions.len()],
        positions,
        reference,
        triangles,
        film: Some(FILM),
        creases,
        fold_signs,
        extra_masses,
        cords: vec![Cord { nodes: [last, 0], stiffness: 50.0, rest_length: 0.6 * size, strain_limit: 1e9 }],
        bridges: vec![[0, node(columns, rows)]],
        bridge_stiffness: 3.0,
        contact_nodes: vec![last],
        ..Model::default()
    }
}

/// One of every law that a scene can choose; the film is a net of springs.
pub fn every_law() -> Vec<LawSpec> {
    every_law_with(springs())
}

/// The films that a scene chooses from, by name.
pub fn films() -> [(&'static str, LawSpec); 2] {
    [("springs", springs()), ("triangles", triangles())]
}

/// One of every law that a scene can choose, with this film.
pub fn every_law_with(film: LawSpec) -> Vec<LawSpec> {
    vec![
        film,
        LawSpec::SpringDamping(0.02.into()),
        creases(1.0),
        drag(),
        spin(),
        gravity(),
        spool(),
        LawSpec::MassDamping(3.0),
    ]
}

pub fn springs() -> LawSpec {
    LawSpec::Springs(SpringParameters {
        buckling: 100.0,
        buckling_on_creases: 1000.0,
        buckling_length: None,
        crease_length: None,
        strain_limit: 1e9,
    })
}

pub fn triangles() -> LawSpec {
    LawSpec::Triangles(TriangleParameters {
        compression: 0.1,
        buckling: 100.0,
        buckling_on_creases: 1000.0,
        buckling_length: None,
        crease_length: None,
        strain_limit: 1e9,
    })
}

pub fn creases(natural_angle: f64) -> LawSpec {
    LawSpec::Creases(CreaseParameters {
        stiffness: 10.0,
        contact_penalty: 100.0,
        natural_angle,
        length_scale: None,
        collapse: 0.05,
    })
}

pub fn drag() -> LawSpec {
    LawSpec::AirDrag(AirDragParameters { pressure: 1e5, temperature: 293.0, air: AirMotion::Still })
}

pub fn spin() -> LawSpec {
    LawSpec::Spin(Spin { rate: 18.0, acceleration: -2.0 })
}

pub fn gravity() -> LawSpec {
    LawSpec::Gravity([1.0, -2.0, -9.81])
}

pub fn spool() -> LawSpec {
    LawSpec::SpoolContact(SpoolContactParameters {
        radius: 0.03,
        stiffness: 200.0,
        half_height: Some(0.02),
        membrane: true,
    })
}
