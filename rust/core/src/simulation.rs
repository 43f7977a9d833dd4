//! The step loop; owns laws, method, state, ledger and watch.

mod adaptive;
mod diagnosis;
mod implicit;
mod watch;

use crate::error::{Error, Result};
use crate::forces::{self, Law, LawSpec, Readings, Spin};
use crate::integrators::{self, Controller, Integrator, Memory, System, Tolerance};
use crate::layout::Layout;
use crate::ledger::{Accounts, Ledger};
use crate::model::{Assembly, Model, non_negative, positive, within};
use crate::stability::{self, Limit};
use crate::state::{Instant, State, Vectors, columns_mut};
use crate::tangent::{Tangent, Weights};
use crate::width::{Sweep, Width};

/// How a run is watched, and how its step is chosen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Share of the stability limit that is taken where no step is given.
    pub margin: f64,
    /// Steps between two checks.
    pub watch_interval: u64,
    /// Surplus of energy, as a share of the energy turned over, at which a run stops.
    pub energy_tolerance: f64,
    /// Energy that the method may lose by itself, as a share of the energy turned over, before a run stops.
    pub loss_tolerance: f64,
    /// Error of a step where no step is given and the method knows its error.
    pub tolerance: Tolerance,
    /// By what factor an implicit method shrinks, per step, what it cannot resolve; from 0 to 1.
    pub spectral_radius: f64,
    /// The instructions that kernels run with; the bits of the results do not depend on it.
    pub width: Width,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            margin: 0.4,
            watch_interval: 32,
            energy_tolerance: 1e-2,
            loss_tolerance: 0.05,
            tolerance: Tolerance { relative: 1e-5, length: 0.1, speed: 1.0 },
            spectral_radius: integrators::SPECTRAL_RADIUS,
            width: Width::widest(),
        }
    }
}

/// A step that is this many times the limit is refused at once.
const HOPELESS: f64 = 100.0;

/// The laws and masses, as an integrator sees them.
struct Mechanics {
    laws: Vec<Box<dyn Law>>,
    masses: Vec<f64>,
    inverse_masses: Vec<f64>,
    evaluation_count: u64,
    /// The last forces of each law without a potential, where the method asks for their work later [N].
    resistances: Vec<Option<Vectors>>,
    /// Where the method is implicit.
    tangent: Option<Tangent>,
    width: Width,
}

/// Forces to accelerations.
struct Divide<'a> {
    columns: [&'a mut [f64]; 3],
    inverse_masses: &'a [f64],
}

impl Sweep for Divide<'_> {
    type Output = ();

    #[inline(always)]
    fn sweep(self) {
        for column in self.columns {
            for (value, inverse) in column.iter_mut().zip(self.inverse_masses) {
                *value *= inverse;
            }
        }
    }
}

/// Adds one array to another.
struct Add<'a> {
    from: &'a [f64],
    to: &'a mut [f64],
}

impl Sweep for Add<'_> {
    type Output = ();

    #[inline(always)]
    fn sweep(self) {
        self.to.iter_mut().zip(self.from).for_each(|(to, from)| *to += from);
    }
}

impl System for Mechanics {
    fn accelerate(&mut self, at: Instant<'_>, accelerations: &mut Vectors, powers: &mut [f64]) {
        accelerations.as_mut_slice().fill(0.0);
        let resistances = &mut self.resistances;
        forces::add_all(&self.laws, at, accelerations, powers, resistances);
        for resistance in resistances.iter().flatten() {
            self.width.run(Add { from: resistance.as_slice(), to: accelerations.as_mut_slice() });
        }
        self.width.run(Divide { columns: columns_mut(accelerations), inverse_masses: &self.inverse_masses });
        self.evaluation_count += 1;
    }

    fn rework(&self, velocities: &Vectors, powers: &mut [f64]) {
        for (power, resistance) in powers.iter_mut().zip(&self.resistances) {
            if let Some(resistance) = resistance {
                *power = resistance.dot(velocities);
            }
        }
    }

