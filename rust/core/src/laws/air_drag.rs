//! Drag of the residual air, eq. (5), on each of a triangle's nodes against its velocity V relative to the air:
//!
//!     D = rho_air V^2 S_n / 6   [N],    S_n = |S . V| / V the area projected along V,   so   F = -(rho_air/6) |S . V| V
//!
//! with S the triangle's vector area and rho_air = p / (R T), R = 287 J/(kg K). The air is at rest in the chamber, so that
//! V = v + Omega x r in the turning frame, or it turns with the hub, so that V = v.
//! Source: Okuizumi et al. (2012), section 3.4.

mod tangent;

use std::ops::Range;
use std::sync::{Mutex, MutexGuard};

use super::{Law, NodalLaw, Spin};
use crate::arrays::blocks::tiles;
use crate::arrays::columns::{Columns, ColumnsMut};
use crate::arrays::jacobian::JacobianBlocks;
use crate::arrays::state::{Instant, NodeVectors, columns, rows};
use crate::assembly::Assembly;
use crate::error::Result;
use crate::layout::Elements;
use crate::model::checks::{non_negative, positive};
use crate::simd::dispatch::{BatchKernel, InstructionSet};
use crate::simd::lanes::{F64x8, SimdF64, cross, dot, scale, sub, sum};
use crate::simd::map::{Formula, each};

/// Specific gas constant of air \[J/(kg K)\].
const GAS_CONSTANT: f64 = 287.0;

/// How the air moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum AirMotion {
    /// At rest in the chamber.
    #[default]
    Still,
    /// Turning with the hub.
    Turning,
}

/// Parameters of the air.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AirDragParameters {
    /// Pressure \[Pa\].
    pub pressure: f64,
    /// Temperature \[K\].
    pub temperature: f64,
    /// How the air moves.
    pub air: AirMotion,
}

/// The law: all triangles, eight to a batch.
pub(super) struct AirDrag {
    elements: Elements<3>,
    /// 1 where there is a triangle, 0 in lanes that are filled up.
    presence: Vec<F64x8>,
    /// rho_air / 12 [kg/m3]: a sixth, and a half because normals are twice the vector areas.
    factor: f64,
    air: Mutex<Air>,
    /// The frame's turning relative to the air.
    spin: Spin,
    width: InstructionSet,
}

/// Room for what one evaluation needs.
struct Air {
    /// Velocity relative to the air along x, then along y [m/s].
    wind: Vec<f64>,
    /// The sum of |S . V| over the triangles of each node, S twice the vector area [m3/s]; zero between evaluations.
    flows: Vec<f64>,
}

impl AirDrag {
    pub(super) fn new(parameters: AirDragParameters, spin: Spin, assembly: &Assembly) -> Result<Self> {
        non_negative("pressure of the air [Pa]", parameters.pressure)?;
        positive("temperature of the air [K]", parameters.temperature)?;
        // Taken from the lowest node: drag does not ask which side faces the wind.
        let lowest_first = |[a, b, c]: [u32; 3]| match a.min(b).min(c) {
            lowest if lowest == a => [a, b, c],
            lowest if lowest == b => [b, c, a],
            _ => [c, a, b],
        };
        let triangles = assembly.mesh.triangles.iter().map(|&nodes| lowest_first(assembly.layout.to_internal(nodes)));
        let elements = Elements::new(&triangles.collect::<Vec<_>>(), assembly.masses.len());
        let nodes = assembly.masses.len();
        let factor = parameters.pressure / (GAS_CONSTANT * parameters.temperature) / 12.0;
        Ok(Self {
            presence: elements.pack(0.0, |_| 1.0),
            elements,
            factor,
            air: Mutex::new(Air { wind: vec![0.0; 2 * nodes], flows: vec![0.0; nodes] }),
            spin: if parameters.air == AirMotion::Still { spin } else { Spin::default() },
            width: assembly.width,
        })
    }

    fn air(&self) -> MutexGuard<'_, Air> {
        self.air.lock().unwrap_or_else(|poisoned| {
            // What a panic left behind.
            self.air.clear_poison();
            let mut air = poisoned.into_inner();
            air.flows.fill(0.0);
            air
        })
    }
}

/// The velocity relative to the air, across the axis, of nodes that move with (u, v) at (x, y) in the frame.
#[inline(always)]
fn wind<V: SimdF64>([x, y]: [V; 2], [u, v]: [V; 2], rate: V) -> [V; 2] {
    [u - rate * y, v + rate * x]
}

