//! Models common to the tests.
#![allow(dead_code, missing_docs, unreachable_pub)]

pub mod patches;
pub mod sail;
pub mod toys;

use membrane_core::arrays::state::{NodeVectors, State};
use membrane_core::assembly::Assembly;
use membrane_core::evaluation::plan::Plan;
use membrane_core::integrators::{METHODS, Method};
use membrane_core::laws::{
    self, BendingForm, BendingParameters, CreaseParameters, DampingParameters, DashpotMass, FilmElements,
    GravityParameters, Instant, Law, LawSpec, Limited, SpinParameters,
};
use membrane_core::model::frame::Spin;
use membrane_core::model::input::{Bridges, ContactSet, Cord, Creases, Film, Model};
use membrane_core::simd::dispatch::InstructionSet;
use membrane_core::simulation::{Settings, Setup, Simulation};

/// A deterministic generator of random numbers in -1 .. 1.
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

/// `columns` x `rows` squares of side `size` with alternating diagonals, creases on all inner rows, tether, bridge.
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
    let lines: Vec<[u32; 2]> =
        (1..rows).flat_map(|j| (0..columns).map(move |i| (i, j))).map(|(i, j)| [node(i, j), node(i + 1, j)]).collect();
    let fold_signs = (0..lines.len()).map(|row| if (row / columns).is_multiple_of(2) { 1.0 } else { -1.0 }).collect();
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
        creases: Creases { nodes: lines, fold_signs, ..Creases::default() },
        extra_masses,
        cords: vec![Cord { nodes: [last, 0], stiffness: 50.0, rest_length: 0.6 * size, strain_limit: 1e9 }],
        bridges: Bridges { nodes: vec![[0, node(columns, rows)]], stiffness: 3.0 },
        contacts: ContactSet { nodes: vec![last] },
        loaded: vec![3, 1],
        ..Model::default()
    }
}

/// One of every law in the list, with a film of springs.
pub fn every_law() -> Vec<LawSpec> {
    every_law_with(film(FilmElements::Links))
}

/// The laws in the list for the elasticity of the film.
pub fn films() -> impl Iterator<Item = LawSpec> {
    LawSpec::examples().into_iter().filter(|law| law.film().is_some())
}

/// The law of a film of these elements.
pub fn film(elements: FilmElements) -> LawSpec {
    films().find(|law| law.film() == Some(elements)).unwrap()
}

/// Whether a law acts by impulses, for which not every method has kicks.
pub fn acts_by_impulses(law: &LawSpec) -> bool {
    matches!(law, LawSpec::SelfContact(_))
}

/// One of every law of force in the list, with this film.
pub fn every_law_with(film: LawSpec) -> Vec<LawSpec> {
    let others = LawSpec::examples().into_iter().filter(|law| law.film().is_none() && !acts_by_impulses(law));
    [film].into_iter().chain(others).collect()
}

/// One of every law in the list, and bending in its other form.
pub fn every_form() -> impl Iterator<Item = LawSpec> {
    LawSpec::examples().into_iter().flat_map(|law| match law {
        LawSpec::Bending(parameters) => vec![law, bending_by_hinges(parameters)],
        _ => vec![law],
    })
}

fn bending_by_hinges(parameters: BendingParameters) -> LawSpec {
    BendingParameters { form: BendingForm::Hinges, ..parameters }.into()
}

/// One of every law in the list with each film, with bending by hinges, and with dashpots that are all limited and
/// mostly at their limit.
pub fn law_sets() -> impl Iterator<Item = Vec<LawSpec>> {
    films().map(every_law_with).chain([every_law_with_hinges(), every_law_with_limited_dashpots()])
}

/// One of every law in the list, with a film of springs and bending by hinges.
pub fn every_law_with_hinges() -> Vec<LawSpec> {
    let mut laws = every_law();
    for law in &mut laws {
        if let LawSpec::Bending(parameters) = *law {
            *law = bending_by_hinges(parameters);
        }
    }
    laws
}

/// One of every law in the list, with a film of springs whose dashpots are limited, and strong.
pub fn every_law_with_limited_dashpots() -> Vec<LawSpec> {
    let mut laws = every_law();
    for law in &mut laws {
        if let LawSpec::SpringDamping(parameters) = law {
            let (ratio, mass, limited) = (2.0, DashpotMass::Reduced, Limited::All);
            *parameters = DampingParameters { ratio, mass, limited, ..*parameters };
        }
    }
    laws
}

