//! Passes over pairs, eight at a time: which may come near, and how far apart they are.
//!
//! For any unit vector n, two convex bodies are no nearer than they are along n. With n along the gap g of a pair and
//! corners that move in straight lines, x_q + t w_q, the least distance from now to the time t is at least
//!
//!     min over both times of ( min of n . x_q of the first  -  max of n . x_q of the second )
//!
//! so that what is not below a bound stays apart by it, whatever happens between.

use std::array::from_fn;

use super::pairs::{Eight, Lines, Listed, Moving, Pairs};
use super::surface::{Pair, Surface};
use crate::contact::closest::{Closest, edge_edge, node_triangle};
use crate::simd::dispatch::{InstructionSet, Kernel};
use crate::simd::lanes::{F64x8, LANES, SimdF64, Vec3, dot, scale, sub, sum};

/// Levels of a list.
pub(super) const LEVELS: usize = 8;

/// v_r: the largest speed at which a pair that is too near is pushed apart \[m/s\].
pub(super) const RECOVERY: f64 = 0.02;
/// Squared sine of the angle below which two edges count as parallel.
const PARALLEL: f64 = 1e-8;
/// Added to products of lengths, so that a gap of 0 is below every bound.
const TINY: f64 = 1e-300;

/// Keeps the pairs that may come nearer than a bound beside what each keeps, and a skin beyond it, by levels: eighths
/// of the skin.
pub(super) struct Narrow<'a> {
    pub(super) surface: &'a Surface,
    pub(super) from: &'a [Pairs],
    pub(super) lines: Lines<'a>,
    pub(super) bound: f64,
    pub(super) skin: f64,
    pub(super) into: &'a mut [Pairs; LEVELS],
}

/// Finds the distance of each pair, at most that at which it touches, and keeps the larger of this share and what it
/// has.
pub(super) struct Raise<'a> {
    pub(super) surface: &'a Surface,
    pub(super) nodes: &'a [Moving],
    pub(super) pairs: &'a mut [Pairs],
    pub(super) share: f64,
}

/// A pair that may come near within a step, and by how much more its closest points are apart at its end than they must
/// be, or all points of a fast one throughout it \[m\].
#[derive(Debug, Clone, Copy)]
pub(super) struct Watched {
    pub(super) listed: Listed,
    pub(super) room: f64,
}

/// A pair that would come nearer than it keeps within a step, if its closest points stayed the same, or a fast one that
/// may.
#[derive(Debug, Clone, Copy)]
pub(super) struct Near {
    pub(super) pair: Pair,
    pub(super) nodes: [u32; 4],
    /// By which the gap is the sum of positions.
    pub(super) weights: [f64; 4],
    pub(super) gap: [f64; 3],
    /// The distances that it keeps, and at which it touches \[m\].
    pub(super) kept: f64,
    pub(super) touching: f64,
}

/// Finds these pairs, and those that may come nearer than a bound beside what they keep.
struct Look<'a> {
    surface: &'a Surface,
    from: &'a [Pairs],
    lines: Lines<'a>,
    bound: f64,
    /// beta.
    share_of_depth: f64,
    watched: &'a mut Vec<Watched>,
    near: &'a mut Vec<Near>,
}

/// The closest points.
#[inline(always)]
fn closest<V: SimdF64, const EDGES: bool>(x: [Vec3<V>; 4]) -> Closest<V> {
    if EDGES { edge_edge(x) } else { node_triangle(x) }
}

/// The least distance along a vector until the end of straight lines, times its length.
#[inline(always)]
fn least_along<V: SimdF64, const EDGES: bool>(n: Vec3<V>, x: &[Vec3<V>; 4], v: &[Vec3<V>; 4], duration: V) -> V {
    let (mut now, mut then) = ([V::zero(); 4], [V::zero(); 4]);
    for corner in 1..4 {
        now[corner] = dot(n, sub(x[corner], x[0]));
        then[corner] = now[corner] + duration * dot(n, sub(v[corner], v[0]));
    }
    let mut least = V::all(f64::INFINITY);
    for along in [now, then] {
        let front = if EDGES { along[0].min(along[1]) } else { along[0] };
        let back = if EDGES { along[2].max(along[3]) } else { along[1].max(along[2]).max(along[3]) };
        least = least.min(front - back);
    }
    least
}

