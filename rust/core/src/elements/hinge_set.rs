//! Hinges of a mesh in batches of eight, each with a stiffness, and their forces, energies and stiffnesses.

use crate::arrays::blocks::tiles;
use crate::arrays::columns::{Columns, ColumnsMut};
use crate::arrays::state::NodeVectors;
use crate::assembly::Assembly;
use crate::elements::hinge::{Facets, HingeForces};
use crate::layout::{CHUNK, Coded, ElementSet, Entry, merged};
use crate::model::mesh::{self, Hinge};
use crate::simd::dispatch::{BatchKernel, InstructionSet};
use crate::simd::lanes::{F64x8, LANES, SimdF64, dot, scale};

/// Hinges in batches. The nodes of an element are A, B, C, D, with the lower node of the edge as A: a hinge has no
/// direction.
pub(crate) struct HingeSet {
    pub(crate) elements: ElementSet<4>,
    pub(crate) parameters: Coded<HingeParameters>,
}

/// Parameters of a batch.
#[derive(Debug, Clone, Copy)]
pub(crate) struct HingeParameters {
    /// +1 valley, -1 mountain.
    pub(crate) sign: F64x8,
    /// (1 + c^2)^2 times the stiffness, with the constant factors of both weights \[N m/rad\].
    pub(crate) stiffness: F64x8,
    /// 4 (c A0)^2 of facet C and of facet D \[m4\].
    pub(crate) softening: [F64x8; 2],
}

impl Entry for HingeParameters {
    type Key = [[u64; LANES]; 4];

    fn key(&self) -> Self::Key {
        [self.sign, self.stiffness, self.softening[0], self.softening[1]].map(|values| values.key())
    }
}

impl HingeParameters {
    /// 4 (c A0)^2 of both facets \[m4\].
    #[inline(always)]
    pub(crate) fn softening<V: SimdF64>(&self) -> [V; 2] {
        [V::load(&self.softening[0]), V::load(&self.softening[1])]
    }
}

/// A hinge in the reference.
#[derive(Debug, Clone, Copy)]
pub(crate) struct HingeSize {
    /// |AB| \[m\].
    pub(crate) length: f64,
    /// The areas of facet C and of facet D \[m2\].
    pub(crate) areas: [f64; 2],
}

impl HingeSize {
    /// Of a hinge with nodes in external order.
    pub(crate) fn of(hinge: &Hinge, reference: &[[f64; 3]]) -> Self {
        let [a, b, c, d] = hinge.nodes.map(|node| reference[node as usize]);
        let e = mesh::sub(b, a);
        let areas = [c, d].map(|apex| {
            let normal = mesh::cross(e, mesh::sub(apex, a));
            0.5 * mesh::dot(normal, normal).sqrt()
        });
        Self { length: mesh::dot(e, e).sqrt(), areas }
    }
}

impl HingeSet {
    /// Hinges with the collapse c of the weights; `sign` and `stiffness` \[N m/rad\] by the row of a hinge.
    pub(crate) fn new(
        assembly: &Assembly,
        hinges: &[Hinge],
        collapse: f64,
        sign: impl Fn(usize) -> f64,
        stiffness: impl Fn(usize, HingeSize) -> f64,
    ) -> Self {
        let sizes: Vec<HingeSize> = hinges.iter().map(|hinge| HingeSize::of(hinge, &assembly.mesh.reference)).collect();
        let oriented = |hinge: &Hinge| {
            let [a, b, c, d] = assembly.numbering.to_internal(hinge.nodes);
            if a < b { ([a, b, c, d], false) } else { ([b, a, d, c], true) }
        };
        let (nodes, is_exchanged): (Vec<[u32; 4]>, Vec<bool>) = hinges.iter().map(oriented).unzip();
        let elements = ElementSet::new(&nodes, assembly.masses.len());
        let packed = |padding: f64, value: &dyn Fn(usize) -> f64| {
            let values = merged((0..sizes.len()).map(value).collect());
            elements.pack(padding, |row| values[row])
        };
        let softening = |facet: usize| {
            packed(1.0, &|row| 4.0 * (collapse * sizes[row].areas[facet ^ usize::from(is_exchanged[row])]).powi(2))
        };
        let sign = elements.pack(1.0, sign);
        let at_reference = 1.0 + collapse * collapse;
        let stiffness = packed(0.0, &|row| stiffness(row, sizes[row]) * (at_reference * at_reference));
        let softening = [softening(0), softening(1)];
        let of_batch = |batch: usize| HingeParameters {
            sign: sign[batch],
            stiffness: stiffness[batch],
            softening: [softening[0][batch], softening[1][batch]],
        };
        Self { parameters: Coded::new((0..elements.batch_count()).map(of_batch)), elements }
    }

    /// Adds the forces of the hinges of one tile.
    pub(crate) fn add_to_tile(
        &self,
        potential: &impl HingePotential,
        instructions: InstructionSet,
        tile: usize,
        positions: &NodeVectors,
        forces: &mut NodeVectors,
    ) -> f64 {
        let (positions, forces) = (Columns::of(positions), ColumnsMut::of(forces));
        instructions.run_batches(MomentKernel { hinges: self, potential, tile, positions, forces })
    }

    /// The sum of U \[J\].
    pub(crate) fn energy(
        &self,
        potential: &impl HingePotential,
        instructions: InstructionSet,
        positions: &NodeVectors,
    ) -> f64 {
        let positions = Columns::of(positions);
        let of_tile = |tile| instructions.run_batches(EnergyKernel { hinges: self, potential, tile, positions });
        tiles(positions.rows()).map(of_tile).sum()
    }