pub fn springs() -> LawSpec {
    film(FilmElements::Links)
}

pub fn creases(natural_angle: f64) -> LawSpec {
    LawSpec::examples()
        .into_iter()
        .find_map(|law| match law {
            LawSpec::Creases(parameters) => Some(LawSpec::Creases(CreaseParameters { natural_angle, ..parameters })),
            _ => None,
        })
        .unwrap()
}

/// A hub with an angular velocity `rate` \[rad/s\] and an angular acceleration \[rad/s2\].
pub fn spin(rate: f64, acceleration: f64) -> LawSpec {
    use std::f64::consts::TAU;
    SpinParameters { frequency: rate / TAU, acceleration: acceleration / TAU, ..SpinParameters::default() }.into()
}

pub fn gravity(acceleration: [f64; 3]) -> LawSpec {
    GravityParameters { acceleration, ..Default::default() }.into()
}

/// The methods in the list, and one outside it.
pub fn methods() -> impl Iterator<Item = Method> {
    METHODS.iter().copied().chain([toys::SEMI_IMPLICIT_EULER])
}

/// A scene with these laws and `more` laws outside the list, by any method.
pub fn simulation_of(
    model: Model,
    specs: &[LawSpec],
    method: Method,
    dt: Option<f64>,
    settings: Settings,
    more: fn(&Assembly) -> Vec<Box<dyn Law>>,
) -> Simulation {
    let assembly = Assembly::new(model, settings.instructions).unwrap();
    let mut laws = laws::build(specs, &assembly).unwrap();
    laws.extend(more(&assembly));
    Simulation::with(Setup { assembly, laws, spin: laws::spin_of(specs), method, dt, limit: None }, settings).unwrap()
}

/// A model with its laws in a given state, for tests of single laws.
pub struct Bench {
    pub assembly: Assembly,
    pub laws: Vec<Box<dyn Law>>,
    pub spin: Spin,
    pub time: f64,
    pub state: State,
}

impl Bench {
    pub fn new(model: Model, specs: &[LawSpec]) -> Self {
        let assembly = Assembly::new(model, InstructionSet::widest()).unwrap();
        // A law outside the list works wherever those in the list do.
        let mut laws = laws::build(specs, &assembly).unwrap();
        laws.push(Box::new(toys::WearingFriction::new(&assembly)));
        let internal = |rows: &[[f64; 3]]| assembly.numbering.internal_vectors(rows);
        let state =
            State { positions: internal(&assembly.model.positions), velocities: internal(&assembly.model.velocities) };
        Self { laws, spin: laws::spin_of(specs), time: 0.3, state, assembly }
    }

    /// A sheet of 4 x 3 squares of 1 cm with random displacements of `size`, in motion, with these laws.
    pub fn crumpled(specs: &[LawSpec], seed: u64, size: f64) -> Self {
        let mut dice = Dice(seed);
        let mut model = sheet(4, 3, 0.01);
        for (point, kick) in model.positions.iter_mut().zip(dice.vectors(100, size)) {
            (0..3).for_each(|axis| point[axis] += kick[axis]);
        }
        model.velocities = dice.vectors(model.positions.len(), 1.0);
        Self::new(model, specs)
    }

    /// The same with regions and creases of their own properties.
    pub fn patched(specs: &[LawSpec], seed: u64, size: f64) -> Self {
        let Self { assembly, .. } = Self::crumpled(specs, seed, size);
        Self::new(patches::patched(assembly.model), specs)
    }

    /// Forces \[N\] and power \[W\] of one law in a state.
    pub fn evaluate(&mut self, row: usize, time: f64, state: &State) -> (NodeVectors, f64) {
        let (mut forces, mut powers) = (NodeVectors::zeros(state.positions.nrows()), vec![0.0; self.laws.len()]);
        let at = Instant::new(state.at(time), &self.spin);
        let plan = Plan::new(&mut self.laws);
        plan.add_selected(&mut self.laws, |other| other == row, at, &mut forces, &mut powers);
        (forces, powers[row])
    }

    pub fn instant(&self) -> Instant<'_> {
        Instant::new(self.state.at(self.time), &self.spin)
    }

    /// Random vectors, one per node.
    pub fn vectors(&self, seed: u64, size: f64) -> NodeVectors {
        self.assembly.numbering.internal_vectors(&Dice(seed).vectors(self.state.positions.nrows(), size))
    }
}
