//! The class behind Python's `Simulation`: that of the core, with the interpreter lock released during steps.

use std::time::{Duration, Instant};

use membrane_core::error::Error;
use membrane_core::integrators::METHODS;
use membrane_core::laws::WorkClass;
use membrane_core::simulation::Simulation as Core;
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::{checked, matrix, rows, vectors};
use crate::components::{model_of, settings_of};
use crate::laws::law_of;
use crate::progress::{progress_of, saved_of};
use crate::readings::{FilmStates, FilmStress, HubLoad, LinkReadings};
use crate::results::{EnergyBalance, MethodFacts, NewtonStatistics, StepLimit};

/// Interval between two checks for Ctrl-C.
const SIGNAL_INTERVAL: Duration = Duration::from_millis(20);

/// Properties of each method, in the order of the list.
#[pyfunction]
pub(crate) fn integrators() -> Vec<MethodFacts> {
    METHODS.iter().map(MethodFacts::of).collect()
}

/// A simulation of the core. Arrays are in external order.
#[pyclass(module = "membrane_rs._core")]
pub(crate) struct Simulation {
    core: Core,
    /// Estimated number of steps in `SIGNAL_INTERVAL`.
    chunk: u64,
}

/// Calls `advance` with `chunk` steps, for about `SIGNAL_INTERVAL`, until it returns true or `longest` has passed.
/// Whether it returned true.
///
/// `chunk` is kept from call to call: each check needs the interpreter lock, for which the core may wait.
fn in_chunks(
    py: Python<'_>,
    chunk: &mut u64,
    longest: Duration,
    mut advance: impl FnMut(u64) -> Result<bool, Error> + Send,
) -> PyResult<bool> {
    let began = Instant::now();
    loop {
        let start = Instant::now();
        let is_done = checked(py.detach(|| advance(*chunk)))?;
        py.check_signals()?;
        if is_done || began.elapsed() >= longest {
            return Ok(is_done);
        }
        let taken = start.elapsed();
        if taken < SIGNAL_INTERVAL / 2 {
            *chunk = chunk.saturating_mul(2);
        } else if taken > SIGNAL_INTERVAL * 2 {
            *chunk = (*chunk / 2).max(1);
        }
    }
}

#[pymethods]
impl Simulation {
    #[new]
    #[pyo3(signature = (model, laws, integrator, dt, settings, instructions=None))]
    fn new(
        model: &Bound<'_, PyAny>,
        laws: Vec<(String, Bound<'_, PyDict>)>,
        integrator: &str,
        dt: Option<f64>,
        settings: &Bound<'_, PyAny>,
        instructions: Option<&str>,
    ) -> PyResult<Self> {
        let laws = laws.iter().map(|(kind, parameters)| law_of(kind, parameters)).collect::<PyResult<Vec<_>>>()?;
        let settings = settings_of(settings, instructions)?;
        Ok(Self { core: checked(Core::new(model_of(model)?, &laws, integrator, dt, settings))?, chunk: 1 })
    }

    #[getter]
    fn time(&self) -> f64 {
        self.core.time()
    }

    #[getter]
    fn dt(&self) -> f64 {
        self.core.dt()
    }

    fn set_dt(&mut self, dt: f64) -> PyResult<()> {
        checked(self.core.set_dt(dt))
    }

    #[getter]
    fn step_count(&self) -> u64 {
        self.core.step_count()
    }

    #[getter]
    fn evaluation_count(&self) -> u64 {
        self.core.evaluation_count()
    }

    #[getter]
    fn is_adaptive(&self) -> bool {
        self.core.is_adaptive()
    }

    #[getter]
    fn rejected_count(&self) -> u64 {
        self.core.rejected_count()
    }

    /// Counts of an implicit method; zeros for others.
    #[getter]
    fn statistics(&self) -> NewtonStatistics {
        self.core.integrator().implicit().map(|method| method.statistics()).unwrap_or_default().into()
    }

    #[getter]
    fn integrator(&self) -> &'static str {
        self.core.integrator().properties().name
    }

    #[getter]
    fn hub_angle(&self) -> f64 {
        self.core.hub_angle()
    }

