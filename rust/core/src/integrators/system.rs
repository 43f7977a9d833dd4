//! The system of equations that methods integrate: x'' = a(t, x, v).

use std::ops::Range;

use crate::arrays::blocks::{row_blocks, rows_of, tiles};
use crate::arrays::state::{NodeVectors, PhasePoint, State, rows_mut};
use crate::linear::tangent::Weights;
use crate::model::hub::Hub;
use crate::model::hub_motion::HubMotion;
use crate::model::load::Load;

/// The laws of one evaluation, for methods with substeps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RateGroup {
    /// The fast laws, evaluated once a substep.
    Fast,
    /// The slow laws, evaluated once a step.
    Slow,
}

/// The net forces on some rows, and the factors that make accelerations \[m/s2\] of them.
pub struct NetForces<'a> {
    /// Net forces \[N\]; of moved nodes their accelerations \[m/s2\]. Whoever reads them sets them to zero.
    pub forces: [&'a mut [f64]; 3],
    /// Reciprocal masses \[1/kg\], 0 for held nodes; 1 for moved nodes.
    pub factors: &'a [f64],
}

/// The end of a step or substep, before the drift of the next one.
pub struct Kick<'a> {
    /// Time \[s\].
    pub time: f64,
    /// Length of the next drift \[s\].
    pub dt: f64,
    /// w of the accelerations of Coriolis, w (v_y, -v_x, 0) \[1/s\].
    pub rate: f64,
    /// Positions, and velocities v_n that impulses change.
    pub state: &'a mut State,
    /// Accelerations, of the fast laws where laws have rate groups; impulses change what Coriolis adds to them.
    pub accelerations: &'a mut NodeVectors,
    /// Accelerations of slow laws, and the duration of their kick before the drift \[s\].
    pub slow: Option<(&'a NodeVectors, f64)>,
}

