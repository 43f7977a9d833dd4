//! Checkpoints: the saved data of a run, and its continuation from them.

use super::Simulation;
use crate::arrays::history::History;
use crate::error::{Error, Result};
use crate::evaluation::ledger::Ledger;
use crate::integrators::Controller;
use crate::model::checks::{finite, within};

/// All data that change during a run: from them a run continues with the same bits.
#[derive(Debug, Clone, PartialEq)]
pub struct Progress {
    /// Steps taken.
    pub step_count: u64,
    /// Those of them that were taken before `origin`.
    pub origin_step: u64,
    /// Evaluations of the forces.
    pub evaluation_count: u64,
    /// The time from which steps are counted \[s\]: t = origin + (step_count - origin_step) dt, not a running sum.
    pub origin: f64,
    /// The angle of the hub at t = 0 \[rad\].
    pub hub_phase: f64,
    /// Positions and velocities, in external order.
    pub positions: Vec<[f64; 3]>,
    /// See `positions`.
    pub velocities: Vec<[f64; 3]>,
    /// The ledger.
    pub ledger: Ledger,
    /// The history of the method.
    pub history: SavedHistory,
    /// The history of each law, in their order.
    pub law_histories: Vec<SavedHistory>,
    /// The step control of an adaptive run.
    pub adaptive: Option<AdaptiveProgress>,
    /// The output time, where it is not the end of the last step \[s\]. All other data are those at that end.
    pub output_time: Option<f64>,
}

/// A history with its vectors in external order.
pub type SavedHistory = (Vec<Vec<[f64; 3]>>, Vec<f64>);

/// Saved data of the step control.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AdaptiveProgress {
    /// The time at the end of the last step \[s\].
    pub step_end_time: f64,
    /// The next step.
    pub controller: Controller,
}

impl Simulation {
    /// The data of a checkpoint.
    pub fn progress(&self) -> Progress {
        let saved = |History { vectors, numbers }: History| {
            (vectors.iter().map(|vectors| self.numbering.external_vectors(vectors)).collect(), numbers)
        };
        let (state, work, histories) = self.at_step_end();
        Progress {
            step_count: self.step_count,
            origin_step: self.origin_step,
            evaluation_count: self.evaluation_count(),
            origin: self.origin,
            hub_phase: self.mechanics.spin.phase,
            positions: self.numbering.external_vectors(&state.positions),
            velocities: self.numbering.external_vectors(&state.velocities),
            ledger: Ledger { work: work.to_vec(), ..self.ledger.clone() },
            history: saved(self.integrator.history()),
            law_histories: histories.into_iter().map(saved).collect(),
            adaptive: self.adaptive_progress(),
            output_time: self.output_time(),
        }
    }

    /// Continues from a checkpoint of the same model, laws, method and step.
    ///
    /// # Errors
    /// `LengthMismatch` and `HistoryMisfit` for a checkpoint of another model, laws or method, `NotFinite`; motion,
    /// ledger, method and laws are then unchanged.
    pub fn resume(&mut self, progress: &Progress) -> Result<()> {
        let before = self.progress();
        let resumed = self.load(progress);
        if resumed.is_err() {
            self.load(&before)?;
        }
        resumed
    }

    fn load(&mut self, progress: &Progress) -> Result<()> {
        let nodes = self.mechanics.masses.len();
        let length = |what, found: usize, expected: usize, per| {
            if found == expected { Ok(()) } else { Err(Error::LengthMismatch { what, found, expected, per }) }
        };
        length("the saved ledger", progress.ledger.work.len().saturating_sub(1), self.laws().len(), "law")?;
        length("the saved ledger", progress.ledger.start.stored.len(), self.laws().len(), "law")?;
        length("the saved changes by jumps", progress.ledger.changes.len(), self.laws().len() + 1, "term of energy")?;
        let is_before = progress.origin_step <= progress.step_count;
        within("saved steps before the origin", progress.origin_step as f64, is_before, "it is at most all steps")?;
        const OF_METHOD: &str = "the saved history of the method";
        const OF_LAWS: &str = "the saved history of the laws";
        if !progress.law_histories.is_empty() {
            length(OF_LAWS, progress.law_histories.len(), self.laws().len(), "law")?;
        }
        let histories = progress.law_histories.iter().map(|history| (OF_LAWS, history));
        for (what, (vectors, _)) in histories.chain([(OF_METHOD, &progress.history)]) {
            vectors.iter().try_for_each(|rows| length(what, rows.len(), nodes, "node"))?;
        }
        finite("saved angle of the hub at t = 0 [rad]", progress.hub_phase)?;
        within("saved origin [s]", progress.origin, progress.origin.is_finite(), "it is finite")?;
        self.output = None;
        (self.origin, self.step_count) = (progress.origin, progress.step_count);
        self.origin_step = progress.origin_step;
        self.find_interval();
        self.mechanics.spin.phase = progress.hub_phase;
        self.set_motion(&progress.positions, &progress.velocities)?;
        self.mechanics.evaluation_count = progress.evaluation_count;
        self.ledger = Ledger { scope: self.mechanics.scope(), ..progress.ledger.clone() };
        let internal = |(vectors, numbers): &SavedHistory| History {
            vectors: vectors.iter().map(|rows| self.numbering.internal_vectors(rows)).collect(),
            numbers: numbers.clone(),
        };
        let of_laws: Vec<History> = progress.law_histories.iter().map(internal).collect();
        if let (Some(owner), true) = (self.mechanics.hub_law(), of_laws.is_empty()) {
            return Err(Error::HistoryMisfit { owner });
        }
        let of_method = internal(&progress.history);
        if !self.integrator.restore_history(of_method) {
            return Err(Error::HistoryMisfit { owner: self.name() });
        }
        if let Some(owner) = self.mechanics.restore_histories(&of_laws) {
            return Err(Error::HistoryMisfit { owner });
        }
        self.resume_adaptive(progress.adaptive.as_ref())?;
        self.start_moved();
        self.record_good(self.energy_terms());
        self.show_saved(progress.output_time)
    }

    /// Shows the state at a saved output time: within the last step of an adaptive run, else less than a step after it.
    fn show_saved(&mut self, output_time: Option<f64>) -> Result<()> {
        let Some(time) = output_time else { return Ok(()) };
        let after = time - self.step_end_time();
        let is_near = if self.is_adaptive() { after <= 0.0 } else { after.abs() <= self.dt() };
        within("saved output time [s]", time, is_near, "it lies within a step of the saved state")?;
        self.show(time)
    }
}
