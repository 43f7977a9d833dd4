//! Common parts of leapfrog with and without substeps: drift with prediction, kick with Boris's rotation,
//! amplification.

use std::ops::Range;

use nalgebra::Matrix3;

use super::{NetForces, System};
use crate::arrays::blocks::{row_blocks, rows_of, tiles};
use crate::arrays::state::{NodeVectors, PhasePoint, State, columns, rows, rows_mut};
use crate::simd::dispatch::InstructionSet;
use crate::simd::lanes::SimdF64;
use crate::simd::map::{Formula, each, on_axes};

/// A drift \[s\], with kicks of slow accelerations before and after it.
#[derive(Clone, Copy)]
pub(super) struct Drift {
    pub(super) dt: f64,
    pub(super) before: f64,
    pub(super) after: f64,
}

impl Drift {
    /// Without kicks of slow accelerations.
    pub(super) const fn alone(dt: f64) -> Self {
        Self { dt, before: 0.0, after: 0.0 }
    }

    /// The position after the drift, and the predicted velocity, with kicks where there are slow accelerations.
    #[inline(always)]
    fn of<V: SimdF64>(&self, a: V, slow: Option<V>, [x, v]: [V; 2]) -> [V; 2] {
        let (dt, half) = (V::all(self.dt), V::all(0.5 * self.dt));
        let kicked = |v: V, weight: f64| slow.map_or(v, |slow| v + V::all(weight) * slow);
        let middle = kicked(v + half * a, self.before);
        [x + dt * middle, kicked(middle + half * a, self.after)]
    }
}

impl Formula<1, 2> for Drift {
    #[inline(always)]
    fn row<V: SimdF64>(&self, [a]: [V; 1], moved: [V; 2]) -> [V; 2] {
        self.of(a, None, moved)
    }
}

impl Formula<2, 2> for Drift {
    #[inline(always)]
    fn row<V: SimdF64>(&self, [fast, slow]: [V; 2], moved: [V; 2]) -> [V; 2] {
        self.of(fast, Some(slow), moved)
    }
}

/// The velocity from its prediction, without the force of Coriolis: v = p + dt/2 (a' - a), with a' = F/m. Numbers of an
/// axis: F, a and v; a' replaces a, and zero replaces F.
#[derive(Clone, Copy)]
struct Correct {
    half: f64,
}

impl Formula<1, 3> for Correct {
    #[inline(always)]
    fn row<V: SimdF64>(&self, [factor]: [V; 1], [force, a, p]: [V; 3]) -> [V; 3] {
        let new = force * factor;
        [V::zero(), new, p + V::all(self.half) * (new - a)]
    }
}

/// The same with the force of Coriolis, for x and y.
#[derive(Clone, Copy)]
struct Boris {
    half: f64,
    rate: f64,
}

impl Formula<1, 6> for Boris {
    #[inline(always)]
    fn row<V: SimdF64>(&self, [factor]: [V; 1], [force_x, ax, px, force_y, ay, py]: [V; 6]) -> [V; 6] {
        let h = self.rate * self.half;
        let (half, rate, scale, h) = (V::all(self.half), V::all(self.rate), V::all(1.0 / (1.0 + h * h)), V::all(h));
        let (new_x, new_y) = (force_x * factor, force_y * factor);
        let (rx, ry) = (half * (new_x - ax), half * (new_y - ay));
        let (dx, dy) = (scale * (rx + h * ry), scale * (ry - h * rx));
        [V::zero(), new_x + rate * dy, px + dx, V::zero(), new_y - rate * dx, py + dy]
    }
}

/// A correction, then the drift of the next step, with kicks of slow accelerations where `KICKED`. Each axis has x as a
/// fourth number.
struct Then<F, const KICKED: bool> {
    correct: F,
    drift: Drift,
}

impl<F, const KICKED: bool> Then<F, KICKED> {
    #[inline(always)]
    fn drifted<V: SimdF64>(&self, [force, a, v]: [V; 3], slow: V, x: V) -> [V; 4] {
        let [x, v] = self.drift.of(a, KICKED.then_some(slow), [x, v]);
        [force, a, v, x]
    }
}

impl<const KICKED: bool> Formula<2, 4> for Then<Correct, KICKED> {
    #[inline(always)]
    fn row<V: SimdF64>(&self, [factor, slow]: [V; 2], [force, a, p, x]: [V; 4]) -> [V; 4] {
        self.drifted(self.correct.row([factor], [force, a, p]), slow, x)
    }
}

