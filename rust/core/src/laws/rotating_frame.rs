//! The frame that turns with the hub, Omega(t) about z, in Cartesian components:
//!
//!     F_x = m (Omega^2 x + 2 Omega y' + Omega' y)
//!     F_y = m (Omega^2 y - 2 Omega x' - Omega' x)   [N]
//!
//! The centrifugal force has the potential U = -Omega^2/2 sum m (x^2 + y^2). The force of Coriolis does no work. The
//! force of Euler and the change of U with Omega count as work on the system. The law is that of Okuizumi et al.
//! (2012), section 3.5, in cylindrical coordinates, without the singularity on the axis.
//!
//! A free hub, with the rates omega and the velocity V of the origin, has the frame
//!
//!     F = -m (omega' x r + omega x (omega x r) + 2 omega x v + A)   [N],   A the acceleration of the origin in space.
//!
//! Its methods integrate velocities u = v + omega x r + V in space, without these forces. The energy of the law is then
//! that of the hub, less that at the start, and the difference of sum m u^2/2 and sum m v^2/2. Its work is that of the
//! motor.

use std::f64::consts::TAU;
use std::ops::Range;
use std::sync::Arc;

use nalgebra::Vector3;
use serde::Deserialize;

use super::{Context, Instant, Kernels, Law, LawParameters, Linearisation, NodalLaw, Properties, WorkClass};
use crate::arrays::jacobian::{Block, JacobianBlocks};
use crate::arrays::state::{columns, rows};
use crate::error::Result;
use crate::model::checks::{finite, positive, within};
use crate::model::frame::{Frame, Spin};
use crate::model::hub::{Freedom, Hub, HubFrame};
use crate::model::schedule::Schedule;
use crate::simd::dispatch::InstructionSet;
use crate::simd::lanes::SimdF64;
use crate::simd::map::{Formula, each};

/// Motion of the hub: Omega(t) = 2 pi (frequency + acceleration t), or 2 pi schedule(t); or a free hub with its motion
/// at the start.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpinParameters {
    /// Revolutions per second at t = 0 \[Hz\].
    pub frequency: f64,
    /// Its rate of change \[Hz/s\].
    pub acceleration: f64,
    /// Revolutions per second as a function of time \[Hz\], in place of both.
    pub schedule: Option<Schedule>,
    /// Moment of inertia of a free hub about its axis, without the nodes held on it \[kg m2\]; `None`: it is driven.
    #[serde(default)]
    pub inertia: Option<f64>,
    /// Torque of a motor about the axis of a free hub as a function of time \[N m\].
    #[serde(default)]
    pub torque: Option<Schedule>,
    /// Mass of a hub that is free in six degrees of freedom \[kg\]; `None`: it turns about its axis.
    #[serde(default)]
    pub mass: Option<f64>,
    /// Its moment of inertia about any axis across its own \[kg m2\].
    #[serde(default)]
    pub transverse_inertia: Option<f64>,
    /// Its rates about x and y at t = 0 \[Hz\].
    #[serde(default)]
    pub tumble: [f64; 2],
}

impl SpinParameters {
    /// What the hub is free to do; `None` where it is driven.
    fn freedom(&self) -> Option<Freedom> {
        let inertia = self.inertia?;
        Some(match (self.mass, self.transverse_inertia) {
            (Some(mass), Some(across)) => Freedom::Body { mass, inertia: [across, across, inertia] },
            _ => Freedom::Axis { inertia },
        })
    }

