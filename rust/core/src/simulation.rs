//! The step loop; owns laws, method, state, ledger and watch.

use crate::error::{Error, Result};
use crate::forces::{self, Law, LawSpec, Readings, Spin};
use crate::integrators::{self, Integrator, System};
use crate::layout::Layout;
use crate::ledger::{Accounts, Ledger};
use crate::model::{Assembly, Model, non_negative, positive};
use crate::stability::{self, Limit};
use crate::state::{Instant, State, Vectors, columns_mut};
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
    /// The instructions that kernels run with; the bits of the results do not depend on it.
    pub width: Width,
}

impl Default for Settings {
    fn default() -> Self {
        Self { margin: 0.4, watch_interval: 32, energy_tolerance: 1e-2, width: Width::widest() }
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

impl System for Mechanics {
    fn accelerate(&mut self, at: Instant<'_>, accelerations: &mut Vectors, powers: &mut [f64]) {
        accelerations.as_mut_slice().fill(0.0);
        for (law, power) in self.laws.iter().zip(powers) {
            *power = law.add_forces(at, accelerations);
        }
        self.width.run(Divide { columns: columns_mut(accelerations), inverse_masses: &self.inverse_masses });
        self.evaluation_count += 1;
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
    /// The state at the last check that found nothing.
    good: (u64, State, Vec<f64>, Accounts),
}

impl Simulation {
    /// Assembles a model and its laws. `dt` of `None` takes the stability limit times the margin.
    ///
    /// # Errors
    /// Those of `Assembly::new` and of the laws; `UnknownName` for the integrator; `NoStiffness` without `dt` where no step
    /// follows; `HopelessStep`; `OutOfRange` for `dt`.
    pub fn new(model: Model, laws: &[LawSpec], integrator: &str, dt: Option<f64>, settings: Settings) -> Result<Self> {
        positive("margin", settings.margin)?;
        non_negative("energy tolerance", settings.energy_tolerance)?;
        if let Some(dt) = dt {
            positive("dt [s]", dt)?;
        }
        let assembly = Assembly::new(model, settings.width)?;
        let spin = forces::spin_of(laws);
        let laws = forces::build(laws, &assembly)?;
        let integrator = integrators::by_name(integrator, assembly.masses.len(), laws.len(), settings.width)?;
        let gather = |rows: &[[f64; 3]]| assembly.layout.gather_vectors(rows);
        let mut state =
            State { positions: gather(&assembly.model.positions), velocities: gather(&assembly.model.velocities) };
        hold(&assembly.inverse_masses, &mut state.velocities);
        let mechanics = Mechanics {
            laws,
            masses: assembly.masses,
            inverse_masses: assembly.inverse_masses,
            evaluation_count: 0,
            width: settings.width,
        };
        let accounts = Accounts::take(&mechanics.laws, &mechanics.masses, 0.0, &state);
        let ledger = Ledger::open(accounts.clone());
        let good = (0, state.clone(), ledger.work.clone(), accounts);
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
        };
        let limit = simulation.limit()?;
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
            None if limit.dt.is_finite() => settings.margin * limit.dt,
            None => return Err(Error::NoStiffness),
        };
        Ok(simulation)
    }

    /// Time \[s\].
    pub fn time(&self) -> f64 {
        self.time_of(self.step_count)
    }

    fn time_of(&self, step: u64) -> f64 {
        self.origin + step as f64 * self.dt
    }

    /// The step \[s\].
    pub fn dt(&self) -> f64 {
        self.dt
    }

    /// Changes the step; steps are counted anew from now, in the ledger's same accounts.
    ///
    /// # Errors
    /// `OutOfRange`.
    pub fn set_dt(&mut self, dt: f64) -> Result<()> {
        positive("dt [s]", dt)?;
        (self.origin, self.step_count, self.good.0, self.dt) = (self.time(), 0, 0, dt);
        Ok(())
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
            let time = self.time();
            self.integrator.step(&mut self.mechanics, time, self.dt, &mut self.state, &mut self.ledger.work);
            self.step_count += 1;
            if self.step_count.is_multiple_of(self.settings.watch_interval.max(1)) {
                self.regular_check()?;
            }
        }
        Ok(())
    }

    /// Looks for values that are not finite, springs over their bound, and energy from nowhere, between two regular
    /// checks: it leaves no trace in the ledger, so that looking on changes nothing.
    ///
    /// # Errors
    /// `Unstable`; the state is then that of the last good regular check.
    pub fn check(&mut self) -> Result<()> {
        let now = self.accounts();
        self.refuse_fault(&now)
    }

    fn regular_check(&mut self) -> Result<()> {
        let now = self.accounts();
        self.refuse_fault(&now)?;
        self.ledger.swing = self.ledger.turned_over(&now);
        self.keep(now);
        Ok(())
    }

    fn refuse_fault(&mut self, now: &Accounts) -> Result<()> {
        if let Some((what, place, law, cure)) = self.fault(now) {
            let (time, step) = (self.time(), self.step_count);
            (self.step_count, self.state, self.ledger.work) = (self.good.0, self.good.1.clone(), self.good.2.clone());
            return Err(Error::Unstable { time, step, good_time: self.time(), what, place, law, cure });
        }
        Ok(())
    }