/// Works out the wind.
struct Blow {
    rate: f64,
}

impl Formula<4, 2> for Blow {
    #[inline(always)]
    fn row<V: SimdF64>(&self, [x, y, u, v]: [V; 4], _: [V; 2]) -> [V; 2] {
        wind([x, y], [u, v], V::all(self.rate))
    }
}

/// Adds the flow |S . V| through the triangles of one tile to their nodes'.
struct Flow<'a> {
    drag: &'a AirDrag,
    tile: usize,
    flows: ColumnsMut<'a, 1>,
    positions: Columns<'a>,
    wind: Columns<'a, 2>,
    /// Velocities along the axis.
    along: Columns<'a, 1>,
}

impl BatchKernel for Flow<'_> {
    #[inline(always)]
    fn part<V: SimdF64, const KIND: usize>(&mut self) -> V {
        let pass = self.drag.elements.pass::<KIND>(self.tile, self.positions.rows());
        let presence = pass.of(&self.drag.presence);
        for batch in 0..pass.len() {
            let r = pass.read::<V, 3>(self.positions, batch);
            let normal = scale(V::load(&presence[batch]), cross(sub(r[1], r[0]), sub(r[2], r[0])));
            let (wind, along) = (pass.read::<V, 2>(self.wind, batch), pass.read::<V, 1>(self.along, batch));
            let mut flow = [V::zero(); 3];
            for k in 0..3 {
                flow[k] = dot(normal, [wind[k][0], wind[k][1], along[k][0]]).abs();
            }
            pass.add_numbers(&mut self.flows, batch, flow);
        }
        V::zero()
    }
}

/// F = -(rho_air/6) (sum of flows) V on a node, and F . v; leaves no flow behind.
struct Resist {
    factor: f64,
}

impl Resist {
    #[inline(always)]
    fn pull<V: SimdF64>(&self, flow: V) -> V {
        V::all(-self.factor) * flow
    }
}

impl Formula<5, 4> for Resist {
    #[inline(always)]
    fn row<V: SimdF64>(&self, [wind_x, wind_y, _, _, w]: [V; 5], [fx, fy, fz, flow]: [V; 4]) -> [V; 4] {
        let pull = self.pull(flow);
        [fx + pull * wind_x, fy + pull * wind_y, fz + pull * w, V::zero()]
    }

    #[inline(always)]
    fn summand<V: SimdF64>(&self, [wind_x, wind_y, u, v, w]: [V; 5], [.., flow]: [V; 4]) -> V {
        self.pull(flow) * (wind_x * u + wind_y * v + w * w)
    }
}

/// Adds C p: the derivative of |S . V| V by V.
struct Damp<'a> {
    drag: &'a AirDrag,
    tile: usize,
    rate: f64,
    positions: Columns<'a>,
    velocities: Columns<'a>,
    p: Columns<'a>,
    out: ColumnsMut<'a>,
}

impl BatchKernel for Damp<'_> {
    #[inline(always)]
    fn part<V: SimdF64, const KIND: usize>(&mut self) -> V {
        let pass = self.drag.elements.pass::<KIND>(self.tile, self.positions.rows());
        let presence = pass.of(&self.drag.presence);
        for batch in 0..pass.len() {
            let (r, v) = (pass.read::<V, 3>(self.positions, batch), pass.read::<V, 3>(self.velocities, batch));
            let p = pass.read::<V, 3>(self.p, batch);
            let normal = cross(sub(r[1], r[0]), sub(r[2], r[0]));
            let factor = V::all(self.drag.factor) * V::load(&presence[batch]);
            let mut products = [[V::zero(); 3]; 3];
            for k in 0..3 {
                let [wind_x, wind_y] = wind([r[k][0], r[k][1]], [v[k][0], v[k][1]], V::all(self.rate));
                let wind = [wind_x, wind_y, v[k][2]];
                let (flow, moved) = (dot(normal, wind), dot(normal, p[k]));
                let along = scale(moved.copysign(flow * moved), wind);
                products[k] = scale(factor, sum(scale(flow.abs(), p[k]), along));
            }
            pass.add(&mut self.out, batch, products);
        }
        V::zero()
    }
}

