//! The step loop, with laws, method, state, ledger and monitor.

mod adaptive;
mod checkpoint;
mod default_step;
mod diagnosis;
mod implicit;
mod jumps;
mod monitor;
mod motor;
mod output;
mod rate_groups;
mod readings;
mod settings;
mod start;
mod tolerance;

use crate::arrays::history::History;
use crate::arrays::state::{NodeVectors, State};
use crate::assembly::Assembly;
use crate::error::{Error, Result};
use crate::evaluation::ledger::{EnergyTerms, Ledger};
use crate::evaluation::mechanics::Mechanics;
use crate::evaluation::plan::Plan;
use crate::integrators::{self, Integrator, Method, Options, Properties};
use crate::laws::{self, Instant, Law, LawSpec};
use crate::layout::Renumbering;
use crate::linear::tangent::Tangent;
use crate::model::checks::{finite, non_negative, positive, within};
use crate::model::frame::Spin;
use crate::model::input::Model;
use crate::simd::dispatch::InstructionSet;
use crate::stability::Limit;

pub use checkpoint::{AdaptiveProgress, Progress, SavedHistory};
pub use readings::HubLoad;
pub use settings::{Settings, Setup};

/// A step is refused at once above this multiple of the limit.
const HOPELESS: f64 = 100.0;
/// The largest changes of the first steps are recorded before a regular check.
const FIRST_STEPS: u64 = 100;

/// The state at the last check without fault.
struct GoodState {
    time: f64,
    origin: f64,
    origin_step: u64,
    step_count: u64,
    state: State,
    work: Vec<f64>,
    energy_terms: EnergyTerms,
    history: History,
    law_histories: Vec<History>,
}

/// A scene that can be stepped.
pub struct Simulation {
    mechanics: Mechanics,
    numbering: Renumbering,
    method: Method,
    integrator: Box<dyn Integrator>,
    /// A second instance of the method, for side steps.
    side: Option<Box<dyn Integrator>>,
    settings: Settings,
    dt: f64,
    /// The time from which steps are counted, that of the last jump if any \[s\], and the number of steps before it.
    origin: f64,
    origin_step: u64,
    step_count: u64,
    /// The times at which schedules jump, ascending \[s\]; those up to `origin` are passed.
    jumps: Vec<f64>,
    state: State,
    ledger: Ledger,
    good: GoodState,
    /// The state before the step that is searched for a fault.
    suspect: Option<State>,
    adaptive: Option<adaptive::Adaptive>,
    /// What is shown, where it is not the end of the last step.
    output: Option<output::Output>,
    /// The limit of the step at the start.
    start_limit: Limit,
}

impl Simulation {
    /// Assembles a model and its laws. Without `dt`, a method with an error estimate chooses each step by the
    /// tolerance, and the others take the stability limit times the margin.
    ///
    /// # Errors
    /// Those of `Assembly::new` and of the laws; `UnknownName` for the integrator; `NoStiffness` for a scene without
    /// stability limit and without `dt`; `HopelessStep`; `OutOfRange` for `dt`.
    pub fn new(model: Model, laws: &[LawSpec], integrator: &str, dt: Option<f64>, settings: Settings) -> Result<Self> {
        let method = integrators::by_name(integrator)?;
        let assembly = Assembly::new(model, settings.instructions)?;
        let (spin, laws) = (laws::spin_of(laws), laws::build(laws, &assembly)?);
        Self::with(Setup { assembly, laws, spin, method, dt, limit: None }, settings)
    }

