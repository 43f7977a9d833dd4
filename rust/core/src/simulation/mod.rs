//! The step loop; owns laws, method, state, ledger and monitor.

mod adaptive;
mod checkpoint;
mod diagnosis;
mod implicit;
mod monitor;
mod rate_groups;

use crate::arrays::history::History;
use crate::arrays::state::{NodeVectors, State};
use crate::assembly::Assembly;
use crate::error::{Error, Result};
use crate::evaluation::ledger::{EnergyTerms, Ledger};
use crate::evaluation::mechanics::Mechanics;
use crate::integrators::{self, Integrator, Method, Options, Properties, Tolerance};
use crate::laws::Instant;
use crate::laws::{self, Law, LawSpec, Readings};
use crate::layout::Renumbering;
use crate::linear::tangent::Tangent;
use crate::model::checks::{non_negative, positive, within};
use crate::model::frame::Spin;
use crate::model::input::Model;
use crate::model::mesh::check_finite;
use crate::simd::dispatch::InstructionSet;
use crate::stability::Limit;

pub use checkpoint::{AdaptiveProgress, Progress, SavedHistory};

/// How a run is monitored, and how its step is chosen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Share of the stability limit that is taken where no step is given.
    pub margin: f64,
    /// Steps between two checks.
    pub check_interval: u64,
    /// Spurious gain, as a share of the reference energy, at which a run stops.
    pub energy_tolerance: f64,
    /// Energy that the method may lose by itself, as a share of the reference energy, before a run stops.
    pub loss_tolerance: f64,
    /// Error of a step where no step is given and the method knows its error.
    pub tolerance: Tolerance,
    /// By what factor an implicit method shrinks, per step, what it cannot resolve; from 0 to 1.
    pub spectral_radius: f64,
    /// Substeps in a step of leapfrog, between which slow laws rest.
    pub substeps: u32,
    /// The instructions that kernels run with; the bits of the results do not depend on it.
    pub instructions: InstructionSet,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            margin: 0.4,
            check_interval: 32,
            energy_tolerance: 1e-2,
            loss_tolerance: 0.05,
            tolerance: Tolerance { relative: 1e-5, length: 0.1, speed: 1.0 },
            spectral_radius: integrators::SPECTRAL_RADIUS,
            substeps: 1,
            instructions: InstructionSet::widest(),
        }
    }
}

/// A step that is this many times the limit is refused at once.
const HOPELESS: f64 = 100.0;

/// The state at a check that found nothing.
struct Good {
    time: f64,
    step_count: u64,
    state: State,
    work: Vec<f64>,
    energy_terms: EnergyTerms,
    history: History,
    law_histories: Vec<History>,
}

/// What a simulation is made of.
pub struct Setup {
    /// The model in the core's numbering.
    pub assembly: Assembly,
    /// Its laws, in the order of the energy terms.
    pub laws: Vec<Box<dyn Law>>,
    /// How the hub turns.
    pub spin: Spin,
    /// The method.
    pub method: Method,
    /// The step \[s\]; see `Simulation::new`.
    pub dt: Option<f64>,
    /// The limit of the step at the start, where it is known: to look for it takes as long as some hundred steps.
    pub limit: Option<Limit>,
}

/// A scene that can be stepped.
pub struct Simulation {
    mechanics: Mechanics,
    numbering: Renumbering,
    integrator: Box<dyn Integrator>,
    settings: Settings,
    dt: f64,
    origin: f64,
    step_count: u64,
    state: State,
    ledger: Ledger,
    good: Good,
    /// The state before the step that is looked at for a fault.
    suspect: Option<State>,
    adaptive: Option<adaptive::Adaptive>,
    /// The limit of the step at the start.
    start_limit: Limit,
}

