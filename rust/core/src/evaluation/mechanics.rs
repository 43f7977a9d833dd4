//! Laws and masses as the system of equations of a method.

use std::ops::Range;

use super::deferral::{Deferral, place_of, power_of, steady_loads};
use super::free_pieces::FreePieces;
use super::ledger::{EnergyTerms, Scope};
use super::plan::{Plan, Sums};
use crate::arrays::state::{NodeVectors, PhasePoint, State, columns, rows, rows_mut};
use crate::integrators::{Integrator, Kick, NetForces, RateGroup, System};
use crate::laws::{Instant, Law, Moved, WorkClass};
use crate::linear::tangent::{Tangent, Weights};
use crate::model::frame::Spin;
use crate::model::hub::Hub;
use crate::model::hub_motion::HubMotion;
use crate::model::load::Load;
use crate::simd::dispatch::InstructionSet;
use crate::simd::lanes::SimdF64;
use crate::simd::map::{Add, Formula, on_axes};

/// Laws, masses, and the motion of the frame.
pub struct Mechanics {
    pub(crate) laws: Vec<Box<dyn Law>>,
    pub(crate) spin: Spin,
    pub(crate) masses: Vec<f64>,
    pub(crate) inverse_masses: Vec<f64>,
    /// By which net forces become accelerations: 1/m, 0 for held nodes, 1 for moved ones.
    factors: Vec<f64>,
    pub(crate) evaluation_count: u64,
    pub(crate) pieces: FreePieces,
    plan: Plan,
    /// For an implicit method.
    tangent: Option<Tangent>,
    /// The forces between nodes \[N\]; zero except between `accumulate_forces` and the end of a row block.
    pub(super) forces: NodeVectors,
    /// Of each law with deferred power.
    deferrals: Vec<Option<Deferral>>,
    /// Whether each law is slow, and whether the selected rate group has it.
    is_slow: Vec<bool>,
    pub(super) is_selected: Vec<bool>,
    pub(super) rate_group: Option<RateGroup>,
    expects_power_at: bool,
    pub(super) instructions: InstructionSet,
    /// The laws with a history.
    pub(super) history_dependent: Vec<usize>,
    /// The law of the nodes that move as prescribed.
    pub(super) moved: Option<usize>,
    /// The loads from outside: those evaluated tile by tile, and nodal laws.
    pub(super) outside: [Vec<usize>; 2],
    /// Those of each law from outside about the origin in the last evaluation, where the hub is free.
    pub(super) outside_loads: Vec<Load>,
    /// The law that acts by impulses.
    pub(super) impulsive: Option<usize>,
    /// The loads that do not depend on velocity.
    pub(super) steady_loads: Vec<usize>,
    /// The law of the frame, where the hub is free, and the nodes held on it.
    pub(crate) hub_row: Option<usize>,
    pub(super) held: Vec<usize>,
}

impl Mechanics {
    /// The system for a method.
    pub(crate) fn new(
        mut laws: Vec<Box<dyn Law>>,
        spin: Spin,
        masses: Vec<f64>,
        inverse_masses: Vec<f64>,
        tangent: Option<Tangent>,
        method: &dyn Integrator,
        instructions: InstructionSet,
    ) -> Self {
        let nodes = masses.len();
        let deferrals = Deferral::of_laws(&mut laws, method, nodes);
        let is_separate: Vec<bool> = deferrals.iter().map(|own| matches!(own, Some(Deferral::Forces(_)))).collect();
        let history_dependent = (0..laws.len()).filter(|&row| laws[row].history_dependent().is_some()).collect();
        let mut factors = inverse_masses.clone();
        laws.iter().filter_map(|law| law.moved()).flat_map(Moved::nodes).for_each(|node| factors[node] = 1.0);
        let outside = [false, true].map(|is_nodal| {
            let is_own = |law: &mut Box<dyn Law>| law.outside_load().is_some() && law.nodal().is_some() == is_nodal;
            laws.iter_mut().enumerate().filter_map(|(row, law)| is_own(law).then_some(row)).collect()
        });
        let hub_row = spin.hub.as_ref().and_then(|_| laws.iter().position(|law| law.is_frame()));
        let mut is_selected = vec![true; laws.len()];
        hub_row.iter().for_each(|&row| is_selected[row] = false);
        Self {
            outside,
            outside_loads: vec![Load::default(); laws.len()],
            hub_row,
            held: (0..nodes).filter(|&node| inverse_masses[node] == 0.0).collect(),
            history_dependent,
            moved: laws.iter().position(|law| law.moved().is_some()),
            steady_loads: steady_loads(&laws),
            impulsive: laws.iter().position(|law| law.has_impulses()),
            pieces: FreePieces::new(&laws, &inverse_masses),
            plan: Plan::with(&mut laws, &is_separate),
            deferrals,
            is_slow: vec![false; laws.len()],
            is_selected,
            rate_group: None,
            expects_power_at: true,
            laws,
            spin,
            masses,
            inverse_masses,
            factors,
            evaluation_count: 0,
            tangent,
            forces: NodeVectors::zeros(nodes),
            instructions,
        }
    }

