//! Steps by plain loops with the scalar forces: the classical Runge-Kutta method, and leapfrog as in
//! `integrators/leapfrog.rs`, with the force of Coriolis at the new velocity.

use membrane_core::assembly::Assembly;

use super::{Motion, Oracle, Vec3, add, scale, sub};

/// The names of the methods.
pub const METHODS: [&str; 2] = ["rk4", "leapfrog"];

/// A scene in motion, and the data of a step.
pub struct Stepper {
    oracle: Oracle,
    inverse_masses: Vec<f64>,
    pub motion: Motion,
    /// State at the start of a step, and sums over its stages.
    start: [Vec<Vec3>; 2],
    sums: [Vec<Vec3>; 2],
    /// Accelerations of leapfrog at the end of the last step.
    accelerations: Option<Vec<Vec3>>,
    /// Work of dashpots and drag [J].
    pub work: f64,
}

impl Stepper {
    pub fn new(oracle: Oracle, assembly: &Assembly) -> Self {
        let Motion { positions, velocities, forces } = Motion::of(assembly);
        Self {
            oracle,
            inverse_masses: assembly.numbering.external_values(&assembly.inverse_masses),
            start: [positions.clone(), velocities.clone()],
            sums: [forces.clone(), forces.clone()],
            motion: Motion { positions, velocities, forces },
            accelerations: None,
            work: 0.0,
        }
    }

    /// Restores the state of a start.
    pub fn resume(&mut self, start: &Motion) {
        self.motion.positions.copy_from_slice(&start.positions);
        self.motion.velocities.copy_from_slice(&start.velocities);
        self.accelerations = None;
    }

    /// Takes `count` steps by a method.
    pub fn step(&mut self, method: &str, dt: f64, count: u64) {
        for _ in 0..count {
            if method == "rk4" { self.runge_kutta(dt) } else { self.leapfrog(dt) }
        }
    }

    /// Fills the forces with accelerations, and returns the power.
    fn accelerate(&mut self) -> f64 {
        let power = self.oracle.evaluate(&mut self.motion);
        for (force, &inverse) in self.motion.forces.iter_mut().zip(&self.inverse_masses) {
            *force = scale(inverse, *force);
        }
        power
    }

    fn runge_kutta(&mut self, dt: f64) {
        self.start[0].copy_from_slice(&self.motion.positions);
        self.start[1].copy_from_slice(&self.motion.velocities);
        self.sums.iter_mut().for_each(|sum| sum.fill([0.0; 3]));
        for (weight, ahead) in [(1.0, 0.5), (2.0, 0.5), (2.0, 1.0), (1.0, 0.0)] {
            self.work += weight * dt / 6.0 * self.accelerate();
            let Motion { positions, velocities, forces } = &mut self.motion;
            for node in 0..positions.len() {
                let (velocity, acceleration) = (velocities[node], forces[node]);
                add(&mut self.sums[0][node], weight, velocity);
                add(&mut self.sums[1][node], weight, acceleration);
                (positions[node], velocities[node]) = (self.start[0][node], self.start[1][node]);
                add(&mut positions[node], ahead * dt, velocity);
                add(&mut velocities[node], ahead * dt, acceleration);
            }
        }
        for node in 0..self.start[0].len() {
            add(&mut self.motion.positions[node], dt / 6.0, self.sums[0][node]);
            add(&mut self.motion.velocities[node], dt / 6.0, self.sums[1][node]);
        }
    }

    fn leapfrog(&mut self, dt: f64) {
        let half = 0.5 * dt;
        let before = self.accelerations.take().unwrap_or_else(|| {
            self.accelerate();
            self.motion.forces.clone()
        });
        // The velocity after half a kick; the motion has the predicted velocity.
        let kicked = &mut self.start[1];
        let Motion { positions, velocities, .. } = &mut self.motion;
        for node in 0..before.len() {
            kicked[node] = velocities[node];
            add(&mut kicked[node], half, before[node]);
            add(&mut positions[node], dt, kicked[node]);
            add(&mut velocities[node], dt, before[node]);
        }
        self.work += dt * self.accelerate();
        // Twice the rate of the frame: the force of Coriolis is m w J v.
        let rate = 2.0 * self.oracle.spin.0;
        let h = rate * half;
        let mut after = before;
        let Motion { velocities, forces, .. } = &mut self.motion;
        for node in 0..after.len() {
            // A held node has no acceleration at any velocity.
            let (rate, h) = if self.inverse_masses[node] == 0.0 { (0.0, 0.0) } else { (rate, h) };
            let mut ahead = self.start[1][node];
            add(&mut ahead, half, forces[node]);
            let [rx, ry, rz] = sub(ahead, velocities[node]);
            let correction = [(rx + h * ry) / (1.0 + h * h), (ry - h * rx) / (1.0 + h * h), rz];
            add(&mut velocities[node], 1.0, correction);
            after[node] = forces[node];
            add(&mut after[node], rate, [correction[1], -correction[0], 0.0]);
        }
        self.accelerations = Some(after);
    }
}