impl Simulation {
    /// Assembles a model and its laws. `dt` of `None` lets a method that knows its error choose each step by the
    /// tolerance; others take the stability limit times the margin.
    ///
    /// # Errors
    /// Those of `Assembly::new` and of the laws; `UnknownName` for the integrator; `NoStiffness` without `dt` where no step
    /// follows; `HopelessStep`; `OutOfRange` for `dt`.
    pub fn new(model: Model, laws: &[LawSpec], integrator: &str, dt: Option<f64>, settings: Settings) -> Result<Self> {
        let method = integrators::by_name(integrator)?;
        let assembly = Assembly::new(model, settings.instructions)?;
        let (spin, laws) = (laws::spin_of(laws), laws::build(laws, &assembly)?);
        Self::with(Setup { assembly, laws, spin, method, dt, limit: None }, settings)
    }

    /// As `new`, of a scene that is assembled already, with any laws and any method.
    ///
    /// # Errors
    /// As `new`.
    pub fn with(setup: Setup, settings: Settings) -> Result<Self> {
        let Setup { assembly, laws, spin, method, dt, limit } = setup;
        positive("margin", settings.margin)?;
        non_negative("energy tolerance", settings.energy_tolerance)?;
        non_negative("loss tolerance", settings.loss_tolerance)?;
        if let Some(dt) = dt {
            positive("dt [s]", dt)?;
        }
        let (spectral_radius, substeps) = (settings.spectral_radius, settings.substeps);
        let is_radius = (0.0..=1.0).contains(&spectral_radius);
        within("spectral radius", spectral_radius, is_radius, "it lies between 0 and 1")?;
        within("substeps", f64::from(substeps), substeps > 0, "it is at least 1")?;
        let (nodes, count, instructions) = (assembly.masses.len(), laws.len(), settings.instructions);
        let mut integrator = (method.make)(&Options { nodes, laws: count, instructions, spectral_radius, substeps });
        let couplings = |visit: &mut dyn FnMut(&[u32])| {
            laws.iter().filter_map(|law| law.linearisation()).for_each(|law| law.visit_couplings(visit));
        };
        let is_implicit = integrator.properties().is_implicit;
        let tangent = is_implicit.then(|| Tangent::new(&couplings, &assembly.inverse_masses)).transpose()?;
        let internal = |rows: &[[f64; 3]]| assembly.numbering.internal_vectors(rows);
        let mut state =
            State { positions: internal(&assembly.model.positions), velocities: internal(&assembly.model.velocities) };
        hold(&assembly.inverse_masses, &mut state.velocities);
        let Assembly { masses, inverse_masses, numbering, .. } = assembly;
        let method = integrator.as_ref();
        let mechanics = Mechanics::new(laws, spin, masses, inverse_masses, tangent, method, instructions);
        let energy_terms = mechanics.energy_terms(0.0, &state);
        let ledger = Ledger::open(energy_terms.clone());
        let good = Good {
            time: 0.0,
            step_count: 0,
            state: state.clone(),
            work: ledger.work.clone(),
            energy_terms,
            history: History::default(),
            law_histories: mechanics.histories(),
        };
        let is_embedded = integrator.embedded().is_some();
        let mut simulation = Self {
            mechanics,
            numbering,
            integrator,
            settings,
            dt: 0.0,
            origin: 0.0,
            step_count: 0,
            state,
            ledger,
            good,
            suspect: None,
            adaptive: None,
            start_limit: Limit { dt: f64::INFINITY, largest_frequency: 0.0, law: "nothing", node: 0 },
        };
        simulation.find_slow_laws()?;
        let limit = limit.map_or_else(|| simulation.limit(), Ok)?;
        simulation.start_limit = limit.clone();
        simulation.dt = match dt {
            Some(dt) if dt > HOPELESS * limit.dt => {
                let part = simulation.part(&limit);
                return Err(Error::HopelessStep { dt, limit: limit.dt, integrator: simulation.name(), part });
            }
            Some(dt) => dt,
            None if is_embedded => {
                simulation.adapt(limit.dt)?;
                0.0
            }
            None if is_implicit && limit.largest_frequency > 0.0 => implicit::LONG_STEP * 2.0 / limit.largest_frequency,
            None if limit.dt.is_finite() => (settings.margin * limit.dt).min(simulation.resonance_bound(&limit)),
            None => return Err(Error::NoStiffness),
        };
        Ok(simulation)
    }

