//! What the energy balance may be off by: rounding, and the method's own error of a rigid motion.
//!
//!     |residual| <= share (reference energy + kinetic energy without rigid motion) + floor
//!     floor = 1e-5 (largest energy) + turning + rounding                                        [J]
//!
//! for gains and losses alike. None of these grows with the speed at which the whole flies, except rounding.

use super::Simulation;
use crate::evaluation::free_pieces::RigidMotion;
use crate::evaluation::ledger::EnergyTerms;
use crate::integrators::{System, Tolerance};

/// Error that is allowed at any reference energy, relative to the largest energy of the motion without the translation
/// of free pieces: springs that become taut, and facets that shut, do so between two steps.
const FLOOR: f64 = 1e-5;

/// Rounding of a position or a velocity in a step, in units in the last place of the largest one.
pub(super) const ULPS: f64 = 4.0;
/// Steps whose rounding is allowed from the start on.
const FIRST_STEPS: f64 = 256.0;
/// Rounding of the sums of energies and works, relative to the largest term.
const SUMMATION: f64 = 1e-13;
/// Reference energy that is no exchange, in units of its rounding.
const NO_EXCHANGE: f64 = 100.0;

/// Error of the balance of a turning piece in a step over K_rigid (omega dt)^4, at most all work of damping: the stages
/// of a step lie on tangents to the circles, so that dashpots do work there. Largest value seen in 1,050 random scenes:
/// 36.
const TANGENTS: f64 = 60.0;
/// Energy of springs at the stages of a step, over K_carried (omega dt)^2 (Omega dt)^2 with omega their largest
/// frequency: seen from a frame of rate Omega a resting piece moves on circles, and on their tangents it is longer by
/// the share (Omega dt/2)^2/2 at the most, k d^2/2 = K_carried (omega/Omega)^2 (Omega dt)^4/64.
const STRETCH: f64 = 1.0 / 64.0;
/// Vibration about the widened shape of a piece that is set turning without strain, over the largest exchange. With x
/// the widening and U = k x^2/2 the spring overshoots to 2 x, so that it exchanges 4 U, of which U is vibration: 1/4.
const OVERSHOOT: f64 = 0.3;

/// Number of frequencies up to the largest one at which the damping by the method is evaluated.
const FREQUENCIES: u32 = 16;

/// Speed of nodes of an adaptive run whose shape is at rest, relative to the allowed error of a step: there the steps
/// grow beyond the limit until the error reaches the tolerance.
const REST_SPEED_FACTOR: f64 = 10.0;

impl Simulation {
    /// The residual over the reference energy; 0 where both are rounding, so that nothing was exchanged.
    pub fn energy_error(&self, now: &EnergyTerms) -> f64 {
        let (residual, rounding) = (self.ledger.residual(now), self.rounding(now));
        let is_exchange = self.ledger.reference_energy(now) > NO_EXCHANGE * rounding || residual.abs() > rounding;
        if is_exchange || residual.is_nan() { self.ledger.error(now) } else { 0.0 }
    }

    /// Energy error by rounding \[J\]. In each step the velocities change by some last digits of their own, and by
    /// those of the positions times the largest frequency: d v. That adds M d v^2/2 a step to nodes at rest, and as a
    /// random walk (M d v^2/2 E n)^1/2 to a motion of the energy E in n steps.
    pub(super) fn rounding(&self, now: &EnergyTerms) -> f64 {
        let frame_rate = self.frame_rate();
        let (length, speed) = (self.state.positions.amax(), self.state.velocities.amax());
        let rate = self.start_limit.largest_frequency + frame_rate;
        let vibration = self.kinetic_at(ULPS * f64::EPSILON * (rate * length + speed));
        let largest = if self.ledger.scope.is_isolated() {
            self.ledger.largest_energy(now)
        } else {
            now.stored.iter().fold(now.kinetic, |most, stored| most.max(stored.abs()))
        };
        let steps = FIRST_STEPS.max(self.step_count as f64);
        let rounding = steps * vibration + 2.0 * (steps * vibration * largest).sqrt() + SUMMATION * largest;
        // Rounding that is not finite allows no error.
        if rounding.is_finite() { rounding } else { 0.0 }
    }

    /// The floor without what belongs to turning pieces \[J\].
    pub(super) fn resting_floor(&self, now: &EnergyTerms) -> f64 {
        FLOOR * self.ledger.largest_energy(now) + self.rounding(now) + self.step_errors(now)
    }

    /// Energy of the errors allowed for the steps of an adaptive run, as a random walk like that of rounding \[J\].
    fn step_errors(&self, now: &EnergyTerms) -> f64 {
        if self.adaptive.is_none() {
            return 0.0;
        }
        let errors = self.step_count as f64 * self.kinetic_at(self.speed_error());
        errors + 2.0 * (errors * self.ledger.reference_energy(now)).sqrt()
    }

