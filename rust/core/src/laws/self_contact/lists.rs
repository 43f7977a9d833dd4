//! Lists of the pairs that may come near, each of the one before, and when they are made anew.
//!
//! A list holds every pair that may come nearer than its bound while the nodes stay within half a skin s of straight
//! lines, and for as long as its horizon. A node of a pair that is not in it is off its line by s/2 at most, so that
//! the pair stays apart by the bound: lists leave out only what has no impulse, and the motion is the same whatever
//! their lengths. Pairs are in levels by how much further apart than the bound they stay on their lines, so that only
//! those are looked at that the largest deviation so far could bring near. The first list is that of a tree of boxes
//! around all elements and their ways; the last one is looked at in every step.

use super::Scheme;
use super::first::{Elements, First};
use super::look::{LEVELS, Narrow, Raise};
use super::pairs::{Lines, Moving, Pairs, Step};
use super::surface::Surface;
use crate::arrays::state::{NodeVectors, columns};
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
const FEW: usize = 2048;
const MANY: usize = 16384;
const WIDEST: f64 = 64.0;
/// Bounds of lists are this much larger than those of impulses, for rounding.
const ROUNDING: f64 = 1e-6;

/// A list and its straight lines.
struct List {
    /// In level k those that stay apart by the bound and at least k/8 of the skin on their lines.
    levels: [Pairs; LEVELS],
    positions: NodeVectors,
    velocities: NodeVectors,
    /// Nodes of pairs, where these are few, and whether each one is among them.
    nodes: Vec<u32>,
    is_node: Vec<bool>,
    begin: f64,
    horizon: f64,
    skin: f64,
    /// The skin that it has when it is made anew.
    next_skin: f64,
    is_valid: bool,
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
    #[cfg(test)]
    made: [u64; LISTS],
    elements: Elements,
    moving: Vec<Moving>,
    mean: NodeVectors,
    instructions: InstructionSet,
}

impl List {
    /// The pairs that may come nearer than the bound while nodes are off their lines by so much \[m\].
    fn within(&self, off: f64) -> &[Pairs] {
        let reached = 2.0 * off * (1.0 + ROUNDING) * LEVELS as f64 / self.skin;
        let count = if reached.is_nan() { LEVELS } else { (reached as usize).saturating_add(1).min(LEVELS) };
        &self.levels[..count]
    }

    /// The nodes of all pairs, where these are few.
    fn nodes(&self) -> Option<&[u32]> {
        (self.len() < FEW).then_some(&self.nodes)
    }

    /// Finds these nodes.
    fn find_nodes(&mut self, surface: &Surface) {
        self.is_node.fill(false);
        for listed in self.levels.iter().flat_map(|pairs| &pairs.0).flatten() {
            surface.nodes(listed.pair).into_iter().for_each(|node| self.is_node[node as usize] = true);
        }
        self.nodes.clear();
        self.nodes.extend((0..).zip(&self.is_node).filter(|(_, is_node)| **is_node).map(|(node, _)| node));
    }

