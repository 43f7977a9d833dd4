//! The largest stable step of a scene.

mod limit;
mod oscillator;
mod quadratic_eigenproblem;

pub use limit::{Limit, limit};
pub use oscillator::axis_limits;
