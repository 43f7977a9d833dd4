//! Sequential impulses: of each pair that would come too near within the step, in order, until none changes much.
//!
//!     g = sum of w_q x_q,   d = |g|,   n = g/d,   v_n = n . sum of w_q u_q
//!     target   v_n >= -(d - d_m)/dt where d > d_m,   else v_n >= min(beta (d_m - d)/dt, v_r)
//!     impulse  lam = max(0, lam + m_r (target - v_n)),   1/m_r = sum of w_q^2/m_q
//!     velocity v_q += lam w_q n/m_q,   and u_q, the velocity of the drift, in step with it
//!
//! With restitution e, a pair that would meet within the step is to separate at -e times its velocity before all
//! impulses, that of v and not of u, which has half a kick more and would gain energy. Coulomb's friction acts in the
//! same sweep: the tangential impulse stops the sliding, and its size is at most mu lam. Warm start: lam begins at 0.9
//! of that of the last step (Catto, Iterative Dynamics with Temporal Coherence, 2005).
//!
//! Sweeps pass over pairs whose nodes have not changed since their turn, for these would find the same.

use nalgebra::Vector3;

use super::contact::{Coefficients, Contact, Drifting, comes_too_near, row};
use super::due::Due;
use super::look::{Near, Watched};
use super::pairs::{Listed, Pairs};
use super::surface::{Pair, Surface};
use super::zones::Zones;
use crate::arrays::state::NodeVectors;

/// Share of the last step's impulse with which a pair begins.
const WARM: f64 = 0.9;
/// Most sweeps, without and with restitution, where what they leave undone adds energy.
const MOST_SWEEPS: [usize; 2] = [100, 1000];
/// Sweeps of a step after which restitution has no more of them than others.
const SWEEPS_OF_STEP: usize = 4000;
/// The place of a node without an impulse.
const UNCHANGED: u32 = u32::MAX;

/// By how much two layers approach in a step \[m\], at which distance they touch \[m\], and a node of each.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Approach {
    pub(super) way: f64,
    pub(super) touching: f64,
    pub(super) nodes: [usize; 2],
}

impl Approach {
    /// The larger one, relative to the distance at which layers touch, and the first where both are alike.
    pub(super) fn max(self, other: Self) -> Self {
        if other.share() > self.share() { other } else { self }
    }

    /// Relative to the distance at which they touch; 0 without layers.
    pub(super) fn share(self) -> f64 {
        self.way / self.touching.max(f64::MIN_POSITIVE)
    }
}

/// A node with an impulse, and its u at the start of the step and at the last look at all pairs \[m/s\].
pub(super) struct Changed {
    pub(super) node: usize,
    pub(super) before: Vector3<f64>,
    looked: Vector3<f64>,
}

/// Contacts of a step, and work arrays.
#[derive(Default)]
pub(super) struct Solver {
    contacts: Vec<Contact>,
    pub(super) changed: Vec<Changed>,
    /// Of each node: its place among those, and the turn of its last change.
    places: Vec<u32>,
    turns: Vec<u64>,
    turn: u64,
    /// Sweeps in this step.
    swept: usize,
    due: Due,
    zones: Zones,
    rigid: Vec<(usize, Vector3<f64>)>,
    /// Whether pairs with an oblique gap are added, and were set aside.
    takes_oblique: bool,
    pub(super) has_late: bool,
    /// Pairs that would come too near if they did not pass by each other, or are for later.
    pub(super) set_aside: Vec<Watched>,
    /// By how much impulses move each node within the drift \[m\].
    ways: Vec<f64>,
}

impl Solver {
    pub(super) fn new(nodes: usize) -> Self {
        Self {
            places: vec![UNCHANGED; nodes],
            turns: vec![0; nodes],
            ways: vec![0.0; nodes],
            due: Due::new(nodes),
            zones: Zones::new(nodes),
            ..Self::default()
        }
    }

    /// Begins a step.
    pub(super) fn begin(&mut self) {
        self.contacts.clear();
        self.zones.clear();
        for Changed { node, .. } in self.changed.drain(..) {
            (self.places[node], self.turns[node], self.ways[node]) = (UNCHANGED, 0, 0.0);
        }
        (self.turn, self.swept, self.takes_oblique) = (0, 0, false);
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
        self.set_aside.clear();
        self.has_late = false;
        for near in near {
            while last.next_if(|(pair, _)| *pair < near.pair).is_some() {}
            if self.contacts[..known].binary_search_by_key(&near.pair, |contact| contact.pair).is_ok() {
                continue;
            }
            let is_oblique = near.is_oblique(positions, drifting);
            let Some(mut contact) = Contact::of(near, is_oblique, of, inverse_masses, drifting) else { continue };
            let is_late = is_oblique && !self.takes_oblique;
            self.has_late |= is_late;
            if is_late || !comes_too_near(near, contact.least, contact.gap_after(near, drifting), positions, drifting) {
                let listed = Listed { pair: near.pair, kept: near.kept };
                self.set_aside.push(Watched { listed, room: f64::NEG_INFINITY });
                continue;
            }
            if of.restitution > 0.0 {
                contact.rebound(of.restitution, contact.relative(drifting.own), self.before(&contact, drifting));
            }
            let way = -contact.relative(drifting.velocities).dot(&contact.normal) * drifting.dt;
            let nodes = [contact.nodes[0], contact.nodes[2]];
            largest = largest.max(Approach { way, touching: near.touching, nodes });
            if let Some((_, pressed)) = last.next_if(|(pair, _)| *pair == near.pair) {
                contact.pressed = WARM * pressed;
            }
            self.contacts.push(contact);
        }
        self.takes_oblique = true;
        if known > 0 {
            self.contacts.sort_unstable_by_key(|contact| contact.pair);
        }
        largest
    }

