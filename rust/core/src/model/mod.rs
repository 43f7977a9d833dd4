//! The model of a simulation in external order, and the checks of each value.

pub mod checks;
pub mod factor;
pub mod film;
pub mod frame;
pub mod graph;
pub mod hub;
pub mod hub_motion;
pub mod input;
pub mod load;
pub mod mesh;
pub mod names;
pub mod optics;
pub mod orthotropy;
pub mod rectangles;
pub mod regions;
pub mod schedule;
mod spring_constants;
pub mod turn;
