//! Linear algebra: the sparse tangent of implicit steps, and extreme eigenvalues.

pub mod tangent;

pub(crate) mod lanczos;
mod passes;
