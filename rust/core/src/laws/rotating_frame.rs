//! The frame that turns with the hub, Omega(t) about z, in Cartesian components:
//!
//!     F_x = m (Omega^2 x + 2 Omega y' + Omega' y)
//!     F_y = m (Omega^2 y - 2 Omega x' - Omega' x)   [N]
//!
//! The centrifugal force has the potential U = -Omega^2/2 sum m (x^2 + y^2). The force of Coriolis does no work. The
//! force of Euler and the change of U with Omega count as work on the system. The law is that of Okuizumi et al.
//! (2012), section 3.5, in cylindrical coordinates, without the singularity on the axis.

use std::f64::consts::TAU;
use std::ops::Range;
use std::sync::Arc;

use serde::Deserialize;

use super::{Context, Instant, Kernels, Law, LawParameters, Linearisation, NodalLaw, Properties, WorkClass};
use crate::arrays::jacobian::{Block, JacobianBlocks};
use crate::arrays::state::{columns, rows};
use crate::error::Result;
use crate::model::checks::{finite, within};
use crate::model::frame::{Frame, Spin};
use crate::model::schedule::Schedule;
use crate::simd::dispatch::InstructionSet;
use crate::simd::lanes::SimdF64;
use crate::simd::map::{Formula, each};

/// Motion of the hub: Omega(t) = 2 pi (frequency + acceleration t), or 2 pi schedule(t).
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpinParameters {
    /// Revolutions per second at t = 0 \[Hz\].
    pub frequency: f64,
    /// Its rate of change \[Hz/s\].
    pub acceleration: f64,
    /// Revolutions per second as a function of time \[Hz\], in place of both.
    pub schedule: Option<Schedule>,
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
        let assembly = context.assembly;
        Ok(Box::new(RotatingFrame { masses: assembly.masses.clone(), instructions: assembly.instructions }))
    }

    fn example() -> Self {
        Self { frequency: 3.0, acceleration: -0.3, schedule: None }
    }

    fn spin(&self) -> Option<Spin> {
        let schedule = self.schedule.clone().map(Arc::new);
        Some(Spin { rate: TAU * self.frequency, acceleration: TAU * self.acceleration, schedule, ..Spin::default() })
    }
}

/// The law.
struct RotatingFrame {
    masses: Vec<f64>,
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

impl NodalLaw for RotatingFrame {
    fn add_to_rows(&mut self, range: Range<usize>, at: Instant<'_>, [fx, fy, _]: [&mut [f64]; 3]) -> f64 {
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

    fn energy(&self, at: Instant<'_>) -> f64 {
        let rate = at.frame.rate;
        let [x, y, _] = columns(at.positions);
        let inertia: f64 = (0..self.masses.len()).map(|i| self.masses[i] * (x[i] * x[i] + y[i] * y[i])).sum();
        -0.5 * rate * rate * inertia
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
