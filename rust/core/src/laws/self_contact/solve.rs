//! Sequential impulses: of each pair that would come too near within the step, in order, until none changes much.
//!
//!     g = sum of w_q x_q,   d = |g|,   n = g/d,   v_n = n . sum of w_q u_q
//!     target   v_n >= -(d - d_m)/dt where d > d_m,   else v_n >= min(beta (d_m - d)/dt, v_r)
//!     impulse  lam = max(0, lam + m_r (target - v_n)),   1/m_r = sum of w_q^2/m_q
//!     velocity v_q += lam w_q n/m_q,   and u_q, the velocity of the drift, in step with it
//!
//! With restitution e, a pair that would meet within the step is to separate at -e times its velocity before, that of v
//! and not of u, which has half a kick more and would gain energy. Coulomb's friction acts in the same sweep: the
//! tangential impulse stops the sliding, and its size is at most mu lam. Warm start: lam begins at 0.9 of that of the
//! last step (Catto, Iterative Dynamics with Temporal Coherence, 2005).
//!
//! A pair whose nodes have not changed since its turn is passed over, for it would find the same.

use nalgebra::Vector3;

use super::look::{Near, Pairs, Watched, least_approach};
use super::surface::{Pair, Surface};
use super::zones::Zones;
use crate::arrays::state::NodeVectors;
use crate::contact::separation::comes_near;
use crate::simd::lanes::{F64x8, SimdF64};

/// Share of the last step's impulse with which a pair begins.
const WARM: f64 = 0.9;
/// Share of the distance that a pair keeps, below which it may not come after all sweeps.
const NEAREST: f64 = 0.25;
/// Most sweeps, and the change of velocity below which a pair is left as it is \[m/s\]: far less than that by which a
/// pair that is too near is pushed apart.
const MOST_SWEEPS: usize = 100;
const CONVERGED: f64 = 1e-4;

/// Coefficients of the law.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Coefficients {
    pub(super) friction: f64,
    pub(super) restitution: f64,
    /// beta.
    pub(super) share_of_depth: f64,
}

/// By how much two layers approach in a step \[m\], and a node of each.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Approach {
    pub(super) way: f64,
    pub(super) nodes: [u32; 2],
}

impl Approach {
    /// The larger one, and the first where both are alike.
    pub(super) fn max(self, other: Self) -> Self {
        if other.way > self.way { other } else { self }
    }
}

/// A pair that may have an impulse.
struct Contact {
    pair: Pair,
    nodes: [usize; 4],
    /// w_q, and w_q/m_q \[1/kg\].
    weights: [f64; 4],
    shares: [f64; 4],
    normal: Vector3<f64>,
    /// m_r \[kg\].
    mass: f64,
    /// Least v_n, and that below which the nodes become a rigid zone \[m/s\].
    target: f64,
    limit: f64,
    /// lam and the tangential impulse \[N s\].
    pressed: f64,
    along: Vector3<f64>,
    turn: u32,
}

/// Velocities of the drift, as impulses change them.
pub(super) struct Drifting<'a> {
    /// u \[m/s\].
    pub(super) velocities: &'a mut NodeVectors,
    /// Velocities v at the kick \[m/s\].
    pub(super) own: &'a NodeVectors,
    /// By which an impulse turns u: w dt/2, with w of the accelerations of Coriolis.
    pub(super) turn: f64,
    pub(super) dt: f64,
}

/// Contacts of a step, and work arrays.
#[derive(Default)]
pub(super) struct Solver {
    contacts: Vec<Contact>,
    /// Nodes with an impulse, and their u before.
    pub(super) changed: Vec<(u32, [f64; 3])>,
    /// Of each node: whether it is among those, and the turn of its last change.
    is_changed: Vec<bool>,
    turns: Vec<u32>,
    turn: u32,
    zones: Zones,
    rigid: Vec<(usize, Vector3<f64>)>,
    /// By how much impulses move each node within the drift \[m\].
    ways: Vec<f64>,
}

impl Solver {
    pub(super) fn new(nodes: usize) -> Self {
        Self { is_changed: vec![false; nodes], turns: vec![0; nodes], ways: vec![0.0; nodes], ..Self::default() }
    }

    /// Begins a step.
    pub(super) fn begin(&mut self) {
        self.contacts.clear();
        self.zones.clear();
        for (node, _) in self.changed.drain(..) {
            let node = node as usize;
            (self.is_changed[node], self.turns[node], self.ways[node]) = (false, 0, 0.0);
        }
        self.turn = 0;
    }

    /// How many pairs may have an impulse.
    pub(super) fn len(&self) -> usize {
        self.contacts.len()
    }

