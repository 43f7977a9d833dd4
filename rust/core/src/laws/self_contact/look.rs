//! Passes over pairs, eight at a time: which may come near, and how far apart they are.
//!
//! For any unit vector n, two convex bodies are no nearer than they are along n. With n along the gap g of a pair and
//! corners that move in straight lines, x_q + t w_q, the least distance from now to the time t is at least
//!
//!     min over both times of ( min of n . x_q of the first  -  max of n . x_q of the second )
//!
//! so that what is not below a bound stays apart by it, whatever happens between.

use super::surface::{Pair, Surface};
use crate::arrays::state::{NodeVectors, columns};
use crate::contact::closest::{Closest, edge_edge, node_triangle};
use crate::simd::dispatch::Kernel;
use crate::simd::lanes::{F64x8, LANES, SimdF64, Vec3, dot, sub};

/// v_r: the largest speed at which a pair that is too near is pushed apart \[m/s\].
const RECOVERY: f64 = 0.02;
/// Squared sine of the angle below which two edges count as parallel.
const PARALLEL: f64 = 1e-8;
/// Added to products of lengths, so that a gap of 0 is below every bound.
const TINY: f64 = 1e-300;

/// Pairs in their order, those of nodes and triangles before those of edges.
#[derive(Default)]
pub(super) struct Pairs {
    pub(super) pairs: Vec<Pair>,
    /// The distance that each keeps \[m\]; empty where it is not known yet.
    pub(super) kept: Vec<f64>,
}

impl Pairs {
    pub(super) fn clear(&mut self) {
        self.pairs.clear();
        self.kept.clear();
    }

    /// The place of the first pair of edges.
    fn split(&self) -> usize {
        self.pairs.partition_point(|pair| !pair.has_edges())
    }

    pub(super) fn push(&mut self, pair: Pair, kept: Option<f64>) {
        self.pairs.push(pair);
        self.kept.extend(kept);
    }
}

/// Position and velocity of a node, three numbers each, in one line of the cache.
#[derive(Debug, Clone, Copy, Default)]
#[repr(C, align(64))]
pub(super) struct Moving([f64; LANES]);

/// Motion in straight lines.
#[derive(Clone, Copy)]
pub(super) struct Lines<'a> {
    pub(super) nodes: &'a [Moving],
    /// How long \[s\].
    pub(super) duration: f64,
}

impl Moving {
    /// Sets its velocity.
    pub(super) fn set_velocity(&mut self, [u, v, w]: [f64; 3]) {
        self.0[3..6].copy_from_slice(&[u, v, w]);
    }
}

impl<'a> Lines<'a> {
    /// Those of nodes at some positions with some velocities.
    pub(super) fn of(
        positions: &NodeVectors,
        velocities: &NodeVectors,
        duration: f64,
        nodes: &'a mut Vec<Moving>,
    ) -> Self {
        let ([x, y, z], [u, v, w]) = (columns(positions), columns(velocities));
        nodes.resize(x.len(), Moving::default());
        let own = x.iter().zip(y).zip(z).zip(u).zip(v).zip(w);
        for (node, (((((x, y), z), u), v), w)) in nodes.iter_mut().zip(own) {
            node.0 = [*x, *y, *z, *u, *v, *w, 0.0, 0.0];
        }
        Self { nodes, duration }
    }
}

/// Keeps the pairs that may come nearer than a bound: a distance beside that which each keeps.
pub(super) struct Narrow<'a> {
    pub(super) surface: &'a Surface,
    pub(super) from: &'a Pairs,
    pub(super) lines: Lines<'a>,
    pub(super) bound: f64,
    pub(super) into: &'a mut Pairs,
}

/// Finds the distance of each pair, at most `most` of its own, and keeps the larger of this share and what it has.
pub(super) struct Raise<'a> {
    pub(super) surface: &'a Surface,
    pub(super) nodes: &'a [Moving],
    pub(super) pairs: &'a mut Pairs,
    pub(super) share: f64,
}

/// Pairs that may come near within a step, and by how much more their closest points are apart at its end than they
/// must be \[m\].
#[derive(Default)]
pub(super) struct Watched {
    pub(super) pairs: Pairs,
    pub(super) room: Vec<f64>,
}

impl Watched {
    pub(super) fn clear(&mut self) {
        self.pairs.clear();
        self.room.clear();
    }
}

/// A pair that would come nearer than it keeps within a step, if its closest points stayed the same.
#[derive(Debug, Clone, Copy)]
pub(super) struct Near {
    pub(super) pair: Pair,
    pub(super) nodes: [u32; 4],
    /// By which the gap is the sum of positions.
    pub(super) weights: [f64; 4],
    pub(super) gap: [f64; 3],
    /// The distance that it keeps \[m\].
    pub(super) kept: f64,
}