    /// Time \[s\].
    pub fn time(&self) -> f64 {
        self.adaptive.as_ref().map_or(self.origin + self.step_count as f64 * self.dt, |adaptive| adaptive.shown)
    }

    /// The step \[s\]; of an adaptive run the one to be tried next.
    pub fn dt(&self) -> f64 {
        self.adaptive.as_ref().map_or(self.dt, |adaptive| adaptive.controller.dt)
    }

    /// Changes the step; steps are counted anew from now, in the same ledger. An adaptive run tries it next.
    ///
    /// # Errors
    /// `OutOfRange`.
    pub fn set_dt(&mut self, dt: f64) -> Result<()> {
        positive("dt [s]", dt)?;
        if let Some(adaptive) = &mut self.adaptive {
            adaptive.controller.dt = dt;
            return Ok(());
        }
        (self.origin, self.step_count, self.good.step_count) = (self.time(), 0, 0);
        if self.integrator.is_started() {
            // What the method conserves changes with the step.
            self.ledger.start_shift += self.energy_shift(dt) - self.energy_shift(self.dt);
        }
        self.dt = dt;
        Ok(())
    }

    fn energy_shift(&self, dt: f64) -> f64 {
        self.integrator.energy_shift(&self.mechanics.masses, dt)
    }

    /// Steps taken since the time from which they are counted.
    pub fn step_count(&self) -> u64 {
        self.step_count
    }

    /// The method.
    pub fn integrator(&self) -> &dyn Integrator {
        self.integrator.as_ref()
    }

    /// What is known of the method.
    fn properties(&self) -> Properties {
        self.integrator.properties()
    }

