//! Spring-mass ("multi-particle") dynamics of thin membranes that are folded, stowed and deployed by spinning.
//!
//! Plain Rust: no Python, no files, no printing, one thread, every number an `f64` in SI units. Imports have one
//! direction, from right to left:
//!
//!     simd, error <- arrays <- model, layout, linear <- contact, assembly, integrators, bodies <- elements <- laws
//!         <- evaluation, stability <- simulation

pub mod arrays;
pub mod assembly;
pub mod bodies;
pub mod contact;
pub mod elements;
pub mod error;
pub mod evaluation;
pub mod integrators;
pub mod laws;
pub mod layout;
pub mod linear;
pub mod model;
pub mod simd;
pub mod simulation;
pub mod stability;

pub use error::{Error, Result};
