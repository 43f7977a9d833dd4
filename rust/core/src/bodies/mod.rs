//! Bodies of prescribed motion: their motion, their shape, and the elements near them. Geometry, without forces.

pub mod near;
pub mod real;
pub mod rigid_body;
pub mod shape;