    fn factorise(&mut self, at: Instant<'_>, weights: Weights) -> bool {
        let Some(tangent) = &mut self.tangent else { return false };
        tangent.assemble(&self.laws, &self.masses, at, weights);
        tangent.factorise()
    }

    fn solve(&mut self, accelerations: &mut Vectors) {
        if let Some(tangent) = &mut self.tangent {
            tangent.solve(&self.masses, accelerations);
        }
    }

    fn gyration(&self, time: f64) -> f64 {
        self.laws.iter().map(|law| law.gyration(time)).sum()
    }
}

/// Everything that changes while a simulation runs: saving and restoring it continues with the same bits.
#[derive(Debug, Clone, PartialEq)]
pub struct Progress {
    /// Steps taken since `origin`.
    pub step_count: u64,
    /// Evaluations of the forces.
    pub evaluation_count: u64,
    /// The time from which steps are counted \[s\]: t = origin + step_count dt, never a running sum.
    pub origin: f64,
    /// Positions and velocities, in the caller's numbering.
    pub positions: Vec<[f64; 3]>,
    /// See `positions`.
    pub velocities: Vec<[f64; 3]>,
    /// The ledger.
    pub ledger: Ledger,
    /// What the method keeps from step to step: vectors per node, and numbers.
    pub memory: (Vec<Vec<[f64; 3]>>, Vec<f64>),
    /// Where steps are chosen by their error; positions, velocities and work are then those at the end of the last step.
    pub adaptive: Option<AdaptiveProgress>,
}

/// What an adaptive run has beside.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AdaptiveProgress {
    /// The end of the last step \[s\].
    pub front: f64,
    /// The instant that is shown, within that step \[s\].
    pub shown: f64,
    /// The step to come.
    pub controller: Controller,
}

/// The state at a check that found nothing.
struct Good {
    time: f64,
    step_count: u64,
    state: State,
    work: Vec<f64>,
    accounts: Accounts,
    memory: Memory,
}

