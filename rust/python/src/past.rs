//! What positions do not show of the past of a motion that goes on.

use pyo3::prelude::*;

use crate::arrays::rows;

/// Angles of creases [rad], where they are known, and shapes (n, 3) [m] whose distances layers of the film keep.
pub(crate) struct Past {
    pub(crate) angles: Option<Vec<f64>>,
    pub(crate) shapes: Vec<Vec<[f64; 3]>>,
}

impl<'a, 'py> FromPyObject<'a, 'py> for Past {
    type Error = PyErr;

    fn extract(given: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        let (angles, shapes): (Option<Vec<f64>>, Vec<Bound<'py, PyAny>>) = given.extract()?;
        let shapes = shapes.iter().map(|shape| rows("layer_shapes", shape)).collect::<PyResult<_>>()?;
        Ok(Self { angles, shapes })
    }
}
