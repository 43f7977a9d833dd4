//! Nodes with a prescribed motion in the turning frame: schedules of a displacement d and a turn theta about the axis,
//!
//!     x(t) = R_z(theta) a + d,    v = theta' J R_z a + d',    x'' = (theta'' J - theta'^2) R_z a + d''
//!
//! with J (x, y) = (-y, x) and no part of z. The anchor a of a node makes x(t) its position at the start, whatever the
//! schedules are there. The force R = m x'' - F that moves a node, F that of all other laws, does the work R . v, which
//! is the work of this law. `evaluation::mechanics` adds its power and the prescribed accelerations to each evaluation,
//! so that stages are consistent with the order of the method; at the end of a step the nodes are set to the prescribed
//! motion. What that changes of their kinetic energy is work too: that of the impulse where a velocity jumps. Where a
//! schedule jumps, a node is displaced; its velocity is that of the schedules before and after.

use std::ops::Range;

use nalgebra::{RowVector3, Vector3};

use super::{HistoryDependent, Instant, Kernels, Law, Properties, WorkClass};
use crate::arrays::history::History;
use crate::arrays::state::NodeVectors;
use crate::assembly::Assembly;
use crate::model::input::Motion;
use crate::model::schedule::Schedule;

/// The law: prescribed motions, and the nodes that follow them.
pub struct Moved {
    motions: Vec<Motion>,
    /// Node, in internal order, ascending, and number of its motion.
    nodes: Vec<(usize, usize)>,
    /// Anchors of all nodes \[m\], zero for others; `None` before the start.
    anchors: Option<NodeVectors>,
    node_count: usize,
}

/// Position \[m\], velocity \[m/s\] and acceleration \[m/s2\] of a node.
pub(crate) struct Prescribed {
    pub(crate) position: Vector3<f64>,
    pub(crate) velocity: Vector3<f64>,
    pub(crate) acceleration: Vector3<f64>,
}

/// A prescribed motion at an instant: turn and displacement, with two derivatives.
#[derive(Clone, Copy)]
pub(crate) struct Pose {
    /// Cosine and sine of theta, theta' and theta''.
    turn: [f64; 4],
    displacement: [Vector3<f64>; 3],
}

impl Pose {
    fn of(motion: &Motion, time: f64, is_frozen: bool) -> Self {
        let at = |schedule: &Option<Schedule>| match schedule {
            Some(schedule) if is_frozen => [schedule.value(time), 0.0, 0.0],
            Some(schedule) => [schedule.value(time), schedule.rate(time), schedule.second(time)],
            None => [0.0; 3],
        };
        let ([angle, rate, second], along) = (at(&motion.turn), motion.displacement.each_ref().map(at));
        let (sine, cosine) = angle.sin_cos();
        let displacement = [0, 1, 2].map(|k| Vector3::from(along.map(|of_axis| of_axis[k])));
        Self { turn: [cosine, sine, rate, second], displacement }
    }

    fn anchor(&self, position: Vector3<f64>) -> Vector3<f64> {
        let ([cosine, sine, ..], x) = (self.turn, position - self.displacement[0]);
        Vector3::new(cosine * x.x + sine * x.y, cosine * x.y - sine * x.x, x.z)
    }

    fn prescribed(&self, anchor: Vector3<f64>) -> Prescribed {
        let [cosine, sine, rate, second] = self.turn;
        let (x, y) = (cosine * anchor.x - sine * anchor.y, cosine * anchor.y + sine * anchor.x);
        let [d, d_rate, d_second] = self.displacement;
        Prescribed {
            position: Vector3::new(x, y, anchor.z) + d,
            velocity: Vector3::new(-rate * y, rate * x, 0.0) + d_rate,
            acceleration: Vector3::new(-second * y - rate * rate * x, second * x - rate * rate * y, 0.0) + d_second,
        }
    }
}

