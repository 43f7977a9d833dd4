//! Force and torque of the drag on some nodes, by the velocity V of each relative to the air and its flow:
//!
//!     sum c V,    sum c r x V,    c = -(rho_air/6) (sum of flows)

use super::DragKernel;
use crate::simd::dispatch::InstructionSet;
use crate::simd::lanes::SimdF64;
use crate::simd::map::{Formula, each};

/// c V along an axis.
struct ForceKernel {
    drag: DragKernel,
}

impl Formula<2, 0> for ForceKernel {
    #[inline(always)]
    fn row<V: SimdF64>(&self, _: [V; 2], _: [V; 0]) -> [V; 0] {
        []
    }

    #[inline(always)]
    fn summand<V: SimdF64>(&self, [wind, flow]: [V; 2], _: [V; 0]) -> V {
        self.drag.coefficient(flow) * wind
    }
}

/// c (x V_y - y V_x).
struct TorqueKernel {
    drag: DragKernel,
}

impl Formula<5, 0> for TorqueKernel {
    #[inline(always)]
    fn row<V: SimdF64>(&self, _: [V; 5], _: [V; 0]) -> [V; 0] {
        []
    }

    #[inline(always)]
    fn summand<V: SimdF64>(&self, [x, y, wind_x, wind_y, flow]: [V; 5], _: [V; 0]) -> V {
        self.drag.coefficient(flow) * (x * wind_y - y * wind_x)
    }
}

/// The nodes.
pub(super) struct Total<'a> {
    pub(super) factor: f64,
    pub(super) places: [&'a [f64]; 3],
    pub(super) wind: [&'a [f64]; 3],
    pub(super) flows: &'a [f64],
    pub(super) instructions: InstructionSet,
}

impl Total<'_> {
    /// The force along an axis \[N\].
    pub(super) fn force(&self, axis: usize) -> f64 {
        let kernel = ForceKernel { drag: DragKernel { factor: self.factor } };
        each(self.instructions, &kernel, [self.wind[axis], self.flows], [])
    }

    /// The torque about an axis through the origin \[N m\].
    pub(super) fn torque(&self, axis: usize) -> f64 {
        let kernel = TorqueKernel { drag: DragKernel { factor: self.factor } };
        let [i, j] = [(axis + 1) % 3, (axis + 2) % 3];
        let read = [self.places[i], self.places[j], self.wind[i], self.wind[j], self.flows];
        each(self.instructions, &kernel, read, [])
    }
}
