//! All laws at one instant; springs and the dashpots along them in one pass.
//!
//! Both laws need the span and the length of each spring, so that one pass costs half of two. The equations stay where they
//! are, in `springs` and `spring_damping`: this pass composes them.

use std::cell::OnceCell;
use std::sync::Arc;

use super::Law;
use super::spring_damping::{self, Dashpots};
use super::springs::Springs;
use crate::columns::{Columns, ColumnsMut};
use crate::lanes::{Lanes, Vector, dot, negate, scale, sub};
use crate::layout::Elements;
use crate::model::Assembly;
use crate::state::{Instant, Vectors, columns_mut};
use crate::width::Kernel;

/// The springs of a scene, arranged once for both laws.
#[derive(Default)]
pub(super) struct Nets {
    film: OnceCell<Arc<Elements<2>>>,
    cords: OnceCell<Arc<Elements<2>>>,
}

impl Nets {
    /// The sides of the mesh.
    pub(super) fn film(&self, assembly: &Assembly) -> Arc<Elements<2>> {
        self.film.get_or_init(|| arranged(assembly.mesh.edges.iter().copied(), assembly)).clone()
    }

    /// The pieces of tether.
    pub(super) fn cords(&self, assembly: &Assembly) -> Arc<Elements<2>> {
        self.cords.get_or_init(|| arranged(assembly.model.cords.iter().map(|cord| cord.nodes), assembly)).clone()
    }
}

fn arranged(pairs: impl Iterator<Item = [u32; 2]>, assembly: &Assembly) -> Arc<Elements<2>> {
    Arc::new(Elements::new(&assembly.layout.inward_pairs(pairs), assembly.masses.len()))
}

/// Adds the forces \[N\] of all laws, and fills the power of each \[W\]. A law with a place in `resistances` has its own
/// forces there too.
pub fn add_all(
    laws: &[Box<dyn Law>],
    at: Instant<'_>,
    forces: &mut Vectors,
    powers: &mut [f64],
    resistances: &mut [Option<Vectors>],
) {
    resistances.iter_mut().flatten().for_each(|resistance| resistance.as_mut_slice().fill(0.0));
    add_between_nodes(laws, |_| true, at, forces, powers, resistances);
    for (row, law) in laws.iter().enumerate() {
        if let Some(law) = law.by_node() {
            let out = resistances[row].as_mut().unwrap_or(forces);
            powers[row] += law.add_to_rows(0..at.positions.nrows(), at, columns_mut(out));
        }
    }
}

/// As `add_all`, for the laws that are taken; but those that act on each node by itself are only prepared, and resistances are added to.
pub fn add_between_nodes(
    laws: &[Box<dyn Law>],
    is_taken: impl Fn(usize) -> bool,
    at: Instant<'_>,
    forces: &mut Vectors,
    powers: &mut [f64],
    resistances: &mut [Option<Vectors>],
) {
    powers.fill(0.0);
    let damping = laws
        .iter()
        .enumerate()
        .filter(|(row, _)| is_taken(*row))
        .find_map(|(row, law)| law.dashpots().map(|damping| (row, damping)));
    for (row, law) in laws.iter().enumerate().filter(|(row, _)| is_taken(*row)) {
        if let Some(law) = law.by_node() {
            law.prepare(at);
            continue;
        }
        if let (Some(springs), Some((damping_row, damping))) = (law.springs(), damping)
            && resistances[damping_row].is_none()
            && let Some(dashpots) = damping.along(springs.name)
        {
            let (positions, velocities) = (Columns::of(at.positions), Columns::of(at.velocities));
            let pass = Damped { springs, dashpots, positions, velocities, forces: ColumnsMut::of(forces) };
            let mut pulls = dashpots.pulls();
            powers[damping_row] += if pulls.is_empty() {
                springs.width.run_kernel(pass)
            } else {
                springs.width.run_kernel(Remembered(pass, &mut pulls))
            };
            continue;
        }
        powers[row] += match (law.dashpots(), &mut resistances[row]) {
            (_, Some(resistance)) => law.add_forces(at, resistance),
            (Some(damping), None) => {
                let is_done =
                    |name: &str| laws.iter().any(|law| law.springs().is_some_and(|springs| springs.name == name));
                damping.resist(at.positions, at.velocities, forces, 1.0, is_done)
            }
            (None, None) => law.add_forces(at, forces),
        };
    }
}

/// Adds what springs and dashpots pull with to the forces, and gives the dashpots' power.
struct Damped<'a> {
    springs: &'a Springs,
    dashpots: &'a Dashpots,
    positions: Columns<'a>,
    velocities: Columns<'a>,
    forces: ColumnsMut<'a>,
}

/// The same, remembering what each dashpot pulls with.
struct Remembered<'a>(Damped<'a>, &'a mut [Lanes]);

impl Damped<'_> {
    #[inline(always)]
    fn part<V: Vector, const LOOSE: bool>(&mut self, mut pulls: Option<&mut [Lanes]>) -> V {
        let pass = self.springs.elements.pass::<LOOSE>(self.positions.rows());
        let (parameters, coefficient) = (pass.of(&self.springs.parameters), pass.of(&self.dashpots.coefficient));
        let mut power = V::zero();
        for group in 0..pass.len() {
            let [a, b] = pass.read::<V>(self.positions, group);
            let [u, v] = pass.read::<V>(self.velocities, group);
            let d = sub(b, a);
            let opening = dot(d, sub(v, u));
            let (tension, inverse) = parameters[group].pull(dot(d, d).sqrt());
            let resistance = spring_damping::pull(&coefficient[group], opening, inverse * inverse);
            power -= resistance * opening;
            let pull = scale(tension + resistance, d);
            pass.add(&mut self.forces, group, [pull, negate(pull)]);
            if let Some(pulls) = &mut pulls {
                pulls[pass.place(group)] = resistance.lanes();
            }
        }
        power
    }
}

impl Kernel for Damped<'_> {
    type Output = f64;

    #[inline(always)]
    fn sweep<V: Vector>(mut self) -> f64 {
        (self.part::<V, false>(None) + self.part::<V, true>(None)).lanes().sum()
    }
}

impl Kernel for Remembered<'_> {
    type Output = f64;

    #[inline(always)]
    fn sweep<V: Vector>(mut self) -> f64 {
        let runs = self.0.part::<V, false>(Some(self.1));
        (runs + self.0.part::<V, true>(Some(self.1))).lanes().sum()
    }
}