    /// Adds the forces \[N\] of one law, and returns its power \[W\].
    pub(crate) fn add_forces_of(&mut self, row: usize, at: Instant<'_>, forces: &mut NodeVectors) -> f64 {
        let mut powers = vec![0.0; self.laws.len()];
        self.plan.add_selected(&mut self.laws, |other| other == row, at, forces, &mut powers);
        powers[row]
    }

    /// Sets the slow laws. Laws along links are slow together or not at all, since they may share a pass.
    pub(crate) fn set_slow(&mut self, mut is_slow: Vec<bool>) {
        let along_links: Vec<usize> = self.plan.along_links().collect();
        if along_links.iter().any(|&row| !is_slow[row]) {
            along_links.iter().for_each(|&row| is_slow[row] = false);
        }
        self.is_slow = is_slow;
    }

    /// The forces \[N\] of all laws, and of those that the hub exerts by contact.
    pub(crate) fn forces_with_contact(&mut self, at: Instant<'_>) -> [NodeVectors; 2] {
        let is_contact = |law: &dyn Law| law.inspection().is_some_and(|law| law.is_contact_with_hub());
        let is_contact: Vec<bool> = self.laws.iter().map(|law| is_contact(law.as_ref())).collect();
        [false, true].map(|contact_only| self.forces_by(|row| !contact_only || is_contact[row], at))
    }

    /// The forces \[N\] of some laws.
    pub(super) fn forces_by(&mut self, is_selected: impl Fn(usize) -> bool + Copy, at: Instant<'_>) -> NodeVectors {
        let (mut forces, mut powers) = (NodeVectors::zeros(self.masses.len()), vec![0.0; self.laws.len()]);
        if (0..self.laws.len()).any(is_selected) {
            self.plan.add_selected(&mut self.laws, is_selected, at, &mut forces, &mut powers);
        }
        forces
    }

    /// Omega L \[J\], with L the angular momentum of all nodes about the axis in inertial space.
    pub(crate) fn turning_energy(&self, point: PhasePoint<'_>) -> f64 {
        let rate = self.spin.at(point.time).rate;
        let ([x, y, _], [u, v, _]) = (columns(point.positions), columns(point.velocities));
        let of_node = |i: usize| self.masses[i] * (x[i] * (v[i] + rate * x[i]) - y[i] * (u[i] - rate * y[i]));
        rate * (0..self.masses.len()).map(of_node).sum::<f64>()
    }

    /// The power by which the loads from outside, of those evaluated tile by tile or of nodal ones, turn with the frame
    /// about the axis \[W\], by their last evaluation. Notes them where the hub is free.
    fn turning_power(&mut self, is_nodal: bool, rate: f64) -> f64 {
        let mut power = 0.0;
        for &row in self.outside[usize::from(is_nodal)].iter().filter(|&&row| self.is_selected[row]) {
            let law = &self.laws[row];
            let load = law.outside_load().unwrap_or_default();
            if law.properties().work_class != WorkClass::Conservative {
                power += rate * load.torque.z;
            }
            if self.hub_row.is_some() {
                self.outside_loads[row] += load;
            }
        }
        power
    }

    /// The laws of a rate group; not the frame of a free hub, without whose forces its methods do.
    pub(crate) fn laws_of(&self, group: RateGroup) -> Vec<&dyn Law> {
        let laws = self.laws.iter().zip(&self.is_slow);
        let own = laws
            .enumerate()
            .filter(|(row, (_, is_slow))| Some(*row) != self.hub_row && **is_slow == (group == RateGroup::Slow));
        own.map(|(_, (law, _))| law.as_ref()).collect()
    }

