//! All laws at one instant; springs and the dashpots along them in one pass.
//!
//! Both laws need the span and the length of each spring, so that one pass costs half of two. The equations stay where they
//! are, in `springs` and `spring_damping`: this pass composes them.

use crate::arrays::blocks::{rows_of, tiles};
use crate::arrays::columns::{Columns, ColumnsMut};
use crate::arrays::state::{Instant, NodeVectors, rows_mut};
use crate::laws::Law;
use crate::laws::spring_damping::{self, Dashpots};
use crate::laws::springs::Springs;
use crate::simd::dispatch::BatchKernel;
use crate::simd::lanes::{F64x8, SimdF64, dot, negate, scale, sub};

/// Adds the forces \[N\] of all laws, and fills the power of each \[W\].
pub fn add_all(laws: &[Box<dyn Law>], at: Instant<'_>, forces: &mut NodeVectors, powers: &mut [f64]) {
    powers.fill(0.0);
    let count = at.positions.nrows();
    for tile in tiles(count) {
        add_between_nodes(laws, |_| true, tile, at, forces, powers, &mut []);
        for (law, power) in laws.iter().zip(&mut *powers) {
            if let Some(law) = law.nodal() {
                let range = rows_of(tile, count);
                *power += law.add_to_rows(range.clone(), at, rows_mut(forces, range));
            }
        }
    }
}

/// Adds the forces \[N\] of what belongs to a tile, of the laws that are taken, and to their power \[W\]. Laws that act on each node by itself
/// are only prepared. A law with a place in `resistances` adds its forces there.
pub fn add_between_nodes(
    laws: &[Box<dyn Law>],
    is_taken: impl Fn(usize) -> bool,
    tile: usize,
    at: Instant<'_>,
    forces: &mut NodeVectors,
    powers: &mut [f64],
    resistances: &mut [Option<NodeVectors>],
) {
    let taken = || laws.iter().enumerate().filter(|(row, _)| is_taken(*row));
    let damping = taken().find_map(|(row, law)| law.dashpots().map(|damping| (row, damping)));
    let is_apart = |row: usize, resistances: &[Option<NodeVectors>]| resistances.get(row).is_some_and(Option::is_some);
    for (row, law) in taken() {
        if let Some(law) = law.nodal() {
            law.prepare(tile, at);
            continue;
        }
        if let (Some(springs), Some((damping_row, damping))) = (law.springs(), damping)
            && !is_apart(damping_row, resistances)
            && let Some(dashpots) = damping.along(springs.name)
        {
            let (positions, velocities) = (Columns::of(at.positions), Columns::of(at.velocities));
            let pass = Damped { springs, dashpots, tile, positions, velocities, forces: ColumnsMut::of(forces) };
            let mut pulls = dashpots.pulls();
            powers[damping_row] += if pulls.is_empty() {
                springs.width.run_batches(pass)
            } else {
                springs.width.run_batches(Cached(pass, &mut pulls))
            };
            continue;
        }
        powers[row] += match (law.dashpots(), resistances.get_mut(row).and_then(Option::as_mut)) {
            (_, Some(resistance)) => law.add_to_tile(tile, at, resistance),
            (Some(damping), None) => {
                let is_done =
                    |name: &str| laws.iter().any(|law| law.springs().is_some_and(|springs| springs.name == name));
                damping.resist(tile, at.positions, at.velocities, forces, 1.0, is_done)
            }
            (None, None) => law.add_to_tile(tile, at, forces),
        };
    }
}

/// Adds what springs and dashpots of one tile pull with to the forces, and gives the dashpots' power.
struct Damped<'a> {
    springs: &'a Springs,
    dashpots: &'a Dashpots,
    tile: usize,
    positions: Columns<'a>,
    velocities: Columns<'a>,
    forces: ColumnsMut<'a>,
}

/// The same, remembering what each dashpot pulls with.
struct Cached<'a>(Damped<'a>, &'a mut [F64x8]);

impl Damped<'_> {
    #[inline(always)]
    fn go<V: SimdF64, const KIND: usize>(&mut self, mut pulls: Option<&mut [F64x8]>) -> V {
        let pass = self.springs.elements.pass::<KIND>(self.tile, self.positions.rows());
        let (parameters, coefficient) = (pass.of(&self.springs.parameters), pass.of(&self.dashpots.coefficient));
        let mut power = V::zero();
        for batch in 0..pass.len() {
            let [a, b] = pass.read::<V, 3>(self.positions, batch);
            let [u, v] = pass.read::<V, 3>(self.velocities, batch);
            let d = sub(b, a);
            let opening = dot(d, sub(v, u));
            let (tension, inverse) = parameters[batch].pull(dot(d, d).sqrt());
            let resistance = spring_damping::pull(&coefficient[batch], opening, inverse * inverse);
            power -= resistance * opening;
            let pull = scale(tension + resistance, d);
            pass.add(&mut self.forces, batch, [pull, negate(pull)]);
            if let Some(pulls) = &mut pulls {
                pulls[pass.place(batch)] = resistance.lanes();
            }
        }
        power
    }
}

impl BatchKernel for Damped<'_> {
    #[inline(always)]
    fn part<V: SimdF64, const KIND: usize>(&mut self) -> V {
        self.go::<V, KIND>(None)
    }
}

impl BatchKernel for Cached<'_> {
    #[inline(always)]
    fn part<V: SimdF64, const KIND: usize>(&mut self) -> V {
        self.0.go::<V, KIND>(Some(self.1))
    }
}
