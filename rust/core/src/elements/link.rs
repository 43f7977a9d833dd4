//! Links between two nodes: edges of the mesh and segments of tethers, in batches of eight.

use std::cell::OnceCell;
use std::sync::Arc;

use crate::arrays::columns::Columns;
use crate::assembly::Assembly;
use crate::layout::ElementSet;
use crate::model::rectangles::Rectangles;
use crate::simd::dispatch::InstructionSet;
use crate::simd::lanes::{F64x8, SimdF64, dot, sub};

/// The vectors along the links of a batch, from the first end to the second.
pub(crate) struct Span<V> {
    pub(crate) d: [V; 3],
}

impl<V: SimdF64> Span<V> {
    #[inline(always)]
    pub(crate) fn between([a, b]: [[V; 3]; 2]) -> Self {
        Self { d: sub(b, a) }
    }

    /// l^2.
    #[inline(always)]
    pub(crate) fn square(&self) -> V {
        dot(self.d, self.d)
    }

    /// l.
    #[inline(always)]
    pub(crate) fn length(&self) -> V {
        self.square().sqrt()
    }

    /// l times its rate, from the velocities of both ends.
    #[inline(always)]
    pub(crate) fn opening(&self, [u, v]: [[V; 3]; 2]) -> V {
        dot(self.d, sub(v, u))
    }
}

/// A set of links, and the instruction set of their kernels.
pub struct Links {
    /// The ends of each link, the lower number first: a link has no direction.
    pub elements: ElementSet<2>,
    pub(crate) instructions: InstructionSet,
}

impl Links {
    fn new(pairs: impl Iterator<Item = [u32; 2]>, assembly: &Assembly) -> Arc<Self> {
        let elements = ElementSet::new(&assembly.numbering.pairs_to_internal(pairs), assembly.masses.len());
        Arc::new(Self { elements, instructions: assembly.instructions })
    }

    /// The length of each link, batch by batch \[m\].
    pub(crate) fn lengths<'a>(&'a self, positions: Columns<'a>) -> impl Iterator<Item = F64x8> + 'a {
        (0..self.elements.batch_count())
            .map(move |batch| Span::between(self.elements.read_any(positions, batch)).length())
    }
}

/// The links of a scene in batches, common to all laws.
#[derive(Default)]
pub struct SpringNetworks {
    film: OnceCell<Arc<Links>>,
    rectangles: OnceCell<Arc<Links>>,
    cords: OnceCell<Arc<Links>>,
}

impl SpringNetworks {
    /// The edges of the mesh.
    pub(crate) fn film(&self, assembly: &Assembly) -> Arc<Links> {
        self.film.get_or_init(|| Links::new(assembly.mesh.edges.iter().copied(), assembly)).clone()
    }

    /// The sides and both diagonals of the rectangles of the mesh.
    pub(crate) fn rectangles(&self, rectangles: &Rectangles, assembly: &Assembly) -> Arc<Links> {
        self.rectangles.get_or_init(|| Links::new(rectangles.ends.iter().copied(), assembly)).clone()
    }

    /// The segments of the tethers.
    pub(crate) fn cords(&self, assembly: &Assembly) -> Arc<Links> {
        self.cords.get_or_init(|| Links::new(assembly.model.cords.iter().map(|cord| cord.nodes), assembly)).clone()
    }
}