impl Moved {
    /// The law of the moved nodes of a scene.
    pub(super) fn new(assembly: &Assembly) -> Self {
        let motions = assembly.model.motions.clone();
        let mut nodes = Vec::new();
        for (number, motion) in motions.iter().enumerate() {
            let internal = motion.nodes.iter().map(|&node| assembly.numbering.to_internal([node])[0]);
            nodes.extend(internal.map(|node| (node as usize, number)));
        }
        nodes.sort_unstable();
        Self { motions, nodes, anchors: None, node_count: assembly.masses.len() }
    }

    /// Whether the nodes have anchors.
    pub(crate) fn is_anchored(&self) -> bool {
        self.anchors.is_some()
    }

    /// Anchors the nodes where they are.
    pub(crate) fn anchor(&mut self, at: Instant<'_>) {
        let mut anchors = NodeVectors::zeros(self.node_count);
        let poses = self.poses(at.time, at.frame.is_frozen);
        for &(node, motion) in &self.nodes {
            let anchor = poses[motion].anchor(at.positions.row(node).transpose());
            anchors.set_row(node, &anchor.transpose());
        }
        self.anchors = Some(anchors);
    }

    /// The motions at a time \[s\].
    pub(crate) fn poses(&self, time: f64, is_frozen: bool) -> Vec<Pose> {
        self.motions.iter().map(|motion| Pose::of(motion, time, is_frozen)).collect()
    }

    fn places(&self, rows: Range<usize>) -> Range<usize> {
        let place = |node: usize| self.nodes.partition_point(|&(other, _)| other < node);
        place(rows.start)..place(rows.end)
    }

    /// The nodes, internal numbers.
    pub(crate) fn nodes(&self) -> impl Iterator<Item = usize> {
        self.nodes.iter().map(|&(node, _)| node)
    }

    /// Whether a node of these rows moves as prescribed.
    pub(crate) fn has_nodes_in(&self, rows: Range<usize>) -> bool {
        !self.places(rows).is_empty()
    }

    /// The prescribed motion of the nodes in these rows, by the motions at an instant.
    pub(crate) fn prescribed(&self, poses: &[Pose], rows: Range<usize>) -> impl Iterator<Item = (usize, Prescribed)> {
        self.nodes[self.places(rows)].iter().map(move |&(node, motion)| {
            let none = RowVector3::zeros();
            let anchor = self.anchors.as_ref().map_or(none, |anchors| anchors.row(node).into_owned());
            (node, poses[motion].prescribed(anchor.transpose()))
        })
    }
}

impl Law for Moved {
    fn properties(&self) -> Properties {
        Properties { name: "moved", work_class: WorkClass::External, depends_on_velocity: false, is_internal: false }
    }

    fn kernels(&self) -> Kernels {
        Kernels::default()
    }

    fn jumps(&self) -> Vec<f64> {
        let schedules = self.motions.iter().flat_map(|motion| motion.displacement.iter().chain([&motion.turn]));
        schedules.flatten().flat_map(Schedule::jumps).collect()
    }

    fn moved(&self) -> Option<&Moved> {
        Some(self)
    }

    fn moved_mut(&mut self) -> Option<&mut Moved> {
        Some(self)
    }

    fn history_dependent(&self) -> Option<&dyn HistoryDependent> {
        Some(self)
    }

    fn history_dependent_mut(&mut self) -> Option<&mut dyn HistoryDependent> {
        Some(self)
    }

    fn remedy_on_free_hub(&self) -> Option<&'static str> {
        Some("move bodies in place of nodes")
    }

    fn remedy(&self) -> &'static str {
        "check the schedules of the moved nodes: move them less, over a longer time, or with more easing"
    }
}

/// The anchors, so that a motion goes on with the same bits.
impl HistoryDependent for Moved {
    fn accept(&mut self, _at: Instant<'_>) {}

    fn history(&self) -> History {
        History { vectors: self.anchors.iter().cloned().collect(), numbers: Vec::new() }
    }

    fn restore_history(&mut self, history: History) -> bool {
        let History { mut vectors, numbers } = history;
        let fits = numbers.is_empty() && vectors.len() <= 1 && vectors.iter().all(|all| all.nrows() == self.node_count);
        if fits {
            self.anchors = vectors.pop();
        }
        fits
    }
}
