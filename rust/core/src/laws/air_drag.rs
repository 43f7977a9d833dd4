//! Drag of the residual air, eq. (5), on each node of a triangle against its velocity V relative to the air:
//!
//!     D = rho_air V^2 S_n / 6   [N],    S_n = |S . V| / V the area projected along V,
//!     F = -(rho_air/6) |S . V| V
//!
//! with S the vector area of the triangle and rho_air = p / (R T), R = 287 J/(kg K). The air is at rest in the chamber,
//! so that V = v + Omega x r in the turning frame, or it turns with the hub, so that V = v. In air at rest the origin
//! of a hub in six degrees of freedom has the velocity V_0: V = v + omega x r + V_0.
//! Source: Okuizumi et al. (2012), section 3.4.

mod tangent;
mod total;
mod wind;

use std::ops::Range;

use nalgebra::Vector3;
use serde::Deserialize;

use self::total::Total;
use self::wind::{AboutAxis, Carried, about_axis};
use super::{
    Context, Inspection, Instant, Kernels, Law, LawParameters, Linearisation, NodalLaw, Properties, WorkClass,
};
use crate::arrays::blocks::tiles;
use crate::arrays::columns::{Columns, ColumnsMut};
use crate::arrays::jacobian::JacobianBlocks;
use crate::arrays::state::{NodeVectors, columns, rows};
use crate::assembly::Assembly;
use crate::elements::facet::{FacetSet, normal};
use crate::error::Result;
use crate::model::checks::{non_negative, positive};
use crate::model::frame::Frame;
use crate::model::load::Load;
use crate::simd::dispatch::{BatchKernel, InstructionSet};
use crate::simd::lanes::{SimdF64, dot, scale, sum};
use crate::simd::map::{Formula, each};

/// Specific gas constant of air \[J/(kg K)\].
const GAS_CONSTANT: f64 = 287.0;

/// Motion of the air.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum AirMotion {
    /// At rest in the chamber.
    #[default]
    Still,
    /// Turning with the hub.
    Turning,
}

/// Parameters of the air.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AirDragParameters {
    /// Pressure \[Pa\].
    pub pressure: f64,
    /// Temperature \[K\].
    pub temperature: f64,
    /// Motion of the air.
    pub air: AirMotion,
}

impl LawParameters for AirDragParameters {
    fn build(&self, context: &Context<'_>) -> Result<Box<dyn Law>> {
        Ok(Box::new(AirDrag::new(*self, context.assembly)?))
    }

    fn example() -> Self {
        Self { pressure: 1e5, temperature: 293.0, air: AirMotion::Still }
    }
}

/// The law: all facets, in batches of eight, and work arrays of an evaluation.
struct AirDrag {
    facets: FacetSet,
    /// rho_air / 12 [kg/m3]: a sixth, and a half because normals are twice the vector areas.
    factor: f64,
    air: AirMotion,
    /// Velocity relative to the air along x, then along y [m/s].
    wind: Vec<f64>,
    /// The same along z, where the frame moves along or across it; else that of the nodes, and this is empty.
    along: Vec<f64>,
    /// The sum of |S . V| over the facets of each node, S twice the vector area [m3/s]; zero between evaluations.
    flows: Vec<f64>,
    /// See `Law::outside_load`.
    outside: Load,
    instructions: InstructionSet,
}

impl AirDrag {
    fn new(parameters: AirDragParameters, assembly: &Assembly) -> Result<Self> {
        non_negative("pressure of the air [Pa]", parameters.pressure)?;
        positive("temperature of the air [K]", parameters.temperature)?;
        let nodes = assembly.masses.len();
        Ok(Self {
            facets: FacetSet::new(assembly),
            factor: parameters.pressure / (GAS_CONSTANT * parameters.temperature) / 12.0,
            air: parameters.air,
            wind: vec![0.0; 2 * nodes],
            along: Vec::new(),
            flows: vec![0.0; nodes],
            outside: Load::default(),
            instructions: assembly.instructions,
        })
    }

    /// Angular velocity of the frame about the axis relative to the air [rad/s].
    fn rate(&self, frame: Frame) -> f64 {
        match self.air {
            AirMotion::Still => frame.rate,
            AirMotion::Turning => 0.0,
        }
    }

    /// The motion of the frame relative to the air, where it is not one about the axis.
    fn carried(&self, frame: Frame) -> Option<Carried> {
        (self.air == AirMotion::Still && frame.body().is_some()).then(|| {
            let (rates, velocity) = frame.carried();
            Carried { rates: rates.into(), velocity: velocity.into() }
        })
    }
}

/// Adds the volume flow |S . V| through the triangles of one tile to the sums of their nodes.
struct FlowKernel<'a> {
    facets: &'a FacetSet,
    tile: usize,
    flows: ColumnsMut<'a, 1>,
    positions: Columns<'a>,
    wind: Columns<'a, 2>,
    /// The same along the axis.
    along: Columns<'a, 1>,
}

