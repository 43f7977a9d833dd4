//! The evaluation plan: which kernels run in which order for the laws of a scene, and which laws share a pass.
//!
//! Laws are gone over in their order. A spring and the dashpot along it go through one pass that adds to two laws' power, where
//! both are evaluated; laws that act on each node by itself are only prepared, for methods add them row block by row block.

use std::sync::Arc;

use super::damped_links::{CachedKernel, DampedKernel};
use super::deferral::Deferral;
use crate::arrays::blocks::{rows_of, tiles};
use crate::arrays::columns::{Columns, ColumnsMut};
use crate::arrays::state::{NodeVectors, rows_mut};
use crate::elements::link::Links;
use crate::laws::Instant;
use crate::laws::spring_damping::{PowerKernel, ResistanceKernel};
use crate::laws::springs::{self, TensionKernel};
use crate::laws::{Law, LinkResponse};
use crate::simd::lanes::F64x8;

/// What is evaluated in one go.
enum Pass {
    /// What a law node by node has to work out before its rows.
    Prepare(usize),
    /// The elements of a law.
    Elements(usize),
    /// Forces along links.
    Links(LinkPass),
}

/// One pass over links, for a law with tension, a law with resistance, or both.
struct LinkPass {
    links: Arc<Links>,
    elastic: Option<(usize, Arc<Vec<springs::Parameters>>)>,
    viscous: Option<Viscous>,
}

/// Resistance along links.
struct Viscous {
    /// The law's row, and which of its sets of links this is.
    row: usize,
    set: usize,
    coefficient: Arc<Vec<F64x8>>,
}

/// What an evaluation adds to.
pub(super) struct Sums<'a> {
    /// Forces of all laws together \[N\].
    pub(super) forces: &'a mut NodeVectors,
    /// The power of each law \[W\].
    pub(super) powers: &'a mut [f64],
    /// Of laws whose power is deferred; empty where none is.
    pub(super) deferrals: &'a mut [Option<Deferral>],
}

/// The passes of a scene, in their order.
#[derive(Default)]
pub struct Plan {
    passes: Vec<Pass>,
}

impl Plan {
    /// For these laws, each evaluated with the others.
    pub fn new(laws: &mut [Box<dyn Law>]) -> Self {
        let is_apart = vec![false; laws.len()];
        Self::with(laws, &is_apart)
    }

    /// Where the forces of some laws are kept apart: these share no pass.
    pub(super) fn with(laws: &mut [Box<dyn Law>], is_apart: &[bool]) -> Self {
        let mut passes = Vec::new();
        let mut resistances: Vec<(Arc<Links>, Viscous)> = Vec::new();
        for (row, law) in laws.iter().enumerate() {
            for (set, force) in law.kernels().links.into_iter().enumerate() {
                if let LinkResponse::Viscous(coefficient) = force.response {
                    resistances.push((force.links, Viscous { row, set, coefficient }));
                }
            }
        }
        let mut take = |links: &Arc<Links>, is_wanted: &dyn Fn(usize) -> bool| {
            let found = resistances.iter().position(|(own, force)| Arc::ptr_eq(own, links) && is_wanted(force.row));
            found.map(|place| resistances.remove(place).1)
        };
        // Springs take the dashpots along them, wherever these stand in the list.
        for (row, law) in laws.iter_mut().enumerate() {
            let kernels = law.kernels();
            if law.nodal().is_some() {
                passes.push(Pass::Prepare(row));
            }
            if kernels.elements {
                passes.push(Pass::Elements(row));
            }
            for force in kernels.links {
                if let LinkResponse::Elastic(parameters) = force.response {
                    let viscous = take(&force.links, &|other| !is_apart[other]);
                    passes.push(Pass::Links(LinkPass {
                        links: force.links,
                        elastic: Some((row, parameters)),
                        viscous,
                    }));
                }
            }
        }
        // The others stand where their law does.
        for (row, law) in laws.iter().enumerate() {
            for force in law.kernels().links {
                if let Some(viscous) = take(&force.links, &|other| other == row) {
                    let behind = passes.iter().position(|pass| pass.row() > row).unwrap_or(passes.len());
                    let pass = LinkPass { links: force.links, elastic: None, viscous: Some(viscous) };
                    passes.insert(behind, Pass::Links(pass));
                }
            }
        }
        Self { passes }
    }

    /// The rows of laws that act along links, some more than once.
    pub(super) fn along_links(&self) -> impl Iterator<Item = usize> {
        let passes = self.passes.iter().filter_map(|pass| if let Pass::Links(pass) = pass { Some(pass) } else { None });
        passes.flat_map(|LinkPass { elastic, viscous, .. }| {
            let of_elastic = elastic.as_ref().map(|(row, _)| *row);
            of_elastic.into_iter().chain(viscous.as_ref().map(|viscous| viscous.row))
        })
    }

