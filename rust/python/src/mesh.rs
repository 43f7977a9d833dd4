//! Functions of triangles, for the package's `Mesh`.

use membrane_core::model::input::Film;
use membrane_core::model::mesh::{Mesh, check_indices, unique_edges};
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;

use crate::arrays::{checked, index_rows, indices_to_python, numbers, rows};
use crate::errors::wrong_value;

type Indices<'py> = Bound<'py, PyArray2<i64>>;

fn mesh_of(reference: &Bound<'_, PyAny>, triangles: &Bound<'_, PyAny>) -> PyResult<Mesh> {
    checked(Mesh::new(rows("reference", reference)?, index_rows("triangles", triangles)?))
}

/// The film of each triangle, of which E h (m,) float64 is given [N/m].
fn films_of(mesh: &Mesh, stiffness: &Bound<'_, PyAny>, poisson_ratio: f64) -> PyResult<Vec<Film>> {
    let (stiffness, count) = (numbers("stiffness", stiffness)?, mesh.triangles.len());
    if stiffness.len() != count {
        return Err(wrong_value(format!(
            "stiffness has {} rows for {count} triangles; give one each",
            stiffness.len()
        )));
    }
    let film = |youngs_modulus| Film { youngs_modulus, poisson_ratio, density: 0.0, thickness: 1.0 };
    Ok(stiffness.into_iter().map(film).collect())
}

/// Edges (e, 2) int64 of (m, 3) int64 triangles, lower node first, sorted; and for each triangle its three edges,
/// (m, 3) int64, edge k opposite corner k.
#[pyfunction]
pub(crate) fn edges<'py>(
    py: Python<'py>,
    triangles: &Bound<'py, PyAny>,
    node_count: usize,
) -> PyResult<(Indices<'py>, Indices<'py>)> {
    let triangles = index_rows("triangles", triangles)?;
    checked(check_indices("triangle", &triangles, node_count))?;
    let (edges, triangle_edges) = unique_edges(&triangles);
    Ok((indices_to_python(py, &edges)?, indices_to_python(py, &triangle_edges)?))
}

/// Spring constant of each edge by eq. (1) [N/m], in the order of `edges`, with the E h of each triangle [N/m].
#[pyfunction]
pub(crate) fn spring_constants<'py>(
    py: Python<'py>,
    reference: &Bound<'py, PyAny>,
    triangles: &Bound<'py, PyAny>,
    stiffness: &Bound<'py, PyAny>,
    poisson_ratio: f64,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let mesh = mesh_of(reference, triangles)?;
    let films = films_of(&mesh, stiffness, poisson_ratio)?;
    Ok(PyArray1::from_vec(py, checked(mesh.spring_constants(|row| films[row]))?))
}

/// Corners (r, 4) int64 in turn of the rectangles that the triangles form in pairs; the diagonal from the first to the
/// third corner is no edge. No crease (c, 2) may be a diagonal.
#[pyfunction]
pub(crate) fn rectangles<'py>(
    py: Python<'py>,
    reference: &Bound<'py, PyAny>,
    triangles: &Bound<'py, PyAny>,
    creases: &Bound<'py, PyAny>,
) -> PyResult<Indices<'py>> {
    let mesh = mesh_of(reference, triangles)?;
    let hinges = checked(mesh.hinges(&index_rows("creases", creases)?))?;
    indices_to_python(py, &checked(mesh.rectangles(&hinges))?.corners())
}

/// Spring constants of the edges and of the second diagonals of these rectangles [N/m], the latter in their order, with
/// the E h of each triangle [N/m].
#[pyfunction]
pub(crate) fn rectangle_constants<'py>(
    py: Python<'py>,
    reference: &Bound<'py, PyAny>,
    triangles: &Bound<'py, PyAny>,
    creases: &Bound<'py, PyAny>,
    stiffness: &Bound<'py, PyAny>,
    poisson_ratio: f64,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let mesh = mesh_of(reference, triangles)?;
    let films = films_of(&mesh, stiffness, poisson_ratio)?;
    let hinges = checked(mesh.hinges(&index_rows("creases", creases)?))?;
    Ok(PyArray1::from_vec(py, checked(checked(mesh.rectangles(&hinges))?.stiffness(|row| films[row]))?))
}

/// A third of each triangle's mass on each of its nodes [kg], for an areal density rho h [kg/m2].
#[pyfunction]
pub(crate) fn lumped_masses<'py>(
    py: Python<'py>,
    reference: &Bound<'py, PyAny>,
    triangles: &Bound<'py, PyAny>,
    areal_density: f64,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    Ok(PyArray1::from_vec(py, checked(mesh_of(reference, triangles)?.lumped_masses(|_| areal_density))?))
}

/// Checks that each crease is an edge with two triangles of one winding, and counts them.
#[pyfunction]
pub(crate) fn hinge_count(
    reference: &Bound<'_, PyAny>,
    triangles: &Bound<'_, PyAny>,
    creases: &Bound<'_, PyAny>,
) -> PyResult<usize> {
    let hinges = mesh_of(reference, triangles)?.hinges(&index_rows("creases", creases)?);
    Ok(checked(hinges)?.len())
}
