//! All laws at one instant: the order of their kernels, the system that methods integrate, the energy balance.

pub mod damped_springs;
pub mod ledger;
pub(crate) mod mechanics;