    fn keep(&mut self, accounts: Accounts) {
        self.good.0 = self.step_count;
        self.good.1.positions.copy_from(&self.state.positions);
        self.good.1.velocities.copy_from(&self.state.velocities);
        self.good.2.copy_from_slice(&self.ledger.work);
        self.good.3 = accounts;
    }

    /// What is wrong now: in words, where, by which law, and the cure.
    fn fault(&self, now: &Accounts) -> Option<(String, String, String, String)> {
        let laws = &self.mechanics.laws;
        let blame = || {
            // The law whose energy (or work) grew most since the last good check; NaN counts as most.
            let growth = |k: usize| {
                let grown =
                    (now.stored[k] - self.good.3.stored[k]).abs() + (self.ledger.work[k] - self.good.2[k]).abs();
                if grown.is_nan() { f64::INFINITY } else { grown }
            };
            (0..laws.len()).max_by(|&a, &b| growth(a).total_cmp(&growth(b)))
        };
        let explain = |law: Option<usize>| {
            let name = law.map_or("no law", |k| laws[k].name());
            let limit =
                stability::limit(self.integrator.as_ref(), laws, self.good_instant(), &self.mechanics.inverse_masses);
            let cure = match limit {
                Ok(limit) if self.dt > limit.dt => format!(
                    "dt = {:.3e} s is above the stability limit of {:.3e} s that {} sets: use a smaller dt, or leave it out",
                    self.dt,
                    limit.dt,
                    self.part(&limit)
                ),
                _ => law.map_or("check the scene", |k| laws[k].cure()).to_owned(),
            };
            (name.to_owned(), cure)
        };
        let node_of = |row: usize| format!("node {}", self.layout.outward(row));
        let bad = (0..self.state.positions.nrows())
            .find(|&i| !(self.state.positions.row(i).sum() + self.state.velocities.row(i).sum()).is_finite());
        if let Some(row) = bad {
            let (law, cure) = explain(blame());
            return Some(("a position or velocity is no longer finite".to_owned(), node_of(row), law, cure));
        }
        for (k, law) in laws.iter().enumerate() {
            if let Some(excess) = law.first_excess(self.instant()) {
                let [i, j] = excess.nodes.map(|node| self.layout.outward(node as usize));
                let (law, cure) = explain(Some(k));
                return Some((excess.what, format!("between nodes {i} and {j}"), law, cure));
            }
        }
        let (surplus, turned_over) = (self.ledger.surplus(now), self.ledger.turned_over(now));
        // Rounding: a fraction of the largest account.
        let rounding = 1e-9 * now.stored.iter().fold(now.kinetic, |most, stored| most.max(stored.abs()));
        if surplus.is_nan() || surplus > self.settings.energy_tolerance * turned_over + rounding {
            let speeds: Vec<f64> = self.state.velocities.row_iter().map(|row| row.norm_squared()).collect();
            let fastest = (0..speeds.len()).max_by(|&i, &j| speeds[i].total_cmp(&speeds[j])).unwrap_or(0);
            let what = format!(
                "{surplus:.3e} J appeared from nowhere, {:.3} % of the energy turned over so far",
                100.0 * surplus / turned_over
            );
            let (law, cure) = explain(blame());
            return Some((
                what,
                format!("{} is fastest at {:.3e} m/s", node_of(fastest), speeds[fastest].sqrt()),
                law,
                cure,
            ));
        }
        None
    }

    fn instant(&self) -> Instant<'_> {
        Instant { time: self.time(), positions: &self.state.positions, velocities: &self.state.velocities }
    }

    fn good_instant(&self) -> Instant<'_> {
        Instant {
            time: self.time_of(self.good.0),
            positions: &self.good.1.positions,
            velocities: &self.good.1.velocities,
        }
    }

    /// The progress, to be saved.
    pub fn progress(&self) -> Progress {
        Progress {
            step_count: self.step_count,
            evaluation_count: self.evaluation_count(),
            origin: self.origin,
            positions: self.positions(),
            velocities: self.velocities(),
            ledger: self.ledger.clone(),
        }
    }

    /// Continues from a saved progress of the same model, laws, method and step.
    ///
    /// # Errors
    /// `LengthMismatch` where it is of another model, `NotFinite`.
    pub fn resume(&mut self, progress: &Progress) -> Result<()> {
        for (found, expected) in
            [(progress.ledger.work.len(), self.laws().len()), (progress.ledger.start.stored.len(), self.laws().len())]
        {
            if found != expected {
                return Err(Error::LengthMismatch { what: "the saved ledger", found, expected, per: "law" });
            }
        }
        (self.origin, self.step_count) = (progress.origin, progress.step_count);
        self.set_motion(&progress.positions, &progress.velocities)?;
        self.mechanics.evaluation_count = progress.evaluation_count;
        self.ledger = progress.ledger.clone();
        self.keep(self.accounts());
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