impl BatchKernel for FlowKernel<'_> {
    #[inline(always)]
    fn sweep_kind<V: SimdF64, const KIND: usize>(&mut self) -> V {
        let pass = self.facets.elements.pass::<KIND>(self.tile, self.positions.rows());
        let positions = pass.reader(self.positions);
        let winds = pass.reader(self.wind);
        let alongs = pass.reader(self.along);
        let mut sums = pass.adder(&mut self.flows);
        let presence = self.facets.presence.of(&pass);
        for batch in 0..pass.len() {
            let r = positions.read::<V>(batch);
            let normal = scale(V::load(&presence[batch]), normal(&r));
            let (wind, along) = (winds.read::<V>(batch), alongs.read::<V>(batch));
            let mut flow = [V::zero(); 3];
            for k in 0..3 {
                flow[k] = dot(normal, [wind[k][0], wind[k][1], along[k][0]]).abs();
            }
            sums.add(batch, flow.map(|number| [number]));
        }
        V::zero()
    }
}

/// F = -(rho_air/6) (sum of flows) V on a node, and F . v; resets the sum of flows to zero.
struct DragKernel {
    factor: f64,
}

impl DragKernel {
    #[inline(always)]
    fn coefficient<V: SimdF64>(&self, flow: V) -> V {
        V::all(-self.factor) * flow
    }
}

impl Formula<6, 4> for DragKernel {
    #[inline(always)]
    fn row<V: SimdF64>(&self, [wind_x, wind_y, wind_z, ..]: [V; 6], [fx, fy, fz, flow]: [V; 4]) -> [V; 4] {
        let coefficient = self.coefficient(flow);
        [fx + coefficient * wind_x, fy + coefficient * wind_y, fz + coefficient * wind_z, V::zero()]
    }

    #[inline(always)]
    fn summand<V: SimdF64>(&self, [wind_x, wind_y, wind_z, u, v, w]: [V; 6], [.., flow]: [V; 4]) -> V {
        self.coefficient(flow) * (wind_x * u + wind_y * v + wind_z * w)
    }
}

/// Adds `factor` C p, with C the derivative of |S . V| V by V.
struct DampingKernel<'a> {
    drag: &'a AirDrag,
    factor: f64,
    tile: usize,
    rate: f64,
    carried: Option<Carried>,
    positions: Columns<'a>,
    velocities: Columns<'a>,
    p: Columns<'a>,
    out: ColumnsMut<'a>,
}

impl BatchKernel for DampingKernel<'_> {
    #[inline(always)]
    fn sweep_kind<V: SimdF64, const KIND: usize>(&mut self) -> V {
        let pass = self.drag.facets.elements.pass::<KIND>(self.tile, self.positions.rows());
        let positions = pass.reader(self.positions);
        let velocities = pass.reader(self.velocities);
        let vectors = pass.reader(self.p);
        let mut sums = pass.adder(&mut self.out);
        let presence = self.drag.facets.presence.of(&pass);
        for batch in 0..pass.len() {
            let (r, v) = (positions.read::<V>(batch), velocities.read::<V>(batch));
            let p = vectors.read::<V>(batch);
            let normal = normal(&r);
            let factor = V::all(self.factor * self.drag.factor) * V::load(&presence[batch]);
            let mut products = [[V::zero(); 3]; 3];
            for k in 0..3 {
                let [wind_x, wind_y] = about_axis([r[k][0], r[k][1]], [v[k][0], v[k][1]], V::all(self.rate));
                let wind = match &self.carried {
                    Some(carried) => carried.wind(r[k], v[k]),
                    None => [wind_x, wind_y, v[k][2]],
                };
                let (flow, change) = (dot(normal, wind), dot(normal, p[k]));
                let along = scale(change.copysign(flow * change), wind);
                products[k] = scale(factor, sum(scale(flow.abs(), p[k]), along));
            }
            sums.add(batch, products);
        }
        V::zero()
    }
}

impl NodalLaw for AirDrag {
    fn prepare(&mut self, tile: usize, at: Instant<'_>) {
        let rate = self.rate(at.frame);
        let new = self.facets.elements.new_rows(tile);
        let carried = self.carried(at.frame);
        let (wind_x, wind_y) = self.wind.split_at_mut(self.flows.len());
        let ([x, y, z], [u, v, w]) = (rows(at.positions, new.clone()), rows(at.velocities, new.clone()));
        let results = [&mut wind_x[new.clone()], &mut wind_y[new.clone()]];
        if let Some(carried) = &carried {
            self.along.resize(self.flows.len(), 0.0);
            let [wind_x, wind_y] = results;
            each(self.instructions, carried, [x, y, z, u, v, w], [wind_x, wind_y, &mut self.along[new]]);
        } else {
            each(self.instructions, &AboutAxis { rate }, [x, y, u, v], results);
        }
        let (positions, wind) = (Columns::of(at.positions), Columns::in_slice(&self.wind));
        let of_nodes = columns(at.velocities)[2];
        let along = Columns::in_slice(if carried.is_some() { &self.along } else { of_nodes });
        let flows = ColumnsMut::single(&mut self.flows);
        self.instructions.run_batches(FlowKernel { facets: &self.facets, tile, flows, positions, wind, along });
    }

