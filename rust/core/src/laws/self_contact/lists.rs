//! Lists of the pairs that may come near, each of the one before, and when they are made anew.
//!
//! A list holds every pair that may come nearer than its bound while the nodes stay within half a skin s of straight
//! lines, and for as long as its horizon. A node of a pair that is not in it is off its line by s/2 at most, so that
//! the pair stays apart by the bound: lists leave out only what has no impulse, and the motion is the same whatever
//! their lengths. The first list is that of a tree of boxes around all elements and their ways; the last one is looked
//! at in every step.

use std::ops::ControlFlow;

use super::Scheme;
use super::look::{Lines, Moving, Narrow, Pairs, Raise};
use super::surface::Surface;
use crate::arrays::state::{NodeVectors, columns};
use crate::contact::box_tree::{Bounds, BoxTree};
use crate::simd::dispatch::{InstructionSet, Kernel};
use crate::simd::lanes::{LANES, SimdF64};

/// Number of lists.
pub(super) const LISTS: usize = 4;
/// Skins of the lists, relative to the distance at which layers touch, and horizons at the start, in steps.
pub(super) const SKINS: [f64; LISTS] = [200.0, 20.0, 2.0, 0.25];
pub(super) const HORIZONS: [f64; LISTS] = [256.0, 32.0, 8.0, 4.0];
/// By which a horizon grows where it ended before the nodes had left their lines, and what it is, relative to the time
/// that they took, where they had.
const LONGER: f64 = 2.0;
const AS_LONG: f64 = 1.25;
/// Shortest and longest horizons, relative to those at the start.
const SHORTEST: f64 = 4.0;
const LONGEST: f64 = 4.0;
/// Pairs of a list below which its skin doubles, up to so many times that of the scheme, and above which it halves.
const FEW: usize = 512;
const MANY: usize = 4096;
const WIDEST: f64 = 16.0;
/// Bounds of lists are this much larger than those of impulses, for rounding.
const ROUNDING: f64 = 1e-6;

/// Nodes that move, from now to the end of a step.
#[derive(Clone, Copy)]
pub(super) struct Step<'a> {
    pub(super) time: f64,
    pub(super) dt: f64,
    pub(super) positions: &'a NodeVectors,
    pub(super) velocities: &'a NodeVectors,
}

/// A list and its straight lines.
struct List {
    pairs: Pairs,
    positions: NodeVectors,
    velocities: NodeVectors,
    begin: f64,
    horizon: f64,
    skin: f64,
    /// The skin that it has when it is made anew.
    next_skin: f64,
    is_valid: bool,
}

/// How often each list was made, for the chart of costs.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct ListCounts {
    /// Makings.
    pub made: [u64; LISTS],
    /// Pairs in each at present.
    pub pairs: [u64; LISTS],
}

/// The lists.
pub(super) struct Lists {
    lists: [List; LISTS],
    scheme: Scheme,
    /// The largest distance at which a pair touches \[m\].
    touching: f64,
    /// Beyond what a pair keeps, in the last list, and altogether, in the others \[m\].
    margin: f64,
    most: f64,
    counts: [u64; LISTS],
    boxes: Vec<Bounds>,
    moving: Vec<Moving>,
    instructions: InstructionSet,
}

impl Lists {
    /// Lists of pairs that keep at most a share of the distance at which they touch, and have impulses up to a margin
    /// beyond that.
    pub(super) fn new(
        surface: &Surface,
        share: f64,
        margin: f64,
        nodes: usize,
        instructions: InstructionSet,
        scheme: Scheme,
    ) -> Self {
        let lists = std::array::from_fn(|k| List {
            pairs: Pairs::default(),
            positions: NodeVectors::zeros(nodes),
            velocities: NodeVectors::zeros(nodes),
            begin: 0.0,
            horizon: 0.0,
            skin: 0.0,
            next_skin: scheme.skins[k] * surface.most_touching(),
            is_valid: false,
        });
        let most = share * surface.most_touching() + margin;
        Self {
            lists,
            scheme,
            touching: surface.most_touching(),
            margin,
            most,
            counts: [0; LISTS],
            boxes: Vec::new(),
            moving: Vec::new(),
            instructions,
        }
    }

    /// Forgets what pairs keep, which another history may change.
    pub(super) fn forget(&mut self) {
        self.lists[1..].iter_mut().for_each(|list| list.is_valid = false);
    }

    /// How often lists were made, and their lengths.
    pub(super) fn counts(&self) -> ListCounts {
        ListCounts { made: self.counts, pairs: self.lists.each_ref().map(|list| list.pairs.pairs.len() as u64) }
    }

    /// The pairs that may come near within a step.
    pub(super) fn at(&mut self, step: Step<'_>, surface: &Surface, share: f64, shapes: &[NodeVectors]) -> &Pairs {
        if !self.holds(LISTS - 1, step) {
            self.renew(step, surface, share, shapes);
        }
        &self.lists[LISTS - 1].pairs
    }