    /// Adds the forces \[N\] of what belongs to a tile, of the laws that are taken, and to the power of each \[W\]. Laws node by
    /// node are only prepared. A law whose power is deferred adds its forces to its own, or keeps its pulls.
    pub(super) fn add_to_tile(
        &self,
        laws: &mut [Box<dyn Law>],
        is_taken: impl Fn(usize) -> bool,
        tile: usize,
        at: Instant<'_>,
        sums: &mut Sums<'_>,
    ) {
        for pass in &self.passes {
            match pass {
                Pass::Prepare(row) if is_taken(*row) => {
                    if let Some(law) = laws[*row].nodal() {
                        law.prepare(tile, at);
                    }
                }
                Pass::Elements(row) if is_taken(*row) => {
                    let own = sums.deferrals.get_mut(*row).and_then(Option::as_mut).and_then(Deferral::forces);
                    sums.powers[*row] += laws[*row].add_to_tile(tile, at, own.unwrap_or(sums.forces));
                }
                Pass::Links(pass) => pass.run(&is_taken, tile, at, sums),
                Pass::Prepare(_) | Pass::Elements(_) => {}
            }
        }
    }

    /// Adds the forces \[N\] of the laws that are taken on all nodes, and fills the power of each \[W\].
    pub fn add_taken(
        &self,
        laws: &mut [Box<dyn Law>],
        is_taken: impl Fn(usize) -> bool,
        at: Instant<'_>,
        forces: &mut NodeVectors,
        powers: &mut [f64],
    ) {
        powers.fill(0.0);
        let count = at.positions.nrows();
        for tile in tiles(count) {
            self.add_to_tile(laws, &is_taken, tile, at, &mut Sums { forces, powers, deferrals: &mut [] });
            for (row, law) in laws.iter_mut().enumerate().filter(|(row, _)| is_taken(*row)) {
                if let Some(law) = law.nodal() {
                    let range = rows_of(tile, count);
                    powers[row] += law.add_to_rows(range.clone(), at, rows_mut(forces, range));
                }
            }
        }
    }

    /// The power \[W\] of the pulls that a law kept at the last evaluation, on the velocities of `at`, whose positions are those of
    /// that evaluation.
    pub(super) fn power_of_pulls(&self, row: usize, pulls: &[Vec<F64x8>], at: Instant<'_>) -> f64 {
        let (positions, velocities) = (Columns::of(at.positions), Columns::of(at.velocities));
        let mut power = 0.0;
        for (set, pulls) in pulls.iter().enumerate() {
            let is_own = |viscous: &Viscous| viscous.row == row && viscous.set == set;
            let links = self.passes.iter().find_map(|pass| match pass {
                Pass::Links(pass) if pass.viscous.as_ref().is_some_and(is_own) => Some(&pass.links),
                _ => None,
            });
            let Some(links) = links else { continue };
            for tile in tiles(positions.rows()) {
                power += links.instructions.run_batches(PowerKernel { links, tile, pulls, positions, velocities });
            }
        }
        power
    }
}

impl Pass {
    /// The law after which others stand.
    fn row(&self) -> usize {
        match self {
            Self::Prepare(row) | Self::Elements(row) => *row,
            Self::Links(LinkPass { elastic, viscous, .. }) => {
                let of_elastic = elastic.as_ref().map(|(row, _)| *row);
                of_elastic.or(viscous.as_ref().map(|viscous| viscous.row)).unwrap_or_default()
            }
        }
    }
}

impl LinkPass {
    fn run(&self, is_taken: impl Fn(usize) -> bool, tile: usize, at: Instant<'_>, sums: &mut Sums<'_>) {
        let Self { links, elastic, viscous } = self;
        let elastic = elastic.as_ref().filter(|(row, _)| is_taken(*row));
        let viscous = viscous.as_ref().filter(|viscous| is_taken(viscous.row));
        let (positions, velocities) = (Columns::of(at.positions), Columns::of(at.velocities));
        let Some(Viscous { row, set, coefficient }) = viscous else {
            if let Some((_, parameters)) = elastic {
                let forces = ColumnsMut::of(sums.forces);
                links.instructions.run_batches(TensionKernel { links, parameters, tile, positions, forces });
            }
            return;
        };
        let (mut pulls, mut own) = (None, None);
        match sums.deferrals.get_mut(*row).and_then(Option::as_mut) {
            Some(Deferral::Pulls(sets)) => pulls = sets.get_mut(*set).map(Vec::as_mut_slice),
            Some(Deferral::Forces(forces)) => own = Some(forces),
            None => {}
        }
        let forces = ColumnsMut::of(own.unwrap_or(sums.forces));
        sums.powers[*row] += if let Some((_, springs)) = elastic {
            let kernel = DampedKernel { links, springs, coefficient, tile, positions, velocities, forces };
            match pulls {
                None => links.instructions.run_batches(kernel),
                Some(pulls) => links.instructions.run_batches(CachedKernel(kernel, pulls)),
            }
        } else {
            let (out, sign) = (forces, 1.0);
            let kernel = ResistanceKernel { links, coefficient, tile, positions, velocities, out, pulls, sign };
            links.instructions.run_batches(kernel)
        };
    }
}
