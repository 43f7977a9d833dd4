//! What the laws of a body share: its shape and motion, and the elements that may touch it.

use super::parameters::{BodyParameters, FeltBy};
use crate::arrays::blocks::tiles;
use crate::arrays::state::{NodeVectors, columns};
use crate::assembly::Assembly;
use crate::bodies::near::{Candidates, Elements, Near};
use crate::bodies::rigid_body::{Pose, RigidBody};
use crate::bodies::shape::Shape;
use crate::laws::Instant;
use crate::simd::dispatch::InstructionSet;

/// Distance from the surface up to which an element is near, as a share of the size of the body, and for a half-space,
/// which has none \[m\].
const SKIN: f64 = 0.05;
const SKIN_OF_PLANE: f64 = 1e-3;

/// A body and the elements that may touch it.
pub(in crate::laws) struct Contacts {
    pub(in crate::laws) shape: Shape,
    pub(in crate::laws) body: RigidBody,
    near: Near,
    /// Of the present evaluation.
    pub(in crate::laws) poses: Vec<Pose>,
    instructions: InstructionSet,
}

/// What is done with an element, its nodes, and a copy of the body, by its number.
pub(in crate::laws) trait Visitor {
    fn visit<const K: usize>(&mut self, nodes: [u32; K], corners: &[[f64; 3]; K], copy: usize);
}

impl Contacts {
    /// The contacts of a body with these elements; those without a free node are left out.
    pub(in crate::laws) fn new(shape: Shape, body: RigidBody, candidates: Candidates, assembly: &Assembly) -> Self {
        let skin = shape.size().map_or(SKIN_OF_PLANE, |size| SKIN * size);
        let is_free = |nodes: &[u32]| nodes.iter().any(|&node| assembly.inverse_masses[node as usize] > 0.0);
        let Candidates { mut points, mut edges, mut triangles } = candidates;
        points.nodes.retain(|nodes| is_free(nodes));
        edges.nodes.retain(|nodes| is_free(nodes));
        triangles.nodes.retain(|nodes| is_free(nodes));
        let near = Near::new(Candidates { points, edges, triangles }, skin, assembly.masses.len());
        Self { shape, body, near, poses: Vec::new(), instructions: assembly.instructions }
    }

    /// All elements.
    pub(in crate::laws) fn candidates(&self) -> &Candidates {
        &self.near.candidates
    }

    /// The poses at an instant.
    pub(in crate::laws) fn poses_at(&self, at: Instant<'_>) -> Vec<Pose> {
        let mut poses = Vec::new();
        self.body.pose(at.time, at.frame.is_frozen, &mut poses);
        poses
    }

    /// Takes the poses of an instant and, where the last list is not valid any more, the elements near them.
    pub(in crate::laws) fn update(&mut self, at: Instant<'_>) {
        self.body.pose(at.time, at.frame.is_frozen, &mut self.poses);
        self.near.update(&self.shape, at.positions, &self.poses, self.instructions);
    }

    /// Visits the elements near the body with their lowest node in a tile, after `update`, in ascending order.
    #[inline(always)]
    pub(in crate::laws) fn visit_tile(&self, tile: usize, positions: &NodeVectors, visitor: &mut impl Visitor) {
        let Candidates { points, edges, triangles } = &self.near.candidates;
        visit(points, tile, positions, visitor);
        visit(edges, tile, positions, visitor);
        visit(triangles, tile, positions, visitor);
    }

    /// Visits every element that may touch the body at these positions and poses, in ascending order.
    pub(in crate::laws) fn visit_all(&self, positions: &NodeVectors, poses: &[Pose], visitor: &mut impl Visitor) {
        let copies = if self.is_listed(positions, poses) { None } else { Some(poses.len()) };
        self.visit_these(copies, positions, visitor);
    }

    /// Visits every element beside each of so many copies, in ascending order.
    pub(in crate::laws) fn visit_each(&self, positions: &NodeVectors, copies: usize, visitor: &mut impl Visitor) {
        self.visit_these(Some(copies), positions, visitor);
    }

    fn visit_these(&self, copies: Option<usize>, positions: &NodeVectors, visitor: &mut impl Visitor) {
        let Candidates { points, edges, triangles } = &self.near.candidates;
        visit_each(points, copies, positions, visitor);
        visit_each(edges, copies, positions, visitor);
        visit_each(triangles, copies, positions, visitor);
    }

    /// Whether the list of near elements holds at these positions and poses.
    pub(in crate::laws) fn is_listed(&self, positions: &NodeVectors, poses: &[Pose]) -> bool {
        self.near.is_valid(positions, poses, self.instructions)
    }

    /// Whether any node that matters has moved by more than a distance \[m\].
    pub(in crate::laws) fn has_moved(&self, from: &NodeVectors, to: &NodeVectors, by: f64) -> bool {
        self.near.has_moved(self.instructions, from, to, by)
    }
}

#[inline(always)]
fn visit<const K: usize>(elements: &Elements<K>, tile: usize, positions: &NodeVectors, visitor: &mut impl Visitor) {
    let x = columns(positions);
    for (nodes, copy) in elements.near(tile, positions.nrows()) {
        visitor.visit(nodes, &corners(x, nodes), copy);
    }
}

/// Visits the near elements, or all of them beside each of so many copies.
fn visit_each<const K: usize>(
    elements: &Elements<K>,
    copies: Option<usize>,
    positions: &NodeVectors,
    visitor: &mut impl Visitor,
) {
    let Some(copies) = copies else {
        return tiles(positions.nrows()).for_each(|tile| visit(elements, tile, positions, visitor));
    };
    let x = columns(positions);
    for &nodes in &elements.nodes {
        (0..copies).for_each(|copy| visitor.visit(nodes, &corners(x, nodes), copy));
    }
}

/// The positions of the nodes of an element.
#[inline(always)]
pub(in crate::laws) fn corners<const K: usize>(x: [&[f64]; 3], nodes: [u32; K]) -> [[f64; 3]; K] {
    nodes.map(|node| x.map(|column| column[node as usize]))
}

/// The elements by which a scene feels a body, internal numbers.
pub(super) fn candidates_of(parameters: &BodyParameters, assembly: &Assembly) -> Candidates {
    let (mesh, cords) = (&assembly.mesh, assembly.model.cord_nodes());
    let is_membrane = parameters.membrane;
    let cords = if parameters.cords { cords } else { Vec::new() };
    let numbering = &assembly.numbering;
    let pairs = |pairs: &[[u32; 2]]| numbering.pairs_to_internal(pairs.iter().copied());
    let mut found = Candidates::default();
    match parameters.elements() {
        FeltBy::Nodes => {
            let membrane = if is_membrane { 0..mesh.reference.len() as u32 } else { 0..0 };
            let nodes = membrane.chain(cords.as_flattened().iter().copied());
            found.points = Elements::new(nodes.map(|node| numbering.to_internal([node])));
        }
        felt_by => {
            let edges = if is_membrane { pairs(&mesh.edges) } else { Vec::new() };
            found.edges = Elements::new(edges.into_iter().chain(pairs(&cords)));
            if felt_by == FeltBy::Triangles && is_membrane {
                found.triangles = Elements::new(mesh.triangles.iter().map(|&nodes| numbering.to_internal(nodes)));
            }
        }
    }
    found
}