    /// Adds pairs near each other, and starts them with the impulses of the last step, in order. The largest approach
    /// of one in a step.
    pub(super) fn add(
        &mut self,
        near: &[Near],
        last: &[(Pair, f64)],
        of: Coefficients,
        positions: &NodeVectors,
        inverse_masses: &[f64],
        drifting: &Drifting<'_>,
    ) -> Approach {
        let (mut last, mut largest) = (last.iter().peekable(), Approach::default());
        let known = self.contacts.len();
        for near in near {
            while last.next_if(|(pair, _)| *pair < near.pair).is_some() {}
            if self.contacts[..known].binary_search_by_key(&near.pair, |contact| contact.pair).is_ok() {
                continue;
            }
            let gap = Vector3::from(near.gap);
            let distance = gap.norm();
            let nodes = near.nodes.map(|node| node as usize);
            let shares: [f64; 4] = std::array::from_fn(|k| near.weights[k] * inverse_masses[nodes[k]]);
            let inverse: f64 = near.weights.iter().zip(shares).map(|(weight, share)| weight * share).sum();
            if inverse <= 0.0 || distance <= 0.0 {
                continue;
            }
            let mut contact = Contact {
                pair: near.pair,
                nodes,
                weights: near.weights,
                shares,
                normal: gap / distance,
                mass: 1.0 / inverse,
                target: 0.0,
                limit: ((NEAREST * near.kept - distance) / drifting.dt).min(0.0),
                pressed: 0.0,
                along: Vector3::zeros(),
                turn: 0,
            };
            let relative = contact.relative(drifting.velocities);
            if !comes_too_near(near, gap + relative * drifting.dt, positions, drifting) {
                continue;
            }
            let before = relative.dot(&contact.normal);
            largest = largest.max(Approach { way: -before * drifting.dt, nodes: [near.nodes[0], near.nodes[2]] });
            let [room, dt, share] = [distance - near.kept, drifting.dt, of.share_of_depth].map(F64x8::all);
            let target = least_approach(room, dt, share).0[0];
            contact.target = target;
            let own = contact.relative(drifting.own).dot(&contact.normal);
            if of.restitution > 0.0 && own < 0.0 {
                // v_n is to change by -(1 + e) v_n, and the velocity of the drift with it.
                contact.target = target.max(before - (1.0 + of.restitution) * own);
            }
            if let Some((_, pressed)) = last.next_if(|(pair, _)| *pair == near.pair) {
                contact.pressed = WARM * pressed;
            }
            self.contacts.push(contact);
        }
        if known > 0 {
            self.contacts.sort_unstable_by_key(|contact| contact.pair);
        }
        largest
    }

    /// Of watched pairs, those that impulses so far may bring too near.
    pub(super) fn of_changed(
        &mut self,
        surface: &Surface,
        watched: &Watched,
        velocities: &NodeVectors,
        dt: f64,
        into: &mut Pairs,
    ) {
        for changed in &self.changed {
            self.ways[changed.0 as usize] = square_of_change(changed, velocities).sqrt() * dt;
        }
        into.clear();
        let Watched { pairs, room } = watched;
        for ((&pair, &kept), &room) in pairs.pairs.iter().zip(&pairs.kept).zip(room) {
            let [a, b, c, d] = surface.nodes(pair).map(|node| self.ways[node as usize]);
            let (first, second) = if pair.has_edges() { (a.max(b), c.max(d)) } else { (a, b.max(c).max(d)) };
            if first + second > room {
                into.push(pair, Some(kept));
            }
        }
    }

    /// Gives the pairs their first impulses.
    pub(super) fn warm(&mut self, drifting: &mut Drifting<'_>) {
        for k in 0..self.contacts.len() {
            let contact = &self.contacts[k];
            if contact.pressed > 0.0 && contact.turn == 0 {
                let impulse = contact.normal * contact.pressed;
                self.give(k, impulse, drifting);
            }
        }
    }

    /// Sweeps over the pairs until none changes much.
    pub(super) fn solve(&mut self, of: Coefficients, drifting: &mut Drifting<'_>) {
        for _ in 0..MOST_SWEEPS {
            let mut is_settled = true;
            for k in 0..self.contacts.len() {
                let contact = &self.contacts[k];
                let is_same = contact.turn > 0 && contact.nodes.iter().all(|&node| self.turns[node] <= contact.turn);
                if is_same {
                    continue;
                }
                let relative = contact.relative(drifting.velocities);
                let along = relative.dot(&contact.normal);
                let pressed = (contact.pressed + contact.mass * (contact.target - along)).max(0.0);
                let mut impulse = contact.normal * (pressed - contact.pressed);
                let mut tangential = contact.along;
                if of.friction > 0.0 && (pressed > 0.0 || tangential != Vector3::zeros()) {
                    let sliding = relative - contact.normal * along;
                    tangential -= sliding * contact.mass;
                    let (size, most) = (tangential.norm(), of.friction * pressed);
                    if size > most {
                        tangential *= most / size;
                    }
                    impulse += tangential - contact.along;
                }
                // At its first turn a pair has what it needs, however little: weight acts by little in a step.
                let least = if contact.turn == 0 { 0.0 } else { CONVERGED * contact.mass };
                let is_changed = impulse.norm() > least;
                let contact = &mut self.contacts[k];
                if is_changed {
                    (contact.pressed, contact.along) = (pressed, tangential);
                    self.give(k, impulse, drifting);
                    is_settled = false;
                }
                self.contacts[k].turn = self.turn.max(1);
            }
            if is_settled {
                break;
            }
        }
    }