    fn check_hub(&self) -> Result<()> {
        const OF_FREE: &str = "it belongs to a free hub, which has an inertia";
        const OF_BODY: &str = "mass, transverse inertia and inertia together make a hub free in six degrees of freedom";
        let numbers = [
            ("inertia of the hub [kg m2]", self.inertia),
            ("mass of the hub [kg]", self.mass),
            ("transverse inertia of the hub [kg m2]", self.transverse_inertia),
        ];
        for (what, value) in numbers.into_iter().filter_map(|(what, value)| Some((what, value?))) {
            positive(what, value)?;
        }
        let mass = self.mass.or(self.transverse_inertia).unwrap_or_default();
        let is_body = self.mass.is_some() && self.transverse_inertia.is_some() && self.inertia.is_some();
        within("mass or transverse inertia of the hub", mass, mass == 0.0 || is_body, OF_BODY)?;
        if let Some(torque) = &self.torque {
            within("torque of the motor [N m]", torque.largest(), self.inertia.is_some(), OF_FREE)?;
        }
        for tumble in self.tumble {
            finite("rate of spin about x or y [rad/s]", TAU * tumble)?;
            within("rate of spin about x or y [Hz]", tumble, tumble == 0.0 || is_body, OF_BODY)?;
        }
        if let (Some(inertia), Some(across)) = (self.inertia, self.transverse_inertia) {
            let range = "it is at most twice the transverse inertia, as that of any body";
            within("inertia of the hub [kg m2]", inertia, inertia <= 2.0 * across, range)?;
        }
        let is_driven = self.acceleration != 0.0 || self.schedule.is_some();
        let range = "the rate of a free hub follows from its inertia; leave acceleration and schedule out";
        within(
            "inertia of the hub [kg m2]",
            self.inertia.unwrap_or_default(),
            self.inertia.is_none() || !is_driven,
            range,
        )
    }
}

impl LawParameters for SpinParameters {
    fn build(&self, context: &Context<'_>) -> Result<Box<dyn Law>> {
        finite("rate of spin [rad/s]", TAU * self.frequency)?;
        finite("acceleration of spin [rad/s2]", TAU * self.acceleration)?;
        if let Some(schedule) = &self.schedule {
            finite("rate of spin by its schedule [rad/s]", TAU * schedule.largest())?;
            finite("acceleration of spin by its schedule [rad/s2]", TAU * schedule.largest_rate())?;
            within(
                "acceleration of spin [Hz/s]",
                self.acceleration,
                self.acceleration == 0.0,
                "a schedule is in place",
            )?;
        }
        self.check_hub()?;
        let assembly = context.assembly;
        let torque = self.torque.clone();
        let nodes = assembly.masses.iter().zip(&assembly.inverse_masses);
        let free_masses = nodes.map(|(mass, inverse)| if *inverse > 0.0 { *mass } else { 0.0 }).collect();
        let (masses, instructions) = (assembly.masses.clone(), assembly.instructions);
        Ok(Box::new(RotatingFrame { masses, free_masses, torque, instructions }))
    }

    fn example() -> Self {
        Self { frequency: 3.0, acceleration: -0.3, ..Self::default() }
    }

    fn spin(&self) -> Option<Spin> {
        let (schedule, motor) = (self.schedule.clone().map(Arc::new), self.torque.clone().map(Arc::new));
        let (rate, [x, y]) = (TAU * self.frequency, self.tumble.map(|rate| TAU * rate));
        let hub = self.freedom().map(|freedom| Box::new(Hub::new(freedom, Vector3::new(x, y, rate), motor)));
        Some(Spin { rate, acceleration: TAU * self.acceleration, schedule, hub, ..Spin::default() })
    }
}

/// The law.
struct RotatingFrame {
    masses: Vec<f64>,
    /// Those without the held nodes, which are parts of a free hub.
    free_masses: Vec<f64>,
    /// Of the motor of a free hub.
    torque: Option<Schedule>,
    instructions: InstructionSet,
}

/// Adds the forces of the frame on a node.
struct FrameKernel {
    rate: f64,
    acceleration: f64,
}

impl Formula<5, 2> for FrameKernel {
    #[inline(always)]
    fn row<V: SimdF64>(&self, [mass, x, y, u, v]: [V; 5], [fx, fy]: [V; 2]) -> [V; 2] {
        let (square, twice) = (V::all(self.rate * self.rate), V::all(2.0 * self.rate));
        let acceleration = V::all(self.acceleration);
        [
            fx + mass * (square * x + twice * v + acceleration * y),
            fy + mass * (square * y - twice * u - acceleration * x),
        ]
    }
}

