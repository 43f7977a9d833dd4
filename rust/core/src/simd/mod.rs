//! Eight numbers at a time, in the vector instructions of the machine.

pub mod aligned;
pub mod counted;
pub mod dispatch;
pub mod lanes;
pub(crate) mod map;
#[cfg(target_arch = "x86_64")]
pub(crate) mod sse2;
#[cfg(target_arch = "x86_64")]
pub(crate) mod x86;