/// Finds these pairs, and those that may come nearer than a bound beside what they keep.
pub(super) struct Look<'a> {
    pub(super) surface: &'a Surface,
    pub(super) from: &'a Pairs,
    pub(super) lines: Lines<'a>,
    pub(super) bound: f64,
    /// beta.
    pub(super) share_of_depth: f64,
    pub(super) watched: &'a mut Watched,
    pub(super) near: &'a mut Vec<Near>,
}

/// Eight pairs, the last one repeated where there are fewer.
struct Eight {
    nodes: [[u32; LANES]; 4],
    count: usize,
}

impl Eight {
    #[inline(always)]
    fn of<const EDGES: bool>(surface: &Surface, pairs: &[Pair]) -> Self {
        let mut nodes = [[0; LANES]; 4];
        for lane in 0..LANES {
            let own = surface.nodes_of::<EDGES>(pairs[lane.min(pairs.len() - 1)]);
            for corner in 0..4 {
                nodes[corner][lane] = own[corner];
            }
        }
        Self { nodes, count: pairs.len().min(LANES) }
    }

    /// Positions, and velocities.
    #[inline(always)]
    fn gather<V: SimdF64>(&self, moving: &[Moving]) -> [[Vec3<V>; 4]; 2] {
        let mut out = [[[V::zero(); 3]; 4]; 2];
        for corner in 0..4 {
            let mut numbers = [[0.0; LANES]; 6];
            for lane in 0..LANES {
                let Moving(own) = &moving[self.nodes[corner][lane] as usize];
                for k in 0..6 {
                    numbers[k][lane] = own[k];
                }
            }
            for axis in 0..3 {
                out[0][corner][axis] = V::load_from(&numbers[axis]);
                out[1][corner][axis] = V::load_from(&numbers[3 + axis]);
            }
        }
        out
    }
}

/// The closest points, and the least distance along the gap until the end of straight lines, times its length.
#[inline(always)]
fn measure<V: SimdF64, const EDGES: bool>(x: [Vec3<V>; 4], v: [Vec3<V>; 4], duration: V) -> (Closest<V>, V) {
    let found = if EDGES { edge_edge(x) } else { node_triangle(x) };
    let (mut now, mut then) = ([V::zero(); 4], [V::zero(); 4]);
    for corner in 1..4 {
        now[corner] = dot(found.gap, sub(x[corner], x[0]));
        then[corner] = now[corner] + duration * dot(found.gap, sub(v[corner], v[0]));
    }
    let mut least = V::all(f64::INFINITY);
    for along in [now, then] {
        let front = if EDGES { along[0].min(along[1]) } else { along[0] };
        let back = if EDGES { along[2].max(along[3]) } else { along[1].max(along[2]).max(along[3]) };
        least = least.min(front - back);
    }
    (found, least)
}

impl Narrow<'_> {
    #[inline(always)]
    fn of_kind<V: SimdF64, const EDGES: bool>(&mut self, first: usize, pairs: &[Pair]) {
        let duration = V::all(self.lines.duration);
        for (chunk, pairs) in pairs.chunks(LANES).enumerate() {
            let eight = Eight::of::<EDGES>(self.surface, pairs);
            let [x, v] = eight.gather::<V>(self.lines.nodes);
            let (found, least) = measure::<V, EDGES>(x, v, duration);
            let kept = kept_of(&self.from.kept, first + chunk * LANES, pairs.len());
            let length = dot(found.gap, found.gap).sqrt();
            let excess = least - (V::load(&kept) + V::all(self.bound)) * length - V::all(TINY);
            let excess = excess.lanes();
            for lane in 0..eight.count {
                if excess.0[lane] < 0.0 || excess.0[lane].is_nan() {
                    let kept = self.from.kept.get(first + chunk * LANES + lane).copied();
                    self.into.push(pairs[lane], kept);
                }
            }
        }
    }
}

/// What eight pairs keep; 0 where it is not known.
#[inline(always)]
fn kept_of(kept: &[f64], first: usize, count: usize) -> F64x8 {
    let mut own = F64x8::ZERO;
    if !kept.is_empty() {
        own.0[..count].copy_from_slice(&kept[first..first + count]);
    }
    own
}

impl Kernel for Narrow<'_> {
    type Output = ();

    #[inline(always)]
    fn sweep<V: SimdF64>(mut self) {
        let (from, split) = (self.from, self.from.split());
        self.of_kind::<V, false>(0, &from.pairs[..split]);
        self.of_kind::<V, true>(split, &from.pairs[split..]);
    }
}