    fn add_to_rows(&mut self, range: Range<usize>, at: Instant<'_>, [fx, fy, fz]: [&mut [f64]; 3]) -> f64 {
        let (wind_x, wind_y) = self.wind.split_at(self.flows.len());
        let ([x, y, z], [u, v, w]) = (rows(at.positions, range.clone()), rows(at.velocities, range.clone()));
        let is_carried = self.carried(at.frame).is_some();
        let wind_z = if is_carried { &self.along[range.clone()] } else { w };
        let [wind_x, wind_y] = [&wind_x[range.clone()], &wind_y[range.clone()]];
        let (places, wind, flows) = ([x, y, z], [wind_x, wind_y, wind_z], &self.flows[range.clone()]);
        let total = Total { factor: self.factor, places, wind, flows, instructions: self.instructions };
        self.outside = Load::default();
        if is_carried {
            self.outside.force = Vector3::from_fn(|axis, _| total.force(axis));
            (self.outside.torque.x, self.outside.torque.y) = (total.torque(0), total.torque(1));
        }
        if self.air == AirMotion::Still && !matches!(at.frame, Frame { rate: 0.0, hub: None, .. }) {
            self.outside.torque.z = total.torque(2);
        }
        let read = [wind_x, wind_y, wind_z, u, v, w];
        each(self.instructions, &DragKernel { factor: self.factor }, read, [fx, fy, fz, &mut self.flows[range]])
    }
}

impl Law for AirDrag {
    fn properties(&self) -> Properties {
        // Air at rest does positive work on nodes that turn against the frame.
        let work_class = match self.air {
            AirMotion::Still => WorkClass::External,
            AirMotion::Turning => WorkClass::Dissipative,
        };
        Properties { name: "air_drag", work_class, depends_on_velocity: true, is_internal: false }
    }

    fn kernels(&self) -> Kernels {
        Kernels::default()
    }

    fn reach(&self, tile: usize) -> usize {
        self.facets.elements.reach(tile)
    }

    fn nodal(&mut self) -> Option<&mut dyn NodalLaw> {
        Some(self)
    }

    fn outside_load(&self) -> Option<Load> {
        (self.air == AirMotion::Still).then_some(self.outside)
    }

    fn linearisation(&self) -> Option<&dyn Linearisation> {
        Some(self)
    }

    fn inspection(&self) -> Option<&dyn Inspection> {
        Some(self)
    }

    fn remedy(&self) -> &'static str {
        "use a smaller dt or a lower pressure"
    }
}

impl Linearisation for AirDrag {
    fn add_damping_product(&self, factor: f64, at: Instant<'_>, p: &NodeVectors, out: &mut NodeVectors) {
        let [positions, velocities, p] = [at.positions, at.velocities, p].map(Columns::of);
        let rate = self.rate(at.frame);
        for tile in tiles(p.rows()) {
            let out = ColumnsMut::of(out);
            self.instructions.run_batches(DampingKernel {
                drag: self,
                factor,
                tile,
                rate,
                carried: self.carried(at.frame),
                positions,
                velocities,
                p,
                out,
            });
        }
    }

    fn visit_couplings(&self, visit: &mut dyn FnMut(&[u32])) {
        self.facets.elements.each().for_each(|(.., nodes)| visit(&nodes));
    }

    fn add_jacobian(&self, at: Instant<'_>, jacobian: &mut dyn JacobianBlocks) {
        self.jacobian(at, jacobian);
    }
}

impl Inspection for AirDrag {
    fn lanes(&self) -> [usize; 2] {
        self.facets.elements.lanes()
    }

    fn contiguous_share(&self) -> Option<f64> {
        Some(self.facets.elements.contiguous_share())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arrays::state::rows_mut;
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
        let mut drag = AirDrag::new(parameters, &assembly).unwrap();
        let (x, v) = (
            assembly.numbering.internal_vectors(&assembly.model.positions),
            assembly.numbering.internal_vectors(&assembly.model.velocities),
        );
        let at = Instant { time: 0.0, frame: Frame::default(), positions: &x, velocities: &v };
        let mut forces = NodeVectors::zeros(3);
        drag.prepare(0, at);
        let power = drag.add_to_rows(0..3, at, rows_mut(&mut forces, 0..3));
        let expected = -0.5 * 5.35e-5 * 4.0 * 0.5;
        assert!((forces.column(2).sum() / expected - 1.0).abs() < 1e-3);
        assert!((power - 2.0 * forces.column(2).sum()).abs() < 1e-18);
    }
}
