//! Functions of links between nodes.

use membrane_core::model::graph::{self, Network};
use numpy::PyArray1;
use pyo3::prelude::*;

use crate::arrays::{checked, index_rows, indices, numbers};
use crate::errors::wrong_value;

/// The number of the group that each of `node_count` nodes is in, (n,) int64, when links (k, 2) int64 tie nodes
/// together; groups are numbered by their lowest nodes.
#[pyfunction]
pub(crate) fn groups<'py>(
    py: Python<'py>,
    links: &Bound<'py, PyAny>,
    node_count: usize,
) -> PyResult<Bound<'py, PyArray1<i64>>> {
    let groups = checked(graph::groups(&index_rows("links", links)?, node_count))?;
    Ok(PyArray1::from_iter(py, groups.into_iter().map(i64::from)))
}

/// Length of the shortest path along links (k, 2) int64 to each node from any of the starts (s,) int64, (n,), with the
/// length in `begun` (s,) that the paths of each start have already; inf where there is none up to `longest`.
#[pyfunction]
pub(crate) fn shortest_paths<'py>(
    py: Python<'py>,
    links: &Bound<'py, PyAny>,
    lengths: &Bound<'py, PyAny>,
    node_count: usize,
    starts: &Bound<'py, PyAny>,
    begun: &Bound<'py, PyAny>,
    longest: f64,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let (starts, begun) = (indices("starts", starts)?, numbers("begun", begun)?);
    if starts.len() != begun.len() {
        return Err(wrong_value(format!(
            "begun has {} rows; give one for each of {} starts",
            begun.len(),
            starts.len()
        )));
    }
    let network = checked(Network::new(&index_rows("links", links)?, &numbers("lengths", lengths)?, node_count))?;
    let starts: Vec<_> = starts.into_iter().zip(begun).collect();
    Ok(PyArray1::from_vec(py, checked(network.shortest_paths(&starts, longest))?))
}
