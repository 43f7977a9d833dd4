//! Bridges: stiff links of zero length that hold two nodes of neighbouring petals together.
//!
//!     U = k/2 |x_j - x_i|^2   [J],      F_i = k (x_j - x_i)   [N]
//!
//! Linear, and without the direction vector, which a link of zero length lacks.

use super::{Inspection, Instant, Kernels, Law, Linearisation, Properties, WorkClass};
use crate::arrays::blocks::tiles;
use crate::arrays::columns::{Columns, ColumnsMut};
use crate::arrays::jacobian::{Block, JacobianBlocks, of_link};
use crate::arrays::state::NodeVectors;
use crate::assembly::Assembly;
use crate::elements::link::Span;
use crate::layout::ElementSet;
use crate::simd::dispatch::{BatchKernel, InstructionSet};
use crate::simd::lanes::{F64x8, SimdF64, negate, scale};

/// The law: all links, of one stiffness, in batches of eight.
pub(super) struct Bridges {
    elements: ElementSet<2>,
    /// k [N/m].
    stiffness: Vec<F64x8>,
    instructions: InstructionSet,
}

impl Bridges {
    pub(super) fn new(assembly: &Assembly) -> Self {
        let pairs = assembly.numbering.pairs_to_internal(assembly.model.bridges.nodes.iter().copied());
        let elements = ElementSet::new(&pairs, assembly.masses.len());
        let stiffness = elements.pack(0.0, |_| assembly.model.bridges.stiffness);
        Self { elements, stiffness, instructions: assembly.instructions }
    }

    /// Adds sign k (x_j - x_i) for the links of a tile.
    fn add_forces(&self, tile: usize, positions: &NodeVectors, out: &mut NodeVectors, sign: f64) -> f64 {
        let (positions, out) = (Columns::of(positions), ColumnsMut::of(out));
        self.instructions.run_batches(LinkKernel { bridges: self, tile, positions, out, sign })
    }
}

/// Adds sign k (x_j - x_i) to the first end of each link, and its opposite to the second.
struct LinkKernel<'a> {
    bridges: &'a Bridges,
    tile: usize,
    positions: Columns<'a>,
    out: ColumnsMut<'a>,
    sign: f64,
}

impl BatchKernel for LinkKernel<'_> {
    #[inline(always)]
    fn sweep_kind<V: SimdF64, const KIND: usize>(&mut self) -> V {
        let pass = self.bridges.elements.pass::<KIND>(self.tile, self.positions.rows());
        let positions = pass.reader(self.positions);
        let mut sums = pass.adder(&mut self.out);
        let stiffness = pass.of(&self.bridges.stiffness);
        for batch in 0..pass.len() {
            let span = Span::between(positions.read::<V>(batch));
            let force = scale(V::all(self.sign) * V::load(&stiffness[batch]), span.d);
            sums.add(batch, [force, negate(force)]);
        }
        V::zero()
    }
}

impl Law for Bridges {
    fn properties(&self) -> Properties {
        Properties {
            name: "bridges",
            work_class: WorkClass::Conservative,
            depends_on_velocity: false,
            is_internal: true,
        }
    }

    fn kernels(&self) -> Kernels {
        Kernels::of_elements()
    }

    fn reach(&self, tile: usize) -> usize {
        self.elements.reach(tile)
    }

    fn add_to_tile(&mut self, tile: usize, at: Instant<'_>, forces: &mut NodeVectors) -> f64 {
        self.add_forces(tile, at.positions, forces, 1.0)
    }

    fn energy(&self, at: Instant<'_>) -> f64 {
        let x = Columns::of(at.positions);
        let energies = (0..self.elements.batch_count())
            .map(|batch| (self.stiffness[batch] * Span::between(self.elements.read_any(x, batch)).square()).sum());
        0.5 * energies.sum::<f64>()
    }

    fn linearisation(&self) -> Option<&dyn Linearisation> {
        Some(self)
    }

    fn inspection(&self) -> Option<&dyn Inspection> {
        Some(self)
    }

    fn remedy(&self) -> &'static str {
        "use a smaller dt or softer bridges"
    }
}

impl Linearisation for Bridges {
    fn add_stiffness_product(&self, _at: Instant<'_>, p: &NodeVectors, out: &mut NodeVectors) {
        for tile in tiles(p.nrows()) {
            self.add_forces(tile, p, out, -1.0);
        }
    }

    fn visit_couplings(&self, visit: &mut dyn FnMut(&[u32])) {
        self.elements.each().for_each(|(.., nodes)| visit(&nodes));
    }

    fn add_jacobian(&self, _at: Instant<'_>, jacobian: &mut dyn JacobianBlocks) {
        for (batch, lane, nodes) in self.elements.each() {
            let derivative = Block::identity() * self.stiffness[batch].0[lane];
            of_link(nodes, &derivative, |i, j, block| jacobian.by_position(i, j, block));
        }
    }
}

impl Inspection for Bridges {
    fn contiguous_share(&self) -> Option<f64> {
        Some(self.elements.contiguous_share())
    }
}
