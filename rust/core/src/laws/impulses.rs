//! Laws that act by impulses between two kicks, rather than by forces.

use nalgebra::Vector3;

use crate::integrators::Kick;

/// A law that changes velocities at once, as stiff contact does.
pub trait Impulses {
    /// Changes the velocities by the impulses that the next drift needs; nodes that move as prescribed have the given
    /// velocities in it \[m/s\]. The change of kinetic energy \[J\]; `None` where there was no impulse.
    fn kick(&mut self, kick: Kick<'_>, moved: &[(usize, Vector3<f64>)]) -> Option<f64>;
}