/// The system x'' = a(t, x, v).
pub trait System {
    /// Selects the laws of the following evaluations, for methods with rate groups; without a selection, all laws.
    fn select_rate_group(&mut self, group: RateGroup);
    /// Whether `power_at` follows the next evaluations, as it does unless this says otherwise.
    fn expect_power_at(&mut self, is_expected: bool);
    /// Bound above the rows that `accumulate_forces` and `power_of_tile` read for a tile and the tiles before it; it
    /// may lie above all rows.
    fn reach(&self, tile: usize) -> usize;
    /// Accumulates the forces between nodes on the rows of a tile. Tiles come in order; the first resets the power of
    /// each law to zero.
    fn accumulate_forces(&mut self, tile: usize, at: PhasePoint<'_>, powers: &mut [f64]);
    /// The net forces on `rows`, a row block of the tile of the last `accumulate_forces`; adds the rates at which each
    /// law changes the mechanical energy to its power \[W\]. Each row is evaluated once. Its position and velocity may
    /// change afterwards, so that methods can use a row block while it is in the cache.
    fn net_forces(&mut self, rows: Range<usize>, at: PhasePoint<'_>, powers: &mut [f64]) -> NetForces<'_>;
    /// The same as accelerations \[m/s2\], with net forces set to zero.
    fn accelerations(
        &mut self,
        rows: Range<usize>,
        at: PhasePoint<'_>,
        accelerations: [&mut [f64]; 3],
        powers: &mut [f64],
    );
    /// Fills all accelerations \[m/s2\], and the power of each law \[W\].
    fn accelerate(&mut self, at: PhasePoint<'_>, accelerations: &mut NodeVectors, powers: &mut [f64]) {
        let count = at.positions.nrows();
        for tile in tiles(count) {
            self.accumulate_forces(tile, at, powers);
            for rows in row_blocks(rows_of(tile, count)) {
                self.accelerations(rows.clone(), at, rows_mut(accelerations, rows), powers);
            }
        }
    }
    /// The free hub, with its present motion, by which laws are evaluated; `None` where the hub is driven. With a free
    /// hub, accelerations are those by forces alone, in space.
    fn hub(&self) -> Option<&Hub> {
        None
    }
    /// Moves the free hub, and the frame with it.
    fn set_hub(&mut self, _motion: HubMotion) {}
    /// The load on the free hub about its centre of mass by the last evaluation, which gave these accelerations: the
    /// reaction to the forces on all free nodes but those from outside, and the motor's torque.
    fn hub_load(&self, _at: PhasePoint<'_>, _accelerations: &NodeVectors) -> Load {
        Load::default()
    }
    /// Adds to powers what the turning of a free hub changes of them: the power of the motor, and that of the loads
    /// from outside by the last evaluation, as they turn with the frame.
    fn hub_power(&self, _time: f64, _powers: &mut [f64]) {}
    /// Nodes that are held.
    fn held(&self) -> &[usize] {
        &[]
    }
    /// Whether laws change velocities between two kicks.
    fn has_impulses(&self) -> bool {
        false
    }
    /// Changes the velocities by the impulses that the next drift needs, and adds their work. Whether there were any.
    fn give_impulses(&mut self, _kick: Kick<'_>, _work: &mut [f64]) -> bool {
        false
    }
    /// Replaces the power of the selected loads that do not depend on velocity, after impulses, by that on the
    /// velocities of `at`, at the same positions.
    fn load_power_at(&mut self, _at: PhasePoint<'_>, _powers: &mut [f64]) {}
    /// The rate w = 2 Omega \[1/s\] of the accelerations of Coriolis, w (v_y, -v_x, 0).
    fn coriolis_rate(&self, time: f64) -> f64;
    /// Whether `row_power_at` adds anything for the selected laws.
    fn has_row_power(&self) -> bool;
    /// Adds deferred power, for methods with `predicts_velocity`: after each `net_forces`, that of its forces on the
    /// `velocities` of these rows. `accumulate_forces` and `net_forces` leave this power out, for laws without
    /// potential whose forces depend on velocity, except along links.
    fn row_power_at(&mut self, rows: Range<usize>, velocities: [&[f64]; 3], powers: &mut [f64]);
    /// Replaces the power of such laws along links, which is that on the predicted velocities: after all rows, by the
    /// power of the forces of the last `accumulate_forces` on the velocities of `at`, at the same positions. `exact` is
    /// a work array of the same length.
    fn power_at(&mut self, at: PhasePoint<'_>, exact: &mut [f64], powers: &mut [f64]) {
        tiles(at.positions.nrows()).for_each(|tile| self.power_of_tile(tile, at, exact));
        self.replace_power(exact, powers);
    }
    /// Adds that power of the links of a tile. Tiles come in order; the first resets the power of each law to zero.
    fn power_of_tile(&mut self, tile: usize, at: PhasePoint<'_>, exact: &mut [f64]);
    /// Replaces the power of such laws by that which `power_of_tile` has found.
    fn replace_power(&self, exact: &[f64], powers: &mut [f64]);
    /// Factorises the symmetric part of a M - b dF/dv - c dF/dx, for implicit methods. Whether it is positive definite.
    fn factorise(&mut self, at: PhasePoint<'_>, weights: Weights) -> bool;
    /// Replaces accelerations r by the solution u of A u = M r, with A factorised last; 0 for held nodes.
    fn solve(&mut self, accelerations: &mut NodeVectors);
    /// Replaces the accelerations of moved nodes by those prescribed at `time`, for methods that solve for others.
    fn prescribed_accelerations(&self, _time: f64, _accelerations: &mut NodeVectors) {}
    /// sum m a . b over the nodes, of two accelerations.
    fn mass_product(&self, a: &NodeVectors, b: &NodeVectors) -> f64;
    /// Positions and velocities as the error of a step is measured by: those of pieces that nothing holds relative to
    /// their centres of mass. `None` where there are no such pieces.
    fn about_centres(&self, _at: PhasePoint<'_>) -> Option<State> {
        None
    }
}
