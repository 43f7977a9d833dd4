//! Node vectors as columns, blocks of their rows, and blocks of Jacobians.

pub mod blocks;
pub mod columns;
pub mod history;
pub mod jacobian;
pub mod state;
