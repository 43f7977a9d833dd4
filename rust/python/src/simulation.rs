//! The class that Python's `Simulation` drives: the core's, with the interpreter lock released while it steps.

use std::time::{Duration, Instant};

use membrane_core::error::Error;
use membrane_core::integrators::{METHODS, Method, Options, Properties, Statistics, Tolerance};
use membrane_core::laws::{Readings, WorkClass};
use membrane_core::model::input::{Cord, Film, Model, NegativeSprings};
use membrane_core::simd::dispatch::InstructionSet;
use membrane_core::simulation::{Settings, Simulation as Core};
use membrane_core::stability::axis_limits;
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::{checked, index_rows, indices, numbers, rows, vectors};
use crate::errors::wrong_value;
use crate::laws::law_of;
use crate::progress::{progress_of, saved_of};

/// One number for each law that has one.
type ByLaw = Vec<(&'static str, f64)>;
/// Strain and whether buckled, per spring.
type SpringArrays<'py> = (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<bool>>);
/// Principal strains and state, per triangle.
type TriangleArrays<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray1<u8>>);

/// How long the core steps between two looks for Ctrl-C.
const BREATH: Duration = Duration::from_millis(20);

/// Name, order, evaluations per step and at the start, whether energy is kept, whether the error is known, limits on the axes.
type Facts = (&'static str, u32, u32, u32, bool, bool, f64, f64);

/// What is known of each integrator.
#[pyfunction]
pub(crate) fn integrators() -> PyResult<Vec<Facts>> {
    let facts = |method: &Method| {
        let mut made = (method.make)(&Options::default());
        let [imaginary, real] = axis_limits(made.as_ref());
        let is_embedded = made.embedded().is_some();
        let Properties { order, evaluations_per_step, evaluations_at_start, conserves_energy, .. } = made.properties();
        Ok((
            method.name,
            order,
            evaluations_per_step,
            evaluations_at_start,
            conserves_energy,
            is_embedded,
            imaginary,
            real,
        ))
    };
    METHODS.iter().map(facts).collect()
}

/// A scene in the core's hands. Arrays go in and come out in the caller's numbering.
#[pyclass(module = "membrane_rs._core")]
pub(crate) struct Simulation {
    core: Core,
    /// Steps that fit into a breath, as far as is known.
    batch: u64,
}

impl Simulation {
    fn reading<T>(&self, law: &str, take: impl Fn(Readings) -> Option<T>) -> Option<T> {
        self.core.readings().filter(|(name, _)| *name == law).find_map(|(_, readings)| take(readings))
    }
}

/// Calls `go` with `batch` steps at a time, about a breath's worth, until it says that it is done.
///
/// The batch is kept from call to call: each look takes the interpreter's lock, for which a thread that writes may make
/// the core wait.
fn in_breaths(py: Python<'_>, batch: &mut u64, mut go: impl FnMut(u64) -> Result<bool, Error> + Send) -> PyResult<()> {
    loop {
        let start = Instant::now();
        let is_done = checked(py.detach(|| go(*batch)))?;
        py.check_signals()?;
        if is_done {
            return Ok(());
        }
        let taken = start.elapsed();
        if taken < BREATH / 2 {
            *batch = batch.saturating_mul(2);
        } else if taken > BREATH * 2 {
            *batch = (*batch / 2).max(1);
        }
    }
}

#[pymethods]
impl Simulation {
    #[new]
    #[pyo3(signature = (*, positions, velocities, reference, triangles, film, negative_springs, creases, fold_signs,
        extra_masses, fixed, cord_pairs, cord_stiffness, cord_rest_length, cord_strain_limit, bridges, bridge_stiffness, contact_nodes,
        laws, integrator, dt, margin, watch_interval, energy_tolerance, loss_tolerance, tolerance, spectral_radius,
        short_steps, instructions=None))]
    #[allow(clippy::too_many_arguments)] // Named on the Python side; this is the one place where a scene crosses over.
    fn new(
        positions: &Bound<'_, PyAny>,
        velocities: &Bound<'_, PyAny>,
        reference: &Bound<'_, PyAny>,
        triangles: &Bound<'_, PyAny>,
        film: Option<(f64, f64, f64, f64)>,
        negative_springs: &str,
        creases: &Bound<'_, PyAny>,
        fold_signs: &Bound<'_, PyAny>,
        extra_masses: &Bound<'_, PyAny>,
        fixed: &Bound<'_, PyAny>,
        cord_pairs: &Bound<'_, PyAny>,
        cord_stiffness: &Bound<'_, PyAny>,
        cord_rest_length: &Bound<'_, PyAny>,
        cord_strain_limit: &Bound<'_, PyAny>,
        bridges: &Bound<'_, PyAny>,
        bridge_stiffness: f64,
        contact_nodes: &Bound<'_, PyAny>,
        laws: Vec<(String, Bound<'_, PyDict>)>,
        integrator: &str,
        dt: Option<f64>,
        margin: f64,
        watch_interval: u64,
        energy_tolerance: f64,
        loss_tolerance: f64,
        tolerance: (f64, f64, f64),
        spectral_radius: f64,
        short_steps: u32,
        instructions: Option<&str>,
    ) -> PyResult<Self> {
        let cord_nodes = index_rows("cord_pairs", cord_pairs)?;
        let [stiffness, rest_length, strain_limit] = [
            numbers("cord_stiffness", cord_stiffness)?,
            numbers("cord_rest_length", cord_rest_length)?,
            numbers("cord_strain_limit", cord_strain_limit)?,
        ];
        if [&stiffness, &rest_length, &strain_limit].iter().any(|column| column.len() != cord_nodes.len()) {
            return Err(wrong_value("the arrays of the cords must have equally many rows".to_owned()));
        }
        let cord = |(row, nodes)| Cord {
            nodes,
            stiffness: stiffness[row],
            rest_length: rest_length[row],
            strain_limit: strain_limit[row],
        };
        let model = Model {
            positions: rows("positions", positions)?,
            velocities: rows("velocities", velocities)?,
            reference: rows("reference", reference)?,
            triangles: index_rows("triangles", triangles)?,
            film: film.map(|(youngs_modulus, poisson_ratio, density, thickness)| Film {
                youngs_modulus,
                poisson_ratio,
                density,
                thickness,
            }),
            negative_springs: match negative_springs {
                "refuse" => NegativeSprings::Refuse,
                "clip" => NegativeSprings::Clip,
                "keep" => NegativeSprings::Keep,
                "unused" => NegativeSprings::Unused,
                other => {
                    return Err(wrong_value(format!("negative = {other:?} is not known; choose refuse, clip or keep")));
                }
            },
            creases: index_rows("creases", creases)?,
            fold_signs: numbers("fold_signs", fold_signs)?,
            extra_masses: numbers("extra_masses", extra_masses)?,
            fixed: indices("fixed", fixed)?,
            cords: cord_nodes.into_iter().enumerate().map(cord).collect(),
            bridges: index_rows("bridges", bridges)?,
            bridge_stiffness,
            contact_nodes: indices("contact_nodes", contact_nodes)?,
        };
        let laws = laws.iter().map(|(kind, parameters)| law_of(kind, parameters)).collect::<PyResult<Vec<_>>>()?;
        let instructions = match instructions {
            None => InstructionSet::widest(),
            Some(name) => {
                InstructionSet::ALL.into_iter().find(|instructions| instructions.name() == name).ok_or_else(|| {
                    let known = InstructionSet::ALL.map(InstructionSet::name).join(", ");
                    wrong_value(format!("there are no instructions named {name:?}; choose one of: {known}"))
                })?
            }
        };
        let (relative, length, speed) = tolerance;
        let tolerance = Tolerance { relative, length, speed };
        let settings = Settings {
            margin,
            watch_interval,
            energy_tolerance,
            loss_tolerance,
            tolerance,
            spectral_radius,
            substeps: short_steps,
            instructions,
        };
        Ok(Self { core: checked(Core::new(model, &laws, integrator, dt, settings))?, batch: 1 })
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

    /// (Newton iterations, factorisations, steps taken in halves) of an implicit method; zeros of others.
    #[getter]
    fn effort(&self) -> (u64, u64, u64) {
        let Statistics { iterations, factorisations, fallbacks } =
            self.core.integrator().implicit().map(|method| method.statistics()).unwrap_or_default();
        (iterations, factorisations, fallbacks)
    }

    #[getter]
    fn integrator(&self) -> &'static str {
        self.core.integrator().properties().name
    }

    #[getter]
    fn hub_angle(&self) -> f64 {
        self.core.hub_angle()
    }

    /// The vector instructions that the kernels run with.
    #[getter]
    fn instructions(&self) -> &'static str {
        self.core.instructions().name()
    }

    /// [(law, share of its elements that kernels reach in straight runs)].
    fn shares_in_runs(&self) -> ByLaw {
        self.core.laws().iter().filter_map(|law| Some((law.name(), law.inspection()?.contiguous_share()))).collect()
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

    /// (kinetic, [(law, potential energy)]) in joules, for the laws that have one.
    fn energies(&self) -> (f64, ByLaw) {
        let energy_terms = self.core.energy_terms();
        let conservative = self
            .core
            .laws()
            .iter()
            .zip(energy_terms.stored)
            .filter(|(law, _)| law.properties().work_class == WorkClass::Conservative);
        (energy_terms.kinetic, conservative.map(|(law, energy)| (law.name(), energy)).collect())
    }

    /// (kinetic, stored, [(law, stored)], [(law, work)], turned over, residual, error).
    fn ledger(&self) -> (f64, f64, ByLaw, ByLaw, f64, f64, f64) {
        let (ledger, now, laws) = (self.core.ledger(), self.core.energy_terms(), self.core.laws());
        let stored =
            laws.iter().zip(&now.stored).filter(|(law, _)| law.properties().work_class == WorkClass::Conservative);
        let stored = stored.map(|(law, energy)| (law.name(), *energy)).collect();
        let work = laws.iter().zip(&ledger.work).filter(|(_, work)| **work != 0.0);
        let work = work.map(|(law, work)| (law.name(), *work)).collect();
        let (reference_energy, residual, error) =
            (ledger.reference_energy(&now), ledger.residual(&now), ledger.error(&now));
        (now.kinetic, now.stored.iter().sum(), stored, work, reference_energy, residual, error)
    }

    /// (strain, buckled) of the springs of one law, or None without it.
    fn spring_readings<'py>(&self, py: Python<'py>, law: &str) -> Option<SpringArrays<'py>> {
        let found = self.reading(law, |readings| {
            if let Readings::Springs { strain, buckled } = readings { Some((strain, buckled)) } else { None }
        });
        found.map(|(strain, buckled)| (PyArray1::from_vec(py, strain), PyArray1::from_vec(py, buckled)))
    }

    /// (principal Green strains (m, 2), state (m,): 0 taut, 1 wrinkled, 2 slack) of the triangles, or None without the law.
    fn triangle_readings<'py>(&self, py: Python<'py>) -> PyResult<Option<TriangleArrays<'py>>> {
        let found = self.reading("triangles", |readings| {
            if let Readings::Triangles { strain, state } = readings { Some((strain, state)) } else { None }
        });
        let Some((strain, state)) = found else { return Ok(None) };
        let strain: Vec<Vec<f64>> = strain.into_iter().map(|pair| pair.to_vec()).collect();
        Ok(Some((PyArray2::from_vec2(py, &strain)?, PyArray1::from_vec(py, state))))
    }

    /// Crease angles [rad], or None without the law.
    fn crease_angles<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<f64>>> {
        let found = self
            .reading("creases", |readings| if let Readings::Creases { angle } = readings { Some(angle) } else { None });
        found.map(|angle| PyArray1::from_vec(py, angle))
    }

    /// (largest stable step [s], largest frequency [rad/s], law, node, both in words).
    fn limit(&self, py: Python<'_>) -> PyResult<(f64, f64, &'static str, usize, String)> {
        let limit = checked(py.detach(|| self.core.limit()))?;
        Ok((limit.dt, limit.largest_frequency, limit.law, self.core.to_external(limit.node), self.core.part(&limit)))
    }

    /// Takes `count` steps without the interpreter lock; Ctrl-C stops it between two steps.
    fn step(&mut self, py: Python<'_>, count: u64) -> PyResult<()> {
        let mut left = count;
        let Self { core, batch } = self;
        in_breaths(py, batch, |batch| {
            let now = batch.min(left);
            left -= now;
            core.step(now).map(|()| left == 0)
        })
    }

    /// Steps an adaptive run until `time` [s] and shows that instant; Ctrl-C as with `step`.
    fn reach(&mut self, py: Python<'_>, time: f64) -> PyResult<()> {
        if !self.core.is_adaptive() {
            return Err(wrong_value("reach: the run has a fixed step; take steps".to_owned()));
        }
        let Self { core, batch } = self;
        in_breaths(py, batch, |batch| core.reach(time, batch))
    }

    /// Looks for a fault now, beside the regular checks.
    fn check(&mut self) -> PyResult<()> {
        checked(self.core.check())
    }

    /// What `resume` needs to continue with the same bits.
    fn progress<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        saved_of(py, self.core.progress(), &self.law_names())
    }

    /// Continues from what `progress` gave.
    fn resume(&mut self, saved: &Bound<'_, PyDict>) -> PyResult<()> {
        let progress = progress_of(saved, &self.law_names())?;
        checked(self.core.resume(&progress))
    }
}
