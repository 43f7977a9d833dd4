//! Contact between layers of the film, and of cords with it: layers that cannot pass through each other.
//!
//! Layers 7.5 um apart that approach at some m/s allow no penalty: a force that stops them within such a distance is
//! stiffer than the film, and what has once passed through is pushed on. Impulses stop them instead: in the kick of
//! leapfrog and of its substeps, each pair of a node and a triangle, and of two edges, that would come too near within
//! the next drift has its velocities changed such that it does not (`solve`). They set no limit of the step, and add
//! neither force nor stiffness.
//!
//!     v_n+1/2 = (v_n + J/m) + dt/2 a_n        x_n+1 = x_n + dt v_n+1/2
//!     work    W = sum of J . (v_n + J/(2 m))  the change of kinetic energy, exactly
//!
//! The velocity of the drift includes what Coriolis adds for J. J is the sum of lam w_q n over the pairs, so that
//! momentum does not change, nor, but for friction at a distance, fast pairs (`ends`) and rigid zones in a turning
//! frame, angular momentum.
//! Layers may come as near as d_m, which differs from pair to pair:
//!
//!     d_m = eta max over some shapes of min(d, d0),   eta = 1/2
//!
//! with the distance d0 of the mid-surfaces of two layers that touch, the film's thickness, and the distances of the
//! pair in the shape at the start and after 1000, 2000, 4000, ... steps. So layers that are stowed nearer than d0 begin
//! at rest, and keep a larger distance once they have been apart. Lists (`lists`) find the pairs. All triangles are
//! checked for crossings, exactly, in regular intervals and soon after layers approach by more than d0 in a step, or
//! rigid zones: a run with a crossing is stopped. Steps use the same memory again, and allocate some only until it has
//! grown, for a shape that is kept, and in these checks.
//!
//! Bridson, Fedkiw and Anderson (SIGGRAPH 2002) and Harmon et al. (2009) have impulses and distances of layers in
//! explicit simulations of cloth.

mod contact;
mod crossed;
mod due;
mod ends;
mod first;
mod history;
mod lists;
mod look;
mod oblique;
mod pairs;
mod parameters;
mod scheme;
mod solve;
mod statistics;
mod surface;
#[cfg(test)]
mod tests;
mod zones;

use std::time::Instant as Clock;

use nalgebra::Vector3;

use self::contact::{Coefficients, Drifted, Drifting, row};
use self::lists::Lists;
use self::look::{Near, Watched, look_at};
use self::pairs::{Lines, Moving, Pairs, Step};
use self::solve::{Approach, Changed, Solver};
use self::surface::{Pair, Surface};
use super::{
    Context, Excess, HistoryDependent, Impulses, Inspection, Instant, Kernels, Law, Linearisation, Properties,
    WorkClass,
};
use crate::arrays::jacobian::JacobianBlocks;
use crate::arrays::state::{NodeVectors, State, columns, columns_mut};
use crate::error::{Error, Result};
use crate::integrators::Kick;
use crate::layout::Renumbering;
use crate::model::checks::{non_negative, positive, within};
use crate::simd::dispatch::InstructionSet;
use crate::simd::map::on_axes;

pub use self::parameters::SelfContactParameters;
pub use self::scheme::Scheme;
pub use self::statistics::ContactStatistics;

/// eta.
const SHARE: f64 = 0.5;
/// Beyond d_m, up to which a pair may have an impulse, relative to d0.
const MARGIN: f64 = 0.1;
/// The largest approach in a step, relative to d0, of a pair that meets in it.
const FASTEST: f64 = 16.0;
/// Steps after which the shape counts for the distances of pairs for the first time; then after twice as many each.
const FIRST_SHAPE: u64 = 1000;
/// Steps after one in which layers approach by more than d0, or with rigid zones, until which all triangles are checked
/// for crossings.
const SOON: u64 = 16;
/// Most rounds of looking in a step, at all pairs and at those near again, and of solving: impulses may bring others
/// near.
const MOST_ROUNDS: usize = 8;