impl Raise<'_> {
    #[inline(always)]
    fn of_kind<V: SimdF64, const EDGES: bool>(&mut self, first: usize, end: usize) {
        for at in (first..end).step_by(LANES) {
            let pairs = &self.pairs.pairs[at..end.min(at + LANES)];
            let eight = Eight::of::<EDGES>(self.surface, pairs);
            let [x, _] = eight.gather::<V>(self.nodes);
            let found = if EDGES { edge_edge(x) } else { node_triangle(x) };
            let length = dot(found.gap, found.gap).sqrt().lanes();
            for lane in 0..eight.count {
                let most = self.surface.touching(self.pairs.pairs[at + lane]);
                let kept = &mut self.pairs.kept[at + lane];
                *kept = kept.max(self.share * length.0[lane].min(most));
            }
        }
    }
}

impl Kernel for Raise<'_> {
    type Output = ();

    #[inline(always)]
    fn sweep<V: SimdF64>(mut self) {
        let (count, split) = (self.pairs.pairs.len(), self.pairs.split());
        self.of_kind::<V, false>(0, split);
        self.of_kind::<V, true>(split, count);
    }
}

impl Look<'_> {
    #[inline(always)]
    fn of_kind<V: SimdF64, const EDGES: bool>(&mut self, first: usize, pairs: &[Pair]) {
        let duration = V::all(self.lines.duration);
        for (chunk, pairs) in pairs.chunks(LANES).enumerate() {
            let eight = Eight::of::<EDGES>(self.surface, pairs);
            let [x, v] = eight.gather::<V>(self.lines.nodes);
            let (found, least) = measure::<V, EDGES>(x, v, duration);
            let kept = kept_of(&self.from.kept, first + chunk * LANES, pairs.len());
            let length = dot(found.gap, found.gap).sqrt();
            let excess = (least - (V::load(&kept) + V::all(self.bound)) * length - V::all(TINY)).lanes();
            let mut nearest = f64::INFINITY;
            for lane in 0..LANES {
                nearest = nearest.min(excess.0[lane]);
            }
            // Most eights have none.
            if nearest >= 0.0 {
                continue;
            }
            let mut approach = V::zero();
            for axis in 0..3 {
                for corner in 0..4 {
                    approach += found.gap[axis] * (found.weights[corner] * v[corner][axis]);
                }
            }
            let room = length - V::load(&kept);
            let short = (approach - least_approach(room, duration, V::all(self.share_of_depth)) * length).lanes();
            let length = length.lanes();
            let (mut weights, mut gap) = ([F64x8::ZERO; 4], [F64x8::ZERO; 3]);
            for corner in 0..4 {
                weights[corner] = found.weights[corner].lanes();
            }
            for axis in 0..3 {
                gap[axis] = found.gap[axis].lanes();
            }
            let inner = if EDGES { inner_edges(&found) } else { V::all(1.0) }.lanes();
            for lane in 0..eight.count {
                if excess.0[lane] >= 0.0 || (inner.0[lane] == 0.0 && !self.surface.has_cord(pairs[lane])) {
                    continue;
                }
                if short.0[lane] < 0.0 {
                    self.near.push(Near {
                        pair: pairs[lane],
                        nodes: eight.nodes.map(|nodes| nodes[lane]),
                        weights: weights.map(|weight| weight.0[lane]),
                        gap: gap.map(|gap| gap.0[lane]),
                        kept: kept.0[lane],
                    });
                } else {
                    self.watched.pairs.push(pairs[lane], Some(kept.0[lane]));
                    self.watched.room.push(short.0[lane] / length.0[lane] * self.lines.duration);
                }
            }
        }
    }
}

/// The least rate of the distance that keeps a pair, with this room, apart for a step: it may lose the room, or, where
/// it is too near, is pushed apart slowly.
#[inline(always)]
pub(super) fn least_approach<V: SimdF64>(room: V, dt: V, share: V) -> V {
    let rate = -room / dt;
    V::zero().below(room, rate, (share * rate).min(V::all(RECOVERY)))
}

/// 1 where the closest points of two edges are inside both and these are not parallel: nodes and triangles keep the
/// others apart.
#[inline(always)]
fn inner_edges<V: SimdF64>(found: &Closest<V>) -> V {
    let (zero, one) = (V::zero(), V::all(1.0));
    let mut inner = V::all(PARALLEL).below(found.square_sine, one, zero);
    for corner in 0..4 {
        inner = zero.below(found.weights[corner].abs(), inner, zero);
    }
    inner
}

impl Kernel for Look<'_> {
    type Output = ();

    #[inline(always)]
    fn sweep<V: SimdF64>(mut self) {
        let (from, split) = (self.from, self.from.split());
        self.of_kind::<V, false>(0, &from.pairs[..split]);
        self.of_kind::<V, true>(split, &from.pairs[split..]);
    }
}