    /// The instant of a point.
    pub(crate) fn instant<'a>(&self, point: PhasePoint<'a>) -> Instant<'a> {
        Instant::new(point, &self.spin)
    }

    /// The terms of the energy balance.
    pub(crate) fn scope(&self) -> Scope {
        Scope::of(&self.laws, &self.pieces)
    }

    /// The energy terms of a state at `time`.
    pub(crate) fn energy_terms(&self, time: f64, state: &State) -> EnergyTerms {
        EnergyTerms::of(&self.laws, &self.masses, &self.pieces, self.instant(state.at(time)))
    }
}

/// Accelerations by net forces, which are set to zero.
struct Accelerations;

impl Formula<1, 2> for Accelerations {
    #[inline(always)]
    fn row<V: SimdF64>(&self, [factor]: [V; 1], [_, force]: [V; 2]) -> [V; 2] {
        [force * factor, V::zero()]
    }
}

impl System for Mechanics {
    fn select_rate_group(&mut self, group: RateGroup) {
        self.rate_group = Some(group);
        for (is_selected, is_slow) in self.is_selected.iter_mut().zip(&self.is_slow) {
            *is_selected = *is_slow == (group == RateGroup::Slow);
        }
    }

    fn expect_power_at(&mut self, is_expected: bool) {
        self.expects_power_at = is_expected;
    }

    fn reach(&self, tile: usize) -> usize {
        self.plan.reach(&self.laws, tile)
    }

    fn accumulate_forces(&mut self, tile: usize, point: PhasePoint<'_>, powers: &mut [f64]) {
        if tile == 0 {
            powers.fill(0.0);
            self.outside_loads.fill(Load::default());
            // With rate groups, evaluations of the fast laws count.
            self.evaluation_count += u64::from(self.rate_group != Some(RateGroup::Slow));
        }
        let at = self.instant(point);
        let Self { plan, laws, is_selected, forces, deferrals, expects_power_at, .. } = self;
        let mut sums = Sums { forces, powers, deferrals, stores_resistances: *expects_power_at };
        plan.add_to_tile(laws, |row| is_selected[row], tile, at, &mut sums);
        powers[self.laws.len()] += self.turning_power(false, at.frame.rate);
    }

