//! Names that scenes give, kept for the life of the process: laws are called by names that live as long.

use std::collections::BTreeSet;
use std::sync::{Mutex, PoisonError};

use crate::error::{Error, Result};

/// The longest name, in bytes.
pub const LONGEST: usize = 64;
/// The most names of a process: four megabytes of the longest ones.
pub const MOST: usize = 65_536;

static NAMES: Mutex<BTreeSet<&'static str>> = Mutex::new(BTreeSet::new());

/// The same name, kept.
///
/// # Errors
/// `BadName` for one that is empty, longer than `LONGEST`, or the first beyond `MOST`.
pub fn kept(name: &str) -> Result<&'static str> {
    let bad = |reason| Err(Error::BadName { name: name.chars().take(LONGEST).collect(), reason });
    if name.is_empty() || name.len() > LONGEST {
        return bad("it must have 1 to 64 letters");
    }
    let mut names = NAMES.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(&known) = names.get(name) {
        return Ok(known);
    }
    if names.len() >= MOST {
        return bad("this process has seen 65536 names; use some of them again, or start another process");
    }
    let own: &'static str = Box::leak(name.to_owned().into_boxed_str());
    names.insert(own);
    Ok(own)
}
