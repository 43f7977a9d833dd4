//! The edges across which the film may bend.

use crate::assembly::Assembly;
use crate::elements::hinge::Facets;
use crate::elements::hinge_set::HingeSize;
use crate::model::mesh::Hinge;
use crate::simd::lanes::{F64x8, SimdF64};

/// An edge between two triangles.
#[derive(Debug, Clone, Copy)]
pub(super) struct InnerEdge {
    pub(super) hinge: Hinge,
    /// In the reference.
    pub(super) size: HingeSize,
    /// Whether facet C, facet D bends here: none along a crease or an edge that is folded at the start, and none whose
    /// nodes are all held, which is rigid.
    pub(super) bends: [bool; 2],
}

/// All edges between two triangles; those with a larger fold angle \[rad\] at the start are folded.
pub(super) fn inner_edges(assembly: &Assembly, fold_limit: f64) -> Vec<InnerEdge> {
    let mut is_crease = vec![false; assembly.mesh.edges.len()];
    assembly.hinges.iter().for_each(|crease| is_crease[crease.edge as usize] = true);
    let is_held = |node: u32| assembly.inverse_masses[assembly.numbering.to_internal([node])[0] as usize] == 0.0;
    let hinges = assembly.mesh.inner_hinges().into_iter();
    let edge = |hinge: Hinge| {
        let [a, b, c, d] = hinge.nodes;
        let is_fold =
            is_crease[hinge.edge as usize] || fold_angle(&hinge, &assembly.model.positions).abs() > fold_limit;
        let bends = [c, d].map(|apex| !is_fold && ![a, b, apex].into_iter().all(is_held));
        InnerEdge { hinge, size: HingeSize::of(&hinge, &assembly.mesh.reference), bends }
    };
    hinges.map(edge).collect()
}

/// The fold angle at these positions \[rad\].
fn fold_angle(hinge: &Hinge, positions: &[[f64; 3]]) -> f64 {
    let corners = hinge.nodes.map(|node| positions[node as usize].map(F64x8::all));
    Facets::new(corners).fold_angle().0[0]
}
