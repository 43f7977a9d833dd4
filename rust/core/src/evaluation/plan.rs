//! The evaluation plan: the passes over the elements of a scene, in the order of its laws, some common to two laws.
//!
//! Springs and the dashpots along them have a common pass when both are evaluated. Nodal laws are only prepared here:
//! methods add their forces row block by row block.

use std::sync::Arc;

use super::damped_links::DampedLinks;
use super::deferral::Deferral;
use crate::arrays::blocks::{rows_of, tiles};
use crate::arrays::columns::{Columns, ColumnsMut};
use crate::arrays::state::{NodeVectors, rows_mut};
use crate::elements::link::Links;
use crate::error::{Error, Result};
use crate::laws::Instant;
use crate::laws::spring_damping::{Dashpots, PowerKernel, ResistanceKernel};
use crate::laws::springs::{self, TensionKernel};
use crate::laws::{Kernels, Law, LinkResponse};
use crate::layout::Coded;
use crate::simd::lanes::F64x8;

/// A pass.
enum Pass {
    /// The preparation of a nodal law.
    Prepare(usize),
    /// The elements of a law.
    Elements(usize),
    /// Forces along links.
    Links(LinkPass),
}

/// A pass over links, for a law with tension, a law with resistance, or both.
struct LinkPass {
    links: Arc<Links>,
    elastic: Option<(usize, Arc<Coded<springs::Parameters>>)>,
    viscous: Option<Viscous>,
}

/// Resistance along links.
struct Viscous {
    /// The row of the law, and the number of these links among its sets.
    row: usize,
    set: usize,
    dashpots: Arc<Dashpots>,
}

/// The results of an evaluation.
pub(super) struct Sums<'a> {
    /// The sum of the forces of all laws \[N\].
    pub(super) forces: &'a mut NodeVectors,
    /// The power of each law \[W\].
    pub(super) powers: &'a mut [f64],
    /// The deferral of each law; empty without deferred power.
    pub(super) deferrals: &'a mut [Option<Deferral>],
    /// Whether resistances are stored.
    pub(super) stores_resistances: bool,
}

/// The passes of a scene, in their order.
#[derive(Default)]
pub struct Plan {
    passes: Vec<Pass>,
}

impl Plan {
    /// Refuses a nodal law with kernels of elements or links: methods add its forces one row block at a time, and those
    /// of elements tile by tile.
    ///
    /// # Errors
    /// `MixedKernels`.
    pub(crate) fn check(laws: &mut [Box<dyn Law>]) -> Result<()> {
        let is_mixed = |law: &mut &mut Box<dyn Law>| {
            let Kernels { elements, links } = law.kernels();
            law.nodal().is_some() && (elements || !links.is_empty())
        };
        laws.iter_mut()
            .find_map(|mut law| is_mixed(&mut law).then(|| law.name()))
            .map_or(Ok(()), |law| Err(Error::MixedKernels { law }))
    }

    /// The plan of these laws.
    pub fn new(laws: &mut [Box<dyn Law>]) -> Self {
        let is_separate = vec![false; laws.len()];
        Self::with(laws, &is_separate)
    }

