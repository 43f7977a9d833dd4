//! Power that is worked out after the forces, on other velocities than those with which these were evaluated: for methods that
//! predict velocities. Concerns laws without potential whose forces depend on velocity; the work of others, on positions alone
//! or with a potential, is taken with the predicted velocities, which costs nothing and keeps the method's order.

use crate::arrays::blocks::ROW_BLOCK;
use crate::arrays::state::NodeVectors;
use crate::integrators::Integrator;
use crate::laws::{Law, Properties, WorkClass};
use crate::simd::lanes::F64x8;

/// How a law's power is deferred.
pub(super) enum Deferral {
    /// What each of its dashpots pulls with over its length \[N/m\], one array for each set of links.
    Pulls(Vec<Vec<F64x8>>),
    /// Its forces by themselves \[N\]: those of one row block of a law node by node whose power is asked for at once, and else all
    /// rows, zero but between the forces and their power.
    Forces(NodeVectors),
}

impl Deferral {
    /// That of each law, for a method.
    pub(super) fn of_laws(laws: &mut [Box<dyn Law>], method: &dyn Integrator, nodes: usize) -> Vec<Option<Self>> {
        // Laws that are told apart by their rate are asked together, after all rows.
        let is_at_once = method.for_slow_laws().is_none();
        let of_law = |law: &mut Box<dyn Law>| {
            let Properties { work_class, depends_on_velocity, .. } = law.properties();
            let is_resolved = work_class == WorkClass::Conservative || !depends_on_velocity;
            if !method.properties().predicts_velocity || is_resolved {
                return None;
            }
            let kernels = law.kernels();
            if law.nodal().is_some() {
                let count = if is_at_once { ROW_BLOCK.min(nodes) } else { nodes };
                Some(Self::Forces(NodeVectors::zeros(count)))
            } else if kernels.elements {
                Some(Self::Forces(NodeVectors::zeros(nodes)))
            } else {
                let pulls = kernels.links.iter().map(|force| vec![F64x8::ZERO; force.links.elements.batch_count()]);
                Some(Self::Pulls(pulls.collect()))
            }
        };
        laws.iter_mut().map(of_law).collect()
    }

    /// The law's forces by themselves, of a law between nodes.
    pub(super) fn forces(&mut self) -> Option<&mut NodeVectors> {
        match self {
            Self::Forces(forces) => Some(forces),
            Self::Pulls(_) => None,
        }
    }
}