    /// As `new`, for an assembled model, with any laws and any method.
    ///
    /// # Errors
    /// As `new`, and `MixedKernels`.
    pub fn with(setup: Setup, settings: Settings) -> Result<Self> {
        let Setup { assembly, mut laws, spin, method, dt, limit } = setup;
        Plan::check(&mut laws)?;
        positive("margin", settings.margin)?;
        non_negative("energy tolerance", settings.energy_tolerance)?;
        non_negative("loss tolerance", settings.loss_tolerance)?;
        positive("tolerance", settings.tolerance.relative)?;
        positive("length of the tolerance [m]", settings.tolerance.length)?;
        positive("speed of the tolerance [m/s]", settings.tolerance.speed)?;
        within("check interval", settings.check_interval as f64, settings.check_interval > 0, "it is at least 1 step")?;
        if let Some(dt) = dt {
            positive("dt [s]", dt)?;
        }
        let (spectral_radius, substeps) = (settings.spectral_radius, settings.substeps);
        let is_radius = (0.0..=1.0).contains(&spectral_radius);
        within("spectral radius", spectral_radius, is_radius, "it lies between 0 and 1")?;
        within("substeps", f64::from(substeps), substeps > 0, "it is at least 1")?;
        finite("time at which the hub is frozen [s]", settings.frozen_at.unwrap_or_default())?;
        let spin = Spin { frozen_at: settings.frozen_at, ..spin };
        let instructions = settings.instructions;
        let is_hub_free = spin.hub.is_some();
        let mut integrator = (method.make)(&options_of(&settings, assembly.masses.len(), laws.len() + 1, is_hub_free));
        settings.check_free_hub(&spin, integrator.as_ref(), &laws)?;
        settings::check_impulses(&settings, integrator.as_ref(), &laws)?;
        let couplings = |visit: &mut dyn FnMut(&[u32])| {
            laws.iter().filter_map(|law| law.linearisation()).for_each(|law| law.visit_couplings(visit));
        };
        let is_implicit = integrator.properties().is_implicit;
        let tangent = is_implicit.then(|| Tangent::new(&couplings, &assembly.inverse_masses)).transpose()?;
        let internal = |rows: &[[f64; 3]]| assembly.numbering.internal_vectors(rows);
        let mut state =
            State { positions: internal(&assembly.model.positions), velocities: internal(&assembly.model.velocities) };
        start::hold(&assembly.inverse_masses, &mut state.velocities);
        let Assembly { masses, inverse_masses, numbering, .. } = assembly;
        let (method_of, count) = (integrator.as_ref(), laws.len());
        let mut mechanics = Mechanics::new(laws, spin, masses, inverse_masses, tangent, method_of, instructions);
        let jumps = if settings.frozen_at.is_some() { Vec::new() } else { jumps::times(&mechanics) };
        mechanics.spin.interval = jumps::interval(&jumps, 0.0);
        mechanics.weigh_hub(&state.positions);
        mechanics.start_moved(state.at(0.0));
        mechanics.set_moved(0.0, &mut state, &mut vec![0.0; count]);
        mechanics.laws.iter().try_for_each(|law| law.check_start(&state.positions))?;
        let energy_terms = mechanics.energy_terms(0.0, &state);
        let turning = mechanics.turning_energy(state.at(0.0));
        let ledger = Ledger::open(mechanics.scope(), energy_terms.clone(), turning);
        let good = GoodState {
            time: 0.0,
            origin: 0.0,
            origin_step: 0,
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
            method,
            integrator,
            side: None,
            settings,
            dt: 0.0,
            origin: 0.0,
            origin_step: 0,
            step_count: 0,
            jumps,
            state,
            ledger,
            good,
            suspect: None,
            adaptive: None,
            output: None,
            start_limit: Limit { dt: f64::INFINITY, largest_frequency: 0.0, law: "nothing", node: 0 },
        };
        simulation.find_slow_laws()?;
        let limit = limit.map_or_else(|| simulation.limit(), Ok)?;
        simulation.start_limit = limit.clone();
        simulation.dt = match dt {
            Some(dt) if dt > HOPELESS * limit.dt => {
                let part = simulation.limiting_part(&limit);
                return Err(Error::HopelessStep { dt, limit: limit.dt, integrator: simulation.name(), part });
            }
            Some(dt) => dt,
            None if is_embedded => {
                simulation.adapt(limit.dt)?;
                0.0
            }
            None => simulation.default_step(&limit)?,
        };
        Ok(simulation)
    }

    /// The step \[s\]; in an adaptive run the next one to attempt.
    pub fn dt(&self) -> f64 {
        self.adaptive.as_ref().map_or(self.dt, |adaptive| adaptive.controller.dt)
    }

    fn energy_shift(&self, dt: f64) -> f64 {
        self.integrator.energy_shift(&self.mechanics.free_masses(), dt)
    }

    /// Number of steps since they were counted anew. The rest of a step up to a jump is none.
    pub fn step_count(&self) -> u64 {
        self.step_count
    }

    /// The method.
    pub fn integrator(&self) -> &dyn Integrator {
        self.integrator.as_ref()
    }

    /// The properties of the method.
    fn properties(&self) -> Properties {
        self.integrator.properties()
    }

    fn options(&self) -> Options {
        let is_hub_free = self.mechanics.spin.hub.is_some();
        options_of(&self.settings, self.mechanics.masses.len(), self.ledger.work.len(), is_hub_free)
    }

