//! Laws and masses, as an integrator sees them.

use std::ops::Range;

use super::damped_springs::add_between_nodes;
use crate::arrays::blocks::ROW_BLOCK;
use crate::arrays::state::{Instant, NodeVectors, columns, rows, rows_mut};
use crate::integrators::{Integrator, RateGroup, System};
use crate::laws::Law;
use crate::linear::tangent::{Tangent, Weights};
use crate::simd::dispatch::InstructionSet;
use crate::simd::lanes::SimdF64;
use crate::simd::map::{Add, Formula, each, on_axes};

/// The laws and masses.
pub(crate) struct Mechanics {
    pub(crate) laws: Vec<Box<dyn Law>>,
    pub(crate) masses: Vec<f64>,
    pub(crate) inverse_masses: Vec<f64>,
    pub(crate) evaluation_count: u64,
    /// Where the method is implicit.
    pub(crate) tangent: Option<Tangent>,
    /// The forces between nodes \[N\]; zero but from `accumulate_forces` to `accelerations`.
    forces: NodeVectors,
    /// Laws without a potential whose power the method asks for later: those that caches_forces their last evaluation.
    cached: Vec<bool>,
    /// And the forces of the others \[N\]: all rows of a law between nodes, zero but from `accumulate_forces` to `power_at`; those of
    /// one stretch of a law node by node, where these are recomputed at once.
    resistances: Vec<Option<NodeVectors>>,
    /// Whether each law is slow, and whether evaluations take it now.
    pub(crate) is_slow: Vec<bool>,
    taken: Vec<bool>,
    rate_group: Option<RateGroup>,
    width: InstructionSet,
}

impl Mechanics {
    /// As `method` needs them.
    pub(crate) fn new(
        mut laws: Vec<Box<dyn Law>>,
        masses: Vec<f64>,
        inverse_masses: Vec<f64>,
        tangent: Option<Tangent>,
        method: &dyn Integrator,
        width: InstructionSet,
    ) -> Self {
        let nodes = masses.len();
        let is_asked = |law: &dyn Law| method.evaluates_elsewhere() && !law.is_conservative();
        // Laws that are told apart are recomputed together, after all are finished.
        let is_at_once = method.for_slow_laws().is_none();
        let cached: Vec<bool> = laws.iter_mut().map(|law| is_asked(law.as_ref()) && law.caches_forces()).collect();
        let resistance = |law: &dyn Law, is_remembered: bool| {
            let count = if is_at_once && law.nodal().is_some() { ROW_BLOCK.min(nodes) } else { nodes };
            (is_asked(law) && !is_remembered).then(|| NodeVectors::zeros(count))
        };
        let rows = laws.iter().zip(&cached);
        Self {
            resistances: rows.map(|(law, &is_remembered)| resistance(law.as_ref(), is_remembered)).collect(),
            cached,
            is_slow: vec![false; laws.len()],
            taken: vec![true; laws.len()],
            rate_group: None,
            laws,
            masses,
            inverse_masses,
            evaluation_count: 0,
            tangent,
            forces: NodeVectors::zeros(nodes),
            width,
        }
    }
}

/// Forces to accelerations; the forces are zero then.
struct Divide;

impl Formula<1, 2> for Divide {
    #[inline(always)]
    fn row<V: SimdF64>(&self, [inverse_mass]: [V; 1], [_, force]: [V; 2]) -> [V; 2] {
        [force * inverse_mass, V::zero()]
    }
}

/// F . v.
struct Power;

impl Formula<6, 0> for Power {
    #[inline(always)]
    fn row<V: SimdF64>(&self, _: [V; 6], _: [V; 0]) -> [V; 0] {
        []
    }

    #[inline(always)]
    fn summand<V: SimdF64>(&self, [fx, fy, fz, vx, vy, vz]: [V; 6], _: [V; 0]) -> V {
        fx * vx + fy * vy + fz * vz
    }
}

/// Where the rows of a stretch are in a resistance, which has those of all nodes or of one stretch.
fn place_of(range: &Range<usize>, resistance: &NodeVectors, nodes: usize) -> Range<usize> {
    if resistance.nrows() < nodes { 0..range.len() } else { range.clone() }
}

