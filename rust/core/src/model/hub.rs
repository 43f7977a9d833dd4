//! A hub that nothing drives: a rigid body in which the frame is fixed.
//!
//!     about its axis                 I Omega' = tau_z                                                   [N m]
//!     in six degrees of freedom      M V' = F,   L' = tau,   L = I omega about the centre of mass       [N, N m]
//!
//! Vectors have components along the axes of the hub, but for the place of the centre. F and tau are the sum of the
//! forces of the sail and that of their torques about the centre. Nodes held on the hub are parts of it.
//!
//! Without forces the hub turns as a free top. Of a symmetric one, I = (I_t, I_t, I_3), the rotation D in a time t is
//! known (Landau and Lifshitz, Mechanics, section 33): by the angle L_3 (1/I_3 - 1/I_t) t about its axis, then by |L|
//! t/I_t about L, which is fixed in space. The rest of another one, L_1^2/2 (1/I_1 - 1/I_t) + L_2^2/2 (1/I_2 - 1/I_t),
//! turns it about the first two axes by half before and half after, symmetric and of order two.

use std::sync::Arc;

use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};

use super::hub_motion::{HubMotion, NUMBERS};
use super::load::Load;
use super::schedule::Schedule;
use super::turn::Turn;

/// What the hub is free to do, with its moments of inertia \[kg m2\] without the nodes held on it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Freedom {
    /// It turns about its axis.
    Axis {
        /// About the axis.
        inertia: f64,
    },
    /// It moves in six degrees of freedom; its centre of mass is the origin.
    Body {
        /// Mass \[kg\].
        mass: f64,
        /// About x, y and z.
        inertia: [f64; 3],
    },
}

/// The frame of a free hub at an instant, beside its rate about the axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HubFrame {
    /// Rates \[rad/s\].
    pub rates: Vector3<f64>,
    /// Velocity of the origin \[m/s\].
    pub velocity: Vector3<f64>,
    /// Rates of change of both, where a reading has found them; else 0 \[rad/s2, m/s2\].
    pub accelerations: [Vector3<f64>; 2],
    /// Kinetic energy of the hub without the nodes held on it, less that at the start \[J\].
    pub energy: f64,
    /// How it stands in space, in six degrees of freedom.
    pub body: Option<BodyFrame>,
}

/// The frame of a hub in six degrees of freedom, as it stands in space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyFrame {
    /// From components of the hub to those in space.
    pub attitude: UnitQuaternion<f64>,
    /// The origin, from the point where the centre of mass of the hub began \[m\].
    pub origin: Vector3<f64>,
    /// Mass at the origin, that of the hub without the nodes held on it \[kg\].
    pub mass: f64,
}

/// A free hub: what it is, and how it moves now.
#[derive(Debug, Clone, PartialEq)]
pub struct Hub {
    /// What it is free to do.
    pub freedom: Freedom,
    /// Rates at the start \[rad/s\].
    pub start: Vector3<f64>,
    /// Torque of a motor about its axis as a function of time \[N m\].
    pub motor: Option<Arc<Schedule>>,
    /// Its motion.
    pub motion: HubMotion,
    /// With the nodes held on it: mass \[kg\], centre of mass \[m\], tensor of inertia about it \[kg m2\].
    mass: f64,
    centre: Vector3<f64>,
    inertia: Matrix3<f64>,
    inverse: Matrix3<f64>,
    /// Principal axes, the nearest to one of symmetry last, with their moments.
    axes: Matrix3<f64>,
    moments: Vector3<f64>,
}

impl Hub {
    /// A hub without held nodes, at its start.
    pub fn new(freedom: Freedom, start: Vector3<f64>, motor: Option<Arc<Schedule>>) -> Self {
        let (none, unit) = (Matrix3::zeros(), Matrix3::identity());
        let mut hub = Self {
            freedom,
            start,
            motor,
            motion: HubMotion::default(),
            mass: 0.0,
            centre: Vector3::zeros(),
            inertia: none,
            inverse: none,
            axes: unit,
            moments: Vector3::zeros(),
        };
        hub.weigh(std::iter::empty());
        hub
    }

    /// Makes nodes a part of the hub, by mass \[kg\] and position \[m\], in place of those before.
    pub fn weigh(&mut self, held: impl Iterator<Item = (f64, Vector3<f64>)> + Clone) {
        let (mass, own) = self.own();
        let about = |x: Vector3<f64>| Matrix3::identity() * x.norm_squared() - x * x.transpose();
        let sums = held.clone().fold((mass, Vector3::zeros()), |(all, moment), (m, x)| (all + m, moment + x * m));
        let tensor = held.fold(Matrix3::from_diagonal(&own), |sum, (m, x)| sum + about(x) * m);
        if let Freedom::Axis { .. } = self.freedom {
            let moment = tensor[(2, 2)];
            self.inertia = Matrix3::from_diagonal(&Vector3::new(0.0, 0.0, moment));
            self.inverse = Matrix3::from_diagonal(&Vector3::new(0.0, 0.0, 1.0 / moment));
            return;
        }
        (self.mass, self.centre) = (sums.0, sums.1 / sums.0);
        self.inertia = tensor - about(self.centre) * self.mass;
        let decomposed = self.inertia.symmetric_eigen();
        let apart = |k: usize| (decomposed.eigenvalues[(k + 1) % 3] - decomposed.eigenvalues[(k + 2) % 3]).abs();
        let last = (0..3).min_by(|&a, &b| apart(a).total_cmp(&apart(b))).unwrap_or(2);
        let order = [(last + 1) % 3, (last + 2) % 3, last];
        self.axes = Matrix3::from_columns(&order.map(|k| decomposed.eigenvectors.column(k).into_owned()));
        // Right-handed: a turn about them is one of the hub.
        let handedness = self.axes.determinant().signum();
        self.axes.column_mut(0).scale_mut(handedness);
        self.moments = Vector3::from(order.map(|k| decomposed.eigenvalues[k]));
        self.inverse = self.axes * Matrix3::from_diagonal(&self.moments.map(f64::recip)) * self.axes.transpose();
    }