/// Eight pairs on straight lines.
struct Measured<V> {
    eight: Eight,
    positions: [Vec3<V>; 4],
    velocities: [Vec3<V>; 4],
    found: Closest<V>,
    /// Length of the gap.
    length: V,
    /// By how much more they stay apart than a bound beside what each keeps, times that length.
    excess: V,
}

impl<V: SimdF64> Measured<V> {
    #[inline(always)]
    fn of<const EDGES: bool>(surface: &Surface, lines: Lines<'_>, bound: f64, pairs: &[Listed]) -> Self {
        let eight = Eight::of::<EDGES>(surface, pairs);
        let [positions, velocities] = eight.gather::<V>(lines.nodes);
        let found = closest::<V, EDGES>(positions);
        let least = least_along::<V, EDGES>(found.gap, &positions, &velocities, V::all(lines.duration));
        let length = dot(found.gap, found.gap).sqrt();
        let excess = least - (V::load(&eight.kept) + V::all(bound)) * length - V::all(TINY);
        Self { eight, positions, velocities, found, length, excess }
    }

    /// By how much more they stay apart than each keeps, at least \[m\]: along the gap of the start, that of the end,
    /// and their bisector.
    #[inline(always)]
    fn least_room<const EDGES: bool>(&self, duration: V) -> V {
        let (x, v) = (&self.positions, &self.velocities);
        let end = from_fn(|corner| sum(x[corner], scale(duration, v[corner])));
        let (start, end) = (self.found.gap, closest::<V, EDGES>(end).gap);
        let unit = |n: Vec3<V>| scale(V::all(1.0) / dot(n, n).sqrt(), n);
        let mut room = V::all(f64::NEG_INFINITY);
        for n in [start, end, sum(unit(start), unit(end))] {
            let least = least_along::<V, EDGES>(n, x, v, duration) - V::all(TINY);
            // A gap of 0 has no direction: the larger is the other of what is no number.
            room = (least / dot(n, n).sqrt() - V::load(&self.eight.kept)).max(room);
        }
        room
    }
}

impl Narrow<'_> {
    #[inline(always)]
    fn of_kind<V: SimdF64, const EDGES: bool>(&mut self, pairs: &[Listed]) {
        let levels = LEVELS as f64 / self.skin;
        for pairs in pairs.chunks(LANES) {
            let Measured { eight, length, excess, .. } =
                Measured::<V>::of::<EDGES>(self.surface, self.lines, self.bound, pairs);
            let level = (excess / length * V::all(levels)).lanes();
            for lane in 0..eight.count {
                // Conversion takes what is negative, or no number, as 0.
                let level = level.0[lane] as usize;
                if level < LEVELS {
                    self.into[level].push(pairs[lane]);
                }
            }
        }
    }
}

impl Kernel for Narrow<'_> {
    type Output = ();

    #[inline(always)]
    fn sweep<V: SimdF64>(mut self) {
        for Pairs([of_nodes, of_edges]) in self.from {
            self.of_kind::<V, false>(of_nodes);
            self.of_kind::<V, true>(of_edges);
        }
    }
}

/// Raises what pairs of one kind keep.
#[inline(always)]
fn raise<V: SimdF64, const EDGES: bool>(surface: &Surface, nodes: &[Moving], share: f64, pairs: &mut [Listed]) {
    for pairs in pairs.chunks_mut(LANES) {
        let eight = Eight::of::<EDGES>(surface, pairs);
        let [x, _] = eight.gather::<V>(nodes);
        let found = closest::<V, EDGES>(x);
        let length = dot(found.gap, found.gap).sqrt().lanes();
        for lane in 0..eight.count {
            let Listed { pair, kept } = &mut pairs[lane];
            *kept = kept.max(share * length.0[lane].min(surface.touching(*pair)));
        }
    }
}

impl Kernel for Raise<'_> {
    type Output = ();

    #[inline(always)]
    fn sweep<V: SimdF64>(self) {
        for Pairs([of_nodes, of_edges]) in self.pairs {
            raise::<V, false>(self.surface, self.nodes, self.share, of_nodes);
            raise::<V, true>(self.surface, self.nodes, self.share, of_edges);
        }
    }
}