/// The sum of F . v over some rows \[W\].
fn power_of(width: InstructionSet, [fx, fy, fz]: [&[f64]; 3], [u, v, w]: [&[f64]; 3]) -> f64 {
    each(width, &Power, [fx, fy, fz, u, v, w], [])
}

impl System for Mechanics {
    fn select_rate_group(&mut self, group: RateGroup) {
        self.rate_group = Some(group);
        for (taken, is_slow) in self.taken.iter_mut().zip(&self.is_slow) {
            *taken = *is_slow == (group == RateGroup::Slow);
        }
    }

    fn accumulate_forces(&mut self, tile: usize, at: Instant<'_>, powers: &mut [f64]) {
        if tile == 0 {
            powers.fill(0.0);
            // Where laws are told apart, evaluations of the fast ones count.
            self.evaluation_count += u64::from(self.rate_group != Some(RateGroup::Slow));
        }
        let (forces, taken) = (&mut self.forces, &self.taken);
        add_between_nodes(&self.laws, |row| taken[row], tile, at, forces, powers, &mut self.resistances);
        // What `power_at` adds later. That of laws node by node is added row by row, between the tiles.
        for (row, power) in powers.iter_mut().enumerate() {
            if self.cached[row] || (self.resistances[row].is_some() && self.laws[row].nodal().is_none()) {
                *power = 0.0;
            }
        }
    }

    fn accelerations(
        &mut self,
        range: Range<usize>,
        at: Instant<'_>,
        accelerations: [&mut [f64]; 3],
        powers: &mut [f64],
    ) {
        let width = self.width;
        for (((law, resistance), power), _) in
            self.laws.iter().zip(&mut self.resistances).zip(powers).zip(&self.taken).filter(|(_, taken)| **taken)
        {
            let forces = rows_mut(&mut self.forces, range.clone());
            match (law.nodal(), resistance) {
                (Some(law), None) => *power += law.add_to_rows(range.clone(), at, forces),
                (Some(law), Some(resistance)) => {
                    let own = place_of(&range, resistance, self.masses.len());
                    rows_mut(resistance, own.clone()).into_iter().for_each(|column| column.fill(0.0));
                    law.add_to_rows(range.clone(), at, rows_mut(resistance, own.clone()));
                    on_axes(width, &Add, [rows(resistance, own)], [forces]);
                }
                (None, Some(resistance)) => on_axes(width, &Add, [rows(resistance, range.clone())], [forces]),
                (None, None) => {}
            }
        }
        let inverse_masses = &self.inverse_masses[range.clone()];
        on_axes(width, &Divide, [[inverse_masses; 3]], [accelerations, rows_mut(&mut self.forces, range)]);
    }

    fn row_power_at(&mut self, range: Range<usize>, velocities: [&[f64]; 3], powers: &mut [f64]) {
        for (((law, resistance), power), _) in
            self.laws.iter().zip(&self.resistances).zip(powers).zip(&self.taken).filter(|(_, taken)| **taken)
        {
            if let (Some(_), Some(resistance)) = (law.nodal(), resistance) {
                let forces = rows(resistance, place_of(&range, resistance, self.masses.len()));
                *power += power_of(self.width, forces, velocities);
            }
        }
    }

    fn power_at(&mut self, at: Instant<'_>, powers: &mut [f64]) {
        for (row, (law, resistance)) in self.laws.iter().zip(&mut self.resistances).enumerate() {
            if !self.taken[row] {
                continue;
            }
            if self.cached[row] {
                powers[row] += law.power_at(at);
            } else if let (None, Some(resistance)) = (law.nodal(), resistance) {
                powers[row] += power_of(self.width, columns(resistance), columns(at.velocities));
                resistance.fill(0.0);
            }
        }
    }

    fn factorise(&mut self, at: Instant<'_>, weights: Weights) -> bool {
        let Some(tangent) = &mut self.tangent else { return false };
        tangent.assemble(&self.laws, &self.masses, at, weights);
        tangent.factorise()
    }

    fn solve(&mut self, accelerations: &mut NodeVectors) {
        if let Some(tangent) = &mut self.tangent {
            tangent.solve(&self.masses, accelerations);
        }
    }

    fn coriolis_rate(&self, time: f64) -> f64 {
        self.laws.iter().map(|law| law.coriolis_rate(time)).sum()
    }
}
