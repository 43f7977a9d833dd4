//! The Hessian of a crease's energy.

use nalgebra::Vector3;

use super::Creases;
use crate::arrays::columns::Columns;
use crate::arrays::jacobian::{JacobianBlocks, at, of_differences};
use crate::elements::hinge_set::HingeParameters;
use crate::elements::hinge_tangent::{Square, WeightedAngle};
use crate::laws::Instant;
use crate::simd::lanes::F64x8;

impl Creases {
    pub(super) fn jacobian(&self, instant: Instant<'_>, jacobian: &mut dyn JacobianBlocks) {
        let x = Columns::of(instant.positions);
        let mut last = (usize::MAX, F64x8::ZERO);
        for (batch, lane, nodes) in self.hinges.elements.each() {
            if last.0 != batch {
                last = (batch, self.facets(x, batch).1);
            }
            let corners = nodes.map(|node| at(instant.positions, node));
            let hessian = self.hessian(batch, lane, last.1, corners);
            of_differences(nodes, &hessian, |i, j, block| jacobian.by_position(i, j, block));
        }
    }

    fn hessian(&self, batch: usize, lane: usize, angles: F64x8, corners: [Vector3<f64>; 4]) -> Square {
        let HingeParameters { sign, stiffness, softening } = self.hinges.parameters[batch];
        let (energy, moment) = self.potential(batch, stiffness, angles);
        let [energy, moment, angle] = [energy, moment, angles].map(|lanes| lanes.0[lane]);
        let [excess, _] = self.own_or_common::<F64x8>(batch).map(|lanes| lanes.0[lane]);
        let gamma = if !(0.0..=std::f64::consts::TAU).contains(&angle) { 1.0 + excess } else { 1.0 };
        // theta = pi - sign phi.
        let slope = -sign.0[lane] * moment;
        WeightedAngle::new(corners, softening.map(|lanes| lanes.0[lane])).hessian(
            energy,
            slope,
            stiffness.0[lane] * gamma,
        )
    }
}