impl RotatingFrame {
    /// Adds the forces of the frame of a free hub, which has the rates and accelerations of `hub`.
    fn add_of_free(&self, range: Range<usize>, at: Instant<'_>, hub: &HubFrame, forces: [&mut [f64]; 3]) {
        let HubFrame { rates, accelerations: [turning, of_origin], .. } = hub;
        let [fx, fy, fz] = forces;
        for (row, node) in range.enumerate() {
            let (x, v) = (at.positions.row(node).transpose(), at.velocities.row(node).transpose());
            let all = turning.cross(&x) + rates.cross(&(rates.cross(&x) + 2.0 * v)) + of_origin;
            let force = -self.masses[node] * all;
            (fx[row], fy[row], fz[row]) = (fx[row] + force.x, fy[row] + force.y, fz[row] + force.z);
        }
    }
}

impl NodalLaw for RotatingFrame {
    fn add_to_rows(&mut self, range: Range<usize>, at: Instant<'_>, forces: [&mut [f64]; 3]) -> f64 {
        if let Some(hub) = &at.frame.hub {
            self.add_of_free(range, at, hub, forces);
            return 0.0;
        }
        let [fx, fy, _] = forces;
        let Frame { rate, acceleration, is_frozen, .. } = at.frame;
        let [x, y, _] = rows(at.positions, range.clone());
        let [u, v, _] = rows(at.velocities, range.clone());
        let masses = &self.masses[range];
        each(self.instructions, &FrameKernel { rate, acceleration }, [masses, x, y, u, v], [fx, fy]);
        if acceleration == 0.0 {
            return 0.0;
        }
        // dU/dt at rest is -Omega Omega' sum m r^2; frozen, Omega does not change.
        let rate = if is_frozen { 0.0 } else { rate };
        let powers =
            (0..masses.len()).map(|i| masses[i] * (y[i] * u[i] - x[i] * v[i] - rate * (x[i] * x[i] + y[i] * y[i])));
        acceleration * powers.sum::<f64>()
    }
}

impl Law for RotatingFrame {
    fn properties(&self) -> Properties {
        Properties { name: "spin", work_class: WorkClass::Conservative, depends_on_velocity: true, is_internal: false }
    }

    fn kernels(&self) -> Kernels {
        Kernels::default()
    }

    fn reach(&self, _tile: usize) -> usize {
        0
    }

    fn nodal(&mut self) -> Option<&mut dyn NodalLaw> {
        Some(self)
    }

    fn is_inertial(&self) -> bool {
        true
    }

    fn is_frame(&self) -> bool {
        true
    }

    fn energy(&self, at: Instant<'_>) -> f64 {
        if let Some(HubFrame { rates, velocity, energy, .. }) = &at.frame.hub {
            let of_node = |node: usize| {
                let (x, v) = (at.positions.row(node).transpose(), at.velocities.row(node).transpose());
                let carried = rates.cross(&x) + velocity;
                self.free_masses[node] * carried.dot(&(v + 0.5 * carried))
            };
            return energy + (0..self.free_masses.len()).map(of_node).sum::<f64>();
        }
        let rate = at.frame.rate;
        let [x, y, _] = columns(at.positions);
        let inertia: f64 = (0..self.masses.len()).map(|i| self.masses[i] * (x[i] * x[i] + y[i] * y[i])).sum();
        -0.5 * rate * rate * inertia
    }

    fn jumps(&self) -> Vec<f64> {
        self.torque.iter().flat_map(Schedule::jumps).collect()
    }

    fn linearisation(&self) -> Option<&dyn Linearisation> {
        Some(self)
    }

    fn remedy(&self) -> &'static str {
        "check the spin frequency, and that what should be held to the hub is held"
    }
}

impl Linearisation for RotatingFrame {
    fn coriolis_rate(&self, frame: Frame) -> f64 {
        2.0 * frame.rate
    }

    fn add_jacobian(&self, at: Instant<'_>, jacobian: &mut dyn JacobianBlocks) {
        let Frame { rate, acceleration, .. } = at.frame;
        let square = rate * rate;
        let by_position = Block::new(square, acceleration, 0.0, -acceleration, square, 0.0, 0.0, 0.0, 0.0);
        let by_velocity = Block::new(0.0, 2.0 * rate, 0.0, -2.0 * rate, 0.0, 0.0, 0.0, 0.0, 0.0);
        for (node, &mass) in self.masses.iter().enumerate() {
            jacobian.by_position(node as u32, node as u32, &(by_position * mass));
            jacobian.by_velocity(node as u32, node as u32, &(by_velocity * mass));
        }
    }
}
