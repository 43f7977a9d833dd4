//! Deferred power, for methods with predicted velocities: the power of forces on velocities that are known only after
//! the evaluation. It concerns laws without potential whose forces depend on velocity. The power of other laws is
//! evaluated with the predicted velocities, at no cost and without loss of order.
//!
//! Along links it takes a second pass. A method that needs it once in several evaluations has the power on the
//! predicted velocities in the others, at no cost.

use std::ops::Range;

use crate::arrays::blocks::ROW_BLOCK;
use crate::arrays::state::NodeVectors;
use crate::integrators::Integrator;
use crate::laws::{Law, Properties, WorkClass};
use crate::simd::dispatch::InstructionSet;
use crate::simd::lanes::{F64x8, SimdF64};
use crate::simd::map::{Formula, each};

/// Data for the deferred power of a law.
pub(super) enum Deferral {
    /// Resistance per length of each of its dashpots \[N/m\], one array for each set of links.
    Resistances(Vec<Vec<F64x8>>),
    /// Its forces alone \[N\]: of one row block for a nodal law whose power follows at once, else of all rows, which
    /// are zero except between the evaluation of the forces and that of their power.
    Forces(NodeVectors),
}

impl Deferral {
    /// The deferral of each law for a method, if needed.
    pub(super) fn of_laws(laws: &mut [Box<dyn Law>], method: &dyn Integrator, nodes: usize) -> Vec<Option<Self>> {
        // With rate groups the power of nodal laws is evaluated after all rows.
        let is_by_row_block = method.for_slow_laws().is_none();
        let of_law = |law: &mut Box<dyn Law>| {
            let Properties { work_class, depends_on_velocity, .. } = law.properties();
            let is_exempt = work_class == WorkClass::Conservative || !depends_on_velocity;
            if !method.properties().predicts_velocity || is_exempt {
                return None;
            }
            let kernels = law.kernels();
            if law.nodal().is_some() {
                let count = if is_by_row_block { ROW_BLOCK.min(nodes) } else { nodes };
                Some(Self::Forces(NodeVectors::zeros(count)))
            } else if kernels.elements {
                Some(Self::Forces(NodeVectors::zeros(nodes)))
            } else {
                let resistances =
                    kernels.links.iter().map(|force| vec![F64x8::ZERO; force.links.elements.batch_count()]);
                Some(Self::Resistances(resistances.collect()))
            }
        };
        laws.iter_mut().map(of_law).collect()
    }

    /// The forces of the law alone.
    pub(super) fn forces(&mut self) -> Option<&mut NodeVectors> {
        match self {
            Self::Forces(forces) => Some(forces),
            Self::Resistances(_) => None,
        }
    }
}

/// F . v.
struct Power;

impl Formula<6, 0> for Power {
    #[inline(always)]
    fn row<V: SimdF64>(&self, _: [V; 6], _: [V; 0]) -> [V; 0] {
        []
    }

    #[inline(always)]
    fn summand<V: SimdF64>(&self, [fx, fy, fz, vx, vy, vz]: [V; 6], _: [V; 0]) -> V {
        fx * vx + fy * vy + fz * vz
    }
}

/// Laws with power whose forces do not depend on velocity; not that of moved nodes, which impulses leave.
pub(super) fn steady_loads(laws: &[Box<dyn Law>]) -> Vec<usize> {
    let is_steady = |law: &dyn Law| {
        let properties = law.properties();
        properties.work_class == WorkClass::External && !properties.depends_on_velocity && law.moved().is_none()
    };
    (0..laws.len()).filter(|&row| is_steady(laws[row].as_ref())).collect()
}

/// The rows of a row block in an array of the forces on all nodes, or on one row block.
pub(super) fn place_of(range: &Range<usize>, forces: &NodeVectors, nodes: usize) -> Range<usize> {
    if forces.nrows() < nodes { 0..range.len() } else { range.clone() }
}

/// The sum of F . v over some rows \[W\].
pub(super) fn power_of(instructions: InstructionSet, [fx, fy, fz]: [&[f64]; 3], [u, v, w]: [&[f64]; 3]) -> f64 {
    each(instructions, &Power, [fx, fy, fz, u, v, w], [])
}
