//! What is integrated: x'' = a(t, x, v), as a method sees it.

use std::ops::Range;

use crate::arrays::blocks::{row_blocks, rows_of, tiles};
use crate::arrays::state::{NodeVectors, PhasePoint, rows_mut};
use crate::linear::tangent::Weights;

/// Which laws a method takes that tells them apart by their pace.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RateGroup {
    /// Those that ask for short steps.
    Fast,
    /// The others.
    Slow,
}

/// What is integrated: x'' = a(t, x, v).
pub trait System {
    /// Says which laws the following evaluations take; all, where nothing is said. For methods that tell laws apart.
    fn select_rate_group(&mut self, group: RateGroup);
    /// Works out what nodes do to each other at this instant, as far as it concerns the rows of a tile; the first tile starts
    /// the power of each law anew. Tiles come in order.
    fn accumulate_forces(&mut self, tile: usize, at: PhasePoint<'_>, powers: &mut [f64]);
    /// Fills the accelerations \[m/s2\] of `rows`, a stretch of the tile of the last `accumulate_forces`, and adds to the
    /// power by which each law changes the mechanical energy \[W\]. Each row is asked for once, but
    /// what is known of it may be changed as soon as it is done: so methods can use a stretch while it is in the cache.
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
    /// The rate w \[1/s\] of the part w (v_y, -v_x, 0) of the accelerations: that of Coriolis, w = 2 Omega.
    fn coriolis_rate(&self, time: f64) -> f64;
    /// For methods that say `evaluates_elsewhere`: laws without a potential leave their power out of `accumulate_forces` and `accelerations`,
    /// and it is added here. That of laws which act on each node by itself: after each `accelerations`, the power of these forces on
    /// the `velocities` of these rows.
    fn row_power_at(&mut self, rows: Range<usize>, velocities: [&[f64]; 3], powers: &mut [f64]);
    /// That of laws between nodes: after all rows, the power of the forces of the last `accumulate_forces` on the velocities of `at`,
    /// whose positions are the same.
    fn power_at(&mut self, at: PhasePoint<'_>, powers: &mut [f64]);
    /// Factorises the symmetric part of a M - b dF/dv - c dF/dx, for methods that say `is_implicit`. Whether it is positive
    /// definite.
    fn factorise(&mut self, at: PhasePoint<'_>, weights: Weights) -> bool;
    /// Replaces accelerations r by the u that the matrix factorised last takes to M r; 0 for nodes that are held.
    fn solve(&mut self, accelerations: &mut NodeVectors);
}