    /// Vibration that an adaptive run may lose, as errors of one sign: within the tolerance it damps what its steps
    /// hardly resolve \[J\].
    pub(super) fn damped_within_tolerance(&self, reference_energy: f64) -> f64 {
        if self.adaptive.is_none() {
            return 0.0;
        }
        let steps = self.step_count as f64;
        let errors = steps * steps * self.kinetic_at(self.speed_error());
        (OVERSHOOT * reference_energy).min(errors + 2.0 * (errors * reference_energy).sqrt())
    }

    /// Allowed error of the velocities in a step of an adaptive run, which grows with the speed of the nodes, of free
    /// pieces about their centres of mass \[m/s\].
    fn speed_error(&self) -> f64 {
        let Tolerance { relative, speed, .. } = self.settings.tolerance;
        let own = self.mechanics.about_centres(self.state.at(self.time()));
        relative * speed.hypot(own.as_ref().unwrap_or(&self.state).velocities.amax())
    }

    /// The floor of what moves \[J\]. A `tolerance` of the kinetic energy without rigid motion: from a start at rest it
    /// would have been exchanged, and a tip that is thrown on a slack cord exchanges it later. The method's own error
    /// of the rigid motion of free pieces: that of their rotation, and in a turning frame that of the motion against
    /// the frame, at most `energy_loss` of the energy of this motion.
    pub(super) fn moving_floor(&self, tolerance: f64, now: &EnergyTerms) -> f64 {
        let kinetic = self.ledger.kinetic(now);
        if self.mechanics.pieces.is_empty() {
            return tolerance * kinetic;
        }
        let RigidMotion { translation, rotation, rate, carried } = self.rigid_motion();
        let own = tolerance * (kinetic - rotation).max(0.0);
        let (dt, most, frame_rate) = (self.dt(), self.settings.loss_tolerance, self.frame_rate());
        // In a turning frame the circles are those of the motion against it, whose rate is at most Omega for a piece
        // that does not turn.
        let tangents = |rate: f64| (TANGENTS * (self.time() / dt) * (rate * dt).powi(4)).min(most);
        let turns = if self.properties().conserves_energy { 1.0 } else { (frame_rate * self.time()).max(1.0) };
        let against_frame = turns * (frame_rate * dt).powi(self.properties().order as i32);
        let translation = if self.ledger.scope.is_isolated() { 0.0 } else { translation };
        let seen_from_frame = translation + rotation + carried;
        let damping: f64 = self.resisting_work().map(|(_, work)| work.abs()).sum();
        let against = tangents(frame_rate) * carried;
        let against = if self.ledger.residual(now) > 0.0 { against.min(damping) } else { against };
        let circles = (tangents(rate) * rotation).min(damping) + against;
        let stretched = (STRETCH * (self.start_limit.largest_frequency * frame_rate * dt * dt).powi(2)).min(most);
        let floor = own + circles + against_frame.min(most) * seen_from_frame + stretched * carried;
        if floor.is_finite() { floor } else { 0.0 }
    }

    /// Vibration that a piece set turning without strain begins with, as far as the method has damped it \[J\].
    pub(super) fn overshoot(&self, reference_energy: f64) -> f64 {
        if self.mechanics.pieces.is_empty() {
            return 0.0;
        }
        let vibration = OVERSHOOT * self.damped_share() * reference_energy;
        vibration.min(self.settings.loss_tolerance * self.rigid_motion().rotation)
    }

    /// The largest share of the energy of an undamped vibration, of any frequency of the scene, that the steps so far
    /// have damped; 1 where their lengths differ.
    fn damped_share(&self) -> f64 {
        if self.adaptive.is_some() {
            return 1.0;
        }
        let frequencies = (1..=FREQUENCIES).map(|k| self.start_limit.largest_frequency * k as f64 / FREQUENCIES as f64);
        let kept = frequencies.map(|omega| self.integrator.amplification(omega, 0.0, self.dt)).fold(1.0, f64::min);
        1.0 - kept.powf(2.0 * self.step_count as f64)
    }

    fn rigid_motion(&self) -> RigidMotion {
        self.mechanics.pieces.rigid_motion(&self.mechanics.masses, self.instant())
    }

    /// Whether the reference energy of an adaptive run is within the errors allowed for its steps.
    pub(super) fn is_within_tolerance(&self, reference_energy: f64) -> bool {
        let allowed = self.kinetic_at(REST_SPEED_FACTOR * self.speed_error());
        self.adaptive.is_some() && reference_energy <= self.step_count as f64 * allowed
    }

    /// Kinetic energy of all nodes at one speed [J].
    fn kinetic_at(&self, speed: f64) -> f64 {
        0.5 * self.mechanics.masses.iter().sum::<f64>() * speed * speed
    }
}
