//! The class behind Python's `Simulation`: that of the core, with the interpreter lock released during steps.

use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use membrane_core::error::Error;
use membrane_core::laws::WorkClass;
use membrane_core::simulation::Simulation as Core;
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::sync::MutexExt;
use pyo3::types::PyDict;

use crate::arrays::{checked, rows, vectors};
use crate::components::{model_of, settings_of};
use crate::errors::wrong_value;
use crate::laws::law_of;
use crate::past::Past;
use crate::progress::{check_values, names_of, progress_of, saved_of};
use crate::readings::{FilmStates, FilmStress, HubLoad, LinkReadings};
use crate::results::{ContactStatistics, EnergyBalance, HubMotion, NewtonStatistics, StepLimit};

/// Interval between two checks for Ctrl-C.
const SIGNAL_INTERVAL: Duration = Duration::from_millis(20);
/// Longest pause between two chunks of steps for other threads that wait to read, in periods of `READER_PERIOD`.
const READER_PERIODS: u32 = 100;
const READER_PERIOD: Duration = Duration::from_micros(50);

/// A simulation of the core. Arrays are in external order.
///
/// One thread steps or sets it at a time; another one that tries is refused. Any thread may read it meanwhile: it waits
/// for the end of a chunk of steps.
#[pyclass(module = "membrane_rs._core", frozen)]
pub(crate) struct Simulation {
    core: Mutex<Core>,
    /// Estimated number of steps in `SIGNAL_INTERVAL`.
    chunk: AtomicU64,
    is_stepping: AtomicBool,
    /// Threads that wait for `core`.
    waiting: AtomicUsize,
}

/// The right to step, until it is dropped.
struct Stepping<'a>(&'a Simulation);

impl Drop for Stepping<'_> {
    fn drop(&mut self) {
        self.0.is_stepping.store(false, Ordering::Release);
    }
}

impl Simulation {
    /// The core, once no other thread uses it. Without the interpreter lock while it waits, so that a thread that
    /// steps can check for Ctrl-C.
    fn core(&self, py: Python<'_>) -> MutexGuard<'_, Core> {
        self.waiting.fetch_add(1, Ordering::AcqRel);
        let guard = self.core.lock_py_attached(py).unwrap_or_else(PoisonError::into_inner);
        self.waiting.fetch_sub(1, Ordering::AcqRel);
        guard
    }

    /// The right to step or to set the motion.
    fn stepping(&self) -> PyResult<Stepping<'_>> {
        if self.is_stepping.swap(true, Ordering::AcqRel) {
            let what = "this simulation is being stepped by another thread, or by what called this; wait until its \
                        step or run has ended, or give each thread a simulation of its own (copy.copy)";
            return Err(wrong_value(what.to_owned()));
        }
        Ok(Stepping(self))
    }

