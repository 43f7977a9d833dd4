//! All laws at one instant: the order of their kernels, the system that methods integrate, the energy balance.

mod damped_links;
mod deferral;
pub mod free_pieces;
mod histories;
mod hub;
mod impulses;
pub mod ledger;
pub mod mechanics;
mod moves;
pub mod plan;
