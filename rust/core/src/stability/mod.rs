//! The largest stable step of a scene.

mod accuracy;
mod limit;
mod oscillator;
mod quadratic_eigenproblem;

pub use accuracy::Accuracy;
pub use limit::{Limit, limit, limit_to};
pub use oscillator::axis_limits;