    /// How many pairs there are.
    fn len(&self) -> usize {
        self.levels.iter().map(Pairs::len).sum()
    }
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
            levels: Default::default(),
            positions: NodeVectors::zeros(nodes),
            velocities: NodeVectors::zeros(nodes),
            nodes: Vec::new(),
            is_node: vec![false; nodes],
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
            #[cfg(test)]
            made: [0; LISTS],
            elements: Elements::default(),
            moving: Vec::new(),
            mean: NodeVectors::zeros(nodes),
            instructions,
        }
    }

    /// Forgets what pairs keep, which another history may change.
    pub(super) fn forget(&mut self) {
        self.lists.iter_mut().for_each(|list| list.is_valid = false);
    }

    /// How often each list was made.
    #[cfg(test)]
    pub(super) fn made(&self) -> [u64; LISTS] {
        self.made
    }

    /// The pairs that may come near within a step, and their nodes where they are few.
    pub(super) fn at(
        &mut self,
        step: Step<'_>,
        surface: &Surface,
        share: f64,
        shapes: &[NodeVectors],
    ) -> (&[Pairs], Option<&[u32]>) {
        let off = self.held(LISTS - 1, step).unwrap_or_else(|| {
            self.renew(step, surface, share, shapes);
            self.deviation(LISTS - 1, step)
        });
        let list = &self.lists[LISTS - 1];
        (list.within(off), list.nodes())
    }

    /// The deviation from the lines of a list that holds until the end of a step.
    fn held(&self, k: usize, step: Step<'_>) -> Option<f64> {
        let list = &self.lists[k];
        let end = step.time + step.dt;
        let is_in_time = list.is_valid && list.begin <= step.time && end <= list.begin + list.horizon;
        is_in_time.then(|| self.deviation(k, step)).filter(|off| *off <= 0.5 * list.skin)
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
        if self.find_mean_velocities(step) {
            let velocities = std::mem::replace(&mut self.mean, NodeVectors::zeros(0));
            let columns = [step.positions, &velocities, step.positions, step.velocities].map(columns);
            let off = self.instructions.dispatch(Deviation { lines: columns, now: 0.0, dt: step.dt }).sqrt();
            let is_near = off <= 0.5 * self.lists[LISTS - 1].next_skin;
            if is_near {
                self.make_anew(Step { velocities: &velocities, ..step }, surface, share, shapes);
            }
            self.mean = velocities;
            if is_near && self.held(LISTS - 1, step).is_some() {
                return;
            }
        }
        self.make_anew(step, surface, share, shapes);
    }

    /// Finds the mean velocities since the last list was made. Whether there was one.
    fn find_mean_velocities(&mut self, step: Step<'_>) -> bool {
        let list = &self.lists[LISTS - 1];
        let elapsed = step.time - list.begin;
        let is_near = list.is_valid && elapsed > 0.0 && elapsed <= list.horizon + step.dt;
        if is_near {
            step.positions.sub_to(&list.positions, &mut self.mean);
            self.mean /= elapsed;
        }
        is_near
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
        #[cfg(test)]
        {
            self.made[k] += 1;
        }
        let off = k.checked_sub(1).map(|before| self.deviation(before, Step { dt: horizon, ..lines }));
        let (before, rest) = self.lists.split_at_mut(k);
        let list = &mut rest[0];
        (list.begin, list.horizon, list.is_valid) = (lines.time, horizon, true);
        let widest = before.last().map_or(f64::INFINITY, |before| 0.5 * before.skin);
        list.skin = list.next_skin.min(widest);
        list.positions.copy_from(lines.positions);
        list.velocities.copy_from(lines.velocities);
        list.levels.iter_mut().for_each(Pairs::clear);
        // What pairs keep is not known of the first list.
        let bound = if k == 0 { self.most } else { self.margin } * (1.0 + ROUNDING);
        let (skin, into) = (list.skin, &mut list.levels);
        match before.last().zip(off) {
            Some((before, off)) => {
                let (from, of) = (before.within(off + 0.5 * skin), before.nodes());
                let straight = Lines::of(of, lines, horizon, &mut self.moving);
                self.instructions.dispatch(Narrow { surface, from, lines: straight, bound, skin, into });
            }
            None => {
                let first = First { surface, lines: Lines::of(None, lines, horizon, &mut self.moving), bound, skin };
                first.find(lines, &mut self.elements, self.instructions, into);
                for positions in shapes {
                    let shape = Step { positions, velocities: positions, ..lines };
                    let nodes = Lines::of(None, shape, 0.0, &mut self.moving).nodes;
                    self.instructions.dispatch(Raise { surface, nodes, pairs: &mut list.levels, share });
                }
            }
        }
        // Short lists may be wide, so that they hold for longer.
        let (least, count) = (self.scheme.skins[k] * self.touching, list.len());
        if count < FEW {
            list.find_nodes(surface);
            list.next_skin = (2.0 * list.skin).min(WIDEST * least);
        } else if count > MANY {
            list.next_skin = (0.5 * list.skin).max(least);
        }
    }
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
