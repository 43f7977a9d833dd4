//! Common parts of leapfrog with and without substeps: drift with prediction, kick with Boris's rotation,
//! amplification.

use std::ops::Range;

use nalgebra::Matrix3;

use super::System;
use crate::arrays::blocks::{row_blocks, rows_of, tiles};
use crate::arrays::state::{NodeVectors, PhasePoint, State, columns, rows, rows_mut};
use crate::simd::dispatch::InstructionSet;
use crate::simd::lanes::SimdF64;
use crate::simd::map::{Formula, each, on_axes};

/// The drift; the predicted velocity replaces the velocity.
pub(super) struct Drift {
    pub(super) dt: f64,
}

impl Formula<1, 2> for Drift {
    #[inline(always)]
    fn row<V: SimdF64>(&self, [a]: [V; 1], [x, v]: [V; 2]) -> [V; 2] {
        let (dt, half) = (V::all(self.dt), V::all(0.5 * self.dt));
        let kicked = v + half * a;
        [x + dt * kicked, kicked + half * a]
    }
}

/// Drift and prediction with a kick of slow forces before or after them.
pub(super) struct KickedDrift {
    pub(super) dt: f64,
    pub(super) before: f64,
    pub(super) after: f64,
}

impl Formula<2, 2> for KickedDrift {
    #[inline(always)]
    fn row<V: SimdF64>(&self, [fast, slow]: [V; 2], [x, v]: [V; 2]) -> [V; 2] {
        let half = V::all(0.5 * self.dt);
        let kicked = v + half * fast + V::all(self.before) * slow;
        [x + V::all(self.dt) * kicked, kicked + half * fast + V::all(self.after) * slow]
    }
}

/// The velocity from its prediction, without the force of Coriolis: v = p + dt/2 (a' - a). a' replaces a.
struct Correct {
    half: f64,
}

impl Formula<1, 2> for Correct {
    #[inline(always)]
    fn row<V: SimdF64>(&self, [new]: [V; 1], [a, p]: [V; 2]) -> [V; 2] {
        [new, p + V::all(self.half) * (new - a)]
    }
}

/// The same with the force of Coriolis, for x and y.
struct Boris {
    half: f64,
    rate: f64,
}

impl Formula<2, 4> for Boris {
    #[inline(always)]
    fn row<V: SimdF64>(&self, [new_x, new_y]: [V; 2], [ax, ay, px, py]: [V; 4]) -> [V; 4] {
        let h = self.rate * self.half;
        let (half, rate, scale, h) = (V::all(self.half), V::all(self.rate), V::all(1.0 / (1.0 + h * h)), V::all(h));
        let (rx, ry) = (half * (new_x - ax), half * (new_y - ay));
        let (dx, dy) = (scale * (rx + h * ry), scale * (ry - h * rx));
        [new_x + rate * dy, new_y - rate * dx, px + dx, py + dy]
    }
}

/// The largest factor by which a step multiplies a solution of x'' = -omega^2 x - damping x'.
pub(super) fn amplification(omega: f64, damping: f64, dt: f64) -> f64 {
    // The amplification matrix of (x, dt v, dt^2 a).
    let (z, c) = ((omega * dt).powi(2), damping * dt);
    let step = Matrix3::new(
        1.0,
        1.0,
        0.5,
        -0.5 * z,
        1.0 - 0.5 * z - 0.5 * c,
        0.5 - 0.25 * z - 0.5 * c,
        -z,
        -z - c,
        -0.5 * z - c,
    );
    step.complex_eigenvalues().iter().map(|value| value.norm()).fold(0.0, f64::max)
}

/// Adds a weight times the power of each law to its work.
pub(super) fn add_work(work: &mut [f64], weight: f64, powers: &[f64]) {
    work.iter_mut().zip(powers).for_each(|(work, power)| *work += weight * power);
}

/// Accelerations at the first instant, and the power of each law; velocities are not predicted there.
pub(super) fn begin(system: &mut dyn System, at: PhasePoint<'_>, accelerations: &mut NodeVectors, powers: &mut [f64]) {
    let count = accelerations.nrows();
    for tile in tiles(count) {
        system.accumulate_forces(tile, at, powers);
        for range in row_blocks(rows_of(tile, count)) {
            system.accelerations(range.clone(), at, rows_mut(accelerations, range.clone()), powers);
            system.row_power_at(range.clone(), rows(at.velocities, range), powers);
        }
    }
}

/// The drift of a step or substep, with a kick of the slow accelerations before and after it, if any.
pub(super) struct RowDrift<'a> {
    pub(super) dt: f64,
    pub(super) kick: Option<(Kick, &'a NodeVectors)>,
}