    /// Gives an impulse to the nodes of a pair.
    fn give(&mut self, k: usize, impulse: Vector3<f64>, drifting: &mut Drifting<'_>) {
        let Contact { nodes, shares, .. } = self.contacts[k];
        self.turn += 1;
        let [x, y, z] = [impulse.x, impulse.y, impulse.z];
        // (I + h J) of the impulse, with J v = (v_y, -v_x, 0).
        let turned = [x + drifting.turn * y, y - drifting.turn * x, z];
        for (node, share) in nodes.into_iter().zip(shares).filter(|(_, share)| *share != 0.0) {
            self.note(node, drifting);
            for axis in 0..3 {
                drifting.velocities[(node, axis)] += share * turned[axis];
            }
        }
    }

    /// Makes rigid zones of the nodes of pairs that still come much too near, until there is none or no zone grows: one
    /// between nodes that are held and such as are moved comes nearer whatever it does.
    pub(super) fn stop(
        &mut self,
        positions: &NodeVectors,
        masses: &[f64],
        inverse_masses: &[f64],
        drifting: &mut Drifting<'_>,
    ) {
        for round in 0.. {
            let (mut is_any, mut is_larger) = (false, false);
            for contact in &self.contacts {
                if contact.relative(drifting.velocities).dot(&contact.normal) < contact.limit - CONVERGED {
                    is_any = true;
                    is_larger |= self.zones.add(contact.nodes);
                }
            }
            // Zones of rounds before have been swept since.
            if !is_any || (round > 0 && !is_larger) {
                return;
            }
            self.turn += 1;
            let Self { zones, rigid, .. } = self;
            rigid.clear();
            zones.visit(positions, drifting.velocities, masses, inverse_masses, |node, own| rigid.push((node, own)));
            for k in 0..self.rigid.len() {
                let (node, own) = self.rigid[k];
                self.note(node, drifting);
                drifting.velocities.set_row(node, &own.transpose());
            }
        }
    }

    /// Notes that a node changes.
    fn note(&mut self, node: usize, drifting: &Drifting<'_>) {
        if !std::mem::replace(&mut self.is_changed[node], true) {
            let row = drifting.velocities.row(node);
            self.changed.push((node as u32, [row[0], row[1], row[2]]));
        }
        self.turns[node] = self.turn;
    }

    /// The pairs with an impulse, in order.
    pub(super) fn pressed(&self, into: &mut Vec<(Pair, f64)>) {
        into.clear();
        into.extend(self.contacts.iter().filter(|c| c.pressed > 0.0).map(|c| (c.pair, c.pressed)));
    }

    /// The largest change of u of a node \[m/s\].
    pub(super) fn largest_change(&self, velocities: &NodeVectors) -> f64 {
        self.changed.iter().map(|changed| square_of_change(changed, velocities)).fold(0.0, f64::max).sqrt()
    }
}

/// The square of the change of u of a node from what it was before \[m2/s2\].
fn square_of_change((node, before): &(u32, [f64; 3]), velocities: &NodeVectors) -> f64 {
    let row = velocities.row(*node as usize);
    (0..3).map(|axis| (row[axis] - before[axis]).powi(2)).sum()
}

impl Contact {
    /// The relative velocity, the sum of w_q u_q \[m/s\].
    fn relative(&self, velocities: &NodeVectors) -> Vector3<f64> {
        let mut sum = Vector3::zeros();
        for (node, weight) in self.nodes.into_iter().zip(self.weights) {
            for axis in 0..3 {
                sum[axis] += weight * velocities[(node, axis)];
            }
        }
        sum
    }
}

/// Whether a pair comes nearer than it keeps at any time of the drift, in straight lines. With the present closest
/// points its gap becomes `then`, which may be too small while others pass at a distance.
fn comes_too_near(near: &Near, then: Vector3<f64>, positions: &NodeVectors, drifting: &Drifting<'_>) -> bool {
    let gap = Vector3::from(near.gap);
    let way = then - gap;
    let share = (-gap.dot(&way) / way.norm_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    if (gap + way * share).norm() < near.kept {
        return true;
    }
    let point = |node: u32, time: f64| -> Vector3<f64> {
        let node = node as usize;
        std::array::from_fn::<f64, 3, _>(|axis| positions[(node, axis)] + time * drifting.velocities[(node, axis)])
            .into()
    };
    let firsts = if near.pair.has_edges() { 2 } else { 1 };
    let mut hull = [Vector3::zeros(); 8];
    let mut count = 0;
    for time in [0.0, drifting.dt] {
        let corners = near.nodes.map(|node| point(node, time));
        for first in &corners[..firsts] {
            for second in &corners[firsts..] {
                hull[count] = first - second;
                count += 1;
            }
        }
    }
    comes_near(&hull[..count], near.kept)
}
