//! A rigid body of prescribed motion: its pose, and the velocity of its points, by schedules.
//!
//! In the frame of the hub, with the centre c, the direction u of the axis or normal, the unit vector e of the azimuth
//! of c, and the horizontal z x e about which the body tilts, all at the start:
//!
//!     centre     X = Rz(turn + 2 pi q/n) (c + (travel_x, travel_y, travel_z) + travel_radial e)      copy q of n
//!     direction  U = Rz(turn + 2 pi q/n) R(z x e, tilt) u
//!     velocity   v(x) = X' + w x (x - X),   w = turn' z + tilt' Rz(...) (z x e)
//!     surface    v(x) + spin' U x (x - X)
//!
//! Where c lies on the axis of the hub, e is the x axis. At a frozen instant nothing moves.

use std::f64::consts::TAU;

use crate::bodies::real::cross;
use crate::error::Result;
use crate::model::checks::{finite, within};
use crate::model::mesh::{dot, sub};
use crate::model::schedule::Schedule;

/// The most copies of a body.
pub const MOST_COPIES: f64 = 1000.0;

/// How a body stands and moves.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Motion {
    /// c \[m\].
    pub centre: [f64; 3],
    /// Direction of the axis or of the normal, of any length.
    pub direction: [f64; 3],
    /// n.
    pub copies: f64,
    /// About the axis of the hub \[rad\].
    pub turn: Option<Schedule>,
    /// Along x, y, z, before the turn \[m\].
    pub travel: [Option<Schedule>; 3],
    /// Along e \[m\].
    pub travel_radial: Option<Schedule>,
    /// About z x e through the centre \[rad\].
    pub tilt: Option<Schedule>,
    /// About its own axis \[rad\].
    pub spin: Option<Schedule>,
}

impl Motion {
    fn schedules(&self) -> impl Iterator<Item = &Schedule> {
        let others = [&self.turn, &self.travel_radial, &self.tilt, &self.spin];
        others.into_iter().chain(&self.travel).flatten()
    }
}

/// A rigid body with checked values.
#[derive(Debug, Clone, PartialEq)]
pub struct RigidBody {
    motion: Motion,
    /// u and e, of length 1.
    direction: [f64; 3],
    radial: [f64; 3],
    copies: usize,
    is_moving: bool,
}

/// Place and velocity of one copy of a body at an instant.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Pose {
    /// X \[m\].
    pub centre: [f64; 3],
    /// U, of length 1.
    pub direction: [f64; 3],
    /// X' \[m/s\].
    pub velocity: [f64; 3],
    /// w \[rad/s\].
    pub rotation: [f64; 3],
    /// spin' \[rad/s\].
    pub spin: f64,
}

impl Pose {
    /// Velocity of the body, its spin left out, at a point \[m/s\].
    #[inline]
    pub fn velocity_at(&self, point: [f64; 3]) -> [f64; 3] {
        let around = cross(self.rotation, sub(point, self.centre));
        [0, 1, 2].map(|axis| self.velocity[axis] + around[axis])
    }

    /// Angular velocity of the surface \[rad/s\].
    #[inline]
    pub fn surface_rotation(&self) -> [f64; 3] {
        [0, 1, 2].map(|axis| self.rotation[axis] + self.spin * self.direction[axis])
    }

    /// Distance of the centre from the origin \[m\].
    pub fn distance(&self) -> f64 {
        dot(self.centre, self.centre).sqrt()
    }

    /// Largest change of the distance between a point and the surface, from one pose to another \[m\]; the points lie
    /// within `reach` of the first centre.
    pub fn shift(&self, other: &Self, reach: f64) -> f64 {
        let length = |a: [f64; 3]| dot(a, a).sqrt();
        let (moved, turned) = (sub(self.centre, other.centre), sub(self.direction, other.direction));
        length(moved) + length(turned) * (reach + length(moved))
    }
}

impl RigidBody {
    /// Checks the values.
    ///
    /// # Errors
    /// `OutOfRange`.
    pub fn new(motion: Motion) -> Result<Self> {
        for value in motion.centre.into_iter().chain(motion.direction) {
            finite("centre or direction of a body", value)?;
        }
        let largest = motion.direction.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
        within("direction of a body", largest, largest > 0.0, "its length must be above zero")?;
        let copies = motion.copies;
        let is_count = (1.0..=MOST_COPIES).contains(&copies) && copies.fract() == 0.0;
        within("copies of a body", copies, is_count, "it must be a whole number from 1 to 1000")?;
        let unit = motion.direction.map(|value| value / largest);
        let length = dot(unit, unit).sqrt();
        let [x, y, _] = motion.centre;
        let radius = x.hypot(y);
        let radial = if radius > 0.0 { [x / radius, y / radius, 0.0] } else { [1.0, 0.0, 0.0] };
        let is_moving = motion.schedules().any(|schedule| schedule.largest_rate() != 0.0);
        Ok(Self { direction: unit.map(|value| value / length), radial, copies: copies as usize, motion, is_moving })
    }

    /// Whether any schedule has a rate.
    pub fn is_moving(&self) -> bool {
        self.is_moving
    }

    /// The times at which it jumps \[s\].
    pub fn jumps(&self) -> Vec<f64> {
        self.motion.schedules().flat_map(Schedule::jumps).collect()
    }

    /// The poses of all copies at a time \[s\], into `poses`.
    pub fn pose(&self, time: f64, is_frozen: bool, poses: &mut Vec<Pose>) {
        let value = |schedule: &Option<Schedule>| schedule.as_ref().map_or(0.0, |schedule| schedule.value(time));
        let rate = |schedule: &Option<Schedule>| {
            schedule.as_ref().filter(|_| !is_frozen).map_or(0.0, |schedule| schedule.rate(time))
        };
        let Motion { turn, travel, travel_radial, tilt, spin, centre, .. } = &self.motion;
        let along = |radial: f64, offset: [f64; 3]| [0, 1, 2].map(|axis| offset[axis] + radial * self.radial[axis]);
        let moved = along(value(travel_radial), travel.each_ref().map(value));
        let centre = [0, 1, 2].map(|axis| centre[axis] + moved[axis]);
        let velocity = along(rate(travel_radial), travel.each_ref().map(rate));
        let about = [-self.radial[1], self.radial[0], 0.0];
        let mut direction = self.direction;
        if tilt.is_some() {
            // Rodrigues's formula.
            let (sine, cosine) = value(tilt).sin_cos();
            let (across, share) = (cross(about, direction), dot(about, direction) * (1.0 - cosine));
            direction = [0, 1, 2].map(|axis| cosine * direction[axis] + sine * across[axis] + share * about[axis]);
        }
        let (turned, turning, tilting, spin) = (value(turn), rate(turn), rate(tilt), rate(spin));
        poses.clear();
        poses.extend((0..self.copies).map(|copy| {
            let angle = turned + TAU * copy as f64 / self.copies as f64;
            let (sine, cosine) = if angle == 0.0 { (0.0, 1.0) } else { angle.sin_cos() };
            let rotated = |a: [f64; 3]| [cosine * a[0] - sine * a[1], sine * a[0] + cosine * a[1], a[2]];
            let (centre, own, about) = (rotated(centre), rotated(velocity), rotated(about));
            Pose {
                centre,
                direction: rotated(direction),
                velocity: [own[0] - turning * centre[1], own[1] + turning * centre[0], own[2]],
                rotation: [tilting * about[0], tilting * about[1], turning + tilting * about[2]],
                spin,
            }
        }));
    }
}
