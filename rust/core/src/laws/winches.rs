//! Cords whose length changes with time: segments of the unstretched length r(t) = f(t) r_1, f a schedule \[-\].
//!
//! As any cord it bears tension alone. Its axial stiffness EA stays; segments become stiffer as they become shorter:
//!
//!     N = EA max(l - r, 0) / r   [N],     U = EA max(l - r, 0)^2 / (2 r)   [J]
//!
//! U depends on time. Its partial derivative, with the strain e = max(l - r, 0)/r,
//!
//!     dU/dt = -EA (e + e^2/2) r'   [W]
//!
//! is the power of the winch: the tension times the speed of hauling, and the elastic energy of the length hauled in.
//! Where r' jumps no step crosses, so that the work has the order of the method. What a jump of r changes of U is
//! recorded as a change (`simulation::jumps`). The masses of the nodes stay as they are.

use super::segments::{Ends, Segments};
use super::{Excess, Inspection, Instant, Kernels, Law, Linearisation, LinkReadings, Properties, WorkClass};
use crate::arrays::jacobian::{Block, JacobianBlocks, at, of_link};
use crate::arrays::state::NodeVectors;
use crate::assembly::Assembly;
use crate::model::input::Cord;
use crate::model::schedule::Schedule;

/// The law.
pub(super) struct Winches {
    segments: Segments<Segment>,
    schedules: Vec<Schedule>,
    /// The smallest value of each schedule.
    least: Vec<f64>,
}

/// A segment.
struct Segment {
    /// Internal numbers, the lower one first.
    nodes: [u32; 2],
    /// Its place among those of the scene that have a winch.
    place: usize,
    /// EA \[N\].
    axial_stiffness: f64,
    /// r_1 \[m\].
    length: f64,
    strain_limit: f64,
    /// The number of its schedule.
    winch: usize,
}

/// Unstretched length over that at f = 1, and its rate \[1/s\].
type Hauled = [f64; 2];

impl Ends for Segment {
    fn ends(&self) -> [u32; 2] {
        self.nodes
    }
}

impl Segment {
    /// Its length without load \[m\].
    fn rest(&self, hauled: &[Hauled]) -> f64 {
        self.length * hauled[self.winch][0]
    }

    /// Strain, 0 where it is slack, of a length \[m\].
    fn strain(&self, hauled: &[Hauled], l: f64) -> f64 {
        let rest = self.rest(hauled);
        (l - rest).max(0.0) / rest
    }

    /// Its length \[m\].
    fn span(&self, positions: &NodeVectors) -> f64 {
        (at(positions, self.nodes[1]) - at(positions, self.nodes[0])).norm()
    }

    /// The derivative of the force by the difference of its ends at the tension N = EA e, which changes by `stiffness`
    /// along it \[N/m\].
    fn derivative(&self, positions: &NodeVectors, tension: f64, stiffness: f64) -> Block {
        let d = at(positions, self.nodes[1]) - at(positions, self.nodes[0]);
        let l = d.norm().max(1e-12 * self.length);
        let per_length = tension / l;
        d * d.transpose() * ((stiffness - per_length) / (l * l)) + Block::identity() * per_length
    }
}

impl Winches {
    /// The law of the cords of a scene that have a winch; `None` without one.
    pub(super) fn new(assembly: &Assembly) -> Option<Self> {
        let model = &assembly.model;
        let wound = model.cords.iter().filter_map(|cord| Some((cord, cord.winch?)));
        let of_cord = |(place, (cord, winch)): (usize, (&Cord, usize))| {
            let [a, b] = assembly.numbering.to_internal(cord.nodes);
            let (axial_stiffness, length) = (cord.stiffness * cord.rest_length, cord.rest_length);
            let nodes = [a.min(b), a.max(b)];
            Segment { nodes, place, axial_stiffness, length, strain_limit: cord.strain_limit, winch }
        };
        let segments: Vec<Segment> = wound.enumerate().map(of_cord).collect();
        let is_none = segments.is_empty();
        let least = |f: &Schedule| f.values().iter().copied().fold(f64::INFINITY, f64::min);
        let own = Self {
            segments: Segments::new(segments, assembly.masses.len()),
            schedules: model.winches.clone(),
            least: model.winches.iter().map(least).collect(),
        };
        (!is_none).then_some(own)
    }

    fn hauled(&self, at: Instant<'_>) -> Vec<Hauled> {
        let rate = |schedule: &Schedule| if at.frame.is_frozen { 0.0 } else { schedule.rate(at.time) };
        self.schedules.iter().map(|schedule| [schedule.value(at.time), rate(schedule)]).collect()
    }