    fn name(&self) -> &'static str {
        self.properties().name
    }

    /// The angle that the hub has turned since t = 0 \[rad\].
    pub fn hub_angle(&self) -> f64 {
        self.instant().frame.angle
    }

    /// The vector instructions that the kernels run with.
    pub fn instructions(&self) -> InstructionSet {
        self.settings.instructions
    }

    /// The laws, in the order of `Ledger::work` and `EnergyTerms::stored`.
    pub fn laws(&self) -> &[Box<dyn Law>] {
        &self.mechanics.laws
    }

    /// Node masses, in the caller's numbering \[kg\].
    pub fn masses(&self) -> Vec<f64> {
        self.numbering.external_values(&self.mechanics.masses)
    }

    /// Positions, in the caller's numbering \[m\].
    pub fn positions(&self) -> Vec<[f64; 3]> {
        self.numbering.external_vectors(&self.state.positions)
    }

    /// Velocities relative to the turning frame, in the caller's numbering \[m/s\].
    pub fn velocities(&self) -> Vec<[f64; 3]> {
        self.numbering.external_vectors(&self.state.velocities)
    }

    /// Sets positions and velocities, in the caller's numbering, and opens the ledger anew. Held nodes stay at rest.
    ///
    /// # Errors
    /// `LengthMismatch`, `NotFinite`.
    pub fn set_motion(&mut self, positions: &[[f64; 3]], velocities: &[[f64; 3]]) -> Result<()> {
        for (what, rows) in [("positions", positions), ("velocities", velocities)] {
            let expected = self.mechanics.masses.len();
            if rows.len() != expected {
                return Err(Error::LengthMismatch { what, found: rows.len(), expected, per: "node" });
            }
        }
        check_finite("the position", positions)?;
        check_finite("the velocity", velocities)?;
        self.state = State {
            positions: self.numbering.internal_vectors(positions),
            velocities: self.numbering.internal_vectors(velocities),
        };
        hold(&self.mechanics.inverse_masses, &mut self.state.velocities);
        self.integrator.restore_history(History::default());
        self.mechanics.restore_histories(&[]);
        self.restart_adaptive();
        self.ledger = Ledger::open(self.energy_terms());
        self.keep(self.ledger.start.clone());
        Ok(())
    }

    /// The ledger so far.
    pub fn ledger(&self) -> &Ledger {
        &self.ledger
    }

    /// The energy terms now.
    pub fn energy_terms(&self) -> EnergyTerms {
        self.mechanics.energy_terms(self.time(), &self.state)
    }

    /// Forces of one law, or of all, in the caller's numbering \[N\].
    ///
    /// # Errors
    /// `UnknownName`, with the laws there are.
    pub fn forces(&mut self, name: Option<&str>) -> Result<Vec<[f64; 3]>> {
        let laws = &self.mechanics.laws;
        if let Some(name) = name
            && !laws.iter().any(|law| law.name() == name)
        {
            let known = laws.iter().map(|law| law.name()).collect::<Vec<_>>().join(", ");
            return Err(Error::UnknownName { what: "law in this scene", name: name.to_owned(), known });
        }
        let rows: Vec<usize> =
            (0..laws.len()).filter(|&row| name.is_none_or(|name| laws[row].name() == name)).collect();
        let mut forces = NodeVectors::zeros(self.mechanics.masses.len());
        let at = Instant::new(self.state.at(self.time()), self.mechanics.spin);
        for row in rows {
            self.mechanics.add_forces_of(row, at, &mut forces);
        }
        Ok(self.numbering.external_vectors(&forces))
    }

    /// What there is to read off the elements of each law.
    pub fn readings(&self) -> impl Iterator<Item = (&'static str, Readings)> {
        let inspected = self.mechanics.laws.iter().filter_map(|law| Some((law.name(), law.inspection()?)));
        inspected.map(|(name, law)| (name, law.readings(self.instant())))
    }

    /// The limit of the step at the current positions.
    ///
    /// # Errors
    /// `NotFinite`.
    pub fn limit(&self) -> Result<Limit> {
        self.limit_at(self.instant())
    }

    /// The caller's number of the core's node `inside`.
    pub fn to_external(&self, inside: usize) -> usize {
        self.numbering.to_external(inside)
    }

    /// The limiting part in words.
    pub fn part(&self, limit: &Limit) -> String {
        format!("{} near node {}", limit.law, self.numbering.to_external(limit.node))
    }

    /// Takes `count` steps, checking as it goes.
    ///
    /// # Errors
    /// `Unstable` where the watch stops the run; the state is then that of the last good check.
    pub fn step(&mut self, count: u64) -> Result<()> {
        for _ in 0..count {
            self.start_if_needed();
            if self.adaptive.is_some() {
                self.adaptive_step()?;
            } else {
                let time = self.time();
                self.integrator.step(&mut self.mechanics, time, self.dt, &mut self.state, &mut self.ledger.work);
                self.step_count += 1;
                self.refuse_stall()?;
            }
            if self.step_count.is_multiple_of(self.settings.check_interval.max(1)) {
                self.regular_check()?;
            }
        }
        Ok(())
    }

    fn start_if_needed(&mut self) {
        if !self.integrator.is_started() {
            let time = self.time();
            self.integrator.start(&mut self.mechanics, time, &self.state);
            self.ledger.start_shift = self.energy_shift(self.dt);
        }
    }

    fn instant(&self) -> Instant<'_> {
        self.mechanics.instant(self.state.at(self.time()))
    }

    /// Evaluations of the forces while stepping.
    pub fn evaluation_count(&self) -> u64 {
        self.mechanics.evaluation_count
    }
}

/// Held nodes do not move.
fn hold(inverse_masses: &[f64], velocities: &mut NodeVectors) {
    for (i, &inverse) in inverse_masses.iter().enumerate() {
        if inverse == 0.0 {
            velocities.row_mut(i).fill(0.0);
        }
    }
}
