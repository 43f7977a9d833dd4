//! The sail of model 1 at any fineness, for evaluation by plain scalar loops and by the kernels at each width.
#![allow(dead_code, clippy::unwrap_used, unreachable_pub)]

use std::hint::black_box;

use membrane_core::arrays::state::{NodeVectors, State};
use membrane_core::assembly::Assembly;
use membrane_core::evaluation::plan::Plan;
use membrane_core::laws::{self, Instant, Law};
use membrane_core::model::frame::Spin;
use membrane_core::model::input::Model;
use membrane_core::simd::dispatch::InstructionSet;

use crate::common::sail;
use crate::oracle::{Motion, Oracle};

/// Number of parts of an evaluation, with all of it as the last.
pub const PARTS: usize = Oracle::PARTS.len() + 1;

/// The label of a part.
pub fn label(part: usize) -> &'static str {
    Oracle::PARTS.get(part).map_or("all", |(label, _, _)| label)
}

/// The instruction sets of this machine.
pub fn widths() -> impl Iterator<Item = InstructionSet> {
    InstructionSet::ALL.into_iter().filter(|instructions| instructions.is_available())
}

/// The sail at one fineness, assembled once for all instruction sets.
pub struct Scene {
    pub assembly: Assembly,
    state: State,
    spin: Spin,
}

impl Scene {
    pub fn new(model: Model) -> Self {
        let assembly = Assembly::new(model, InstructionSet::Baseline).unwrap();
        let positions = assembly.numbering.internal_vectors(&assembly.model.positions);
        let velocities = assembly.numbering.internal_vectors(&assembly.model.velocities);
        Self { assembly, state: State { positions, velocities }, spin: laws::spin_of(&sail::laws()) }
    }

    pub fn loops(&self) -> Loops {
        Loops { oracle: Oracle::new(&sail::laws(), &self.assembly), motion: Motion::of(&self.assembly) }
    }

    pub fn kernels(&mut self, instructions: InstructionSet) -> Kernels {
        self.assembly.instructions = instructions;
        Kernels::new(&self.assembly)
    }

    pub fn at(&self) -> Instant<'_> {
        Instant::new(self.state.at(0.0), &self.spin)
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

/// The kernels of each part with one instruction set.
pub struct Kernels {
    parts: Vec<Part>,
    forces: NodeVectors,
}

/// The laws of a part, and their evaluation plan.
struct Part {
    laws: Vec<Box<dyn Law>>,
    plan: Plan,
    powers: Vec<f64>,
}

impl Kernels {
    fn new(assembly: &Assembly) -> Self {
        let parts = (0..PARTS).map(|part| {
            let mut laws = laws::build(&sail::laws(), assembly).unwrap();
            if let Some((_, names, _)) = Oracle::PARTS.get(part) {
                laws.retain(|law| names.contains(&law.name()));
            }
            Part { plan: Plan::new(&mut laws), powers: vec![0.0; laws.len()], laws }
        });
        Self { parts: parts.collect(), forces: NodeVectors::zeros(assembly.masses.len()) }
    }

    /// Number of elements of a part, and of their lanes; zero for a part node by node.
    pub fn lanes(&self, part: usize) -> [usize; 2] {
        let inspected = self.parts[part].laws.iter().filter_map(|law| law.inspection());
        inspected.map(|law| law.lanes()).fold([0, 0], |sum, [elements, lanes]| [sum[0] + elements, sum[1] + lanes])
    }

    /// Adds the forces of a part to those of earlier evaluations, which do not affect the time.
    pub fn evaluate(&mut self, part: usize, at: Instant<'_>) {
        if part == PARTS - 1 {
            self.forces.as_mut_slice().fill(0.0);
        }
        let Part { laws, plan, powers } = &mut self.parts[part];
        plan.add_selected(laws, |_| true, black_box(at), &mut self.forces, powers);
    }
}
