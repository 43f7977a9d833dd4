//! What contact keeps from step to step: shapes whose distances count, and the impulses of the last step.

use super::surface::Pair;
use super::{FIRST_SHAPE, SelfContact};
use crate::arrays::history::History;
use crate::arrays::state::NodeVectors;
use crate::laws::{HistoryDependent, Instant};

/// Numbers of a pair in a history.
const NUMBERS: usize = 4;
/// Most steps of a history, which are whole as a double.
const MOST_STEPS: f64 = 1e15;
/// Most doublings of the steps after which a shape counts, of a run of that many steps.
const MOST_DOUBLINGS: usize = 39;

impl HistoryDependent for SelfContact {
    fn begin(&mut self, at: Instant<'_>) {
        if self.shapes.is_empty() {
            self.shapes.push(at.positions.clone());
            self.lists.forget();
        }
    }

    fn accept(&mut self, at: Instant<'_>) {
        self.steps += 1;
        if self.steps.is_multiple_of(FIRST_SHAPE) && (self.steps / FIRST_SHAPE).is_power_of_two() {
            self.shapes.push(at.positions.clone());
            self.lists.forget();
        }
        if self.steps.is_multiple_of(self.interval) || self.early_check.is_some_and(|due| due <= self.steps) {
            self.check_crossings(at.positions);
        }
    }

    fn check_before_good(&mut self, at: Instant<'_>) {
        if self.early_check.is_some() {
            self.check_crossings(at.positions);
        }
    }

    fn end(&mut self, at: Instant<'_>) {
        self.check_crossings(at.positions);
    }

    fn layer_shapes(&self) -> &[NodeVectors] {
        &self.shapes
    }

    fn set_layer_shapes(&mut self, shapes: &[NodeVectors]) {
        self.shapes = shapes.to_vec();
        // As many steps as there are shapes for, so that restarts add no more than a long run has.
        self.steps = shapes.len().checked_sub(2).map_or(0, |doublings| FIRST_SHAPE << doublings.min(MOST_DOUBLINGS));
        self.lists.forget();
    }

    fn is_at_fault(&self) -> bool {
        self.fault.is_some()
    }

    fn history(&self) -> History {
        if self.shapes.is_empty() {
            return History::default();
        }
        let numbers = self.pressed.iter().flat_map(|&(pair, pressed)| {
            let [first, second] = pair.parts();
            let first = if pair.has_edges() { first } else { self.numbering.to_external(first) };
            [f64::from(u8::from(pair.has_edges())), first as f64, second as f64, pressed]
        });
        let counts = [self.steps, self.early_check.unwrap_or(0)].map(|count| count as f64);
        History { vectors: self.shapes.clone(), numbers: counts.into_iter().chain(numbers).collect() }
    }

    fn restore_history(&mut self, history: History) -> bool {
        let History { vectors, numbers } = history;
        (self.fault, self.early_check) = (None, None);
        if self.shapes != vectors {
            self.lists.forget();
        }
        let Some((&counts, pairs)) = numbers.split_first_chunk::<2>() else {
            let is_start = vectors.is_empty() && numbers.is_empty();
            (self.steps, self.shapes) = (0, vectors);
            self.pressed.clear();
            return is_start;
        };
        let are_counts = counts.iter().all(|count| (0.0..=MOST_STEPS).contains(count));
        if vectors.is_empty() || !pairs.len().is_multiple_of(NUMBERS) || !are_counts {
            return false;
        }
        let pair_of = |numbers: &[f64]| {
            let [kind, first, second, pressed] = *numbers.first_chunk::<NUMBERS>()?;
            let is_in = |value: f64, count: usize| value >= 0.0 && value < count as f64;
            let pair = if kind == 1.0 {
                let count = self.surface.edges.len();
                (is_in(first, count) && is_in(second, count)).then(|| Pair::of_edges(first as u32, second as u32))
            } else {
                let is_known = is_in(first, self.masses.len()) && is_in(second, self.surface.triangles.len());
                is_known.then(|| Pair::of_node(self.numbering.to_internal([first as u32])[0], second as u32))
            };
            pair.zip((0.0..f64::INFINITY).contains(&pressed).then_some(pressed))
        };
        let Some(pressed) = pairs.chunks(NUMBERS).map(pair_of).collect::<Option<Vec<_>>>() else { return false };
        let [steps, due] = counts.map(|count| count as u64);
        (self.steps, self.early_check, self.shapes, self.pressed) = (steps, (due > 0).then_some(due), vectors, pressed);
        self.pressed.sort_unstable_by_key(|(pair, _)| *pair);
        true
    }
}
