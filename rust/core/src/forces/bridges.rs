//! Bridges: stiff links of zero length that hold two nodes of neighbouring petals together.
//!
//!     U = k/2 |x_j - x_i|^2   [J],      F_i = k (x_j - x_i)   [N]
//!
//! Linear, and without the direction that a spring of no length would lack.

use super::Law;
use crate::columns::{Columns, ColumnsMut};
use crate::lanes::{Lanes, Vector, dot, negate, scale, sub};
use crate::layout::Elements;
use crate::model::Assembly;
use crate::slopes::{Block, Slopes, of_link};
use crate::state::{Instant, Vectors, tiles};
use crate::width::{GroupKernel, Width};

/// The law: all links, of one stiffness, eight to a group.
pub(super) struct Bridges {
    elements: Elements<2>,
    /// k [N/m].
    stiffness: Vec<Lanes>,
    width: Width,
}

impl Bridges {
    pub(super) fn new(assembly: &Assembly) -> Self {
        let pairs = assembly.layout.inward_pairs(assembly.model.bridges.iter().copied());
        let elements = Elements::new(&pairs, assembly.masses.len());
        let stiffness = elements.pack(0.0, |_| assembly.model.bridge_stiffness);
        Self { elements, stiffness, width: assembly.width }
    }

    fn pull(&self, tile: usize, positions: &Vectors, out: &mut Vectors, sign: f64) -> f64 {
        let (positions, out) = (Columns::of(positions), ColumnsMut::of(out));
        self.width.run_groups(Pull { bridges: self, tile, positions, out, sign })
    }
}

/// Adds sign k (x_j - x_i) to the first end of each link, and its opposite to the second.
struct Pull<'a> {
    bridges: &'a Bridges,
    tile: usize,
    positions: Columns<'a>,
    out: ColumnsMut<'a>,
    sign: f64,
}

impl GroupKernel for Pull<'_> {
    #[inline(always)]
    fn part<V: Vector, const KIND: usize>(&mut self) -> V {
        let pass = self.bridges.elements.pass::<KIND>(self.tile, self.positions.rows());
        let stiffness = pass.of(&self.bridges.stiffness);
        for group in 0..pass.len() {
            let [a, b] = pass.read::<V, 3>(self.positions, group);
            let pull = scale(V::all(self.sign) * V::load(&stiffness[group]), sub(b, a));
            pass.add(&mut self.out, group, [pull, negate(pull)]);
        }
        V::zero()
    }
}

impl Law for Bridges {
    fn name(&self) -> &'static str {
        "bridges"
    }

    fn is_conservative(&self) -> bool {
        true
    }

    fn add_to_tile(&self, tile: usize, at: Instant<'_>, forces: &mut Vectors) -> f64 {
        self.pull(tile, at.positions, forces, 1.0)
    }

    fn energy(&self, at: Instant<'_>) -> f64 {
        let x = Columns::of(at.positions);
        let energies = (0..self.elements.group_count()).map(|group| {
            let [a, b] = self.elements.read_any(x, group);
            let d = sub(b, a);
            (self.stiffness[group] * dot(d, d)).sum()
        });
        0.5 * energies.sum::<f64>()
    }

    fn add_stiffness_product(&self, _at: Instant<'_>, p: &Vectors, out: &mut Vectors) {
        for tile in tiles(p.nrows()) {
            self.pull(tile, p, out, -1.0);
        }
    }

    fn visit_couplings(&self, visit: &mut dyn FnMut(&[u32])) {
        self.elements.each().for_each(|(.., nodes)| visit(&nodes));
    }

    fn add_slopes(&self, _at: Instant<'_>, slopes: &mut dyn Slopes) {
        for (group, lane, nodes) in self.elements.each() {
            let slope = Block::identity() * self.stiffness[group].0[lane];
            of_link(nodes, &slope, |i, j, block| slopes.by_position(i, j, block));
        }
    }

    fn share_in_runs(&self) -> Option<f64> {
        Some(self.elements.share_in_runs())
    }

    fn cure(&self) -> &'static str {
        "use a smaller dt or softer bridges"
    }
}