    /// Whether a list holds until the end of a step.
    fn holds(&self, k: usize, step: Step<'_>) -> bool {
        let list = &self.lists[k];
        let end = step.time + step.dt;
        let is_in_time = list.is_valid && list.begin <= step.time && end <= list.begin + list.horizon;
        is_in_time && self.deviation(k, step) <= 0.5 * list.skin
    }

    /// The largest distance of a node from its line, now and at the end of a step \[m\].
    fn deviation(&self, k: usize, step: Step<'_>) -> f64 {
        let list = &self.lists[k];
        let lines = [&list.positions, &list.velocities, step.positions, step.velocities].map(columns);
        let now = step.time - list.begin;
        self.instructions.dispatch(Deviation { lines, now, dt: step.dt }).sqrt()
    }

    /// Makes the last list anew, and those before it that do not hold as long.
    fn renew(&mut self, step: Step<'_>, surface: &Surface, share: f64, shapes: &[NodeVectors]) {
        // Mean velocities predict better than those of a moment, which vibrate.
        if let Some(velocities) = self.mean_velocities(step) {
            let lines = Step { velocities: &velocities, ..step };
            let columns = [step.positions, &velocities, step.positions, step.velocities].map(columns);
            let off = self.instructions.dispatch(Deviation { lines: columns, now: 0.0, dt: step.dt }).sqrt();
            if off <= 0.5 * self.lists[LISTS - 1].next_skin {
                self.make_anew(lines, surface, share, shapes);
                if self.holds(LISTS - 1, step) {
                    return;
                }
            }
        }
        self.make_anew(step, surface, share, shapes);
    }

    /// The mean velocities since the last list was made, where there was one.
    fn mean_velocities(&self, step: Step<'_>) -> Option<NodeVectors> {
        let list = &self.lists[LISTS - 1];
        let elapsed = step.time - list.begin;
        let is_near = list.is_valid && elapsed > 0.0 && elapsed <= list.horizon + step.dt;
        is_near.then(|| (step.positions - &list.positions) / elapsed)
    }

    /// Makes the last list, and those before it that do not hold as long, with straight lines.
    fn make_anew(&mut self, lines: Step<'_>, surface: &Surface, share: f64, shapes: &[NodeVectors]) {
        let mut horizons: [f64; LISTS] = std::array::from_fn(|k| self.next_horizon(k, lines));
        let mut first = LISTS - 1;
        while first > 0 {
            if let Some(horizon) = self.covered(first - 1, first, horizons[first], lines) {
                horizons[first] = horizon;
                break;
            }
            first -= 1;
        }
        for k in first..LISTS {
            if k > first {
                horizons[k] = horizons[k].min(horizons[k - 1]);
            }
            self.make(k, horizons[k], lines, surface, share, shapes);
        }
    }

    /// The horizon of a list that is to be made: longer where the last one ended before the nodes left their lines.
    fn next_horizon(&self, k: usize, lines: Step<'_>) -> f64 {
        let list = &self.lists[k];
        let (usual, elapsed) = (self.scheme.horizons[k] * lines.dt, lines.time - list.begin);
        let is_outlived = elapsed + lines.dt > list.horizon;
        let next = match list.is_valid && elapsed > 0.0 {
            false => usual,
            true if is_outlived => LONGER * list.horizon,
            true => AS_LONG * elapsed,
        };
        next.clamp(usual / SHORTEST, usual * LONGEST).max(lines.dt)
    }

    /// For how long a list would hold beside the next one, made with these lines: as long as asked for, or not much
    /// shorter.
    fn covered(&self, k: usize, next: usize, horizon: f64, lines: Step<'_>) -> Option<f64> {
        let (list, next) = (&self.lists[k], &self.lists[next]);
        let left = list.begin + list.horizon - lines.time;
        let own = horizon.min(left);
        let is_in_time = list.is_valid && list.begin <= lines.time && own >= lines.dt.max(0.25 * horizon);
        let ahead = Step { dt: own, ..lines };
        (is_in_time && self.deviation(k, ahead) + 0.5 * next.next_skin.min(0.5 * list.skin) <= 0.5 * list.skin)
            .then_some(own)
    }