/// The law.
pub struct SelfContact {
    surface: Surface,
    lists: Lists,
    solver: Solver,
    coefficients: Coefficients,
    /// Beyond d_m, up to which pairs are watched \[m\].
    margin: f64,
    numbering: Renumbering,
    masses: Vec<f64>,
    inverse_masses: Vec<f64>,
    instructions: InstructionSet,
    interval: u64,
    /// Steps since the start, and after how many all triangles are checked before the interval is over.
    steps: u64,
    early_check: Option<u64>,
    /// The shapes whose distances pairs keep.
    shapes: Vec<NodeVectors>,
    /// Pairs with an impulse in the last step.
    pressed: Vec<(Pair, f64)>,
    /// u, and pairs near each other.
    drift: NodeVectors,
    watched: Vec<Watched>,
    changed: Pairs,
    rest: Vec<Watched>,
    moving: Vec<Moving>,
    near: Vec<Near>,
    fault: Option<Excess>,
    statistics: ContactStatistics,
}

impl SelfContact {
    /// The law of a scene.
    ///
    /// # Errors
    /// `OutOfRange`.
    pub fn new(parameters: &SelfContactParameters, context: &Context<'_>) -> Result<Self> {
        let (assembly, scheme) = (context.assembly, parameters.scheme);
        let of_film = assembly.model.film.map_or(0.0, |film| film.thickness);
        let thickness = parameters.thickness.unwrap_or(of_film);
        if !assembly.mesh.triangles.is_empty() {
            positive("thickness of layers that touch [m]", thickness)?;
        }
        non_negative("diameter of cords that touch layers [m]", parameters.cord_thickness)?;
        non_negative("friction of layers", parameters.friction)?;
        let restitution = parameters.restitution;
        within("restitution of layers", restitution, (0.0..=1.0).contains(&restitution), "it lies between 0 and 1")?;
        let interval = parameters.crossing_interval;
        within("steps between checks for crossings", interval, interval >= 1.0, "it is at least 1")?;
        let touching = [thickness, 0.5 * (thickness + parameters.cord_thickness)];
        let surface = Surface::new(assembly, parameters.cords, touching, scheme.has_edges);
        let nodes = assembly.masses.len();
        let margin = MARGIN * surface.most_touching();
        Ok(Self {
            lists: Lists::new(&surface, SHARE, margin, nodes, assembly.instructions, scheme),
            solver: Solver::new(nodes),
            coefficients: Coefficients {
                friction: parameters.friction,
                restitution,
                share_of_depth: scheme.share_of_depth,
            },
            numbering: assembly.numbering.clone(),
            masses: assembly.masses.clone(),
            inverse_masses: assembly.inverse_masses.clone(),
            instructions: assembly.instructions,
            interval: interval as u64,
            steps: 0,
            early_check: None,
            shapes: Vec::new(),
            pressed: Vec::new(),
            drift: NodeVectors::zeros(nodes),
            watched: Vec::new(),
            changed: Pairs::default(),
            rest: Vec::new(),
            moving: Vec::new(),
            near: Vec::new(),
            fault: None,
            statistics: ContactStatistics::default(),
            margin,
            surface,
        })
    }

    /// Looks at all pairs that may come near, with u until the end of a drift.
    fn look(&mut self, positions: &NodeVectors, time: f64, dt: f64) {
        let Self { surface, lists, solver, drift, shapes, watched, near, moving, statistics, .. } = self;
        let began = Clock::now();
        solver.look(drift);
        watched.clear();
        near.clear();
        let step = Step { time, dt, positions, velocities: drift };
        let (from, nodes) = lists.at(step, surface, SHARE, shapes);
        let (listed, count) = (Clock::now(), from.iter().map(Pairs::len).sum::<usize>());
        if count > 0 {
            let lines = Lines::of(nodes, step, dt, moving);
            let of = (self.margin, self.coefficients.share_of_depth);
            look_at(surface, from, lines, of, self.instructions, watched, near);
        }
        statistics.looked_at += count as u64;
        statistics.list_time += listed - began;
        statistics.look_time += listed.elapsed();
    }

