//! Hinges of a mesh in batches of eight, each with a stiffness, and their forces, energies and stiffnesses.

use crate::arrays::columns::{Columns, ColumnsMut};
use crate::assembly::Assembly;
use crate::elements::hinge::{Facets, HingeForces};
use crate::layout::{CHUNK, Coded, ElementSet, Entry, Pass, merged};
use crate::model::mesh::{self, Hinge};
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

    /// Adds the forces of the hinges of one tile; `potential` gives u \[J\] and -du/dphi \[N m\] of a batch.
    ///
    /// In chunks of batches: the path from the positions of a batch to its forces is a long chain of dependent
    /// operations, and the instruction window of a processor holds little more than one batch. Two stages over a chunk,
    /// first angles, roots and divisions, then vectors, have shorter chains that overlap.
    #[inline(always)]
    pub(crate) fn add_forces<V: SimdF64, const KIND: usize>(
        &self,
        pass: Pass<'_, 4, KIND>,
        positions: Columns<'_>,
        forces: &mut ColumnsMut<'_>,
        potential: impl Fn(usize, &HingeParameters, &Facets<V>) -> (V, V),
    ) {
        let positions = pass.reader(positions);
        let mut sums = pass.adder(forces);
        let parameters = self.parameters.of(&pass);
        let mut of_chunk = [HingeForces::zero(); CHUNK];
        for chunk in pass.chunks_of_batches() {
            for (batch, of_batch) in chunk.clone().zip(&mut of_chunk) {
                let parameters = &parameters[batch];
                let facets = Facets::new(positions.read::<V>(batch));
                let (energy, moment) = potential(batch, parameters, &facets);
                *of_batch = HingeForces::new(&facets, parameters.softening(), energy, moment);
            }
            for (batch, of_batch) in chunk.zip(&of_chunk) {
                sums.add(batch, of_batch.on_nodes(&Facets::new(positions.read::<V>(batch))));
            }
        }
    }

    /// The sum of U over the hinges of one tile \[J\]; `potential` gives u of a batch of the pass.
    #[inline(always)]
    pub(crate) fn energy<V: SimdF64, const KIND: usize>(
        &self,
        pass: Pass<'_, 4, KIND>,
        positions: Columns<'_>,
        potential: impl Fn(usize, &HingeParameters, &Facets<V>) -> V,
    ) -> V {
        let positions = pass.reader(positions);
        let parameters = self.parameters.of(&pass);
        let mut energy = V::zero();
        for batch in 0..pass.len() {
            let parameters = &parameters[batch];
            let facets = Facets::new(positions.read::<V>(batch));
            let weight = facets.weight(parameters.softening());
            energy += weight * potential(batch, parameters, &facets);
        }
        energy
    }

    /// Adds k g g^T p over the hinges of one tile, with k a factor times the stiffness, and g the gradient of the
    /// angle; the part of each facet has its weight.
    #[inline(always)]
    pub(crate) fn add_stiffness<V: SimdF64, const KIND: usize>(
        &self,
        pass: Pass<'_, 4, KIND>,
        positions: Columns<'_>,
        p: Columns<'_>,
        out: &mut ColumnsMut<'_>,
        factor: f64,
    ) {
        let positions = pass.reader(positions);
        let p = pass.reader(p);
        let mut sums = pass.adder(out);
        let parameters = self.parameters.of(&pass);
        let factor = V::all(factor);
        for batch in 0..pass.len() {
            let parameters = &parameters[batch];
            let facets = Facets::new(positions.read::<V>(batch));
            let [at_a, at_b, at_c, at_d] = facets.weighted_gradients(parameters.softening());
            let [a, b, c, d] = p.read::<V>(batch);
            let rotation = dot(at_a, a) + dot(at_b, b) + dot(at_c, c) + dot(at_d, d);
            let moment = V::load(&parameters.stiffness) * factor * rotation;
            sums.add(batch, [scale(moment, at_a), scale(moment, at_b), scale(moment, at_c), scale(moment, at_d)]);
        }
    }
}
