//! The frame that turns with the hub, Omega(t) about z, in Cartesian components:
//!
//!     F_x = m (Omega^2 x + 2 Omega y' + Omega' y)
//!     F_y = m (Omega^2 y - 2 Omega x' - Omega' x)   [N]
//!
//! The centrifugal force has the potential U = -Omega^2/2 sum m (x^2 + y^2); the Coriolis force does no work; the Euler
//! force and the change of U with Omega are counted as work done on the system. The same law as the cylindrical one of
//! Okuizumi et al. (2012), section 3.5, without its singularity on the axis.

use std::ops::Range;

use super::{Law, NodalLaw};
use crate::arrays::jacobian::{Block, JacobianBlocks};
use crate::arrays::state::{Instant, NodeVectors, columns, rows};
use crate::assembly::Assembly;
use crate::error::Result;
use crate::model::checks::finite;
use crate::simd::dispatch::InstructionSet;
use crate::simd::lanes::SimdF64;
use crate::simd::map::{Formula, each};

/// How fast the hub turns about z.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Spin {
    /// Omega at t = 0 \[rad/s\].
    pub rate: f64,
    /// Omega' \[rad/s2\].
    pub acceleration: f64,
}

impl Spin {
    /// Omega at `time` \[rad/s\].
    pub fn rate_at(&self, time: f64) -> f64 {
        self.rate + self.acceleration * time
    }

    /// The angle that the hub has turned since t = 0 \[rad\].
    pub fn angle_at(&self, time: f64) -> f64 {
        (self.rate + 0.5 * self.acceleration * time) * time
    }
}

/// The law.
pub(super) struct RotatingFrame {
    spin: Spin,
    masses: Vec<f64>,
    width: InstructionSet,
}

impl RotatingFrame {
    pub(super) fn new(spin: Spin, assembly: &Assembly) -> Result<Self> {
        finite("rate of spin [rad/s]", spin.rate)?;
        finite("acceleration of spin [rad/s2]", spin.acceleration)?;
        Ok(Self { spin, masses: assembly.masses.clone(), width: assembly.width })
    }
}

/// Adds the forces of the frame on a node.
struct Swing {
    rate: f64,
    acceleration: f64,
}

impl Formula<5, 2> for Swing {
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
    fn add_to_rows(&self, range: Range<usize>, at: Instant<'_>, [fx, fy, _]: [&mut [f64]; 3]) -> f64 {
        let (rate, acceleration) = (self.spin.rate_at(at.time), self.spin.acceleration);
        let [x, y, _] = rows(at.positions, range.clone());
        let [u, v, _] = rows(at.velocities, range.clone());
        let masses = &self.masses[range];
        each(self.width, &Swing { rate, acceleration }, [masses, x, y, u, v], [fx, fy]);
        if acceleration == 0.0 {
            return 0.0;
        }
        let powers =
            (0..masses.len()).map(|i| masses[i] * (y[i] * u[i] - x[i] * v[i] - rate * (x[i] * x[i] + y[i] * y[i])));
        acceleration * powers.sum::<f64>()
    }
}

impl Law for RotatingFrame {
    fn name(&self) -> &'static str {
        "spin"
    }

    fn is_conservative(&self) -> bool {
        true
    }

    fn add_to_tile(&self, tile: usize, at: Instant<'_>, forces: &mut NodeVectors) -> f64 {
        self.add_to_nodes(tile, at, forces)
    }

    fn nodal(&self) -> Option<&dyn NodalLaw> {
        Some(self)
    }

    fn coriolis_rate(&self, time: f64) -> f64 {
        2.0 * self.spin.rate_at(time)
    }

    fn energy(&self, at: Instant<'_>) -> f64 {
        let rate = self.spin.rate_at(at.time);
        let [x, y, _] = columns(at.positions);
        let inertia: f64 = (0..self.masses.len()).map(|i| self.masses[i] * (x[i] * x[i] + y[i] * y[i])).sum();
        -0.5 * rate * rate * inertia
    }

    fn add_jacobian(&self, at: Instant<'_>, jacobian: &mut dyn JacobianBlocks) {
        let (rate, acceleration) = (self.spin.rate_at(at.time), self.spin.acceleration);
        let square = rate * rate;
        let by_position = Block::new(square, acceleration, 0.0, -acceleration, square, 0.0, 0.0, 0.0, 0.0);
        let by_velocity = Block::new(0.0, 2.0 * rate, 0.0, -2.0 * rate, 0.0, 0.0, 0.0, 0.0, 0.0);
        for (node, &mass) in self.masses.iter().enumerate() {
            jacobian.by_position(node as u32, node as u32, &(by_position * mass));
            jacobian.by_velocity(node as u32, node as u32, &(by_velocity * mass));
        }
    }

    fn remedy(&self) -> &'static str {
        "check the spin frequency, and that what should be held to the hub is held"
    }
}