    fn net_forces(&mut self, range: Range<usize>, point: PhasePoint<'_>, powers: &mut [f64]) -> NetForces<'_> {
        let (at, nodes) = (self.instant(point), self.masses.len());
        let Self { laws, deferrals, forces, is_selected, instructions, .. } = self;
        for (((law, deferral), power), _) in laws
            .iter_mut()
            .zip(deferrals)
            .zip(powers.iter_mut())
            .zip(is_selected)
            .filter(|(_, is_selected)| **is_selected)
        {
            let forces = rows_mut(forces, range.clone());
            match (law.nodal(), deferral.as_mut().and_then(Deferral::forces)) {
                (Some(law), None) => *power += law.add_to_rows(range.clone(), at, forces),
                (Some(law), Some(own)) => {
                    let place = place_of(&range, own, nodes);
                    rows_mut(own, place.clone()).into_iter().for_each(|column| column.fill(0.0));
                    law.add_to_rows(range.clone(), at, rows_mut(own, place.clone()));
                    on_axes(*instructions, &Add, [rows(own, place)], [forces]);
                }
                (None, Some(own)) => on_axes(*instructions, &Add, [rows(own, range.clone())], [forces]),
                (None, None) => {}
            }
        }
        powers[self.laws.len()] += self.turning_power(true, at.frame.rate);
        let moves = self.moves_in(range.clone(), point.time);
        if let Some(row) = self.moved {
            powers[row] += moves.iter().map(|(node, prescribed)| self.power_of_move(*node, prescribed)).sum::<f64>();
        }
        // The acceleration of moved nodes belongs to the fast laws, where laws have rate groups.
        let share = if self.rate_group == Some(RateGroup::Slow) { 0.0 } else { 1.0 };
        for (node, prescribed) in &moves {
            self.forces.set_row(*node, &(share * prescribed.acceleration).transpose());
        }
        NetForces { forces: rows_mut(&mut self.forces, range.clone()), factors: &self.factors[range] }
    }

    fn accelerations(
        &mut self,
        range: Range<usize>,
        point: PhasePoint<'_>,
        accelerations: [&mut [f64]; 3],
        powers: &mut [f64],
    ) {
        let instructions = self.instructions;
        let NetForces { forces, factors } = self.net_forces(range, point, powers);
        on_axes(instructions, &Accelerations, [[factors; 3]], [accelerations, forces]);
    }

    fn has_row_power(&self) -> bool {
        let has_own = |deferral: &Option<Deferral>| matches!(deferral, Some(Deferral::Forces(_)));
        self.deferrals.iter().zip(&self.is_selected).any(|(deferral, is_selected)| *is_selected && has_own(deferral))
    }

    fn row_power_at(&mut self, range: Range<usize>, velocities: [&[f64]; 3], powers: &mut [f64]) {
        let nodes = self.masses.len();
        for (((law, deferral), power), _) in self
            .laws
            .iter_mut()
            .zip(&mut self.deferrals)
            .zip(powers)
            .zip(&self.is_selected)
            .filter(|(_, is_selected)| **is_selected)
        {
            if let Some(own) = deferral.as_mut().and_then(Deferral::forces) {
                let place = place_of(&range, own, nodes);
                *power += power_of(self.instructions, rows(own, place.clone()), velocities);
                if law.nodal().is_none() {
                    rows_mut(own, place).into_iter().for_each(|column| column.fill(0.0));
                }
            }
        }
    }

    fn power_of_tile(&mut self, tile: usize, point: PhasePoint<'_>, exact: &mut [f64]) {
        if tile == 0 {
            exact.fill(0.0);
        }
        let at = self.instant(point);
        for (row, deferral) in self.deferrals.iter().enumerate().filter(|(row, _)| self.is_selected[*row]) {
            if let Some(Deferral::Resistances(own)) = deferral {
                exact[row] += self.plan.power_of_resistances(row, own, tile, at);
            }
        }
    }

    fn replace_power(&self, exact: &[f64], powers: &mut [f64]) {
        for (row, deferral) in self.deferrals.iter().enumerate().filter(|(row, _)| self.is_selected[*row]) {
            if let Some(Deferral::Resistances(_)) = deferral {
                powers[row] = exact[row];
            }
        }
    }

    fn factorise(&mut self, point: PhasePoint<'_>, weights: Weights) -> bool {
        let at = self.instant(point);
        let Some(tangent) = &mut self.tangent else { return false };
        let linearised = || self.laws.iter().filter_map(|law| law.linearisation());
        tangent.assemble(&self.masses, weights, |blocks| linearised().for_each(|law| law.add_jacobian(at, blocks)));
        tangent.factorise()
    }

    fn solve(&mut self, accelerations: &mut NodeVectors) {
        if let Some(tangent) = &mut self.tangent {
            tangent.solve(&self.masses, accelerations);
        }
    }

    fn prescribed_accelerations(&self, time: f64, accelerations: &mut NodeVectors) {
        for (node, prescribed) in self.moves_in(0..self.masses.len(), time) {
            accelerations.set_row(node, &prescribed.acceleration.transpose());
        }
    }

    fn mass_product(&self, a: &NodeVectors, b: &NodeVectors) -> f64 {
        self.masses.iter().enumerate().map(|(node, mass)| mass * a.row(node).dot(&b.row(node))).sum()
    }

    fn about_centres(&self, at: PhasePoint<'_>) -> Option<State> {
        (!self.pieces.is_empty()).then(|| self.pieces.about_centres(&self.masses, at))
    }

    fn hub(&self) -> Option<&Hub> {
        self.spin.hub.as_deref()
    }

    fn set_hub(&mut self, motion: HubMotion) {
        if let Some(hub) = &mut self.spin.hub {
            hub.motion = motion;
        }
    }

    fn hub_load(&self, at: PhasePoint<'_>, accelerations: &NodeVectors) -> Load {
        self.load_on_hub(at, accelerations)
    }

    fn hub_power(&self, time: f64, powers: &mut [f64]) {
        self.add_hub_power(time, powers);
    }

    fn held(&self) -> &[usize] {
        &self.held
    }

    fn has_impulses(&self) -> bool {
        self.impulsive.is_some()
    }

    fn give_impulses(&mut self, kick: Kick<'_>, work: &mut [f64]) -> bool {
        self.kick(kick, work)
    }

    fn load_power_at(&mut self, point: PhasePoint<'_>, powers: &mut [f64]) {
        self.find_load_power(point, powers);
    }

    fn coriolis_rate(&self, time: f64) -> f64 {
        if self.spin.hub.is_some() {
            return 0.0;
        }
        let frame = self.spin.at(time);
        self.laws.iter().filter_map(|law| law.linearisation()).map(|law| law.coriolis_rate(frame)).sum()
    }
}
