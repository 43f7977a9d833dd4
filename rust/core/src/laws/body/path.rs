//! Bounds of the depth in a body, on the paths between steps.
//!
//! Depth may not exceed half of the size of the body. A path that starts and ends outside may not dip in by more than a
//! twentieth of it, so that no evaluation need have felt the contact. Paths are straight, from one check to the next; a
//! check is due once a node, or the body, has moved by a twentieth of the size since the last one. Along a path the
//! depth changes by no more than the way, so that it is followed from bound to bound.
//!
//! Only the last fault is kept in the history: positions are those of the state, from which paths start anew.

use super::contacts::{Contacts, Visitor, corners};
use crate::arrays::history::History;
use crate::arrays::state::{NodeVectors, columns};
use crate::bodies::rigid_body::Pose;
use crate::bodies::shape::Shape;
use crate::laws::{Excess, Instant};
use crate::model::mesh::{dot, sub};

/// The bound of the depth, and of that between ends that lie outside, as shares of the size.
pub(super) const DEPTH_BOUND: f64 = 0.5;
const UNFELT_BOUND: f64 = 0.05;
/// The most pieces in which a path is followed.
const MOST_PIECES: usize = 10_000;

/// The nodes of an element that went too deep, and its depth \[m\].
#[derive(Debug, Clone, PartialEq)]
struct Fault {
    nodes: Vec<u32>,
    depth: f64,
}

/// The bounds of a body, and the state at the last check.
pub(super) struct Path {
    label: &'static str,
    /// Both bounds; none in a half-space \[m\].
    bounds: Option<[f64; 2]>,
    last: Option<(NodeVectors, Vec<Pose>)>,
    passed: Option<Fault>,
    /// Work array.
    poses: Vec<Pose>,
}

impl Path {
    pub(super) fn new(label: &'static str, shape: &Shape) -> Self {
        let bounds = shape.size().map(|size| [DEPTH_BOUND * size, UNFELT_BOUND * size]);
        Self { label, bounds, last: None, passed: None, poses: Vec::new() }
    }

    /// Starts the paths.
    pub(super) fn begin(&mut self, contacts: &Contacts, at: Instant<'_>) {
        if self.last.is_none() {
            self.restart(contacts, at);
        }
    }

    /// Starts the paths anew.
    pub(super) fn restart(&mut self, contacts: &Contacts, at: Instant<'_>) {
        if self.bounds.is_some() {
            self.last = Some((at.positions.clone(), contacts.poses_at(at)));
        }
    }

    /// Checks the paths since the last check, if one is due.
    pub(super) fn accept(&mut self, contacts: &mut Contacts, at: Instant<'_>) {
        let mut poses = std::mem::take(&mut self.poses);
        contacts.body.pose(at.time, at.frame.is_frozen, &mut poses);
        self.check(contacts, at, &poses);
        self.poses = poses;
    }

    fn check(&mut self, contacts: &mut Contacts, at: Instant<'_>, poses: &[Pose]) {
        let (Some([bound, unfelt]), Some((from, old))) = (self.bounds, &mut self.last) else { return };
        let is_turned = old.iter().zip(poses).any(|(old, new)| old.direction != new.direction);
        let reach = if is_turned { 2.0 * (at.positions.amax() + poses[0].distance()) } else { 0.0 };
        let way = old.iter().zip(poses).map(|(old, new)| old.shift(new, reach)).fold(0.0, f64::max);
        if way < unfelt && !contacts.has_moved(from, at.positions, unfelt - way) {
            return;
        }
        contacts.update(at);
        let mut search = Search { shape: contacts.shape, from, old, poses, bound, unfelt, way, found: None };
        // Paths between two states at which the list holds meet no other element.
        if contacts.is_listed(from, old) {
            contacts.visit_all(at.positions, poses, &mut search);
        } else {
            contacts.visit_each(at.positions, poses.len(), &mut search);
        }
        self.passed = self.passed.take().or(search.found);
        from.copy_from(at.positions);
        old.clear();
        old.extend_from_slice(poses);
    }

    pub(super) fn is_at_fault(&self) -> bool {
        self.passed.is_some()
    }