    /// Looks at those pairs again that impulses since the last look at all may bring too near.
    fn look_again(&mut self, dt: f64) {
        let Self { surface, solver, drift, watched, changed, rest, near, moving, .. } = self;
        let began = Clock::now();
        solver.of_changed(surface, watched, changed);
        rest.clear();
        near.clear();
        if changed.len() > 0 {
            let velocity = |node: usize| row(drift, node).into();
            solver.changed.iter().for_each(|changed| moving[changed.node].set_velocity(velocity(changed.node)));
            let (lines, of) = (Lines { nodes: moving, duration: dt }, (self.margin, self.coefficients.share_of_depth));
            look_at(surface, std::slice::from_ref(changed), lines, of, self.instructions, rest, near);
        }
        self.statistics.look_time += began.elapsed();
    }

    /// Takes note of a fault, if it is the first one.
    fn note_fault(&mut self, nodes: &[usize], what: impl FnOnce() -> String) {
        self.fault
            .get_or_insert_with(|| Excess { nodes: nodes.iter().map(|&node| node as u32).collect(), what: what() });
    }

    /// Gives pairs impulses until none would come too near. The largest approach in the step.
    fn give(&mut self, State { positions, velocities }: &State, time: f64, dt: f64, turn: f64) -> Approach {
        let mut fastest = Approach::default();
        self.solver.begin();
        for _ in 0..MOST_ROUNDS {
            self.look(positions, time, dt);
            for is_first in (0..MOST_ROUNDS).map(|round| round == 0) {
                let known = self.solver.len();
                let mut drifting = Drifting { velocities: &mut self.drift, own: velocities, turn, dt };
                let (of, solver) = (self.coefficients, &mut self.solver);
                let approach = solver.add(&self.near, &self.pressed, of, positions, &self.inverse_masses, &drifting);
                fastest = fastest.max(approach);
                let is_over = solver.len() == known && !solver.has_late;
                if is_first {
                    self.watched.append(&mut solver.set_aside);
                }
                if is_over {
                    return fastest;
                }
                for _ in 0..MOST_ROUNDS {
                    solver.solve(of, &mut drifting);
                    solver.stop(positions, &self.masses, &self.inverse_masses, &mut drifting);
                    if !solver.measure_ends(positions, &self.inverse_masses, &drifting) {
                        break;
                    }
                }
                // Beyond the margin a pair may come too near that was not looked at.
                if solver.find_ways(&self.drift, dt) > 0.5 * self.margin {
                    break;
                }
                self.look_again(dt);
            }
        }
        fastest
    }
}

impl Impulses for SelfContact {
    fn kick(&mut self, kick: Kick<'_>, moved: &[(usize, Vector3<f64>)]) -> Option<f64> {
        let (began, others) = (Clock::now(), self.statistics.others());
        let work = self.press(kick, moved);
        self.statistics.add_impulses(began, others);
        work
    }
}