    /// Calls `advance` with a number of steps, for about `SIGNAL_INTERVAL`, until it returns true or `longest` has
    /// passed. Whether it returned true.
    ///
    /// The number is kept from call to call: each check needs the interpreter lock, for which the core may wait.
    fn in_chunks(
        &self,
        py: Python<'_>,
        longest: Duration,
        mut advance: impl FnMut(&mut Core, u64) -> Result<bool, Error> + Send,
    ) -> PyResult<bool> {
        let _right = self.stepping()?;
        let began = Instant::now();
        loop {
            let chunk = self.chunk.load(Ordering::Relaxed);
            let start = Instant::now();
            let is_done = checked(py.detach(|| {
                let is_done = advance(&mut self.core.lock().unwrap_or_else(PoisonError::into_inner), chunk);
                for _ in 0..READER_PERIODS {
                    if self.waiting.load(Ordering::Acquire) == 0 {
                        break;
                    }
                    std::thread::sleep(READER_PERIOD);
                }
                is_done
            }))?;
            py.check_signals()?;
            if is_done || began.elapsed() >= longest {
                return Ok(is_done);
            }
            let taken = start.elapsed();
            if taken < SIGNAL_INTERVAL / 2 {
                self.chunk.store(chunk.saturating_mul(2), Ordering::Relaxed);
            } else if taken > SIGNAL_INTERVAL * 2 {
                self.chunk.store((chunk / 2).max(1), Ordering::Relaxed);
            }
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
        let (py, model) = (model.py(), model_of(model)?);
        let core = checked(py.detach(|| Core::new(model, &laws, integrator, dt, settings)))?;
        Ok(Self {
            core: Mutex::new(core),
            chunk: AtomicU64::new(1),
            is_stepping: AtomicBool::new(false),
            waiting: AtomicUsize::new(0),
        })
    }

    #[getter]
    fn time(&self, py: Python<'_>) -> f64 {
        self.core(py).time()
    }

    #[getter]
    fn dt(&self, py: Python<'_>) -> f64 {
        self.core(py).dt()
    }

    fn set_dt(&self, py: Python<'_>, dt: f64) -> PyResult<()> {
        let _right = self.stepping()?;
        checked(self.core(py).set_dt(dt))
    }

    #[getter]
    fn step_count(&self, py: Python<'_>) -> u64 {
        self.core(py).step_count()
    }

    #[getter]
    fn evaluation_count(&self, py: Python<'_>) -> u64 {
        self.core(py).evaluation_count()
    }

    #[getter]
    fn is_adaptive(&self, py: Python<'_>) -> bool {
        self.core(py).is_adaptive()
    }

    #[getter]
    fn rejected_count(&self, py: Python<'_>) -> u64 {
        self.core(py).rejected_count()
    }

    /// Counts of an implicit method; zeros for others.
    #[getter]
    fn statistics(&self, py: Python<'_>) -> NewtonStatistics {
        self.core(py).integrator().implicit().map(|method| method.statistics()).unwrap_or_default().into()
    }

    /// What contact between layers has spent; zeros without it.
    #[getter]
    fn contact_statistics(&self, py: Python<'_>) -> ContactStatistics {
        self.core(py).contact_statistics().into()
    }

    #[getter]
    fn integrator(&self, py: Python<'_>) -> &'static str {
        self.core(py).integrator().properties().name
    }

    #[getter]
    fn hub_angle(&self, py: Python<'_>) -> f64 {
        self.core(py).hub_angle()
    }

    #[getter]
    fn hub_rate(&self, py: Python<'_>) -> f64 {
        self.core(py).hub_rate()
    }

    fn hub(&self, py: Python<'_>) -> HubMotion {
        HubMotion::of(&self.core(py))
    }

    #[getter]
    fn instructions(&self, py: Python<'_>) -> &'static str {
        self.core(py).instructions().name()
    }

    /// Share of the elements in contiguous or split batches, by law.
    fn contiguous_shares<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let shares = PyDict::new(py);
        for law in self.core(py).laws() {
            if let Some(share) = law.inspection().and_then(|law| law.contiguous_share()) {
                shares.set_item(law.name(), share)?;
            }
        }
        Ok(shares)
    }

    #[getter]
    fn slow_laws(&self, py: Python<'_>) -> Vec<&'static str> {
        self.core(py).slow_laws().collect()
    }

    #[getter]
    fn law_names(&self, py: Python<'_>) -> Vec<&'static str> {
        names_of(&self.core(py))
    }

    fn positions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        vectors(py, &self.core(py).positions())
    }

    fn velocities<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        vectors(py, &self.core(py).velocities())
    }

    fn set_motion(&self, py: Python<'_>, positions: &Bound<'_, PyAny>, velocities: &Bound<'_, PyAny>) -> PyResult<()> {
        let _right = self.stepping()?;
        checked(self.core(py).set_motion(&rows("positions", positions)?, &rows("velocities", velocities)?))
    }

    /// Starts from a motion at a time [s], with this motion of the hub, and what positions do not show of its past.
    fn start_from(
        &self,
        py: Python<'_>,
        time: f64,
        hub: &HubMotion,
        positions: &Bound<'_, PyAny>,
        velocities: &Bound<'_, PyAny>,
        past: Past,
    ) -> PyResult<()> {
        let _right = self.stepping()?;
        let (positions, velocities) = (rows("positions", positions)?, rows("velocities", velocities)?);
        let angles = past.angles.as_deref();
        checked(self.core(py).start_from(time, &hub.state, &positions, &velocities, angles, &past.shapes))
    }

    fn masses<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_vec(py, self.core(py).masses())
    }

    #[pyo3(signature = (law=None))]
    fn forces<'py>(&self, py: Python<'py>, law: Option<&str>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        vectors(py, &checked(self.core(py).forces(law))?)
    }

