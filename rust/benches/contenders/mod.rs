//! Model 1's sail at any fineness, ready to be evaluated: by plain scalar loops and by the kernels at each width.
#![allow(dead_code, clippy::unwrap_used, unreachable_pub)]

use std::hint::black_box;
use std::ops::Range;

use membrane_core::forces::{self, Law};
use membrane_core::model::{Assembly, Model};
use membrane_core::state::{Instant, Vectors};
use membrane_core::width::Width;

use crate::common::sail;
use crate::oracle::{Motion, Oracle};

/// The parts of an evaluation, then all of it.
pub const PARTS: usize = Oracle::PARTS.len() + 1;

/// What a part is called.
pub fn label(part: usize) -> &'static str {
    Oracle::PARTS.get(part).map_or("all", |(label, _, _)| label)
}

/// The widths that this machine has.
pub fn widths() -> impl Iterator<Item = Width> {
    Width::ALL.into_iter().filter(|width| width.is_available())
}

/// The sail at one fineness, arranged once for all widths.
pub struct Scene {
    pub assembly: Assembly,
    positions: Vectors,
    velocities: Vectors,
}

impl Scene {
    pub fn new(model: Model) -> Self {
        let assembly = Assembly::new(model, Width::Baseline).unwrap();
        let positions = assembly.layout.gather_vectors(&assembly.model.positions);
        let velocities = assembly.layout.gather_vectors(&assembly.model.velocities);
        Self { assembly, positions, velocities }
    }

    pub fn loops(&self) -> Loops {
        Loops { oracle: Oracle::new(&sail::laws(), &self.assembly), motion: Motion::of(&self.assembly) }
    }

    pub fn kernels(&mut self, width: Width) -> Kernels {
        self.assembly.width = width;
        Kernels::new(&self.assembly)
    }

    pub fn at(&self) -> Instant<'_> {
        Instant { time: 0.0, positions: &self.positions, velocities: &self.velocities }
    }
}

/// The plain loops.
pub struct Loops {
    pub oracle: Oracle,
    motion: Motion,
}

impl Loops {
    pub fn evaluate(&mut self, part: usize) {
        let motion = black_box(&mut self.motion);
        match Oracle::PARTS.get(part) {
            Some((_, _, evaluate)) => evaluate(&self.oracle, motion),
            None => self.oracle.evaluate(motion),
        };
    }
}

/// The kernels at one width.
pub struct Kernels {
    /// Those of each part side by side.
    laws: Vec<Box<dyn Law>>,
    parts: Vec<Range<usize>>,
    forces: Vectors,
    powers: Vec<f64>,
}

impl Kernels {
    fn new(assembly: &Assembly) -> Self {
        let part_of =
            |law: &dyn Law| Oracle::PARTS.iter().position(|(_, names, _)| names.contains(&law.name())).unwrap();
        let mut laws = forces::build(&sail::laws(), assembly).unwrap();
        laws.sort_by_key(|law| part_of(law.as_ref()));
        let first = |part: usize| laws.partition_point(|law| part_of(law.as_ref()) < part);
        let mut parts: Vec<Range<usize>> = (0..PARTS - 1).map(|part| first(part)..first(part + 1)).collect();
        parts.push(0..laws.len());
        Self { parts, forces: Vectors::zeros(assembly.masses.len()), powers: vec![0.0; laws.len()], laws }
    }

    /// The elements of a part, and the lanes that they take up; none for a part that goes node by node.
    pub fn lanes(&self, part: usize) -> [usize; 2] {
        let laws = self.laws[self.parts[part].clone()].iter();
        laws.filter_map(|law| law.lanes()).fold([0, 0], |sum, [elements, lanes]| [sum[0] + elements, sum[1] + lanes])
    }

    /// Adds the forces of a part to what was there: all laws add, so that the time does not depend on it.
    pub fn evaluate(&mut self, part: usize, at: Instant<'_>) {
        let range = self.parts[part].clone();
        if part == PARTS - 1 {
            self.forces.as_mut_slice().fill(0.0);
        }
        let powers = &mut self.powers[range.clone()];
        forces::add_all(&self.laws[range], black_box(at), &mut self.forces, powers);
    }
}
