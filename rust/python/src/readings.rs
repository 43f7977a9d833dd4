//! Readings of the core, as named types of arrays and plain values.

use membrane_core::elements::stress::TriangleStress;
use membrane_core::laws::{FilmStates as CoreFilmStates, LinkReadings as CoreLinkReadings};
use membrane_core::simulation::HubLoad as CoreHubLoad;
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;

use crate::arrays::{matrix, vectors};

/// Readings of s links: engineering strain, tension [N], whether shorter than the critical length; each (s,).
#[pyclass(frozen, get_all, module = "membrane_rs._core")]
pub(crate) struct LinkReadings {
    strain: Py<PyArray1<f64>>,
    tension: Py<PyArray1<f64>>,
    buckled: Py<PyArray1<bool>>,
}

impl LinkReadings {
    pub(crate) fn of(py: Python<'_>, links: CoreLinkReadings) -> Self {
        Self {
            strain: PyArray1::from_vec(py, links.strain).unbind(),
            tension: PyArray1::from_vec(py, links.tension).unbind(),
            buckled: PyArray1::from_vec(py, links.buckled).unbind(),
        }
    }
}

/// Principal Green strains (m, 2), larger first, and state (m,) of each triangle: 0 taut, 1 wrinkled, 2 slack; whether
/// each edge (s,) is buckled.
#[pyclass(frozen, get_all, module = "membrane_rs._core")]
pub(crate) struct FilmStates {
    strain: Py<PyArray2<f64>>,
    state: Py<PyArray1<u8>>,
    buckled: Py<PyArray1<bool>>,
}

impl FilmStates {
    pub(crate) fn of(py: Python<'_>, film: CoreFilmStates) -> PyResult<Self> {
        Ok(Self {
            strain: matrix(py, &film.strain)?.unbind(),
            state: PyArray1::from_vec(py, film.state).unbind(),
            buckled: PyArray1::from_vec(py, film.buckled).unbind(),
        })
    }
}

/// Principal stresses (m, 2) of each triangle, larger first [Pa], and their directions, (m, 3) each.
#[pyclass(frozen, get_all, module = "membrane_rs._core")]
pub(crate) struct FilmStress {
    principal: Py<PyArray2<f64>>,
    first: Py<PyArray2<f64>>,
    second: Py<PyArray2<f64>>,
}

impl FilmStress {
    pub(crate) fn of(py: Python<'_>, stresses: &[TriangleStress]) -> PyResult<Self> {
        let values: Vec<[f64; 2]> = stresses.iter().map(|stress| stress.values()).collect();
        let directions: Vec<[[f64; 3]; 2]> = stresses.iter().map(|stress| stress.directions()).collect();
        let [first, second] = [0, 1].map(|k| directions.iter().map(|pair| pair[k]).collect::<Vec<[f64; 3]>>());
        Ok(Self {
            principal: matrix(py, &values)?.unbind(),
            first: vectors(py, &first)?.unbind(),
            second: vectors(py, &second)?.unbind(),
        })
    }
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
