//! Crossings of triangles, counted without the interpreter lock.

use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use membrane_core::contact;
use numpy::PyArray2;
use pyo3::prelude::*;

use crate::arrays::{checked, index_rows, indices_to_python, rows};

/// Interval between two checks for Ctrl-C.
const SIGNAL_INTERVAL: Duration = Duration::from_millis(20);

/// Pairs of triangles by what they have in common: how many, and the first that cross, (k, 2).
#[pyclass(frozen, get_all, module = "membrane_rs._core")]
pub(crate) struct Crossings {
    pairs: Py<PyArray2<i64>>,
    count: u64,
    overlapping: u64,
    touching: u64,
    candidates: u64,
}

/// Crossings of triangles (m, 3) at positions (n, 3) [m]: all counted, the first `limit` listed. Ctrl-C ends it.
#[pyfunction]
pub(crate) fn crossings(
    py: Python<'_>,
    positions: &Bound<'_, PyAny>,
    triangles: &Bound<'_, PyAny>,
    limit: usize,
) -> PyResult<Crossings> {
    let (positions, triangles) = (rows("positions", positions)?, index_rows("triangles", triangles)?);
    let mut last = Instant::now();
    let pause = || {
        if last.elapsed() < SIGNAL_INTERVAL {
            return ControlFlow::Continue(());
        }
        last = Instant::now();
        Python::attach(|py| py.check_signals()).map_or_else(ControlFlow::Break, ControlFlow::Continue)
    };
    let found = match checked(py.detach(|| contact::crossings(&positions, &triangles, limit, pause)))? {
        ControlFlow::Continue(found) => found,
        ControlFlow::Break(interruption) => return Err(interruption),
    };
    let contact::Crossings { count, overlapping, touching, candidates, .. } = found;
    Ok(Crossings { pairs: indices_to_python(py, &found.pairs)?.unbind(), count, overlapping, touching, candidates })
}