    fn name(&self) -> &'static str {
        self.properties().name
    }

    /// The angle of rotation of the hub since t = 0 \[rad\].
    pub fn hub_angle(&self) -> f64 {
        self.instant().frame.angle
    }

    /// The instruction set of the kernels.
    pub fn instructions(&self) -> InstructionSet {
        self.settings.instructions
    }

    /// The laws, in the order of `Ledger::work` and `EnergyTerms::stored`.
    pub fn laws(&self) -> &[Box<dyn Law>] {
        &self.mechanics.laws
    }

    /// Node masses, in external order \[kg\].
    pub fn masses(&self) -> Vec<f64> {
        self.numbering.external_values(&self.mechanics.masses)
    }

    /// Positions, in external order \[m\].
    pub fn positions(&self) -> Vec<[f64; 3]> {
        self.numbering.external_vectors(&self.state.positions)
    }

    /// Velocities relative to the turning frame, in external order \[m/s\].
    pub fn velocities(&self) -> Vec<[f64; 3]> {
        self.numbering.external_vectors(&self.state.velocities)
    }

    /// The ledger since the start.
    pub fn ledger(&self) -> &Ledger {
        &self.ledger
    }

    /// The energy terms at present.
    pub fn energy_terms(&self) -> EnergyTerms {
        self.mechanics.energy_terms(self.time(), &self.state)
    }

    /// Forces of one law, or of all, in external order \[N\].
    ///
    /// # Errors
    /// `UnknownName`, with the laws of the scene.
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
        let at = Instant::new(self.state.at(self.time()), &self.mechanics.spin);
        let at = self.mechanics.with_accelerations(at);
        for row in rows {
            self.mechanics.add_forces_of(row, at, &mut forces);
        }
        Ok(self.numbering.external_vectors(&forces))
    }

    /// The limit of the step at the current positions.
    ///
    /// # Errors
    /// `NotFinite`.
    pub fn limit(&self) -> Result<Limit> {
        self.limit_at(self.instant())
    }

    /// The same at the start, as it was found when the simulation was made.
    pub fn start_limit(&self) -> &Limit {
        &self.start_limit
    }

    /// External number of a node.
    pub fn to_external(&self, internal: usize) -> usize {
        self.numbering.to_external(internal)
    }

    /// The law and the node of a limit, in words.
    pub fn limiting_part(&self, limit: &Limit) -> String {
        format!("{} near node {}", limit.law, self.numbering.to_external(limit.node))
    }

    /// Takes `count` steps, with regular checks.
    ///
    /// # Errors
    /// `Unstable` where the monitor stops the run; the state is then that of the last good check.
    pub fn step(&mut self, count: u64) -> Result<()> {
        for _ in 0..count {
            self.whole_step()?;
            self.pass_due_jumps()?;
        }
        Ok(())
    }

    /// Takes a step, from the state after the jumps up to its start. One of constant step passes those within it.
    fn whole_step(&mut self) -> Result<()> {
        self.put_step_end_back();
        self.pass_due_jumps()?;
        self.pass_jumps_within_step()?;
        self.start_if_needed();
        if self.adaptive.is_some() {
            self.adaptive_step()?;
        } else {
            self.fixed_step();
            self.refuse_stall()?;
        }
        self.mechanics.accept(self.state.at(self.time()));
        if self.step_count.is_multiple_of(self.settings.check_interval) || self.mechanics.is_at_fault() {
            self.regular_check()?;
        } else if self.step_count < FIRST_STEPS && self.step_count.is_power_of_two() {
            self.record_exchange();
        }
        Ok(())
    }

    /// One step of the given length, from the present time.
    fn fixed_step(&mut self) {
        let time = self.time();
        self.integrator.step(&mut self.mechanics, time, self.dt, &mut self.state, &mut self.ledger.work);
        self.step_count += 1;
        self.set_moved();
    }

    fn start_if_needed(&mut self) {
        self.mechanics.begin(self.state.at(self.time()));
        if !self.integrator.is_started() {
            let time = self.time();
            let (state, work) = (&mut self.state, &mut self.ledger.work);
            self.integrator.start(&mut self.mechanics, time, self.dt, state, work);
            self.ledger.start_shift = self.energy_shift(self.dt);
        }
    }

    fn instant(&self) -> Instant<'_> {
        self.mechanics.instant(self.state.at(self.time()))
    }

    /// Number of evaluations of the forces by steps.
    pub fn evaluation_count(&self) -> u64 {
        self.mechanics.evaluation_count
    }
}

/// The options of the method.
fn options_of(settings: &Settings, nodes: usize, works: usize, is_hub_free: bool) -> Options {
    let Settings { instructions, spectral_radius, substeps, .. } = *settings;
    Options { nodes, works, instructions, spectral_radius, substeps, is_hub_free }
}