    /// Energies in joules by name: "kinetic", and one for each law that has a potential.
    fn energies<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let (kinetic, stored) = {
            let core = self.core(py);
            let terms = core.energy_terms();
            let laws = core.laws().iter().zip(terms.stored);
            let stored = laws.filter(|(law, _)| law.properties().work_class == WorkClass::Conservative);
            (terms.kinetic, stored.map(|(law, energy)| (law.name(), energy)).collect::<Vec<_>>())
        };
        let energies = PyDict::new(py);
        energies.set_item("kinetic", kinetic)?;
        for (law, energy) in stored {
            energies.set_item(law, energy)?;
        }
        Ok(energies)
    }

    /// The energy balance at present.
    fn ledger(&self, py: Python<'_>) -> PyResult<EnergyBalance> {
        EnergyBalance::of(py, &self.core(py))
    }

    /// Readings of the links of one law, or None without links.
    fn link_readings(&self, py: Python<'_>, law: &str) -> Option<LinkReadings> {
        self.core(py).links(law).map(|links| LinkReadings::of(py, links))
    }

    /// State of a film of triangles, or None without its law.
    fn film_states(&self, py: Python<'_>) -> PyResult<Option<FilmStates>> {
        self.core(py).film_states().map(|film| FilmStates::of(py, film)).transpose()
    }

    /// Stress of each triangle of the film, or None without its law.
    fn film_stress(&self, py: Python<'_>) -> PyResult<Option<FilmStress>> {
        self.core(py).film_stress().map(|stresses| FilmStress::of(py, &stresses)).transpose()
    }

    /// The largest principal stress of the film [Pa], at least 0, or None without its law.
    fn largest_film_stress(&self, py: Python<'_>) -> Option<f64> {
        let core = self.core(py);
        py.detach(|| core.largest_film_stress())
    }

    /// Crease angles [rad], or None without the law.
    fn crease_angles<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<f64>>> {
        self.core(py).crease_angles().map(|angles| PyArray1::from_vec(py, angles))
    }

    /// Shapes whose distances layers of the film keep.
    fn layer_shapes<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyArray2<f64>>>> {
        self.core(py).layer_shapes().iter().map(|shape| vectors(py, shape)).collect()
    }

    /// Forces of contact that the hub exerts on the nodes.
    fn contact_forces<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        vectors(py, &self.core(py).contact_forces())
    }

    /// The load of the sail on the hub.
    fn hub_load(&self, py: Python<'_>) -> HubLoad {
        let core: &mut Core = &mut self.core(py);
        py.detach(|| core.hub_load()).into()
    }

    /// The limit of the step at the current positions.
    fn limit(&self, py: Python<'_>) -> PyResult<StepLimit> {
        let core = self.core(py);
        let limit = py.detach(|| core.limit());
        Ok(StepLimit::of(&core, &checked(limit)?))
    }

    /// The same at the start, as it was found when the simulation was made.
    fn start_limit(&self, py: Python<'_>) -> StepLimit {
        let core = self.core(py);
        StepLimit::of(&core, core.start_limit())
    }

    /// Takes `count` steps without the interpreter lock; Ctrl-C stops it between two steps.
    fn step(&self, py: Python<'_>, count: u64) -> PyResult<()> {
        let mut left = count;
        self.in_chunks(py, Duration::MAX, |core, chunk| {
            let now = chunk.min(left);
            left -= now;
            core.step(now).map(|()| left == 0)
        })?;
        Ok(())
    }

    /// Steps to `time` [s] and shows the state there, or stops after about `seconds` of wall time at the end of a step;
    /// Ctrl-C as in `step`. Whether `time` was reached.
    #[pyo3(signature = (time, seconds=None))]
    fn reach(&self, py: Python<'_>, time: f64, seconds: Option<f64>) -> PyResult<bool> {
        let longest = seconds.and_then(|seconds| Duration::try_from_secs_f64(seconds).ok()).unwrap_or(Duration::MAX);
        self.in_chunks(py, longest, |core, chunk| core.reach(time, chunk))
    }

    /// Time at the end of a constant step, by its number, or of a jump of schedules before it [s].
    fn time_of_step(&self, py: Python<'_>, number: u64) -> f64 {
        self.core(py).time_of_step(number)
    }

    /// Checks for a fault, between the regular checks; at the end of a run the energy balance too.
    fn check(&self, py: Python<'_>, is_end: bool) -> PyResult<()> {
        let core: &mut Core = &mut self.core(py);
        checked(py.detach(|| core.check(is_end)))
    }

    /// The data of a checkpoint, for `resume`.
    fn progress<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let core = self.core(py);
        let (names, progress) = (names_of(&core), core.progress());
        drop(core);
        saved_of(py, progress, &names)
    }

    /// Continues from a checkpoint.
    fn resume(&self, py: Python<'_>, saved: &Bound<'_, PyDict>) -> PyResult<()> {
        let _right = self.stepping()?;
        let names = names_of(&self.core(py));
        let progress = progress_of(saved, &names)?;
        check_values(&progress)?;
        checked(self.core(py).resume(&progress))
    }
}