impl<const KICKED: bool> Formula<3, 8> for Then<Boris, KICKED> {
    #[inline(always)]
    fn row<V: SimdF64>(
        &self,
        [factor, slow_x, slow_y]: [V; 3],
        [force_x, ax, px, x, force_y, ay, py, y]: [V; 8],
    ) -> [V; 8] {
        let [fx, ax, vx, fy, ay, vy] = self.correct.row([factor], [force_x, ax, px, force_y, ay, py]);
        let [fx, ax, vx, x] = self.drifted([fx, ax, vx], slow_x, x);
        let [fy, ay, vy, y] = self.drifted([fy, ay, vy], slow_y, y);
        [fx, ax, vx, x, fy, ay, vy, y]
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
pub(crate) fn begin(system: &mut dyn System, at: PhasePoint<'_>, accelerations: &mut NodeVectors, powers: &mut [f64]) {
    let count = accelerations.nrows();
    for tile in tiles(count) {
        system.accumulate_forces(tile, at, powers);
        for range in row_blocks(rows_of(tile, count)) {
            system.accelerations(range.clone(), at, rows_mut(accelerations, range.clone()), powers);
            system.row_power_at(range.clone(), rows(at.velocities, range), powers);
        }
    }
}

/// The drift of a step or substep, with slow accelerations, if any, for its kicks.
pub(super) struct RowDrift<'a> {
    pub(super) drift: Drift,
    pub(super) slow: Option<&'a NodeVectors>,
}

impl RowDrift<'_> {
    /// Moves these rows, by accelerations at the start of the drift.
    pub(super) fn run(&self, instructions: InstructionSet, range: Range<usize>, fast: &NodeVectors, state: &mut State) {
        let changed = [rows_mut(&mut state.positions, range.clone()), rows_mut(&mut state.velocities, range.clone())];
        let fast = rows(fast, range.clone());
        match self.slow {
            Some(slow) => on_axes(instructions, &self.drift, [fast, rows(slow, range)], changed),
            None => on_axes(instructions, &self.drift, [fast], changed),
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
        let End { time, half, accelerations, powers, instructions } = self;
        let (rate, count) = (system.coriolis_rate(time), accelerations.nrows());
        // The power of rows is that on the corrected velocities, before these are predicted again.
        let (has_power, correction) = (system.has_row_power(), Correction { half, rate, instructions });
        let then = after.filter(|_| !has_power);
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
                let net = system.net_forces(range.clone(), state.at(time), powers);
                match then {
                    None => correction.run(net, range.clone(), accelerations, state),
                    Some(drift) if drift.slow.is_none() => {
                        correction.run_then::<false>(net, range.clone(), accelerations, state, drift);
                    }
                    Some(drift) => correction.run_then::<true>(net, range.clone(), accelerations, state, drift),
                }
                if has_power {
                    system.row_power_at(range.clone(), rows(&state.velocities, range.clone()), powers);
                    if let Some(after) = after {
                        after.run(instructions, range, accelerations, state);
                    }
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

/// The correction of the velocities at the end of a step.
#[derive(Clone, Copy)]
struct Correction {
    half: f64,
    /// Of the accelerations of Coriolis.
    rate: f64,
    instructions: InstructionSet,
}

impl Correction {
    /// Corrects the velocities of these rows; accelerations become new ones.
    fn run(&self, net: NetForces<'_>, range: Range<usize>, accelerations: &mut NodeVectors, state: &mut State) {
        let (NetForces { forces: [fx, fy, fz], factors }, Self { half, rate, instructions }) = (net, *self);
        let [ax, ay, az] = rows_mut(accelerations, range.clone());
        let [vx, vy, vz] = rows_mut(&mut state.velocities, range);
        let correct = Correct { half };
        each(instructions, &correct, [factors], [fz, az, vz]);
        if rate == 0.0 {
            each(instructions, &correct, [factors], [fx, ax, vx]);
            each(instructions, &correct, [factors], [fy, ay, vy]);
        } else {
            each(instructions, &Boris { half, rate }, [factors], [fx, ax, vx, fy, ay, vy]);
        }
    }

    /// The same, then the drift, with slow accelerations where `KICKED`.
    fn run_then<const KICKED: bool>(
        &self,
        net: NetForces<'_>,
        range: Range<usize>,
        accelerations: &mut NodeVectors,
        state: &mut State,
        &RowDrift { drift, slow }: &RowDrift<'_>,
    ) {
        let (NetForces { forces: [fx, fy, fz], factors }, Self { half, rate, instructions }) = (net, *self);
        let [ax, ay, az] = rows_mut(accelerations, range.clone());
        let [vx, vy, vz] = rows_mut(&mut state.velocities, range.clone());
        let [x, y, z] = rows_mut(&mut state.positions, range.clone());
        // Without slow accelerations what is given in their place is not read.
        let [slow_x, slow_y, slow_z] = slow.map_or([factors; 3], |slow| rows(slow, range));
        let alone = Then::<_, KICKED> { correct: Correct { half }, drift };
        each(instructions, &alone, [factors, slow_z], [fz, az, vz, z]);
        if rate == 0.0 {
            each(instructions, &alone, [factors, slow_x], [fx, ax, vx, x]);
            each(instructions, &alone, [factors, slow_y], [fy, ay, vy, y]);
        } else {
            let both = Then::<_, KICKED> { correct: Boris { half, rate }, drift };
            each(instructions, &both, [factors, slow_x, slow_y], [fx, ax, vx, x, fy, ay, vy, y]);
        }
    }
}

/// -dt^2/8 sum m a^2: the modified energy that leapfrog conserves under linear undamped forces, minus the energy \[J\].
pub(super) fn energy_shift(accelerations: &NodeVectors, masses: &[f64], dt: f64) -> f64 {
    let [x, y, z] = columns(accelerations);
    let squares = (0..masses.len()).map(|i| masses[i] * (x[i] * x[i] + y[i] * y[i] + z[i] * z[i]));
    -0.125 * dt * dt * squares.sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROWS: usize = 11;

    /// Numbers without an order, the same for each seed.
    fn vectors(seed: f64) -> NodeVectors {
        NodeVectors::from_fn(ROWS, |row, axis| (seed + 7.3 * row as f64 + 2.1 * axis as f64).sin())
    }

    /// The state, accelerations and forces after the correction and the drift `then`, in one pass or one by one.
    fn corrected(instructions: InstructionSet, rate: f64, then: &RowDrift<'_>, in_one: bool) -> [NodeVectors; 4] {
        let (mut forces, mut accelerations) = (vectors(0.1), vectors(0.2));
        let mut state = State { positions: vectors(0.3), velocities: vectors(0.4) };
        let factors: Vec<f64> = (0..ROWS).map(|row| if row == 3 { 0.0 } else { 1.0 / (1.0 + row as f64) }).collect();
        let net = NetForces { forces: rows_mut(&mut forces, 0..ROWS), factors: &factors };
        let correction = Correction { half: 0.03, rate, instructions };
        match (in_one, then.slow.is_some()) {
            (true, false) => correction.run_then::<false>(net, 0..ROWS, &mut accelerations, &mut state, then),
            (true, true) => correction.run_then::<true>(net, 0..ROWS, &mut accelerations, &mut state, then),
            (false, _) => {
                correction.run(net, 0..ROWS, &mut accelerations, &mut state);
                then.run(instructions, 0..ROWS, &accelerations, &mut state);
            }
        }
        [state.positions, state.velocities, accelerations, forces]
    }

    #[test]
    fn a_drift_in_the_pass_of_the_correction_has_the_bits_of_one_after_it() {
        let slow = vectors(0.5);
        for instructions in InstructionSet::ALL {
            for rate in [0.0, 0.7] {
                for slow in [None, Some(&slow)] {
                    let then = RowDrift { drift: Drift { dt: 0.06, before: 0.0, after: 0.09 }, slow };
                    let [one, other] = [true, false].map(|in_one| corrected(instructions, rate, &then, in_one));
                    assert_eq!(one, other, "{instructions:?}, rate {rate}");
                    assert_eq!(one[3], NodeVectors::zeros(ROWS));
                }
            }
        }
    }

    #[test]
    fn a_correction_solves_for_the_force_of_coriolis() {
        let (rate, half) = (0.7, 0.03);
        // A drift of no length predicts the velocity itself.
        let still = RowDrift { drift: Drift::alone(0.0), slow: None };
        let [_, v, new, _] = corrected(InstructionSet::Baseline, rate, &still, false);
        let [_, _, without, _] = corrected(InstructionSet::Baseline, 0.0, &still, false);
        let (old, p) = (vectors(0.2), vectors(0.4));
        for row in 0..ROWS {
            let d = [0, 1, 2].map(|axis| v[(row, axis)] - p[(row, axis)]);
            let coriolis = [rate * d[1], -rate * d[0], 0.0];
            for axis in 0..3 {
                assert!((new[(row, axis)] - without[(row, axis)] - coriolis[axis]).abs() < 1e-15, "{row} {axis}");
                assert!((d[axis] - half * (new[(row, axis)] - old[(row, axis)])).abs() < 1e-15, "{row} {axis}");
            }
        }
    }
}