    /// The instruction set of the kernels.
    #[getter]
    fn instructions(&self) -> &'static str {
        self.core.instructions().name()
    }

    /// Share of the elements in contiguous or split batches, by law.
    fn contiguous_shares<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let shares = PyDict::new(py);
        for law in self.core.laws() {
            if let Some(share) = law.inspection().and_then(|law| law.contiguous_share()) {
                shares.set_item(law.name(), share)?;
            }
        }
        Ok(shares)
    }

    #[getter]
    fn slow_laws(&self) -> Vec<&'static str> {
        self.core.slow_laws().collect()
    }

    #[getter]
    fn law_names(&self) -> Vec<&'static str> {
        self.core.laws().iter().map(|law| law.name()).collect()
    }

    fn positions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        vectors(py, &self.core.positions())
    }

    fn velocities<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        vectors(py, &self.core.velocities())
    }

    fn set_motion(&mut self, positions: &Bound<'_, PyAny>, velocities: &Bound<'_, PyAny>) -> PyResult<()> {
        checked(self.core.set_motion(&rows("positions", positions)?, &rows("velocities", velocities)?))
    }

    fn masses<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_vec(py, self.core.masses())
    }

    #[pyo3(signature = (law=None))]
    fn forces<'py>(&mut self, py: Python<'py>, law: Option<&str>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        vectors(py, &checked(self.core.forces(law))?)
    }

    /// Energies in joules by name: "kinetic", and one for each law that has a potential.
    fn energies<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let (terms, energies) = (self.core.energy_terms(), PyDict::new(py));
        energies.set_item("kinetic", terms.kinetic)?;
        for (law, energy) in self.core.laws().iter().zip(terms.stored) {
            if law.properties().work_class == WorkClass::Conservative {
                energies.set_item(law.name(), energy)?;
            }
        }
        Ok(energies)
    }

    /// The energy balance at present.
    fn ledger(&self, py: Python<'_>) -> PyResult<EnergyBalance> {
        EnergyBalance::of(py, &self.core)
    }

    /// Readings of the links of one law, or None without links.
    fn link_readings(&self, py: Python<'_>, law: &str) -> Option<LinkReadings> {
        self.core.links(law).map(|links| LinkReadings {
            strain: PyArray1::from_vec(py, links.strain).unbind(),
            tension: PyArray1::from_vec(py, links.tension).unbind(),
            buckled: PyArray1::from_vec(py, links.buckled).unbind(),
        })
    }

    /// State of a film of triangles, or None without its law.
    fn film_states(&self, py: Python<'_>) -> PyResult<Option<FilmStates>> {
        let Some(film) = self.core.film_states() else { return Ok(None) };
        Ok(Some(FilmStates {
            strain: matrix(py, &film.strain)?.unbind(),
            state: PyArray1::from_vec(py, film.state).unbind(),
            buckled: PyArray1::from_vec(py, film.buckled).unbind(),
        }))
    }

    /// Stress of each triangle of the film, or None without its law.
    fn film_stress(&self, py: Python<'_>) -> PyResult<Option<FilmStress>> {
        let Some(stresses) = self.core.film_stress() else { return Ok(None) };
        let values: Vec<[f64; 2]> = stresses.iter().map(|stress| stress.values()).collect();
        let directions: Vec<[[f64; 3]; 2]> = stresses.iter().map(|stress| stress.directions()).collect();
        let [first, second] = [0, 1].map(|k| directions.iter().map(|pair| pair[k]).collect::<Vec<[f64; 3]>>());
        Ok(Some(FilmStress {
            principal: matrix(py, &values)?.unbind(),
            first: vectors(py, &first)?.unbind(),
            second: vectors(py, &second)?.unbind(),
        }))
    }

    /// The largest principal stress of the film [Pa], at least 0, or None without its law.
    fn largest_film_stress(&self) -> Option<f64> {
        self.core.largest_film_stress()
    }

    /// Crease angles [rad], or None without the law.
    fn crease_angles<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<f64>>> {
        self.core.crease_angles().map(|angles| PyArray1::from_vec(py, angles))
    }

    /// Forces of contact that the hub exerts on the nodes.
    fn contact_forces<'py>(&mut self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        vectors(py, &self.core.contact_forces())
    }

    /// The load of the sail on the hub.
    fn hub_load(&mut self) -> HubLoad {
        self.core.hub_load().into()
    }

    /// The limit of the step at the current positions.
    fn limit(&self, py: Python<'_>) -> PyResult<StepLimit> {
        let limit = checked(py.detach(|| self.core.limit()))?;
        Ok(StepLimit::of(&self.core, &limit))
    }

    /// Takes `count` steps without the interpreter lock; Ctrl-C stops it between two steps.
    fn step(&mut self, py: Python<'_>, count: u64) -> PyResult<()> {
        let mut left = count;
        let Self { core, chunk } = self;
        in_chunks(py, chunk, Duration::MAX, |chunk| {
            let now = chunk.min(left);
            left -= now;
            core.step(now).map(|()| left == 0)
        })?;
        Ok(())
    }

    /// Steps to `time` [s] and shows the state there, or stops after about `seconds` of wall time at the end of a step;
    /// Ctrl-C as in `step`. Whether `time` was reached.
    #[pyo3(signature = (time, seconds=None))]
    fn reach(&mut self, py: Python<'_>, time: f64, seconds: Option<f64>) -> PyResult<bool> {
        let longest = seconds.and_then(|seconds| Duration::try_from_secs_f64(seconds).ok()).unwrap_or(Duration::MAX);
        let Self { core, chunk } = self;
        in_chunks(py, chunk, longest, |chunk| core.reach(time, chunk))
    }

    /// Checks for a fault, between the regular checks.
    fn check(&mut self) -> PyResult<()> {
        checked(self.core.check())
    }

    /// The data of a checkpoint, for `resume`.
    fn progress<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        saved_of(py, self.core.progress(), &self.law_names())
    }

    /// Continues from a checkpoint.
    fn resume(&mut self, saved: &Bound<'_, PyDict>) -> PyResult<()> {
        let progress = progress_of(saved, &self.law_names())?;
        checked(self.core.resume(&progress))
    }
}