    /// Mass \[kg\] and moments of inertia about the axes \[kg m2\] without the nodes held on it; 0 where it is held.
    fn own(&self) -> (f64, Vector3<f64>) {
        match self.freedom {
            Freedom::Axis { inertia } => (0.0, Vector3::new(0.0, 0.0, inertia)),
            Freedom::Body { mass, inertia } => (mass, inertia.into()),
        }
    }

    /// Masses at `n` places r on the hub whose kinetic energy in any motion of it is at most its own \[kg\]: about an
    /// axis I/(n r^2). In six degrees of freedom (v + omega x r)^2 <= 2 v^2 + 2 omega^2 r^2: each has the lesser of
    /// M/(2 n) and of the least moment of inertia over 2 sum r^2.
    pub fn shares(&self, places: impl ExactSizeIterator<Item = Vector3<f64>>) -> Vec<f64> {
        let count = places.len() as f64;
        let arms: Vec<f64> = places.map(|x| self.arm_square(x - self.centre)).collect();
        if !self.is_body() {
            return arms.iter().map(|square| self.inertia[(2, 2)] / (count * square)).collect();
        }
        let share = (0.5 * self.mass / count).min(0.5 * self.moments.min() / arms.iter().sum::<f64>());
        vec![share; arms.len()]
    }

    /// The square of the distance from the axis, or from the centre \[m2\].
    fn arm_square(&self, x: Vector3<f64>) -> f64 {
        if self.is_body() { x.norm_squared() } else { x.xy().norm_squared() }
    }

    /// Whether it moves in six degrees of freedom.
    pub fn is_body(&self) -> bool {
        matches!(self.freedom, Freedom::Body { .. })
    }

    /// Its centre of mass, or a point of the axis \[m\].
    pub fn centre(&self) -> Vector3<f64> {
        self.centre
    }

    /// Rates \[rad/s\].
    pub fn rates(&self) -> Vector3<f64> {
        self.start + self.motion.change
    }

    /// Velocity of the origin \[m/s\].
    pub fn velocity_of_origin(&self) -> Vector3<f64> {
        self.motion.velocity - self.rates().cross(&self.centre)
    }

    /// From components of the hub to those in space.
    pub fn attitude(&self) -> UnitQuaternion<f64> {
        match self.freedom {
            Freedom::Axis { .. } => UnitQuaternion::from_axis_angle(&Vector3::z_axis(), self.motion.angle),
            Freedom::Body { .. } => UnitQuaternion::new_normalize(self.motion.attitude),
        }
    }

    /// Its motion with the rates themselves as changes, and with the place and the velocity of the origin in place of
    /// those of the centre of mass: from it a hub of another start, which holds other nodes, may go on.
    pub fn state(&self) -> HubMotion {
        let attitude = self.attitude();
        HubMotion {
            attitude: attitude.into_inner(),
            centre: self.motion.centre - attitude * self.centre,
            change: self.rates(),
            velocity: self.velocity_of_origin(),
            ..self.motion
        }
    }

    /// Goes on from such a motion, as far as it is free to. The nodes held on it are weighed before.
    pub fn go_on(&mut self, state: &HubMotion) {
        let change = state.change - self.start;
        self.motion = match self.freedom {
            Freedom::Axis { .. } => {
                HubMotion { angle: state.angle, change: Vector3::new(0.0, 0.0, change.z), ..HubMotion::default() }
            }
            Freedom::Body { .. } => HubMotion {
                change,
                centre: state.centre + UnitQuaternion::new_normalize(state.attitude) * self.centre,
                velocity: state.velocity + state.change.cross(&self.centre),
                ..*state
            },
        };
    }

    /// Angular momentum about the centre of mass \[kg m2/s\].
    pub fn momentum(&self) -> Vector3<f64> {
        self.inertia * self.rates()
    }

    /// Angular momentum without the nodes held on it \[kg m2/s\], about a point from which the origin of the frame lies
    /// at `origin`; of a hub on its axis about that. Its own centre of mass is the origin.
    pub fn own_momentum(&self, origin: Vector3<f64>) -> Vector3<f64> {
        let (mass, inertia) = self.own();
        self.rates().component_mul(&inertia) + mass * origin.cross(&self.velocity_of_origin())
    }

