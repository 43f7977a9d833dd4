//! Uniform pressure on the film, in the direction of the normal of each triangle: a follower load.
//!
//!     F = (p/6) (x1 - x0) x (x2 - x0)   [N]   on each node of a triangle
//!
//! that is a third of p times the present vector area of the triangle. The normal points to the side from which the
//! nodes appear counterclockwise. On a closed surface the sum of the forces and their total torque vanish, as integrals
//! of p n over a surface without boundary. On a surface with an edge the load has no potential; its work is external.
//!
//! The load is lumped in thirds, as the masses are. Its derivatives are exact:
//!
//!     dF/dx1 = -(p/6) [x2 - x0]x,      dF/dx2 = (p/6) [x1 - x0]x,      dF/dx0 = -(dF/dx1 + dF/dx2)

use serde::Deserialize;

use super::{
    Context, Inspection, Instant, Kernels, Law, LawParameters, Linearisation, OF_AXIS_ALONE, Properties, WorkClass,
};
use crate::arrays::columns::{Columns, ColumnsMut};
use crate::arrays::jacobian::{JacobianBlocks, at, cross_matrix};
use crate::arrays::state::NodeVectors;
use crate::elements::facet::{FacetSet, normal};
use crate::error::Result;
use crate::model::checks::finite;
use crate::model::frame::Frame;
use crate::simd::dispatch::{BatchKernel, InstructionSet};
use crate::simd::lanes::{SimdF64, dot, scale, sum};

/// Parameters of the load.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PressureParameters {
    /// p, the difference of the pressures on both sides; a negative one acts against the normal \[Pa\].
    pub pressure: f64,
}

impl LawParameters for PressureParameters {
    fn build(&self, context: &Context<'_>) -> Result<Box<dyn Law>> {
        finite("pressure on the film [Pa]", self.pressure)?;
        let (facets, instructions) = (FacetSet::new(context.assembly), context.assembly.instructions);
        Ok(Box::new(Pressure { facets, sixth: self.pressure / 6.0, torque: 0.0, instructions }))
    }

    fn example() -> Self {
        Self { pressure: 2.0 }
    }
}

/// The law: all facets, in batches of eight.
struct Pressure {
    facets: FacetSet,
    /// p/6 [Pa].
    sixth: f64,
    /// See `Law::outside_torque`.
    torque: f64,
    instructions: InstructionSet,
}

/// Adds the load on the facets of one tile; the result is its power.
struct LoadKernel<'a> {
    load: &'a Pressure,
    tile: usize,
    positions: Columns<'a>,
    velocities: Columns<'a>,
    forces: ColumnsMut<'a>,
}

impl BatchKernel for LoadKernel<'_> {
    #[inline(always)]
    fn sweep_kind<V: SimdF64, const KIND: usize>(&mut self) -> V {
        let Pressure { facets, sixth, .. } = self.load;
        let pass = facets.elements.pass::<KIND>(self.tile, self.positions.rows());
        let positions = pass.reader(self.positions);
        let velocities = pass.reader(self.velocities);
        let mut sums = pass.adder(&mut self.forces);
        let presence = facets.presence.of(&pass);
        let mut power = V::zero();
        for batch in 0..pass.len() {
            let corners = positions.read::<V>(batch);
            let [u, v, w] = velocities.read::<V>(batch);
            let force = scale(V::all(*sixth) * V::load(&presence[batch]), normal(&corners));
            power += dot(force, sum(u, sum(v, w)));
            sums.add(batch, [force; 3]);
        }
        power
    }
}

/// The torque of the load on the facets of one tile about the axis \[N m\].
struct TorqueKernel<'a> {
    load: &'a Pressure,
    tile: usize,
    positions: Columns<'a>,
}

impl BatchKernel for TorqueKernel<'_> {
    #[inline(always)]
    fn sweep_kind<V: SimdF64, const KIND: usize>(&mut self) -> V {
        let Pressure { facets, sixth, .. } = self.load;
        let pass = facets.elements.pass::<KIND>(self.tile, self.positions.rows());
        let positions = pass.reader(self.positions);
        let presence = facets.presence.of(&pass);
        let mut torque = V::zero();
        for batch in 0..pass.len() {
            let corners = positions.read::<V>(batch);
            let [x, y, _] = sum(corners[0], sum(corners[1], corners[2]));
            let [fx, fy, _] = scale(V::all(*sixth) * V::load(&presence[batch]), normal(&corners));
            torque += x * fy - y * fx;
        }
        torque
    }
}

impl Law for Pressure {
    fn properties(&self) -> Properties {
        let work_class = WorkClass::External;
        Properties { name: "pressure", work_class, depends_on_velocity: false, is_internal: false }
    }

    fn kernels(&self) -> Kernels {
        Kernels::of_elements()
    }

    fn reach(&self, tile: usize) -> usize {
        self.facets.elements.reach(tile)
    }

    fn add_to_tile(&mut self, tile: usize, at: Instant<'_>, forces: &mut NodeVectors) -> f64 {
        let (positions, velocities) = (Columns::of(at.positions), Columns::of(at.velocities));
        let forces = ColumnsMut::of(forces);
        self.torque = match at.frame {
            Frame { rate: 0.0, hub: None, .. } => 0.0,
            _ => self.instructions.run_batches(TorqueKernel { load: self, tile, positions }),
        };
        self.instructions.run_batches(LoadKernel { load: self, tile, positions, velocities, forces })
    }

    fn outside_torque(&self) -> Option<f64> {
        Some(self.torque)
    }

    fn remedy_on_free_hub(&self, is_body: bool) -> Option<&'static str> {
        is_body.then_some(OF_AXIS_ALONE)
    }

    fn linearisation(&self) -> Option<&dyn Linearisation> {
        Some(self)
    }

    fn inspection(&self) -> Option<&dyn Inspection> {
        Some(self)
    }

    fn remedy(&self) -> &'static str {
        "use a smaller dt or a smaller pressure"
    }
}

/// Without stiffness: the limit of the step is that of the other laws.
impl Linearisation for Pressure {
    fn visit_couplings(&self, visit: &mut dyn FnMut(&[u32])) {
        self.facets.elements.each().for_each(|(.., nodes)| visit(&nodes));
    }

    fn add_jacobian(&self, instant: Instant<'_>, jacobian: &mut dyn JacobianBlocks) {
        for (_, _, nodes) in self.facets.elements.each() {
            let [a, b, c] = nodes.map(|node| at(instant.positions, node));
            let (by_b, by_c) = (cross_matrix(&(c - a)) * -self.sixth, cross_matrix(&(b - a)) * self.sixth);
            for node in nodes {
                jacobian.by_position(node, nodes[1], &by_b);
                jacobian.by_position(node, nodes[2], &by_c);
                jacobian.by_position(node, nodes[0], &-(by_b + by_c));
            }
        }
    }
}

impl Inspection for Pressure {
    fn lanes(&self) -> [usize; 2] {
        self.facets.elements.lanes()
    }

    fn contiguous_share(&self) -> Option<f64> {
        Some(self.facets.elements.contiguous_share())
    }
}
