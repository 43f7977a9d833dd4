//! The edges across which the film may bend, and their natural fold angles.
//!
//! A natural curvature K [1/m] is that of the surface z = x . K x / 2. On its nodes each facet has the slope of the
//! surface between them, so that an edge AB, with the foot of an apex C at A + t AB and its height h, is folded by
//!
//!     phi_0 = q_C + q_D,   q_C = (c . K c - t b . K b) / (2 h_C)   [rad],   c = C - A, b = B - A
//!
//! to first order in K; a facet of another region has its own K.

use std::f64::consts::FRAC_PI_2;

use crate::assembly::Assembly;
use crate::elements::hinge::Facets;
use crate::elements::hinge_set::HingeSize;
use crate::error::{Error, Result};
use crate::model::mesh::{Hinge, dot, sub};
use crate::model::regions::{FilmOfTriangles, RegionFilm};
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

/// The natural fold angle of a hinge between the film of one triangle on the side of C and that of another on D's.
///
/// # Errors
/// `CurvatureBeyondMesh` above 90 degrees.
pub(super) fn natural_fold(
    assembly: &Assembly,
    films: &FilmOfTriangles,
    edge: &InnerEdge,
    triangles: [u32; 2],
) -> Result<f64> {
    let [a, b, c, d] = edge.hinge.nodes.map(|node| assembly.mesh.reference[node as usize]);
    let along = sub(b, a);
    let mut fold = 0.0;
    let films_here = films_of(films, triangles);
    for ((apex, film), area) in [c, d].into_iter().zip(films_here).zip(edge.size.areas) {
        let (to_apex, height) = (sub(apex, a), 2.0 * area / edge.size.length);
        let foot = dot(to_apex, along) / dot(along, along);
        fold += (film.natural_rise(to_apex) - foot * film.natural_rise(along)) / (2.0 * height);
    }
    if fold.abs() > FRAC_PI_2 {
        let [a, b, ..] = edge.hinge.nodes.map(|node| node as usize);
        let triangle = triangles[usize::from(!films_here[0].is_curved())] as usize;
        let (region, degrees) = (films.name_of(triangle).to_owned(), fold.abs().to_degrees());
        return Err(Error::CurvatureBeyondMesh { region, edge: [a, b], degrees });
    }
    Ok(fold)
}

/// The films of two triangles.
pub(super) fn films_of(films: &FilmOfTriangles, triangles: [u32; 2]) -> [&RegionFilm; 2] {
    triangles.map(|triangle| films.of(triangle as usize))
}

/// The fold angle at these positions \[rad\].
fn fold_angle(hinge: &Hinge, positions: &[[f64; 3]]) -> f64 {
    let corners = hinge.nodes.map(|node| positions[node as usize].map(F64x8::all));
    Facets::new(corners).fold_angle().0[0]
}