impl Look<'_> {
    #[inline(always)]
    fn of_kind<V: SimdF64, const EDGES: bool>(&mut self, pairs: &[Listed]) {
        let duration = V::all(self.lines.duration);
        for pairs in pairs.chunks(LANES) {
            let measured = Measured::<V>::of::<EDGES>(self.surface, self.lines, self.bound, pairs);
            let Measured { eight, velocities: v, found, length, excess, .. } = &measured;
            let (kept, mut excess) = (eight.kept, excess.lanes());
            // Most eights have none.
            if is_none_below(excess) {
                continue;
            }
            let fast = is_fast::<V, EDGES>(v, duration, V::load(&kept));
            if EDGES {
                let counts = inner_edges(found).max(fast).lanes();
                for lane in 0..eight.count {
                    if counts.0[lane] == 0.0 && !self.surface.has_cord(pairs[lane].pair) {
                        excess.0[lane] = f64::INFINITY;
                    }
                }
                if is_none_below(excess) {
                    continue;
                }
            }
            let mut approach = V::zero();
            for axis in 0..3 {
                for corner in 0..4 {
                    approach += found.gap[axis] * (found.weights[corner] * v[corner][axis]);
                }
            }
            let beyond = *length - V::load(&kept);
            let least = least_approach(beyond, duration, V::all(self.share_of_depth));
            let mut room = (approach - least * *length) / *length * duration;
            if fast.lanes().0.iter().any(|fast| *fast != 0.0) {
                room = V::zero().below(fast, measured.least_room::<EDGES>(duration), room);
            }
            let room = room.lanes();
            let (mut weights, mut gap) = ([F64x8::ZERO; 4], [F64x8::ZERO; 3]);
            for corner in 0..4 {
                weights[corner] = found.weights[corner].lanes();
            }
            for axis in 0..3 {
                gap[axis] = found.gap[axis].lanes();
            }
            for lane in 0..eight.count {
                if excess.0[lane] >= 0.0 {
                    continue;
                }
                if room.0[lane] < 0.0 {
                    self.near.push(Near {
                        pair: pairs[lane].pair,
                        nodes: eight.nodes.map(|nodes| nodes[lane]),
                        weights: weights.map(|weight| weight.0[lane]),
                        gap: gap.map(|gap| gap.0[lane]),
                        kept: kept.0[lane],
                        touching: self.surface.touching(pairs[lane].pair),
                    });
                } else {
                    self.watched.push(Watched { listed: pairs[lane], room: room.0[lane] });
                }
            }
        }
    }
}

/// Whether no number is below 0, or none.
#[inline(always)]
fn is_none_below(numbers: F64x8) -> bool {
    let mut least = f64::INFINITY;
    for lane in 0..LANES {
        least = least.min(numbers.0[lane]);
    }
    least >= 0.0
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

/// 1 where nodes of a pair move further past each other within a step than it keeps, so that other points than the
/// closest ones of its start may come together.
#[inline(always)]
fn is_fast<V: SimdF64, const EDGES: bool>(v: &[Vec3<V>; 4], duration: V, kept: V) -> V {
    let of_edges: &[[usize; 2]] = &[[0, 2], [0, 3], [1, 2], [1, 3]];
    let of_node: &[[usize; 2]] = &[[0, 1], [0, 2], [0, 3]];
    let mut square = V::zero();
    for &[first, second] in if EDGES { of_edges } else { of_node } {
        let apart = sub(v[first], v[second]);
        square = square.max(dot(apart, apart));
    }
    let way = square.sqrt() * duration;
    kept.below(way, V::all(1.0), V::zero())
}

impl Kernel for Look<'_> {
    type Output = ();

    #[inline(always)]
    fn sweep<V: SimdF64>(mut self) {
        for Pairs([of_nodes, of_edges]) in self.from {
            self.of_kind::<V, false>(of_nodes);
            self.of_kind::<V, true>(of_edges);
        }
    }
}

/// Looks at pairs, and puts those in order that would come too near.
pub(super) fn look_at(
    surface: &Surface,
    from: &[Pairs],
    lines: Lines<'_>,
    (bound, share_of_depth): (f64, f64),
    instructions: InstructionSet,
    watched: &mut Vec<Watched>,
    near: &mut Vec<Near>,
) {
    instructions.dispatch(Look { surface, from, lines, bound, share_of_depth, watched, near });
    near.sort_unstable_by_key(|near| near.pair);
}