    /// Each segment, in the order of the scene, with its strain, negative where it is slack.
    fn strains(&self, at: Instant<'_>) -> Vec<(&Segment, f64)> {
        let hauled = self.hauled(at);
        let strain = |segment: &Segment| segment.span(at.positions) / segment.rest(&hauled) - 1.0;
        let mut found: Vec<_> = self.segments.all().iter().map(|segment| (segment, strain(segment))).collect();
        found.sort_by_key(|(segment, _)| segment.place);
        found
    }
}

impl Law for Winches {
    fn properties(&self) -> Properties {
        let work_class = WorkClass::Conservative;
        Properties { name: "winches", work_class, depends_on_velocity: false, is_internal: true }
    }

    fn kernels(&self) -> Kernels {
        Kernels::of_elements()
    }

    fn reach(&self, tile: usize) -> usize {
        self.segments.reach(tile)
    }

    fn add_to_tile(&mut self, tile: usize, instant: Instant<'_>, forces: &mut NodeVectors) -> f64 {
        let hauled = self.hauled(instant);
        let mut power = 0.0;
        for segment in self.segments.of_tile(tile) {
            let [a, b] = segment.nodes;
            let d = at(instant.positions, b) - at(instant.positions, a);
            let l = d.norm();
            let strain = segment.strain(&hauled, l);
            if strain > 0.0 {
                let force = d * (segment.axial_stiffness * strain / l);
                for k in 0..3 {
                    forces[(a as usize, k)] += force[k];
                    forces[(b as usize, k)] -= force[k];
                }
                let rate = segment.length * hauled[segment.winch][1];
                power -= segment.axial_stiffness * strain * (1.0 + 0.5 * strain) * rate;
            }
        }
        power
    }

    fn energy(&self, at: Instant<'_>) -> f64 {
        let hauled = self.hauled(at);
        let of_segment = |segment: &Segment| {
            let strain = segment.strain(&hauled, segment.span(at.positions));
            0.5 * segment.axial_stiffness * strain * strain * segment.rest(&hauled)
        };
        self.segments.all().iter().map(of_segment).sum()
    }

    fn jumps(&self) -> Vec<f64> {
        self.schedules.iter().flat_map(Schedule::breaks).collect()
    }

    fn linearisation(&self) -> Option<&dyn Linearisation> {
        Some(self)
    }

    fn inspection(&self) -> Option<&dyn Inspection> {
        Some(self)
    }

    fn remedy(&self) -> &'static str {
        "haul the cord in more slowly or with more easing, or use a smaller dt"
    }
}

impl Linearisation for Winches {
    /// With every segment taut, and as short without load as it will be, when it is stiffest.
    fn add_stiffness_product(&self, instant: Instant<'_>, p: &NodeVectors, out: &mut NodeVectors) {
        let hauled = self.hauled(instant);
        for segment in self.segments.all() {
            let [a, b] = segment.nodes;
            let strain = segment.strain(&hauled, segment.span(instant.positions));
            let stiffest = segment.axial_stiffness / (segment.length * self.least[segment.winch]);
            let derivative = segment.derivative(instant.positions, segment.axial_stiffness * strain, stiffest);
            let product = derivative * (at(p, b) - at(p, a));
            for k in 0..3 {
                out[(a as usize, k)] -= product[k];
                out[(b as usize, k)] += product[k];
            }
        }
    }

    fn visit_couplings(&self, visit: &mut dyn FnMut(&[u32])) {
        self.segments.all().iter().for_each(|segment| visit(&segment.nodes));
    }

    fn add_jacobian(&self, instant: Instant<'_>, jacobian: &mut dyn JacobianBlocks) {
        let hauled = self.hauled(instant);
        for segment in self.segments.all() {
            let strain = segment.strain(&hauled, segment.span(instant.positions));
            if strain > 0.0 {
                let stiffness = segment.axial_stiffness / segment.rest(&hauled);
                let derivative = segment.derivative(instant.positions, segment.axial_stiffness * strain, stiffness);
                of_link(segment.nodes, &derivative, |i, j, block| jacobian.by_position(i, j, block));
            }
        }
    }
}

impl Inspection for Winches {
    fn first_excess(&self, at: Instant<'_>) -> Option<Excess> {
        let (segment, strain) =
            self.strains(at).into_iter().find(|(segment, strain)| *strain > segment.strain_limit)?;
        let (percent, bound) = (100.0 * strain, 100.0 * segment.strain_limit);
        let what = format!(
            "a segment of {:.4e} m before hauling is stretched by {percent:.3} %, over its bound of {bound:.3} %",
            segment.length
        );
        Some(Excess { nodes: segment.nodes.to_vec(), what })
    }

    fn links(&self, at: Instant<'_>) -> Option<LinkReadings> {
        let found = self.strains(at);
        Some(LinkReadings {
            strain: found.iter().map(|&(_, strain)| strain).collect(),
            tension: found.iter().map(|(segment, strain)| segment.axial_stiffness * strain.max(0.0)).collect(),
            buckled: found.iter().map(|&(_, strain)| strain < 0.0).collect(),
        })
    }
}
