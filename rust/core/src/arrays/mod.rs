//! Node vectors as columns, blocks of their rows, histories, and blocks of the Jacobian.

pub mod blocks;
pub mod columns;
pub mod history;
pub mod jacobian;
pub mod state;
