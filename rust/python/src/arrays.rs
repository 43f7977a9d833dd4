//! Conversion of arrays: checks of shape and dtype from Python, new arrays to Python.

use numpy::{PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::errors::{raise, wrong_type, wrong_value};

fn describe(value: &Bound<'_, PyAny>) -> String {
    let attribute = |name| value.getattr(name).and_then(|found| found.str()).map(|text| text.to_string());
    match (attribute("shape"), attribute("dtype")) {
        (Ok(shape), Ok(dtype)) => format!("an array of shape {shape} and dtype {dtype}"),
        _ => value.get_type().to_string(),
    }
}

/// (n, N) float64 to rows.
pub(crate) fn rows<const N: usize>(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Vec<[f64; N]>> {
    let fail = || wrong_type(format!("{name} must be a float64 array of shape (n, {N}), not {}", describe(value)));
    let array: PyReadonlyArray2<'_, f64> = value.extract().map_err(|_| fail())?;
    let array = array.as_array();
    if array.ncols() != N {
        return Err(fail());
    }
    Ok(array.rows().into_iter().map(|row| std::array::from_fn(|k| row[k])).collect())
}

/// (n, N) int64 to rows of node indices.
pub(crate) fn index_rows<const N: usize>(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Vec<[u32; N]>> {
    let fail = || wrong_type(format!("{name} must be an int64 array of shape (n, {N}), not {}", describe(value)));
    let array: PyReadonlyArray2<'_, i64> = value.extract().map_err(|_| fail())?;
    let array = array.as_array();
    if array.ncols() != N {
        return Err(fail());
    }
    let mut rows = Vec::with_capacity(array.nrows());
    for (number, row) in array.rows().into_iter().enumerate() {
        let mut nodes = [0; N];
        for (node, &index) in nodes.iter_mut().zip(row) {
            *node = index_of(name, number, index)?;
        }
        rows.push(nodes);
    }
    Ok(rows)
}

/// (n,) int64 to node indices.
pub(crate) fn indices(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Vec<u32>> {
    let array: PyReadonlyArray1<'_, i64> = value
        .extract()
        .map_err(|_| wrong_type(format!("{name} must be an int64 array of shape (n,), not {}", describe(value))))?;
    array.as_array().iter().enumerate().map(|(row, &index)| index_of(name, row, index)).collect()
}

fn index_of(name: &str, row: usize, index: i64) -> PyResult<u32> {
    // The two largest numbers are marks of the core.
    u32::try_from(index).ok().filter(|&index| index < u32::MAX - 1).ok_or_else(|| {
        wrong_value(format!("{name}, row {row}: {index} is not an index; give a whole number, 0 or above"))
    })
}

/// (n,) float64.
pub(crate) fn numbers(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Vec<f64>> {
    let array: PyReadonlyArray1<'_, f64> = value
        .extract()
        .map_err(|_| wrong_type(format!("{name} must be a float64 array of shape (n,), not {}", describe(value))))?;
    Ok(array.as_array().iter().copied().collect())
}

/// Rows to (n, 3) float64.
pub(crate) fn vectors<'py>(py: Python<'py>, rows: &[[f64; 3]]) -> PyResult<Bound<'py, PyArray2<f64>>> {
    matrix(py, rows)
}

/// Rows to an (n, N) array.
pub(crate) fn matrix<'py, T: numpy::Element + Copy, const N: usize>(
    py: Python<'py>,
    rows: &[[T; N]],
) -> PyResult<Bound<'py, PyArray2<T>>> {
    numpy::PyArray1::from_slice(py, rows.as_flattened()).reshape([rows.len(), N])
}

/// Rows of indices to (n, N) int64.
pub(crate) fn indices_to_python<'py, const N: usize>(
    py: Python<'py>,
    rows: &[[u32; N]],
) -> PyResult<Bound<'py, PyArray2<i64>>> {
    let rows: Vec<[i64; N]> = rows.iter().map(|row| row.map(i64::from)).collect();
    matrix(py, &rows)
}

/// The result of a call of the core, with its error as an exception.
pub(crate) fn checked<T>(result: membrane_core::Result<T>) -> PyResult<T> {
    result.map_err(raise)
}

/// A value of a table, by its key; `owner` names the table in errors.
pub(crate) fn get<'py, T>(table: &Bound<'py, PyDict>, owner: &str, key: &str) -> PyResult<T>
where
    T: for<'a> FromPyObject<'a, 'py>,
{
    let value = table.get_item(key)?.ok_or_else(|| wrong_value(format!("{owner}: {key} is missing")))?;
    value.extract().map_err(|_| wrong_type(format!("{owner}: {key} = {value} is of the wrong type")))
}
