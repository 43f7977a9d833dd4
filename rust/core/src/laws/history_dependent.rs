//! Laws with a history: their forces depend on the states of earlier steps.

use super::Instant;
use crate::arrays::history::History;
use crate::arrays::state::NodeVectors;

/// A law that keeps data from step to step. Evaluations read them without change, since they also serve steps that are
/// rejected, and forces that are only read.
pub trait HistoryDependent {
    /// Called before each step, with its initial state, which is that of the last `accept` unless the motion was set or
    /// restored. Data that follow from this state need not be part of the history.
    fn begin(&mut self, _at: Instant<'_>) {}

    /// Called where schedules have jumped, with the state after that: no path leads there from the states before.
    fn restart_paths(&mut self, _at: Instant<'_>) {}

    /// Updates the history at the end of a step. It is called once after each accepted step, with the accepted state,
    /// and the new history is that of all later evaluations.
    fn accept(&mut self, at: Instant<'_>);

    /// Called before a state counts as good, for a check that is due soon.
    fn check_before_good(&mut self, _at: Instant<'_>) {}

    /// Called at the end of a run, with its last state, for what is checked now and then.
    fn end(&mut self, _at: Instant<'_>) {}

    /// Whether the last step went beyond a bound of the law, which a later state may not show; `Inspection` tells it.
    fn is_at_fault(&self) -> bool {
        false
    }

    /// Takes over the angles of creases \[rad\], in external order, as those of the present positions, which give them
    /// up to whole turns. Angles of another number of creases are left.
    fn set_crease_angles(&mut self, _angles: &[f64]) {}

    /// Shapes whose distances layers of the film keep.
    fn layer_shapes(&self) -> &[NodeVectors] {
        &[]
    }

    /// Takes over such shapes, of a motion that goes on.
    fn set_layer_shapes(&mut self, _shapes: &[NodeVectors]) {}

    /// Data kept from step to step, saved and restored with the run.
    fn history(&self) -> History;

    /// Continues from a history; an empty one is that of the start. Whether its sizes fit.
    fn restore_history(&mut self, history: History) -> bool;
}
