//! Spring-mass ("multi-particle") dynamics of thin membranes that are folded, stowed and deployed by spinning.
//!
//! Plain Rust: no Python, no files, no printing, one thread, every number an `f64` in SI units.
//! Imports go one way: `mesh`, `layout`, `state` <- `model` <- `forces`, `integrators` <- `stability`, `ledger` <- `simulation`.

pub mod aligned;
pub mod columns;
pub mod error;
pub mod forces;
pub mod integrators;
pub mod lanes;
pub mod layout;
pub mod ledger;
pub mod mesh;
pub mod model;
pub(crate) mod rowwise;
pub mod simulation;
pub mod slopes;
pub mod stability;
pub mod state;
pub mod tangent;
pub mod width;

pub use error::{Error, Result};