    /// The first element beyond the bound.
    pub(super) fn first_excess(&self, contacts: &Contacts, at: Instant<'_>) -> Option<Excess> {
        let [bound, unfelt] = self.bounds?;
        let Fault { nodes, depth } = self.passed.clone().or_else(|| {
            let poses = contacts.poses_at(at);
            let mut deep = Deep { shape: contacts.shape, poses: &poses, bound, found: None };
            contacts.visit_all(at.positions, &poses, &mut deep);
            deep.found
        })?;
        let element = match nodes.len() {
            1 => "a node",
            2 => "an edge",
            _ => "a triangle",
        };
        let label = self.label;
        let what = format!(
            "{element} goes {depth:.4e} m deep into {label}, over its bound of {bound:.4e} m for one in contact and \
             {unfelt:.4e} m within a step, and may come out on another side"
        );
        Some(Excess { nodes, what })
    }

    /// Depth and nodes of the element at fault.
    pub(super) fn history(&self) -> History {
        let numbers = self.passed.as_ref().map_or_else(Vec::new, |Fault { nodes, depth }| {
            [*depth].into_iter().chain(nodes.iter().map(|&node| f64::from(node))).collect()
        });
        History { vectors: Vec::new(), numbers }
    }

    /// Continues from a history. Whether it fits.
    pub(super) fn restore(&mut self, history: History) -> bool {
        (self.last, self.passed) = (None, None);
        let count = u32::MAX;
        let is_node = |node: &f64| node.fract() == 0.0 && (0.0..f64::from(count)).contains(node);
        match history.numbers.split_first() {
            None => history.vectors.is_empty(),
            Some((depth, nodes)) if (1..=3).contains(&nodes.len()) && nodes.iter().all(is_node) => {
                self.passed = Some(Fault { nodes: nodes.iter().map(|&node| node as u32).collect(), depth: *depth });
                history.vectors.is_empty()
            }
            Some(_) => false,
        }
    }
}

/// Looks for an element beyond the bound.
struct Deep<'a> {
    shape: Shape,
    poses: &'a [Pose],
    bound: f64,
    found: Option<Fault>,
}

impl Visitor for Deep<'_> {
    fn visit<const K: usize>(&mut self, nodes: [u32; K], corners: &[[f64; 3]; K], copy: usize) {
        if self.found.is_none() {
            let depth = self.shape.depth(&self.poses[copy], corners);
            self.found = (depth > self.bound).then(|| Fault { nodes: nodes.to_vec(), depth });
        }
    }
}

/// Looks for an element with a path beyond a bound.
struct Search<'a> {
    shape: Shape,
    from: &'a NodeVectors,
    old: &'a [Pose],
    poses: &'a [Pose],
    bound: f64,
    unfelt: f64,
    /// Of the body \[m\].
    way: f64,
    found: Option<Fault>,
}

impl Visitor for Search<'_> {
    fn visit<const K: usize>(&mut self, nodes: [u32; K], to: &[[f64; 3]; K], copy: usize) {
        if self.found.is_some() {
            return;
        }
        let from = corners(columns(self.from), nodes);
        let moved = (0..K).map(|k| dot(sub(to[k], from[k]), sub(to[k], from[k])).sqrt()).fold(0.0, f64::max);
        let way = self.way + moved;
        let depth_at = |share: f64| {
            let corners: [_; K] = std::array::from_fn(|k| between(from[k], to[k], share));
            self.shape.depth(&pose_between(&self.old[copy], &self.poses[copy], share), &corners)
        };
        let end = depth_at(1.0);
        if end + way <= self.unfelt {
            return;
        }
        let start = depth_at(0.0);
        let limit = if start <= 0.0 && end <= 0.0 { self.unfelt } else { self.bound };
        // The largest depth that a path of this length can have between these ends.
        if 0.5 * (start + end + way) <= limit {
            return;
        }
        let mut share = 0.0;
        for _ in 0..MOST_PIECES {
            let depth = depth_at(share);
            if depth > limit {
                self.found = Some(Fault { nodes: nodes.to_vec(), depth });
                return;
            }
            if share >= 1.0 {
                return;
            }
            share = (share + ((limit - depth) / way).max(1e-3)).min(1.0);
        }
    }
}

fn between(a: [f64; 3], b: [f64; 3], share: f64) -> [f64; 3] {
    [0, 1, 2].map(|axis| a[axis] + share * (b[axis] - a[axis]))
}

fn pose_between(a: &Pose, b: &Pose, share: f64) -> Pose {
    let direction = between(a.direction, b.direction, share);
    let length = dot(direction, direction).sqrt();
    let direction = if length > 0.0 { direction.map(|component| component / length) } else { b.direction };
    Pose { centre: between(a.centre, b.centre, share), direction, ..*b }
}
