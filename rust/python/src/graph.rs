//! Functions of links between nodes.

use membrane_core::model::graph::{self, Network};
use numpy::{PyArray1, PyArray2};
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

/// Lengths of the shortest paths along links (k, 2) int64 from each of the starts (s,) int64 to each node, (s, n); inf
/// where there is no path, or none up to the number in `longest` (s,) of that start.
#[pyfunction]
pub(crate) fn shortest_paths<'py>(
    py: Python<'py>,
    links: &Bound<'py, PyAny>,
    lengths: &Bound<'py, PyAny>,
    node_count: usize,
    starts: &Bound<'py, PyAny>,
    longest: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let (starts, longest) = (indices("starts", starts)?, numbers("longest", longest)?);
    if starts.len() != longest.len() {
        return Err(wrong_value(format!(
            "longest has {} rows; give one for each of {} starts",
            longest.len(),
            starts.len()
        )));
    }
    let network = checked(Network::new(&index_rows("links", links)?, &numbers("lengths", lengths)?, node_count))?;
    let paths = starts.iter().zip(&longest).map(|(&start, &longest)| network.shortest_paths(start, longest));
    let paths: Vec<f64> = checked(paths.collect::<membrane_core::Result<Vec<_>>>())?.concat();
    numpy::PyArrayMethods::reshape(&PyArray1::from_vec(py, paths), [starts.len(), node_count])
}