/// A scene that can be stepped.
pub struct Simulation {
    mechanics: Mechanics,
    layout: Layout,
    spin: Spin,
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
        Self::with_limit(model, laws, integrator, dt, settings, None)
    }

    /// As `new`, where the limit of the step at the start is known: to look for it takes as long as some hundred steps.
    ///
    /// # Errors
    /// As `new`.
    pub fn with_limit(
        model: Model,
        laws: &[LawSpec],
        integrator: &str,
        dt: Option<f64>,
        settings: Settings,
        known: Option<Limit>,
    ) -> Result<Self> {
        positive("margin", settings.margin)?;
        non_negative("energy tolerance", settings.energy_tolerance)?;
        non_negative("loss tolerance", settings.loss_tolerance)?;
        if let Some(dt) = dt {
            positive("dt [s]", dt)?;
        }
        let assembly = Assembly::new(model, settings.width)?;
        let spin = forces::spin_of(laws);
        let laws = forces::build(laws, &assembly)?;
        let mut integrator = integrators::by_name(integrator, assembly.masses.len(), laws.len(), settings.width)?;
        within(
            "spectral radius",
            settings.spectral_radius,
            (0.0..=1.0).contains(&settings.spectral_radius),
            "it lies between 0 and 1",
        )?;
        integrator.dissipate(settings.spectral_radius);
        let tangent = integrator.is_implicit().then(|| Tangent::new(&laws, &assembly.inverse_masses)).transpose()?;
        let gather = |rows: &[[f64; 3]]| assembly.layout.gather_vectors(rows);
        let mut state =
            State { positions: gather(&assembly.model.positions), velocities: gather(&assembly.model.velocities) };
        hold(&assembly.inverse_masses, &mut state.velocities);
        let resistance = |law: &dyn Law| {
            let is_asked_for = integrator.evaluates_elsewhere() && !law.is_conservative();
            is_asked_for.then(|| Vectors::zeros(assembly.masses.len()))
        };
        let mechanics = Mechanics {
            resistances: laws.iter().map(|law| resistance(law.as_ref())).collect(),
            tangent,
            laws,
            masses: assembly.masses,
            inverse_masses: assembly.inverse_masses,
            evaluation_count: 0,
            width: settings.width,
        };
        let accounts = Accounts::take(&mechanics.laws, &mechanics.masses, 0.0, &state);
        let ledger = Ledger::open(accounts.clone());
        let good = Good {
            time: 0.0,
            step_count: 0,
            state: state.clone(),
            work: ledger.work.clone(),
            accounts,
            memory: Memory::default(),
        };
        let mut simulation = Self {
            mechanics,
            layout: assembly.layout,
            spin,
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
        let limit = known.map_or_else(|| simulation.limit(), Ok)?;
        simulation.start_limit = limit.clone();
        simulation.dt = match dt {
            Some(dt) if dt > HOPELESS * limit.dt => {
                let part = simulation.part(&limit);
                return Err(Error::HopelessStep {
                    dt,
                    limit: limit.dt,
                    integrator: simulation.integrator.name(),
                    part,
                });
            }
            Some(dt) => dt,
            None if simulation.integrator.embedded().is_some() => {
                simulation.adapt(limit.dt)?;
                0.0
            }
            None if simulation.integrator.is_implicit() && limit.largest_frequency > 0.0 => {
                implicit::LONG_STEP * 2.0 / limit.largest_frequency
            }
            None if limit.dt.is_finite() => settings.margin * limit.dt,
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

    /// Changes the step; steps are counted anew from now, in the ledger's same accounts. An adaptive run tries it next.
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

    /// The angle that the hub has turned since t = 0 \[rad\].
    pub fn hub_angle(&self) -> f64 {
        self.spin.angle_at(self.time())
    }

    /// The vector instructions that the kernels run with.
    pub fn width(&self) -> Width {
        self.settings.width
    }

    /// The laws, in the order of `Ledger::work` and `Accounts::stored`.
    pub fn laws(&self) -> &[Box<dyn Law>] {
        &self.mechanics.laws
    }

    /// Node masses, in the caller's numbering \[kg\].
    pub fn masses(&self) -> Vec<f64> {
        self.layout.scatter(&self.mechanics.masses)
    }

    /// Positions, in the caller's numbering \[m\].
    pub fn positions(&self) -> Vec<[f64; 3]> {
        self.layout.scatter_vectors(&self.state.positions)
    }

    /// Velocities relative to the turning frame, in the caller's numbering \[m/s\].
    pub fn velocities(&self) -> Vec<[f64; 3]> {
        self.layout.scatter_vectors(&self.state.velocities)
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
        crate::mesh::check_finite("the position", positions)?;
        crate::mesh::check_finite("the velocity", velocities)?;
        self.state = State {
            positions: self.layout.gather_vectors(positions),
            velocities: self.layout.gather_vectors(velocities),
        };
        hold(&self.mechanics.inverse_masses, &mut self.state.velocities);
        self.integrator.recall(Memory::default());
        self.restart_adaptive();
        self.ledger = Ledger::open(self.accounts());
        self.keep(self.ledger.start.clone());
        Ok(())
    }

    /// The ledger so far.
    pub fn ledger(&self) -> &Ledger {
        &self.ledger
    }

    /// The accounts now.
    pub fn accounts(&self) -> Accounts {
        Accounts::take(&self.mechanics.laws, &self.mechanics.masses, self.time(), &self.state)
    }

    /// Forces of one law, or of all, in the caller's numbering \[N\].
    ///
    /// # Errors
    /// `UnknownName`, with the laws there are.
    pub fn forces(&self, name: Option<&str>) -> Result<Vec<[f64; 3]>> {
        let laws = &self.mechanics.laws;
        if let Some(name) = name
            && !laws.iter().any(|law| law.name() == name)
        {
            let known = laws.iter().map(|law| law.name()).collect::<Vec<_>>().join(", ");
            return Err(Error::UnknownName { what: "law in this scene", name: name.to_owned(), known });
        }
        let mut forces = Vectors::zeros(self.mechanics.masses.len());
        for law in laws.iter().filter(|law| name.is_none_or(|name| law.name() == name)) {
            law.add_forces(self.instant(), &mut forces);
        }
        Ok(self.layout.scatter_vectors(&forces))
    }

    /// What there is to read off the elements of each law.
    pub fn readings(&self) -> impl Iterator<Item = (&'static str, Readings)> {
        self.mechanics.laws.iter().map(|law| (law.name(), law.readings(self.instant())))
    }

    /// The limit of the step at the current positions.
    ///
    /// # Errors
    /// `NotFinite`.
    pub fn limit(&self) -> Result<Limit> {
        stability::limit(self.integrator.as_ref(), &self.mechanics.laws, self.instant(), &self.mechanics.inverse_masses)
    }

    /// The caller's number of the core's node `inside`.
    pub fn outward(&self, inside: usize) -> usize {
        self.layout.outward(inside)
    }

    /// The limiting part in words.
    pub fn part(&self, limit: &Limit) -> String {
        format!("{} near node {}", limit.law, self.layout.outward(limit.node))
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
            if self.step_count.is_multiple_of(self.settings.watch_interval.max(1)) {
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
        Instant { time: self.time(), positions: &self.state.positions, velocities: &self.state.velocities }
    }

    /// The progress, to be saved.
    pub fn progress(&self) -> Progress {
        let memory = self.integrator.memory();
        let vectors = memory.vectors.iter().map(|vectors| self.layout.scatter_vectors(vectors)).collect();
        let (state, work) = self.front();
        Progress {
            step_count: self.step_count,
            evaluation_count: self.evaluation_count(),
            origin: self.origin,
            positions: self.layout.scatter_vectors(&state.positions),
            velocities: self.layout.scatter_vectors(&state.velocities),
            ledger: Ledger { work: work.to_vec(), ..self.ledger.clone() },
            memory: (vectors, memory.numbers),
            adaptive: self.adaptive_progress(),
        }
    }

    /// Continues from a saved progress of the same model, laws, method and step.
    ///
    /// # Errors
    /// `LengthMismatch` where it is of another model, law or method, `NotFinite`.
    pub fn resume(&mut self, progress: &Progress) -> Result<()> {
        let nodes = self.mechanics.masses.len();
        let length = |what, found: usize, expected: usize, per| {
            if found == expected { Ok(()) } else { Err(Error::LengthMismatch { what, found, expected, per }) }
        };
        length("the saved ledger", progress.ledger.work.len(), self.laws().len(), "law")?;
        length("the saved ledger", progress.ledger.start.stored.len(), self.laws().len(), "law")?;
        for rows in &progress.memory.0 {
            length("the saved memory of the method", rows.len(), nodes, "node")?;
        }
        (self.origin, self.step_count) = (progress.origin, progress.step_count);
        self.set_motion(&progress.positions, &progress.velocities)?;
        self.mechanics.evaluation_count = progress.evaluation_count;
        self.ledger = progress.ledger.clone();
        let vectors = progress.memory.0.iter().map(|rows| self.layout.gather_vectors(rows)).collect();
        if !self.integrator.recall(Memory { vectors, numbers: progress.memory.1.clone() }) {
            let (found, expected) = (progress.memory.1.len(), self.laws().len());
            return Err(Error::LengthMismatch { what: "the saved memory of the method", found, expected, per: "law" });
        }
        self.resume_adaptive(progress.adaptive.as_ref())?;
        self.keep(self.accounts());
        self.show_saved(progress.adaptive.as_ref());
        Ok(())
    }

    /// Evaluations of the forces while stepping.
    pub fn evaluation_count(&self) -> u64 {
        self.mechanics.evaluation_count
    }
}

/// Held nodes do not move.
fn hold(inverse_masses: &[f64], velocities: &mut Vectors) {
    for (i, &inverse) in inverse_masses.iter().enumerate() {
        if inverse == 0.0 {
            velocities.row_mut(i).fill(0.0);
        }
    }
}
