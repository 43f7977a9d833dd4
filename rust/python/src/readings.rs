//! Readings of the core, as named types of arrays and plain values.

use membrane_core::simulation::HubLoad as CoreHubLoad;
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;

/// Readings of s links: engineering strain, tension [N], whether shorter than the critical length; each (s,).
#[pyclass(frozen, get_all, module = "membrane_rs._core")]
pub(crate) struct LinkReadings {
    pub(crate) strain: Py<PyArray1<f64>>,
    pub(crate) tension: Py<PyArray1<f64>>,
    pub(crate) buckled: Py<PyArray1<bool>>,
}

/// Principal Green strains (m, 2), larger first, and state (m,) of each triangle: 0 taut, 1 wrinkled, 2 slack; whether
/// each edge (s,) is buckled.
#[pyclass(frozen, get_all, module = "membrane_rs._core")]
pub(crate) struct FilmStates {
    pub(crate) strain: Py<PyArray2<f64>>,
    pub(crate) state: Py<PyArray1<u8>>,
    pub(crate) buckled: Py<PyArray1<bool>>,
}

/// Principal stresses (m, 2) of each triangle, larger first [Pa], and their directions, (m, 3) each.
#[pyclass(frozen, get_all, module = "membrane_rs._core")]
pub(crate) struct FilmStress {
    pub(crate) principal: Py<PyArray2<f64>>,
    pub(crate) first: Py<PyArray2<f64>>,
    pub(crate) second: Py<PyArray2<f64>>,
}

/// Force [N] and torque about the origin [N m] of the sail on the hub, in the turning frame, and the sum of the
/// magnitudes of the forces of contact [N].
#[pyclass(frozen, get_all, module = "membrane_rs._core")]
pub(crate) struct HubLoad {
    force: [f64; 3],
    torque: [f64; 3],
    contact: f64,
}

impl From<CoreHubLoad> for HubLoad {
    fn from(CoreHubLoad { force, torque, contact }: CoreHubLoad) -> Self {
        Self { force, torque, contact }
    }
}