    /// Takes note of a look at all pairs.
    pub(super) fn look(&mut self, velocities: &NodeVectors) {
        self.changed.iter_mut().for_each(|changed| changed.looked = row(velocities, changed.node));
    }

    /// By how much impulses since the last look at all pairs move a node within the drift at most \[m\].
    pub(super) fn find_ways(&mut self, velocities: &NodeVectors, dt: f64) -> f64 {
        let mut largest = 0.0_f64;
        for &Changed { node, looked, .. } in &self.changed {
            self.ways[node] = (row(velocities, node) - looked).norm() * dt;
            largest = largest.max(self.ways[node]);
        }
        largest
    }

    /// Of watched pairs, those that these ways may bring too near.
    pub(super) fn of_changed(&self, surface: &Surface, watched: &[Watched], into: &mut Pairs) {
        into.clear();
        for &Watched { listed, room } in watched {
            let [a, b, c, d] = surface.nodes(listed.pair).map(|node| self.ways[node as usize]);
            let (first, second) = if listed.pair.has_edges() { (a.max(b), c.max(d)) } else { (a, b.max(c).max(d)) };
            if first + second > room {
                into.push(listed);
            }
        }
    }

    /// Gives the pairs their first impulses.
    fn warm(&mut self, drifting: &mut Drifting<'_>) {
        for k in 0..self.contacts.len() {
            let contact = &self.contacts[k];
            if contact.pressed > 0.0 && contact.turn == 0 {
                let impulse = contact.normal * contact.pressed;
                self.give(k, impulse, drifting);
            }
        }
    }

    /// Begins with the impulses of the last step, and sweeps over the pairs until none changes much.
    pub(super) fn solve(&mut self, of: Coefficients, drifting: &mut Drifting<'_>) {
        self.due.take_up(self.contacts.iter().map(|contact| contact.nodes));
        self.warm(drifting);
        for (k, contact) in self.contacts.iter().enumerate() {
            let is_same = contact.turn > 0 && contact.nodes.iter().all(|&node| self.turns[node] <= contact.turn);
            if !is_same {
                self.due.add(k);
            }
        }
        let has_more = of.restitution > 0.0 && self.swept < SWEEPS_OF_STEP;
        for _ in 0..MOST_SWEEPS[usize::from(has_more)] {
            self.swept += 1;
            let (mut is_settled, mut place) = (true, 0);
            while let Some(k) = self.due.take_from(place) {
                place = k + 1;
                let contact = &self.contacts[k];
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
                let least = if contact.turn == 0 { 0.0 } else { contact.settled * contact.mass };
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
            self.due.add_of(node);
            for axis in 0..3 {
                drifting.velocities[(node, axis)] += share * turned[axis];
            }
        }
        self.due.remove(k);
    }

    /// Measures fast pairs at the end of the drift. Whether one is too near.
    pub(super) fn measure_ends(
        &mut self,
        positions: &NodeVectors,
        inverse_masses: &[f64],
        drifting: &Drifting<'_>,
    ) -> bool {
        let mut is_any = false;
        for contact in &mut self.contacts {
            is_any |= contact.go_on_with_ends(positions, inverse_masses, drifting);
        }
        is_any
    }

    /// Whether there are rigid zones in this step.
    pub(super) fn has_zones(&self) -> bool {
        !self.zones.is_empty()
    }

    /// A node of each layer of the first pair that passes through in spite of all impulses.
    pub(super) fn passing(&self, positions: &NodeVectors, drifting: &Drifting<'_>) -> Option<[usize; 2]> {
        let pair = self.contacts.iter().find(|contact| contact.passes(positions, drifting))?;
        Some([pair.nodes[0], pair.nodes[2]])
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
                if contact.relative(drifting.velocities).dot(&contact.normal) < contact.limit - contact.settled {
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

    /// The relative velocity of a pair before impulses.
    fn before(&self, contact: &Contact, drifting: &Drifting<'_>) -> Vector3<f64> {
        let of = |node: usize| match self.places[node] {
            UNCHANGED => row(drifting.velocities, node),
            place => self.changed[place as usize].before,
        };
        contact.nodes.iter().zip(contact.weights).map(|(&node, weight)| of(node) * weight).sum()
    }

    /// Notes that a node changes.
    fn note(&mut self, node: usize, drifting: &Drifting<'_>) {
        if self.places[node] == UNCHANGED {
            self.places[node] = self.changed.len() as u32;
            let before = row(drifting.velocities, node);
            self.changed.push(Changed { node, before, looked: before });
        }
        self.turns[node] = self.turn;
    }

    /// The pairs with an impulse, in order.
    pub(super) fn pressed(&self, into: &mut Vec<(Pair, f64)>) {
        into.clear();
        into.extend(self.contacts.iter().filter(|c| c.pressed > 0.0).map(|c| (c.pair, c.pressed)));
    }
}
