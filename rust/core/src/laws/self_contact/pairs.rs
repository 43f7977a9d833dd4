//! Pairs in lists, and eight of them at a time.

use super::surface::{Pair, Surface};
use crate::arrays::state::{NodeVectors, columns};
use crate::simd::lanes::{F64x8, HALF, LANES, SimdF64, Vec3};

/// A pair, and the distance that it keeps; 0 where that is not known yet \[m\].
#[derive(Debug, Clone, Copy)]
pub(super) struct Listed {
    pub(super) pair: Pair,
    pub(super) kept: f64,
}

/// Pairs of nodes and triangles, and of edges.
#[derive(Default)]
pub(super) struct Pairs(pub(super) [Vec<Listed>; 2]);

impl Pairs {
    pub(super) fn clear(&mut self) {
        self.0.iter_mut().for_each(Vec::clear);
    }

    pub(super) fn push(&mut self, listed: Listed) {
        self.0[usize::from(listed.pair.has_edges())].push(listed);
    }

    /// How many there are.
    pub(super) fn len(&self) -> usize {
        self.0.iter().map(Vec::len).sum()
    }

    /// How many there are of the kind with more.
    pub(super) fn most(&self) -> usize {
        self.0[0].len().max(self.0[1].len())
    }
}

/// Nodes that move, from now to the end of a step.
#[derive(Clone, Copy)]
pub(super) struct Step<'a> {
    pub(super) time: f64,
    pub(super) dt: f64,
    pub(super) positions: &'a NodeVectors,
    pub(super) velocities: &'a NodeVectors,
}

/// Position and velocity of a node, three numbers each, in one line of the cache.
#[derive(Debug, Clone, Copy, Default)]
#[repr(C, align(64))]
pub(super) struct Moving([[f64; HALF]; 2]);

impl Moving {
    #[inline(always)]
    fn new([x, y, z]: [f64; 3], [u, v, w]: [f64; 3]) -> Self {
        Self([[x, y, z, u], [v, w, 0.0, 0.0]])
    }

    /// Sets its velocity.
    pub(super) fn set_velocity(&mut self, [u, v, w]: [f64; 3]) {
        let Self([first, second]) = self;
        first[3] = u;
        second[..2].copy_from_slice(&[v, w]);
    }
}

/// Motion in straight lines.
#[derive(Clone, Copy)]
pub(super) struct Lines<'a> {
    pub(super) nodes: &'a [Moving],
    /// How long \[s\].
    pub(super) duration: f64,
}

impl<'a> Lines<'a> {
    /// Those of some nodes, or of all.
    pub(super) fn of(some: Option<&[u32]>, of: Step<'_>, duration: f64, nodes: &'a mut Vec<Moving>) -> Self {
        let ([x, y, z], [u, v, w]) = (columns(of.positions), columns(of.velocities));
        nodes.resize(x.len(), Moving::default());
        match some {
            Some(some) => {
                for k in some.iter().map(|&node| node as usize) {
                    nodes[k] = Moving::new([x[k], y[k], z[k]], [u[k], v[k], w[k]]);
                }
            }
            None => {
                let all = x.iter().zip(y).zip(z).zip(u).zip(v).zip(w);
                for (node, (((((x, y), z), u), v), w)) in nodes.iter_mut().zip(all) {
                    *node = Moving::new([*x, *y, *z], [*u, *v, *w]);
                }
            }
        }
        Self { nodes, duration }
    }
}

/// Eight pairs of one kind, the last one repeated where there are fewer.
pub(super) struct Eight {
    pub(super) nodes: [[u32; LANES]; 4],
    pub(super) count: usize,
    /// What each keeps \[m\].
    pub(super) kept: F64x8,
}

impl Eight {
    #[inline(always)]
    pub(super) fn of<const EDGES: bool>(surface: &Surface, pairs: &[Listed]) -> Self {
        let (mut nodes, mut kept) = ([[0; LANES]; 4], F64x8::ZERO);
        for lane in 0..LANES {
            let listed = pairs[lane.min(pairs.len() - 1)];
            let own = surface.nodes_of::<EDGES>(listed.pair);
            for corner in 0..4 {
                nodes[corner][lane] = own[corner];
            }
            kept.0[lane] = listed.kept;
        }
        Self { nodes, count: pairs.len().min(LANES), kept }
    }

    /// Positions, and velocities.
    #[inline(always)]
    pub(super) fn gather<V: SimdF64>(&self, moving: &[Moving]) -> [[Vec3<V>; 4]; 2] {
        let mut out = [[[V::zero(); 3]; 4]; 2];
        for corner in 0..4 {
            let (mut first, mut second) = ([&[0.0; HALF]; LANES], [&[0.0; HALF]; LANES]);
            for lane in 0..LANES {
                let Moving([one, other]) = &moving[self.nodes[corner][lane] as usize];
                (first[lane], second[lane]) = (one, other);
            }
            let ([x, y, z, u], [v, w, ..]) = (V::of_rows(first), V::of_rows(second));
            (out[0][corner], out[1][corner]) = ([x, y, z], [u, v, w]);
        }
        out
    }
}
