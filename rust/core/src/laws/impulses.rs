//! Laws that act by impulses between two kicks, rather than by forces.

use crate::integrators::Kick;

/// A law that changes velocities at once, as stiff contact does.
pub trait Impulses {
    /// Changes the velocities by the impulses that the next drift needs. The change of kinetic energy \[J\]; `None`
    /// where there was no impulse.
    fn kick(&mut self, kick: Kick<'_>) -> Option<f64>;
}