/// Weights of the slow accelerations before and after a drift \[s\].
#[derive(Clone, Copy)]
pub(super) struct Kick {
    pub(super) before: f64,
    pub(super) after: f64,
}

impl RowDrift<'_> {
    /// Moves these rows, by accelerations at the start of the drift.
    pub(super) fn run(&self, instructions: InstructionSet, range: Range<usize>, fast: &NodeVectors, state: &mut State) {
        let changed = [rows_mut(&mut state.positions, range.clone()), rows_mut(&mut state.velocities, range.clone())];
        let (dt, fast) = (self.dt, rows(fast, range.clone()));
        match self.kick {
            Some((Kick { before, after }, slow)) => {
                on_axes(instructions, &KickedDrift { dt, before, after }, [fast, rows(slow, range)], changed);
            }
            None => on_axes(instructions, &Drift { dt }, [fast], changed),
        }
    }
}

/// The end of a step: positions at `time`, velocities as predicted.
pub(super) struct End<'a> {
    pub(super) time: f64,
    /// Half of the step.
    pub(super) half: f64,
    /// Those at the start of the step, then those at its end, with the power of each law.
    pub(super) accelerations: &'a mut NodeVectors,
    pub(super) powers: &'a mut [f64],
    /// Work array for the accelerations of one row block.
    pub(super) row_block: &'a mut NodeVectors,
    pub(super) instructions: InstructionSet,
}

impl End<'_> {
    /// Evaluates the accelerations and corrects the velocities, in one sweep over the tiles, while their data are in
    /// the cache. The drift `before`, if given, moves the rows that a tile reads before its evaluation. The drift
    /// `after` moves each row block once its velocities are known, since no element of a later tile uses its nodes. The
    /// power of links on the corrected velocities, if `exact` is given, follows as soon as a tile's rows are corrected.
    pub(super) fn correct(
        self,
        system: &mut dyn System,
        state: &mut State,
        before: Option<&RowDrift<'_>>,
        after: Option<&RowDrift<'_>>,
        mut exact: Option<&mut [f64]>,
    ) {
        debug_assert!(
            after.is_none() || exact.is_none(),
            "the power of links is that at the positions of the evaluation"
        );
        let End { time, half, accelerations, powers, row_block, instructions } = self;
        let (rate, count) = (system.coriolis_rate(time), accelerations.nrows());
        let (mut moved, mut measured) = (0, 0);
        for tile in tiles(count) {
            let end = rows_of(tile, count).end;
            if let Some(before) = before {
                let reach = system.reach(tile).clamp(end, count);
                before.run(instructions, moved..reach.max(moved), accelerations, state);
                moved = moved.max(reach);
            }
            system.accumulate_forces(tile, state.at(time), powers);
            for range in row_blocks(rows_of(tile, count)) {
                system.accelerations(range.clone(), state.at(time), rows_mut(row_block, 0..range.len()), powers);
                let [new_x, new_y, new_z] = rows(row_block, 0..range.len());
                let [ax, ay, az] = rows_mut(accelerations, range.clone());
                let [vx, vy, vz] = rows_mut(&mut state.velocities, range.clone());
                if rate == 0.0 {
                    each(instructions, &Correct { half }, [new_x], [ax, vx]);
                    each(instructions, &Correct { half }, [new_y], [ay, vy]);
                } else {
                    each(instructions, &Boris { half, rate }, [new_x, new_y], [ax, ay, vx, vy]);
                }
                each(instructions, &Correct { half }, [new_z], [az, vz]);
                system.row_power_at(range.clone(), rows(&state.velocities, range.clone()), powers);
                if let Some(after) = after {
                    after.run(instructions, range, accelerations, state);
                }
            }
            while let Some(exact) = exact.as_deref_mut()
                && measured <= tile
                && system.reach(measured).min(count) <= end
            {
                system.power_of_tile(measured, state.at(time), exact);
                measured += 1;
            }
        }
        if let Some(exact) = exact {
            system.replace_power(exact, powers);
        }
    }
}

/// -dt^2/8 sum m a^2: the modified energy that leapfrog conserves under linear undamped forces, minus the energy \[J\].
pub(super) fn energy_shift(accelerations: &NodeVectors, masses: &[f64], dt: f64) -> f64 {
    let [x, y, z] = columns(accelerations);
    let squares = (0..masses.len()).map(|i| masses[i] * (x[i] * x[i] + y[i] * y[i] + z[i] * z[i]));
    -0.125 * dt * dt * squares.sum::<f64>()
}
