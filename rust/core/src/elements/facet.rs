//! Facets: triangles as oriented surfaces, for loads and drag, in batches of eight.

use crate::assembly::Assembly;
use crate::layout::{Coded, ElementSet};
use crate::simd::lanes::{F64x8, SimdF64, Vec3, cross, sub};

/// All triangles of a mesh, each with its nodes in cyclic order from the lowest: the first node is arbitrary.
pub(crate) struct FacetSet {
    pub(crate) elements: ElementSet<3>,
    /// 1 for a facet, 0 in padding lanes.
    pub(crate) presence: Coded<F64x8>,
}

impl FacetSet {
    pub(crate) fn new(assembly: &Assembly) -> Self {
        let triangles = assembly.mesh.triangles.iter();
        let oriented: Vec<[u32; 3]> =
            triangles.map(|&nodes| from_lowest(assembly.numbering.to_internal(nodes)).0).collect();
        let elements = ElementSet::new(&oriented, assembly.masses.len());
        Self { presence: Coded::new(elements.pack(0.0, |_| 1.0)), elements }
    }
}

/// Three nodes in cyclic order from the lowest, and the number of places by which they were rotated.
pub(crate) fn from_lowest(mut nodes: [u32; 3]) -> ([u32; 3], usize) {
    let places = (0..3).min_by_key(|&k| nodes[k]).unwrap_or(0);
    nodes.rotate_left(places);
    (nodes, places)
}

/// Twice the vector area of facets with these corners \[m2\].
#[inline(always)]
pub(crate) fn normal<V: SimdF64>(corners: &[Vec3<V>; 3]) -> Vec3<V> {
    cross(sub(corners[1], corners[0]), sub(corners[2], corners[0]))
}