    /// Adds k g g^T p, with k the stiffness times the largest factor of the potential, and g the gradient of the angle;
    /// the part of each facet has its weight.
    pub(crate) fn add_stiffness_product(
        &self,
        potential: &impl HingePotential,
        instructions: InstructionSet,
        positions: &NodeVectors,
        p: &NodeVectors,
        out: &mut NodeVectors,
    ) {
        let (positions, p, factor) = (Columns::of(positions), Columns::of(p), potential.largest_factor());
        for tile in tiles(p.rows()) {
            let out = ColumnsMut::of(out);
            instructions.run_batches(StiffnessKernel { hinges: self, factor, tile, positions, p, out });
        }
    }
}

/// A function u of the fold angle of each hinge.
pub(crate) trait HingePotential {
    /// u \[J\] and -du/dphi \[N m\] of the batch at this place among all batches, with the factor of its stiffness.
    fn of_batch<V: SimdF64>(&self, place: usize, parameters: &HingeParameters, facets: &Facets<V>) -> (V, V);

    /// The largest second derivative of u over the stiffness.
    fn largest_factor(&self) -> f64 {
        1.0
    }
}

/// Adds -dU/dx of the hinges of one tile to the forces.
///
/// In chunks of batches: the path from the positions of a batch to its forces is a long chain of dependent operations,
/// and the instruction window of a processor holds little more than one batch. Two stages over a chunk, first angles,
/// roots and divisions, then vectors, have shorter chains that overlap.
struct MomentKernel<'a, P> {
    hinges: &'a HingeSet,
    potential: &'a P,
    tile: usize,
    positions: Columns<'a>,
    forces: ColumnsMut<'a>,
}

impl<P: HingePotential> BatchKernel for MomentKernel<'_, P> {
    #[inline(always)]
    fn sweep_kind<V: SimdF64, const KIND: usize>(&mut self) -> V {
        let pass = self.hinges.elements.pass::<KIND>(self.tile, self.positions.rows());
        let positions = pass.reader(self.positions);
        let mut sums = pass.adder(&mut self.forces);
        let parameters = self.hinges.parameters.of(&pass);
        let mut of_chunk = [HingeForces::zero(); CHUNK];
        for chunk in pass.chunks_of_batches() {
            for (batch, of_batch) in chunk.clone().zip(&mut of_chunk) {
                let parameters = &parameters[batch];
                let facets = Facets::new(positions.read::<V>(batch));
                let (energy, moment) = self.potential.of_batch(pass.place(batch), parameters, &facets);
                *of_batch = HingeForces::new(&facets, parameters.softening(), energy, moment);
            }
            for (batch, of_batch) in chunk.zip(&of_chunk) {
                sums.add(batch, of_batch.on_nodes(&Facets::new(positions.read::<V>(batch))));
            }
        }
        V::zero()
    }
}

/// The sum of U over the hinges of one tile.
struct EnergyKernel<'a, P> {
    hinges: &'a HingeSet,
    potential: &'a P,
    tile: usize,
    positions: Columns<'a>,
}

impl<P: HingePotential> BatchKernel for EnergyKernel<'_, P> {
    #[inline(always)]
    fn sweep_kind<V: SimdF64, const KIND: usize>(&mut self) -> V {
        let pass = self.hinges.elements.pass::<KIND>(self.tile, self.positions.rows());
        let positions = pass.reader(self.positions);
        let parameters = self.hinges.parameters.of(&pass);
        let mut energy = V::zero();
        for batch in 0..pass.len() {
            let parameters = &parameters[batch];
            let facets = Facets::new(positions.read::<V>(batch));
            let weight = facets.weight(parameters.softening());
            energy += weight * self.potential.of_batch(pass.place(batch), parameters, &facets).0;
        }
        energy
    }
}

/// Adds k g g^T p over the hinges of one tile, with k a factor times the stiffness.
struct StiffnessKernel<'a> {
    hinges: &'a HingeSet,
    factor: f64,
    tile: usize,
    positions: Columns<'a>,
    p: Columns<'a>,
    out: ColumnsMut<'a>,
}

impl BatchKernel for StiffnessKernel<'_> {
    #[inline(always)]
    fn sweep_kind<V: SimdF64, const KIND: usize>(&mut self) -> V {
        let pass = self.hinges.elements.pass::<KIND>(self.tile, self.positions.rows());
        let (positions, p) = (pass.reader(self.positions), pass.reader(self.p));
        let mut sums = pass.adder(&mut self.out);
        let parameters = self.hinges.parameters.of(&pass);
        let factor = V::all(self.factor);
        for batch in 0..pass.len() {
            let parameters = &parameters[batch];
            let facets = Facets::new(positions.read::<V>(batch));
            let [at_a, at_b, at_c, at_d] = facets.weighted_gradients(parameters.softening());
            let [a, b, c, d] = p.read::<V>(batch);
            let rotation = dot(at_a, a) + dot(at_b, b) + dot(at_c, c) + dot(at_d, d);
            let moment = V::load(&parameters.stiffness) * factor * rotation;
            sums.add(batch, [scale(moment, at_a), scale(moment, at_b), scale(moment, at_c), scale(moment, at_d)]);
        }
        V::zero()
    }
}
