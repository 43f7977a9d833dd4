//! The histories of the laws, and of a free hub, from step to step.

use super::mechanics::Mechanics;
use crate::arrays::history::History;
use crate::arrays::state::PhasePoint;
use crate::laws::{HistoryDependent, Instant};
use crate::model::hub_motion::HubMotion;

impl Mechanics {
    /// The history of each law; that of the frame is the motion of a free hub.
    pub(crate) fn histories(&self) -> Vec<History> {
        let own = self.laws.iter().map(|law| law.history_dependent());
        let mut histories: Vec<History> =
            own.map(|law| law.map_or_else(History::default, |law| law.history())).collect();
        if let (Some(row), Some(hub)) = (self.hub_row, &self.spin.hub) {
            histories[row].numbers = hub.motion.numbers().to_vec();
        }
        histories
    }

    /// Restores the history of each law, or that of the start where none is given; a free hub then goes on as it moves.
    /// The first law whose history does not fit, if any.
    pub(crate) fn restore_histories(&mut self, histories: &[History]) -> Option<&'static str> {
        let hub_row = self.hub_row;
        if let (Some(row), Some(hub)) = (hub_row, &mut self.spin.hub)
            && let Some(history) = histories.get(row)
        {
            let Some(motion) = HubMotion::from_numbers(&history.numbers) else { return Some(self.laws[row].name()) };
            hub.motion = motion;
        }
        let given = histories.iter().cloned().chain(std::iter::repeat_with(History::default));
        let others = self.laws.iter_mut().zip(given).enumerate().filter(|(row, _)| Some(*row) != hub_row);
        let mut unfit = others.filter_map(|(_, (law, history))| {
            let fits = match law.history_dependent_mut() {
                Some(law) => law.restore_history(history),
                None => history == History::default(),
            };
            (!fits).then(|| law.name())
        });
        unfit.next()
    }

    /// Passes the initial state of a step to each law with a history.
    #[inline]
    pub(crate) fn begin(&mut self, point: PhasePoint<'_>) {
        self.pass(point, |law, at| law.begin(at));
    }

    /// Passes the end of an accepted step to each law with a history.
    #[inline]
    pub(crate) fn accept(&mut self, point: PhasePoint<'_>) {
        self.pass(point, |law, at| law.accept(at));
    }

    /// Passes a state that may count as good to each law with a history.
    pub(crate) fn check_before_good(&mut self, point: PhasePoint<'_>) {
        self.pass(point, |law, at| law.check_before_good(at));
    }

    /// Passes the end of a run to each law with a history.
    pub(crate) fn end(&mut self, point: PhasePoint<'_>) {
        self.pass(point, |law, at| law.end(at));
    }

    /// Passes the state after a jump of schedules to each law with a history.
    pub(crate) fn restart_paths(&mut self, point: PhasePoint<'_>) {
        self.pass(point, |law, at| law.restart_paths(at));
    }

    /// Passes a state to each law with a history.
    #[inline]
    fn pass<'a>(&mut self, point: PhasePoint<'a>, to: impl Fn(&mut dyn HistoryDependent, Instant<'a>)) {
        let at = self.instant(point);
        for &row in &self.history_dependent {
            if let Some(law) = self.laws[row].history_dependent_mut() {
                to(law, at);
            }
        }
    }

    /// Whether a law with a history has found a fault in the last step.
    #[inline]
    pub(crate) fn is_at_fault(&self) -> bool {
        let has_found = |row: &usize| self.laws[*row].history_dependent().is_some_and(|law| law.is_at_fault());
        self.history_dependent.iter().any(has_found)
    }
}