    /// The torque of the motor at a time \[N m\].
    pub fn motor_torque(&self, time: f64) -> f64 {
        self.motor.as_ref().map_or(0.0, |motor| motor.value(time))
    }

    /// The frame at present.
    pub fn frame(&self) -> HubFrame {
        let (mass, inertia) = self.own();
        let origin = self.velocity_of_origin();
        let body = self.is_body().then(|| {
            let attitude = self.attitude();
            BodyFrame { attitude, origin: self.motion.centre - attitude * self.centre, mass }
        });
        let turning = 0.5 * inertia.component_mul(&self.motion.change).dot(&(2.0 * self.start + self.motion.change));
        HubFrame {
            rates: self.rates(),
            velocity: origin,
            accelerations: [Vector3::zeros(); 2],
            energy: turning + 0.5 * mass * origin.norm_squared(),
            body,
        }
    }

    /// Rates of change of the rates \[rad/s2\], and of the velocities in space of the centre and of the origin, under a
    /// load about the centre of mass \[m/s2\].
    pub fn accelerations(&self, load: &Load) -> [Vector3<f64>; 3] {
        let rates = self.rates();
        if !self.is_body() {
            return [self.inverse * load.torque, Vector3::zeros(), Vector3::zeros()];
        }
        let turning = self.inverse * (load.torque - rates.cross(&self.momentum()));
        let centre = load.force / self.mass;
        let to_origin = -self.centre;
        [turning, centre, centre + turning.cross(&to_origin) + rates.cross(&rates.cross(&to_origin))]
    }

    /// Rates of change of the numbers of the motion under such a load.
    pub fn derivative(&self, load: &Load) -> [f64; NUMBERS] {
        let (rates, [turning, centre, _]) = (self.rates(), self.accelerations(load));
        if !self.is_body() {
            let still = Quaternion::new(0.0, 0.0, 0.0, 0.0);
            return HubMotion { angle: rates.z, attitude: still, change: turning, ..HubMotion::default() }.numbers();
        }
        HubMotion {
            angle: rates.z,
            attitude: self.motion.attitude * Quaternion::from_imag(0.5 * rates),
            centre: self.attitude() * self.motion.velocity,
            change: turning,
            velocity: centre - rates.cross(&self.motion.velocity),
        }
        .numbers()
    }

    /// Adds the impulse of a load about its centre of mass over a time \[s\].
    pub fn kick(&mut self, load: &Load, dt: f64) {
        self.motion.change += self.inverse * load.torque * dt;
        if self.is_body() {
            self.motion.velocity += load.force * (dt / self.mass);
        }
    }

    /// F^2/M + tau . I^-1 tau of such a load \[N2/kg\].
    pub fn square_of(&self, load: &Load) -> f64 {
        let along = if self.is_body() { load.force.norm_squared() / self.mass } else { 0.0 };
        along + load.torque.dot(&(self.inverse * load.torque))
    }

    /// Moves as without forces for a time \[s\]. Its turn.
    pub fn drift(&mut self, dt: f64) -> Turn {
        let rates = self.rates();
        if !self.is_body() {
            self.motion.angle += rates.z * dt;
            return Turn::about(Vector3::z(), rates.z * dt);
        }
        self.motion.centre += self.attitude() * self.motion.velocity * dt;
        let turn = self.free_top(dt);
        self.motion.velocity = turn.back(self.motion.velocity);
        self.motion.change += self.inverse * (turn.excess.transpose() * self.momentum());
        self.motion.angle += 0.5 * (rates.z + self.rates().z) * dt;
        self.motion.attitude = (self.motion.attitude * turn.quaternion).normalize();
        turn
    }

    /// The turn of the hub without torque in a time \[s\].
    fn free_top(&self, dt: f64) -> Turn {
        let [a, b, c]: [f64; 3] = self.moments.map(f64::recip).into();
        let (transverse, mut momentum) = (0.5 * (a + b), self.axes.transpose() * self.momentum());
        let (mut all, half) = (Turn::none(), 0.5 * dt);
        let first = |l: Vector3<f64>| Turn::about(Vector3::x(), l.x * (a - transverse) * half);
        let second = |l: Vector3<f64>| Turn::about(Vector3::y(), l.y * (b - transverse) * half);
        let symmetric = |l: Vector3<f64>| {
            let about_momentum = Turn::about(l, l.norm() * transverse * dt);
            about_momentum.then(&Turn::about(Vector3::z(), l.z * (c - transverse) * dt))
        };
        let parts: [&dyn Fn(Vector3<f64>) -> Turn; 5] = [&first, &second, &symmetric, &second, &first];
        for part in parts {
            let turn = part(momentum);
            momentum = turn.back(momentum);
            all = all.then(&turn);
        }
        let along = self.axes * all.quaternion.imag();
        Turn {
            excess: self.axes * all.excess * self.axes.transpose(),
            quaternion: Quaternion::from_parts(all.quaternion.w, along),
        }
    }
}

#[cfg(test)]
mod tests;