    /// The plan where some laws have separate forces: these have passes of their own.
    pub(super) fn with(laws: &mut [Box<dyn Law>], is_separate: &[bool]) -> Self {
        let mut passes = Vec::new();
        let mut resistances: Vec<(Arc<Links>, Viscous)> = Vec::new();
        for (row, law) in laws.iter().enumerate() {
            for (set, force) in law.kernels().links.into_iter().enumerate() {
                if let LinkResponse::Viscous(dashpots) = force.response {
                    resistances.push((force.links, Viscous { row, set, dashpots }));
                }
            }
        }
        let mut take = |links: &Arc<Links>, is_wanted: &dyn Fn(usize) -> bool| {
            let found = resistances.iter().position(|(own, force)| Arc::ptr_eq(own, links) && is_wanted(force.row));
            found.map(|place| resistances.remove(place).1)
        };
        // Springs take the dashpots along them, wherever these are in the list.
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
                    let viscous = take(&force.links, &|other| !is_separate[other]);
                    passes.push(Pass::Links(LinkPass {
                        links: force.links,
                        elastic: Some((row, parameters)),
                        viscous,
                    }));
                }
            }
        }
        // The remaining dashpots have the place of their law.
        for (row, law) in laws.iter().enumerate() {
            for force in law.kernels().links {
                if let Some(viscous) = take(&force.links, &|other| other == row) {
                    let place = passes.iter().position(|pass| pass.row() > row).unwrap_or(passes.len());
                    let pass = LinkPass { links: force.links, elastic: None, viscous: Some(viscous) };
                    passes.insert(place, Pass::Links(pass));
                }
            }
        }
        Self { passes }
    }

    /// The rows of laws along links, possibly repeated.
    pub(super) fn along_links(&self) -> impl Iterator<Item = usize> {
        let passes = self.passes.iter().filter_map(|pass| if let Pass::Links(pass) = pass { Some(pass) } else { None });
        passes.flat_map(|LinkPass { elastic, viscous, .. }| {
            let of_elastic = elastic.as_ref().map(|(row, _)| *row);
            of_elastic.into_iter().chain(viscous.as_ref().map(|viscous| viscous.row))
        })
    }

    /// Adds the forces \[N\] of the elements of a tile, for the selected laws, and their power \[W\]. Nodal laws are
    /// only prepared. A law with deferred power adds its forces to an array of its own, without power, or stores its
    /// resistances.
    pub(super) fn add_to_tile(
        &self,
        laws: &mut [Box<dyn Law>],
        is_selected: impl Fn(usize) -> bool,
        tile: usize,
        at: Instant<'_>,
        sums: &mut Sums<'_>,
    ) {
        for pass in &self.passes {
            match pass {
                Pass::Prepare(row) if is_selected(*row) => {
                    if let Some(law) = laws[*row].nodal() {
                        law.prepare(tile, at);
                    }
                }
                Pass::Elements(row) if is_selected(*row) => {
                    match sums.deferrals.get_mut(*row).and_then(Option::as_mut).and_then(Deferral::forces) {
                        Some(own) => _ = laws[*row].add_to_tile(tile, at, own),
                        None => sums.powers[*row] += laws[*row].add_to_tile(tile, at, sums.forces),
                    }
                }
                Pass::Links(pass) => pass.run(&is_selected, tile, at, sums),
                Pass::Prepare(_) | Pass::Elements(_) => {}
            }
        }
    }

    /// Adds the forces \[N\] of the selected laws on all nodes, and fills the power of each \[W\].
    pub fn add_selected(
        &self,
        laws: &mut [Box<dyn Law>],
        is_selected: impl Fn(usize) -> bool,
        at: Instant<'_>,
        forces: &mut NodeVectors,
        powers: &mut [f64],
    ) {
        powers.fill(0.0);
        let count = at.positions.nrows();
        for tile in tiles(count) {
            self.add_to_tile(
                laws,
                &is_selected,
                tile,
                at,
                &mut Sums { forces, powers, deferrals: &mut [], stores_resistances: false },
            );
            for (row, law) in laws.iter_mut().enumerate().filter(|(row, _)| is_selected(*row)) {
                if let Some(law) = law.nodal() {
                    let range = rows_of(tile, count);
                    powers[row] += law.add_to_rows(range.clone(), at, rows_mut(forces, range));
                }
            }
        }
    }

    /// Bound above the nodes whose motion the laws read for a tile and the tiles before it.
    pub(super) fn reach(&self, laws: &[Box<dyn Law>], tile: usize) -> usize {
        let of_pass = |pass: &Pass| match pass {
            Pass::Prepare(row) | Pass::Elements(row) => laws[*row].reach(tile),
            Pass::Links(pass) => pass.links.elements.reach(tile),
        };
        self.passes.iter().map(of_pass).max().unwrap_or(0)
    }

    /// The power \[W\] of the resistances of the last evaluation of a law in a tile on the velocities of `at`, at the
    /// positions of that evaluation.
    pub(super) fn power_of_resistances(
        &self,
        row: usize,
        resistances: &[Vec<F64x8>],
        tile: usize,
        at: Instant<'_>,
    ) -> f64 {
        let (positions, velocities) = (Columns::of(at.positions), Columns::of(at.velocities));
        let mut power = 0.0;
        for (set, resistances) in resistances.iter().enumerate() {
            let is_own = |viscous: &Viscous| viscous.row == row && viscous.set == set;
            let links = self.passes.iter().find_map(|pass| match pass {
                Pass::Links(pass) if pass.viscous.as_ref().is_some_and(is_own) => Some(&pass.links),
                _ => None,
            });
            let Some(links) = links else { continue };
            power += links.instructions.run_batches(PowerKernel { links, tile, resistances, positions, velocities });
        }
        power
    }
}

impl Pass {
    /// The row of the law whose place the pass has.
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
    fn run(&self, is_selected: impl Fn(usize) -> bool, tile: usize, at: Instant<'_>, sums: &mut Sums<'_>) {
        let Self { links, elastic, viscous } = self;
        let elastic = elastic.as_ref().filter(|(row, _)| is_selected(*row));
        let viscous = viscous.as_ref().filter(|viscous| is_selected(viscous.row));
        let (positions, velocities) = (Columns::of(at.positions), Columns::of(at.velocities));
        let Some(Viscous { row, set, dashpots }) = viscous else {
            if let Some((_, parameters)) = elastic {
                let forces = ColumnsMut::of(sums.forces);
                links.instructions.run_batches(TensionKernel { links, parameters, tile, positions, forces });
            }
            return;
        };
        let (mut cache, mut own) = (None, None);
        match sums.deferrals.get_mut(*row).and_then(Option::as_mut) {
            Some(Deferral::Resistances(sets)) if sums.stores_resistances => {
                cache = sets.get_mut(*set).map(Vec::as_mut_slice);
            }
            Some(Deferral::Forces(forces)) => own = Some(forces),
            _ => {}
        }
        let has_own = own.is_some();
        let forces = ColumnsMut::of(own.unwrap_or(sums.forces));
        let power = if let Some((_, springs)) = elastic {
            DampedLinks { links, springs, dashpots, tile, positions, velocities, forces }.run(cache)
        } else {
            let (out, sign, is_limited) = (forces, 1.0, true);
            let kernel =
                ResistanceKernel { links, dashpots, is_limited, tile, positions, velocities, out, cache, sign };
            links.instructions.run_batches(kernel)
        };
        if !has_own {
            sums.powers[*row] += power;
        }
    }
}
