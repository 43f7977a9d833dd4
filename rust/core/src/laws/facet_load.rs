//! Loads on the facets of the film from outside: on each node of a triangle the same force, a function of its normal.

use super::Instant;
use crate::arrays::columns::{Columns, ColumnsMut};
use crate::arrays::jacobian::{Block, JacobianBlocks, at, cross_matrix};
use crate::arrays::state::NodeVectors;
use crate::assembly::Assembly;
use crate::elements::facet::{FacetSet, normal};
use crate::model::frame::Frame;
use crate::simd::dispatch::{BatchKernel, InstructionSet};
use crate::simd::lanes::{SimdF64, Vec3, dot, sum};
use nalgebra::Vector3;

/// The force on a node of a facet as a function of the facet's normal.
pub(super) trait FacetLoad {
    /// The force \[N\] by twice the vector area \[m2\]; `presence` is 1 for a facet, 0 in padding lanes.
    fn on_node<V: SimdF64>(&self, presence: V, normal: Vec3<V>) -> Vec3<V>;

    /// The change of the force by a change of twice the vector area.
    fn change(&self, normal: &Vector3<f64>, by: &Block) -> Block;
}

/// All facets, in batches of eight, and the torque of the load on those of the last tile.
pub(super) struct LoadedFacets {
    pub(super) facets: FacetSet,
    /// See `Law::outside_torque`.
    pub(super) torque: f64,
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
            let force = self.load.on_node(V::load(&presence[batch]), normal(&corners));
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
            let [fx, fy, _] = self.load.on_node(V::load(&presence[batch]), normal(&corners));
            torque += x * fy - y * fx;
        }
        torque
    }
}

impl LoadedFacets {
    pub(super) fn new(assembly: &Assembly) -> Self {
        Self { facets: FacetSet::new(assembly), torque: 0.0, instructions: assembly.instructions }
    }

    /// See `Law::add_to_tile`.
    pub(super) fn add_to_tile(
        &mut self,
        load: &impl FacetLoad,
        tile: usize,
        at: Instant<'_>,
        forces: &mut NodeVectors,
    ) -> f64 {
        let (positions, velocities) = (Columns::of(at.positions), Columns::of(at.velocities));
        let (facets, forces) = (&self.facets, ColumnsMut::of(forces));
        self.torque = match at.frame {
            Frame { rate: 0.0, hub: None, .. } => 0.0,
            _ => self.instructions.run_batches(TorqueKernel { facets, load, tile, positions }),
        };
        self.instructions.run_batches(LoadKernel { facets, load, tile, positions, velocities, forces })
    }

    /// See `Linearisation::visit_couplings`.
    pub(super) fn visit_couplings(&self, visit: &mut dyn FnMut(&[u32])) {
        self.facets.elements.each().for_each(|(.., nodes)| visit(&nodes));
    }

    /// See `Linearisation::add_jacobian`: with n = (b - a) x (c - a), dn/db = -[c - a]x and dn/dc = [b - a]x.
    pub(super) fn add_jacobian(&self, load: &impl FacetLoad, instant: Instant<'_>, jacobian: &mut dyn JacobianBlocks) {
        for (_, _, nodes) in self.facets.elements.each() {
            let [a, b, c] = nodes.map(|node| at(instant.positions, node));
            let (to_b, to_c) = (b - a, c - a);
            let normal = to_b.cross(&to_c);
            let by_b = load.change(&normal, &-cross_matrix(&to_c));
            let by_c = load.change(&normal, &cross_matrix(&to_b));
            for node in nodes {
                jacobian.by_position(node, nodes[1], &by_b);
                jacobian.by_position(node, nodes[2], &by_c);
                jacobian.by_position(node, nodes[0], &-(by_b + by_c));
            }
        }
    }
}
