//! Checks of single values, each with its message.

use crate::error::{Error, Result};

/// Refuses a value that is not finite and above zero.
///
/// # Errors
/// `OutOfRange`.
pub fn positive(what: &'static str, value: f64) -> Result<()> {
    within(what, value, value > 0.0, "it must be finite and above zero")
}

/// Refuses a value that is not finite or is negative.
///
/// # Errors
/// `OutOfRange`.
pub fn non_negative(what: &'static str, value: f64) -> Result<()> {
    within(what, value, value >= 0.0, "it must be finite and not negative")
}

/// Refuses a value that is not finite.
///
/// # Errors
/// `OutOfRange`.
pub fn finite(what: &'static str, value: f64) -> Result<()> {
    within(what, value, true, "it must be finite")
}

/// Refuses a value that is not finite or not `inside` its range.
///
/// # Errors
/// `OutOfRange`.
pub fn within(what: &'static str, value: f64, inside: bool, range: &'static str) -> Result<()> {
    if value.is_finite() && inside { Ok(()) } else { Err(Error::OutOfRange { what, value, range }) }
}
