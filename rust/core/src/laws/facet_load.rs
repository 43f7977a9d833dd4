//! Loads on the facets of the film from outside: on each node of a triangle the same force, a function of its normal.

use super::{Inspection, Instant, Kernels, Law, Linearisation, Properties, WorkClass};
use crate::arrays::columns::{Columns, ColumnsMut};
use crate::arrays::jacobian::{Block, JacobianBlocks, at, cross_matrix};
use crate::arrays::state::NodeVectors;
use crate::assembly::Assembly;
use crate::elements::facet::{FacetSet, normal};
use crate::model::factor::Factor;
use crate::model::frame::Frame;
use crate::model::load::Load;
use crate::simd::dispatch::{BatchKernel, InstructionSet};
use crate::simd::lanes::{SimdF64, Vec3, cross, dot, sum};
use nalgebra::Vector3;

/// The force on a node of a facet as a function of the facet's normal.
pub(super) trait FacetLoad {
    /// The force \[N\] by twice the vector area \[m2\] of the batch at this place among all batches; `presence` is 1
    /// for a facet, 0 in padding lanes.
    fn on_node<V: SimdF64>(&self, place: usize, presence: V, normal: Vec3<V>) -> Vec3<V>;

    /// The change of the force by a change of twice the vector area, of the facet in a lane of a batch.
    fn change(&self, place: (usize, usize), normal: &Vector3<f64>, by: &Block) -> Block;
}

/// A load on facets as a function of time and of the frame.
pub(super) trait FacetLoadLaw: Send + Sync {
    /// The load at an instant.
    type Load<'a>: FacetLoad
    where
        Self: 'a;
    /// Name in scenes, errors and energies.
    const NAME: &'static str;
    /// The remedy for a fault by it.
    const REMEDY: &'static str;

    /// The load at an instant.
    fn at<'a>(&'a self, at: Instant<'_>) -> Self::Load<'a>;

    /// By which it is multiplied.
    fn factor(&self) -> &Factor;
}

/// The law of a load on all facets, in batches of eight.
pub(super) struct LoadedFacets<L> {
    load: L,
    facets: FacetSet,
    /// On the facets of the last tile, see `Law::outside_load`.
    outside: Load,
    instructions: InstructionSet,
}

/// Adds the load on the facets of one tile; the result is its power.
struct LoadKernel<'a, L> {
    facets: &'a FacetSet,
    load: &'a L,
    tile: usize,
    positions: Columns<'a>,
    velocities: Columns<'a>,
    forces: ColumnsMut<'a>,
}

impl<L: FacetLoad> BatchKernel for LoadKernel<'_, L> {
    #[inline(always)]
    fn sweep_kind<V: SimdF64, const KIND: usize>(&mut self) -> V {
        let pass = self.facets.elements.pass::<KIND>(self.tile, self.positions.rows());
        let positions = pass.reader(self.positions);
        let velocities = pass.reader(self.velocities);
        let mut sums = pass.adder(&mut self.forces);
        let presence = self.facets.presence.of(&pass);
        let mut power = V::zero();
        for batch in 0..pass.len() {
            let corners = positions.read::<V>(batch);
            let [u, v, w] = velocities.read::<V>(batch);
            let force = self.load.on_node(pass.place(batch), V::load(&presence[batch]), normal(&corners));
            power += dot(force, sum(u, sum(v, w)));
            sums.add(batch, [force; 3]);
        }
        power
    }
}

/// The torque of the load on the facets of one tile about the axis \[N m\].
struct TorqueKernel<'a, L> {
    facets: &'a FacetSet,
    load: &'a L,
    tile: usize,
    positions: Columns<'a>,
}

impl<L: FacetLoad> BatchKernel for TorqueKernel<'_, L> {
    #[inline(always)]
    fn sweep_kind<V: SimdF64, const KIND: usize>(&mut self) -> V {
        let pass = self.facets.elements.pass::<KIND>(self.tile, self.positions.rows());
        let positions = pass.reader(self.positions);
        let presence = self.facets.presence.of(&pass);
        let mut torque = V::zero();
        for batch in 0..pass.len() {
            let corners = positions.read::<V>(batch);
            let [x, y, _] = sum(corners[0], sum(corners[1], corners[2]));
            let [fx, fy, _] = self.load.on_node(pass.place(batch), V::load(&presence[batch]), normal(&corners));
            torque += x * fy - y * fx;
        }
        torque
    }
}

/// The sum of the load on the facets of one tile, about the origin.
struct SumKernel<'a, L> {
    facets: &'a FacetSet,
    load: &'a L,
    tile: usize,
    positions: Columns<'a>,
    sum: &'a mut Load,
}