impl SelfContact {
    /// Gives all pairs what they need in a step, and takes note of faults.
    fn press(&mut self, kick: Kick<'_>, moved: &[(usize, Vector3<f64>)]) -> Option<f64> {
        let Kick { time, dt, rate, state, accelerations, slow } = kick;
        let half = 0.5 * dt;
        let (slow, weight) = slow.unwrap_or((&*accelerations, 0.0));
        let read = [columns(&state.velocities), columns(accelerations), columns(slow)];
        let formula = Drifted { half, slow: weight };
        on_axes(self.instructions, &formula, read, [columns_mut(&mut self.drift)]);
        moved.iter().for_each(|(node, velocity)| self.drift.set_row(*node, &velocity.transpose()));
        let turn = rate * half;
        let approach = self.give(state, time, dt, turn);
        self.solver.pressed(&mut self.pressed);
        let is_rigid = self.solver.has_zones();
        self.statistics.near += self.solver.len() as u64;
        self.statistics.pressed += self.pressed.len() as u64;
        self.statistics.rigid += u64::from(is_rigid);
        if approach.share() > 1.0 || is_rigid {
            self.early_check.get_or_insert(self.steps + SOON);
        }
        if approach.share() > FASTEST {
            let (way, limit) = (approach.way, FASTEST * approach.touching);
            self.note_fault(&approach.nodes, || {
                format!("two layers approach by {way:.3e} m in a step, and may pass each other beyond {limit:.3e} m")
            });
        }
        let drifting = Drifting { velocities: &mut self.drift, own: &state.velocities, turn, dt };
        if let Some(nodes) = self.solver.passing(&state.positions, &drifting) {
            self.note_fault(&nodes, || {
                "two layers pass through each other, which impulses cannot stop: nodes of both are held or moved, or \
                 others press on"
                    .to_owned()
            });
        }
        if self.solver.changed.is_empty() {
            return None;
        }
        let mut work = 0.0;
        let scale = 1.0 / (1.0 + turn * turn);
        for &Changed { node, before, .. } in &self.solver.changed {
            let [x, y, z]: [f64; 3] = (row(&self.drift, node) - before).into();
            // The impulse itself, of which u has (I + h J).
            let change = [scale * (x - turn * y), scale * (y + turn * x), z];
            for axis in 0..3 {
                let v = &mut state.velocities[(node, axis)];
                work += self.masses[node] * change[axis] * (*v + 0.5 * change[axis]);
                *v += change[axis];
            }
            accelerations[(node, 0)] += rate * change[1];
            accelerations[(node, 1)] -= rate * change[0];
        }
        Some(work)
    }
}

impl Law for SelfContact {
    fn properties(&self) -> Properties {
        Properties {
            name: "self_contact",
            work_class: WorkClass::Dissipative,
            depends_on_velocity: false,
            is_internal: true,
        }
    }

    fn kernels(&self) -> Kernels {
        Kernels::default()
    }

    fn reach(&self, _tile: usize) -> usize {
        0
    }

    fn impulses(&mut self) -> Option<&mut dyn Impulses> {
        Some(self)
    }

    fn has_impulses(&self) -> bool {
        true
    }

    fn check_start(&self, positions: &NodeVectors) -> Result<()> {
        match self.crossed(positions) {
            Some(crossed) => Err(Error::StartsCrossed { what: self.described(&crossed) }),
            None => Ok(()),
        }
    }

    fn linearisation(&self) -> Option<&dyn Linearisation> {
        Some(self)
    }

    fn remedy_on_free_hub(&self) -> Option<&'static str> {
        Some("leave it out")
    }

    fn inspection(&self) -> Option<&dyn Inspection> {
        Some(self)
    }

    fn history_dependent(&self) -> Option<&dyn HistoryDependent> {
        Some(self)
    }

    fn history_dependent_mut(&mut self) -> Option<&mut dyn HistoryDependent> {
        Some(self)
    }

    fn remedy(&self) -> &'static str {
        "use a smaller dt, so that layers move less in a step, move none through one that is held, or leave \
         self_contact out"
    }
}

/// There are neither stiffness nor damping.
impl Linearisation for SelfContact {
    /// All layers and cords are one: pieces of the film that meet exchange momentum.
    fn visit_couplings(&self, visit: &mut dyn FnMut(&[u32])) {
        let elements = &self.surface.elements;
        elements.windows(2).for_each(|pair| visit(&[pair[0].corners, pair[1].corners].concat()));
    }

    fn add_jacobian(&self, _at: Instant<'_>, _jacobian: &mut dyn JacobianBlocks) {}
}

impl Inspection for SelfContact {
    fn first_excess(&self, _at: Instant<'_>) -> Option<Excess> {
        self.fault.clone()
    }

    fn contact_statistics(&self) -> Option<ContactStatistics> {
        Some(self.statistics)
    }
}
