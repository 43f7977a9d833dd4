//! Results of the core, as named types of plain values.

use membrane_core::evaluation::ledger::Ledger;
use membrane_core::integrators::{METHODS, Method, Options, Properties, Statistics};
use membrane_core::laws::{ContactStatistics as CoreContactStatistics, WorkClass};
use membrane_core::simulation::Simulation as Core;
use membrane_core::stability::{Limit, axis_limits};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Properties of a method of time integration.
#[pyclass(frozen, get_all, module = "membrane_rs._core")]
pub(crate) struct MethodFacts {
    name: &'static str,
    order: u32,
    evaluations_per_step: u32,
    evaluations_at_start: u32,
    conserves_energy: bool,
    is_adaptive: bool,
    imaginary_limit: f64,
    real_limit: f64,
}

impl MethodFacts {
    pub(crate) fn of(method: &Method) -> Self {
        let mut made = (method.make)(&Options::default());
        let [imaginary_limit, real_limit] = axis_limits(made.as_ref());
        let is_adaptive = made.embedded().is_some();
        let Properties { order, evaluations_per_step, evaluations_at_start, conserves_energy, .. } = made.properties();
        Self {
            name: method.name,
            order,
            evaluations_per_step,
            evaluations_at_start,
            conserves_energy,
            is_adaptive,
            imaginary_limit,
            real_limit,
        }
    }
}

/// Properties of each method, in the order of the list.
#[pyfunction]
pub(crate) fn integrators() -> Vec<MethodFacts> {
    METHODS.iter().map(MethodFacts::of).collect()
}

/// The energy balance: its terms [J], and the residual over the reference energy.
#[pyclass(frozen, get_all, module = "membrane_rs._core")]
pub(crate) struct EnergyBalance {
    kinetic: f64,
    stored: f64,
    stored_by_law: Py<PyDict>,
    work_by_law: Py<PyDict>,
    changes: Py<PyDict>,
    motor_work: Option<f64>,
    reference_energy: f64,
    residual: f64,
    error: f64,
}

impl EnergyBalance {
    pub(crate) fn of(py: Python<'_>, core: &Core) -> PyResult<Self> {
        let (ledger, now): (&Ledger, _) = (core.ledger(), core.energy_terms());
        let (stored, worked) = (PyDict::new(py), PyDict::new(py));
        for ((law, energy), work) in core.laws().iter().zip(&now.stored).zip(&ledger.work) {
            let properties = law.properties();
            if properties.work_class == WorkClass::Conservative {
                stored.set_item(properties.name, energy)?;
            }
            if *work != 0.0 {
                worked.set_item(properties.name, work)?;
            }
        }
        let changes = PyDict::new(py);
        let names = ["kinetic"].into_iter().chain(core.laws().iter().map(|law| law.name()));
        for (name, change) in names.zip(&ledger.changes).filter(|(_, change)| **change != 0.0) {
            changes.set_item(name, change)?;
        }
        Ok(Self {
            kinetic: now.kinetic,
            stored: now.stored.iter().sum(),
            stored_by_law: stored.unbind(),
            work_by_law: worked.unbind(),
            changes: changes.unbind(),
            motor_work: core.motor_work(),
            reference_energy: ledger.reference_energy(&now),
            residual: ledger.residual(&now),
            error: core.energy_error(&now),
        })
    }
}

/// The largest stable step [s], the largest frequency [rad/s], and the law and node that set the step, also in words.
#[pyclass(frozen, get_all, module = "membrane_rs._core")]
pub(crate) struct StepLimit {
    dt: f64,
    largest_frequency: f64,
    law: &'static str,
    node: usize,
    part: String,
}

impl StepLimit {
    pub(crate) fn of(core: &Core, limit: &Limit) -> Self {
        let &Limit { dt, largest_frequency, law, node } = limit;
        Self { dt, largest_frequency, law, node: core.to_external(node), part: core.limiting_part(limit) }
    }
}

/// Counts of an implicit method; zeros for others.
#[pyclass(frozen, get_all, module = "membrane_rs._core")]
pub(crate) struct NewtonStatistics {
    iterations: u64,
    factorisations: u64,
    fallbacks: u64,
}

impl From<Statistics> for NewtonStatistics {
    fn from(Statistics { iterations, factorisations, fallbacks }: Statistics) -> Self {
        Self { iterations, factorisations, fallbacks }
    }
}

/// What contact between layers has spent: pairs, steps and exact checks over all steps, and time [s].
#[pyclass(frozen, get_all, module = "membrane_rs._core")]
pub(crate) struct ContactStatistics {
    looked_at: u64,
    near: u64,
    pressed: u64,
    rigid: u64,
    checks: u64,
    list_time: f64,
    look_time: f64,
    impulse_time: f64,
    check_time: f64,
}

impl From<CoreContactStatistics> for ContactStatistics {
    fn from(core: CoreContactStatistics) -> Self {
        let CoreContactStatistics { looked_at, near, pressed, rigid, checks, .. } = core;
        let times = [core.list_time, core.look_time, core.impulse_time, core.check_time];
        let [list_time, look_time, impulse_time, check_time] = times.map(|time| time.as_secs_f64());
        Self { looked_at, near, pressed, rigid, checks, list_time, look_time, impulse_time, check_time }
    }
}

/// The motion of the hub: attitude, place, angular momenta, and of a free hub the torque of its motor.
#[pyclass(frozen, get_all, module = "membrane_rs._core")]
pub(crate) struct HubMotion {
    attitude: [f64; 4],
    centre: [f64; 3],
    momentum: [f64; 3],
    sail_momentum: [f64; 3],
    motor_torque: Option<f64>,
    pub(crate) state: [f64; 14],
}

impl HubMotion {
    pub(crate) fn of(core: &Core) -> Self {
        let (attitude, centre) = core.hub_pose();
        let [momentum, sail_momentum] = core.momenta().map(Into::into);
        let (motor_torque, state) = (core.motor_torque(), core.hub_state());
        Self { attitude, centre, momentum, sail_momentum, motor_torque, state }
    }
}
