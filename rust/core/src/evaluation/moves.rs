//! Nodes that move as prescribed, in the evaluations and states of a method.

use std::ops::Range;

use super::mechanics::Mechanics;
use crate::arrays::state::{PhasePoint, State};
use crate::integrators::RateGroup;
use crate::laws::{Moved, Prescribed};

impl Mechanics {
    fn moved(&self) -> Option<&Moved> {
        self.laws[self.moved?].moved()
    }

    /// The prescribed motion at a time of the nodes in `rows` that move as prescribed; empty where there are none.
    pub(super) fn moves_in(&self, rows: Range<usize>, time: f64) -> Vec<(usize, Prescribed)> {
        let Some(moved) = self.moved().filter(|moved| moved.has_nodes_in(rows.clone())) else { return Vec::new() };
        let poses = moved.poses(self.spin.time_of(time), self.spin.frozen_at.is_some());
        moved.prescribed(&poses, rows).collect()
    }

    /// The power \[W\] of the force that moves a node against that of the evaluated laws. The acceleration belongs to
    /// the fast laws, where laws have rate groups.
    pub(super) fn power_of_move(&self, node: usize, prescribed: &Prescribed) -> f64 {
        let inertia = if self.rate_group == Some(RateGroup::Slow) { 0.0 } else { self.masses[node] };
        (inertia * prescribed.acceleration - self.forces.row(node).transpose()).dot(&prescribed.velocity)
    }

    /// Sets the moved nodes to their motion at `time`, and adds what that changes of their kinetic energy to the work
    /// of their law.
    pub(crate) fn set_moved(&self, time: f64, state: &mut State, work: &mut [f64]) {
        let Some(row) = self.moved else { return };
        for (node, prescribed) in self.moves_in(0..self.masses.len(), time) {
            let before = state.velocities.row(node).norm_squared();
            state.positions.set_row(node, &prescribed.position.transpose());
            state.velocities.set_row(node, &prescribed.velocity.transpose());
            work[row] += 0.5 * self.masses[node] * (prescribed.velocity.norm_squared() - before);
        }
    }

    /// What the velocities of the moved nodes change of the turning energy as these are set to their motion at `time`
    /// \[J\].
    pub(crate) fn turning_impulse(&self, time: f64, state: &State) -> f64 {
        let moves = self.moves_in(0..self.masses.len(), time).into_iter();
        let torques = moves.map(|(node, Prescribed { position, velocity, .. })| {
            let change = velocity - state.velocities.row(node).transpose();
            self.masses[node] * (position.x * change.y - position.y * change.x)
        });
        self.spin.at(time).rate * torques.sum::<f64>()
    }

    /// Starts the prescribed motion from where the nodes are, unless it has started.
    pub(crate) fn start_moved(&mut self, point: PhasePoint<'_>) {
        let at = self.instant(point);
        if let Some(moved) = self.moved.and_then(|row| self.laws[row].moved_mut()).filter(|moved| !moved.is_anchored())
        {
            moved.anchor(at);
        }
    }

    /// Inertia m x'' \[N\] of a node that moves as prescribed; none of others.
    pub(crate) fn prescribed_inertia(&self, time: f64) -> Vec<(usize, nalgebra::Vector3<f64>)> {
        let moves = self.moves_in(0..self.masses.len(), time).into_iter();
        moves.map(|(node, prescribed)| (node, self.masses[node] * prescribed.acceleration)).collect()
    }

    /// Masses, 0 for held nodes: those of motion that the method integrates.
    pub(crate) fn free_masses(&self) -> Vec<f64> {
        let all = self.masses.iter().zip(&self.inverse_masses);
        all.map(|(mass, inverse)| if *inverse > 0.0 { *mass } else { 0.0 }).collect()
    }
}