    fn make(&mut self, k: usize, horizon: f64, lines: Step<'_>, surface: &Surface, share: f64, shapes: &[NodeVectors]) {
        self.counts[k] += 1;
        let (before, rest) = self.lists.split_at_mut(k);
        let list = &mut rest[0];
        (list.begin, list.horizon, list.is_valid) = (lines.time, horizon, true);
        let widest = before.last().map_or(f64::INFINITY, |before| 0.5 * before.skin);
        list.skin = list.next_skin.min(widest);
        list.positions.copy_from(lines.positions);
        list.velocities.copy_from(lines.velocities);
        list.pairs.clear();
        let own = if k + 1 == LISTS { self.margin } else { self.most };
        let bound = own * (1.0 + ROUNDING) + list.skin;
        let straight = Lines::of(&list.positions, &list.velocities, horizon, &mut self.moving);
        let into = &mut list.pairs;
        match before.last() {
            Some(before) => {
                self.instructions.dispatch(Narrow { surface, from: &before.pairs, lines: straight, bound, into });
            }
            None => first_list(surface, lines, straight, bound, &mut self.boxes, self.instructions, into),
        }
        // Short lists may be wide, so that they hold for longer.
        let (least, count) = (self.scheme.skins[k] * self.touching, list.pairs.pairs.len());
        if count < FEW {
            list.next_skin = (2.0 * list.skin).min(WIDEST * least);
        } else if count > MANY {
            list.next_skin = (0.5 * list.skin).max(least);
        }
        if k == LISTS - 2 {
            list.pairs.kept.resize(list.pairs.pairs.len(), 0.0);
            for positions in shapes {
                let nodes = Lines::of(positions, positions, 0.0, &mut self.moving).nodes;
                self.instructions.dispatch(Raise { surface, nodes, pairs: &mut list.pairs, share });
            }
        }
    }
}

/// The pairs that may come nearer than a bound, in order: of elements whose boxes, around them and their ways, meet.
fn first_list(
    surface: &Surface,
    ways: Step<'_>,
    lines: Lines<'_>,
    bound: f64,
    boxes: &mut Vec<Bounds>,
    instructions: InstructionSet,
    into: &mut Pairs,
) {
    const AT_ONCE: usize = 4096;
    let (x, v) = (columns(ways.positions), columns(ways.velocities));
    let half = 0.5 * bound;
    boxes.clear();
    boxes.extend(surface.elements.iter().map(|element| {
        let mut bounds = Bounds { low: [f64::INFINITY; 3], high: [f64::NEG_INFINITY; 3] };
        for node in element.corners.map(|node| node as usize) {
            for axis in 0..3 {
                let now = x[axis][node];
                let then = now + lines.duration * v[axis][node];
                bounds.low[axis] = bounds.low[axis].min(now.min(then) - half);
                bounds.high[axis] = bounds.high[axis].max(now.max(then) + half);
            }
        }
        bounds
    }));
    let is_finite = boxes.iter().all(|bounds| bounds.low.iter().chain(&bounds.high).all(|value| value.is_finite()));
    if !is_finite {
        // A motion that diverges is found by the monitor.
        return;
    }
    let tree = BoxTree::new(boxes);
    // Those of nodes and triangles, and of edges.
    let mut found = [Pairs::default(), Pairs::default()];
    let _: ControlFlow<()> = tree.visit_pairs(&mut |slot, leaf, mut meeting| {
        while meeting != 0 {
            let other = leaf + meeting.trailing_zeros() as usize;
            meeting &= meeting - 1;
            let [first, second] = [slot, other].map(|slot| tree.order()[slot] as usize);
            surface.visit_pairs(first, second, &mut |pair| found[usize::from(pair.has_edges())].pairs.push(pair));
        }
        for found in found.iter_mut().filter(|found| found.pairs.len() >= AT_ONCE) {
            instructions.dispatch(Narrow { surface, from: found, lines, bound, into });
            found.clear();
        }
        ControlFlow::Continue(())
    });
    for found in &found {
        instructions.dispatch(Narrow { surface, from: found, lines, bound, into });
    }
    into.pairs.sort_unstable();
}

/// The largest squared distance of nodes x from lines y + t w, at t = `now` and, moving on with v, `dt` later.
struct Deviation<'a> {
    /// y, w, x and v.
    lines: [[&'a [f64]; 3]; 4],
    now: f64,
    dt: f64,
}

impl Kernel for Deviation<'_> {
    type Output = f64;

    #[inline(always)]
    fn sweep<V: SimdF64>(self) -> f64 {
        let Self { lines: [y, w, x, v], now, dt } = self;
        let (at, dt) = (V::all(now), V::all(dt));
        let count = x[0].len();
        let mut largest = V::zero();
        for first in (0..count).step_by(LANES) {
            let (mut here, mut later) = (V::zero(), V::zero());
            for axis in 0..3 {
                let off = load::<V>(x[axis], first) - load::<V>(y[axis], first);
                let (w, v) = (load::<V>(w[axis], first), load::<V>(v[axis], first));
                let off = off - at * w;
                let then = off + dt * (v - w);
                here += off * off;
                later += then * then;
            }
            largest = largest.max(here.max(later));
        }
        largest.lanes().0.into_iter().fold(0.0, f64::max)
    }
}

/// Eight numbers from `first` on; zeros behind the last.
#[inline(always)]
fn load<V: SimdF64>(column: &[f64], first: usize) -> V {
    match column[first..].first_chunk::<LANES>() {
        Some(numbers) => V::load_from(numbers),
        None => {
            let mut numbers = [0.0; LANES];
            numbers[..column.len() - first].copy_from_slice(&column[first..]);
            V::load_from(&numbers)
        }
    }
}