impl<L: FacetLoad> BatchKernel for SumKernel<'_, L> {
    #[inline(always)]
    fn sweep_kind<V: SimdF64, const KIND: usize>(&mut self) -> V {
        let pass = self.facets.elements.pass::<KIND>(self.tile, self.positions.rows());
        let positions = pass.reader(self.positions);
        let presence = self.facets.presence.of(&pass);
        let mut sums = [[V::zero(); 3]; 2];
        for batch in 0..pass.len() {
            let corners = positions.read::<V>(batch);
            let force = self.load.on_node(pass.place(batch), V::load(&presence[batch]), normal(&corners));
            let torque = cross(sum(corners[0], sum(corners[1], corners[2])), force);
            sums = [sum(sums[0], sum(force, sum(force, force))), sum(sums[1], torque)];
        }
        for k in 0..3 {
            self.sum.force[k] += sums[0][k].lanes().sum();
            self.sum.torque[k] += sums[1][k].lanes().sum();
        }
        V::zero()
    }
}

impl<L> LoadedFacets<L> {
    pub(super) fn new(load: L, facets: FacetSet, assembly: &Assembly) -> Self {
        Self { load, facets, outside: Load::default(), instructions: assembly.instructions }
    }
}

impl<L: FacetLoadLaw> Law for LoadedFacets<L> {
    fn properties(&self) -> Properties {
        let work_class = WorkClass::External;
        Properties { name: L::NAME, work_class, depends_on_velocity: false, is_internal: false }
    }

    fn kernels(&self) -> Kernels {
        Kernels::of_elements()
    }

    fn reach(&self, tile: usize) -> usize {
        self.facets.elements.reach(tile)
    }

    fn add_to_tile(&mut self, tile: usize, at: Instant<'_>, forces: &mut NodeVectors) -> f64 {
        let (positions, velocities) = (Columns::of(at.positions), Columns::of(at.velocities));
        let (load, facets, forces) = (&self.load.at(at), &self.facets, ColumnsMut::of(forces));
        self.outside = Load::default();
        if at.frame.body().is_some() {
            let sum = &mut self.outside;
            self.instructions.run_batches(SumKernel { facets, load, tile, positions, sum });
        } else if !matches!(at.frame, Frame { rate: 0.0, hub: None, .. }) {
            self.outside.torque.z = self.instructions.run_batches(TorqueKernel { facets, load, tile, positions });
        }
        self.instructions.run_batches(LoadKernel { facets, load, tile, positions, velocities, forces })
    }

    fn outside_load(&self) -> Option<Load> {
        Some(self.outside)
    }

    fn jumps(&self) -> Vec<f64> {
        self.load.factor().jumps()
    }

    fn linearisation(&self) -> Option<&dyn Linearisation> {
        Some(self)
    }

    fn inspection(&self) -> Option<&dyn Inspection> {
        Some(self)
    }

    fn remedy(&self) -> &'static str {
        L::REMEDY
    }
}

/// Without stiffness: the limit of the step is that of the other laws.
impl<L: FacetLoadLaw> Linearisation for LoadedFacets<L> {
    fn visit_couplings(&self, visit: &mut dyn FnMut(&[u32])) {
        self.facets.elements.each().for_each(|(.., nodes)| visit(&nodes));
    }

    /// With n = (b - a) x (c - a), dn/db = -[c - a]x and dn/dc = [b - a]x.
    fn add_jacobian(&self, instant: Instant<'_>, jacobian: &mut dyn JacobianBlocks) {
        let load = self.load.at(instant);
        for (batch, lane, nodes) in self.facets.elements.each() {
            let [a, b, c] = nodes.map(|node| at(instant.positions, node));
            let (to_b, to_c) = (b - a, c - a);
            let normal = to_b.cross(&to_c);
            let by_b = load.change((batch, lane), &normal, &-cross_matrix(&to_c));
            let by_c = load.change((batch, lane), &normal, &cross_matrix(&to_b));
            for node in nodes {
                jacobian.by_position(node, nodes[1], &by_b);
                jacobian.by_position(node, nodes[2], &by_c);
                jacobian.by_position(node, nodes[0], &-(by_b + by_c));
            }
        }
    }
}

impl<L: FacetLoadLaw> Inspection for LoadedFacets<L> {
    fn lanes(&self) -> [usize; 2] {
        self.facets.elements.lanes()
    }

    fn contiguous_share(&self) -> Option<f64> {
        Some(self.facets.elements.contiguous_share())
    }
}