impl NodalLaw for AirDrag {
    fn prepare(&self, tile: usize, at: Instant<'_>) {
        let Air { wind, flows } = &mut *self.air();
        let rate = self.spin.rate_at(at.time);
        let ahead = self.elements.new_rows(tile);
        let (wind_x, wind_y) = wind.split_at_mut(flows.len());
        let ([x, y, _], [u, v, _]) = (rows(at.positions, ahead.clone()), rows(at.velocities, ahead.clone()));
        each(self.width, &Blow { rate }, [x, y, u, v], [&mut wind_x[ahead.clone()], &mut wind_y[ahead]]);
        let (positions, wind) = (Columns::of(at.positions), Columns::in_slice(wind));
        let along = Columns::in_slice(columns(at.velocities)[2]);
        self.width.run_batches(Flow { drag: self, tile, flows: ColumnsMut::single(flows), positions, wind, along });
    }

    fn add_to_rows(&self, range: Range<usize>, at: Instant<'_>, [fx, fy, fz]: [&mut [f64]; 3]) -> f64 {
        let Air { wind, flows } = &mut *self.air();
        let (wind_x, wind_y) = wind.split_at(flows.len());
        let [u, v, w] = rows(at.velocities, range.clone());
        let read = [&wind_x[range.clone()], &wind_y[range.clone()], u, v, w];
        each(self.width, &Resist { factor: self.factor }, read, [fx, fy, fz, &mut flows[range]])
    }
}

impl Law for AirDrag {
    fn name(&self) -> &'static str {
        "air_drag"
    }

    fn is_conservative(&self) -> bool {
        false
    }

    fn add_to_tile(&self, tile: usize, at: Instant<'_>, forces: &mut NodeVectors) -> f64 {
        self.add_to_nodes(tile, at, forces)
    }

    fn nodal(&self) -> Option<&dyn NodalLaw> {
        Some(self)
    }

    fn add_damping_product(&self, at: Instant<'_>, p: &NodeVectors, out: &mut NodeVectors) {
        let [positions, velocities, p] = [at.positions, at.velocities, p].map(Columns::of);
        let rate = self.spin.rate_at(at.time);
        for tile in tiles(p.rows()) {
            let out = ColumnsMut::of(out);
            self.width.run_batches(Damp { drag: self, tile, rate, positions, velocities, p, out });
        }
    }

    fn visit_couplings(&self, visit: &mut dyn FnMut(&[u32])) {
        self.elements.each().for_each(|(.., nodes)| visit(&nodes));
    }

    fn add_jacobian(&self, at: Instant<'_>, jacobian: &mut dyn JacobianBlocks) {
        self.jacobian(at, jacobian);
    }

    fn lanes(&self) -> Option<[usize; 2]> {
        Some(self.elements.lanes())
    }

    fn contiguous_share(&self) -> Option<f64> {
        Some(self.elements.contiguous_share())
    }

    fn remedy(&self) -> &'static str {
        "use a smaller dt or a lower pressure"
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::input::{Film, Model};

    #[test]
    fn drag_on_a_plate_across_the_wind_is_half_rho_v2_s() {
        let points = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let film = Film { youngs_modulus: 1.0, poisson_ratio: 0.3, density: 1.0, thickness: 1.0 };
        let model = Model {
            positions: points.clone(),
            velocities: vec![[0.0, 0.0, 2.0]; 3],
            reference: points,
            triangles: vec![[0, 1, 2]],
            film: Some(film),
            extra_masses: vec![0.0; 3],
            ..Model::default()
        };
        let assembly = Assembly::new(model, InstructionSet::widest()).unwrap();
        let parameters = AirDragParameters { pressure: 4.5, temperature: 293.0, air: AirMotion::Still };
        let drag = AirDrag::new(parameters, Spin::default(), &assembly).unwrap();
        let (x, v) = (
            assembly.layout.internal_vectors(&assembly.model.positions),
            assembly.layout.internal_vectors(&assembly.model.velocities),
        );
        let mut forces = NodeVectors::zeros(3);
        let power = drag.add_forces(Instant { time: 0.0, positions: &x, velocities: &v }, &mut forces);
        let expected = -0.5 * 5.35e-5 * 4.0 * 0.5;
        assert!((forces.column(2).sum() / expected - 1.0).abs() < 1e-3);
        assert!((power - 2.0 * forces.column(2).sum()).abs() < 1e-18);
    }
}
