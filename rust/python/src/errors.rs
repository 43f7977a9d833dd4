//! Errors of the core as exceptions of the package, which derive from the nearest built-in ones.

use membrane_core::error::Error;
use pyo3::PyErr;

mod python {
    pyo3::import_exception!(membrane_rs.errors, InputError);
    pyo3::import_exception!(membrane_rs.errors, InputTypeError);
    pyo3::import_exception!(membrane_rs.errors, MeshError);
    pyo3::import_exception!(membrane_rs.errors, UnstableError);
}

/// The exception for `error`.
pub(crate) fn raise(error: Error) -> PyErr {
    let text = error.to_string();
    match error {
        Error::Unstable { time, step, place, law, .. } => {
            python::UnstableError::new_err((text, time, step, place, law))
        }
        Error::IndexOutOfRange { .. }
        | Error::TriangleOutOfRange { .. }
        | Error::DegenerateTriangle { .. }
        | Error::SingularTriangle { .. }
        | Error::NegativeSprings { .. }
        | Error::NotRectangles { .. }
        | Error::SlenderRectangles { .. }
        | Error::NotAHinge { .. }
        | Error::RegionsOverlap { .. }
        | Error::TiltedFilm { .. }
        | Error::CurvatureBeyondMesh { .. } => python::MeshError::new_err(text),
        _ => python::InputError::new_err(text),
    }
}

/// An error for a value or an array of the wrong type.
pub(crate) fn wrong_type(text: String) -> PyErr {
    python::InputTypeError::new_err(text)
}

/// An error for a value out of range.
pub(crate) fn wrong_value(text: String) -> PyErr {
    python::InputError::new_err(text)
}
