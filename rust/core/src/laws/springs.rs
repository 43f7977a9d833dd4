//! In-plane elasticity: springs along the sides of triangles, which buckle; and tethers, which go slack.
//!
//! Spring constants, eq. (1): the energy of a triangle's three springs equals the strain energy of the film in
//! each of the three uniaxial stress states parallel to a side,
//!
//!     A_ij = [1 - (1 - delta_ij) 4 (1 + nu) S^2 / (L_i^2 L_j^2)]^2,   k_i = (E h S / L_i^2) sum_j (A^-1)_ij   [N/m]
//!
//! and triangles that share a side add their springs. Buckling, eq. (2): the force stays constant below a critical
//! length, Euler's strain of a slender column,
//!
//!     l_cr = L - alpha pi^2 h^2 / (12 L)   [m],     N(l) = k (max(l, l_cr) - L)   [N], tension positive
//!
//! or, with a physical length in place of L, at one critical strain on every mesh (see `buckling`). A tether is the same law with l_cr = L: it bears no compression.
//! Source: Okuizumi et al., Trans. JSASS Aerospace Tech. Japan 10 (2012), section 3.1 and 3.2.

mod measures;
mod tangent;

use std::sync::Arc;

use self::measures::{Exceed, Stiffen, Store};
use super::buckling::Buckling;
use super::{Excess, Law, Readings};
use crate::arrays::blocks::tiles;
use crate::arrays::columns::{Columns, ColumnsMut};
use crate::arrays::jacobian::JacobianBlocks;
use crate::arrays::state::{Instant, NodeVectors};
use crate::assembly::Assembly;
use crate::elements::link::SpringNetworks;
use crate::error::Result;
use crate::layout::Elements;
use crate::model::checks::positive;
use crate::simd::dispatch::{BatchKernel, InstructionSet};
use crate::simd::lanes::{F64x8, SimdF64, Vec3, dot, negate, scale, sub};

/// Parameters of the membrane's springs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpringParameters {
    /// Buckling parameter alpha of eq. (2).
    pub buckling: f64,
    /// alpha on edges that are creases.
    pub buckling_on_creases: f64,
    /// Length in place of each spring's own in eq. (2) \[m\]; `None`: its own.
    pub buckling_length: Option<f64>,
    /// Length that gives creases a buckling force of their own \[m\]; `None`: a critical strain.
    pub crease_length: Option<f64>,
    /// Tensile strain at which a run stops.
    pub strain_limit: f64,
}

/// One spring, before it is arranged.
#[derive(Debug, Clone, Copy)]
struct Spring {
    stiffness: f64,
    rest_length: f64,
    critical_length: f64,
    strain_limit: f64,
}

/// The law: a set of springs and what they are called. One entry per batch of eight.
pub struct Springs {
    pub(crate) name: &'static str,
    pub(crate) elements: Arc<Elements<2>>,
    pub(crate) parameters: Vec<Parameters>,
    strain_limit: Vec<F64x8>,
    /// Whether any constant is negative.
    has_negative: bool,
    pub(crate) width: InstructionSet,
}

/// What the pull of a batch of eight springs depends on.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Parameters {
    stiffness: F64x8,
    rest_length: F64x8,
    critical_length: F64x8,
}

impl Parameters {
    /// What springs of length `l` pull with, over their length \[N/m\], and the inverse of that length \[1/m\]. A spring of no
    /// length has no direction: its force fades out over the last 1e-12 of its rest length.
    #[inline(always)]
    pub(crate) fn pull<V: SimdF64>(&self, l: V) -> (V, V) {
        let rest_length = V::load(&self.rest_length);
        let tension = V::load(&self.stiffness) * (l.max(V::load(&self.critical_length)) - rest_length);
        let inverse = V::all(1.0) / l.max(V::all(1e-12) * rest_length);
        (tension * inverse, inverse)
    }
}

impl Springs {
    /// The springs of the film.
    pub(crate) fn membrane(
        parameters: SpringParameters,
        assembly: &Assembly,
        networks: &SpringNetworks,
    ) -> Result<Self> {
        let SpringParameters { buckling, buckling_on_creases, buckling_length, crease_length, strain_limit } =
            parameters;
        positive("strain limit of the springs", strain_limit)?;
        let (parameter, on_creases, length) = (buckling, buckling_on_creases, buckling_length);
        let buckling = Buckling { parameter, on_creases, length, crease_length };
        let shortenings = buckling.shortenings(assembly)?;
        let springs = assembly.edge_stiffness.iter().zip(shortenings);
        let springs = springs.map(|(&stiffness, (rest_length, shortening))| Spring {
            stiffness,
            rest_length,
            critical_length: rest_length - shortening,
            strain_limit,
        });
        Ok(Self::arranged("springs", networks.film(assembly), &springs.collect::<Vec<_>>(), assembly.width))
    }

    /// The tethers.
    pub(crate) fn tethers(assembly: &Assembly, networks: &SpringNetworks) -> Self {
        let cords = assembly.model.cords.iter().map(|cord| Spring {
            stiffness: cord.stiffness,
            rest_length: cord.rest_length,
            critical_length: cord.rest_length,
            strain_limit: cord.strain_limit,
        });
        Self::arranged("tethers", networks.cords(assembly), &cords.collect::<Vec<_>>(), assembly.width)
    }

    fn arranged(name: &'static str, elements: Arc<Elements<2>>, springs: &[Spring], width: InstructionSet) -> Self {
        let stiffness = elements.pack(0.0, |row| springs[row].stiffness).into_iter();
        let rest_length = elements.pack(1.0, |row| springs[row].rest_length);
        let critical_length = elements.pack(1.0, |row| springs[row].critical_length);
        let parameters =
            |((stiffness, rest_length), critical_length)| Parameters { stiffness, rest_length, critical_length };
        Self {
            name,
            parameters: stiffness.zip(rest_length).zip(critical_length).map(parameters).collect(),
            strain_limit: elements.pack(f64::INFINITY, |row| springs[row].strain_limit),
            elements,
            has_negative: springs.iter().any(|spring| spring.stiffness < 0.0),
            width,
        }
    }

    /// The vector from the first to the second end of each spring of a batch, and its length [m].
    fn span(&self, x: Columns<'_>, batch: usize) -> (Vec3, F64x8) {
        let [a, b] = self.elements.read_any(x, batch);
        let d = sub(b, a);
        (d, dot(d, d).sqrt())
    }

    fn batches<T>(&self, at: Instant<'_>, take: impl Fn(usize, F64x8) -> T) -> impl Iterator<Item = T> {
        let x = Columns::of(at.positions);
        (0..self.elements.batch_count()).map(move |batch| take(batch, self.span(x, batch).1))
    }
}

/// Adds the springs' tensions to the forces.
struct Pull<'a> {
    springs: &'a Springs,
    tile: usize,
    positions: Columns<'a>,
    forces: ColumnsMut<'a>,
}

impl BatchKernel for Pull<'_> {
    #[inline(always)]
    fn part<V: SimdF64, const KIND: usize>(&mut self) -> V {
        let pass = self.springs.elements.pass::<KIND>(self.tile, self.positions.rows());
        let parameters = pass.of(&self.springs.parameters);
        for batch in 0..pass.len() {
            let [a, b] = pass.read::<V, 3>(self.positions, batch);
            let d = sub(b, a);
            let pull = scale(parameters[batch].pull(dot(d, d).sqrt()).0, d);
            pass.add(&mut self.forces, batch, [pull, negate(pull)]);
        }
        V::zero()
    }
}

impl Law for Springs {
    fn name(&self) -> &'static str {
        self.name
    }

    fn is_conservative(&self) -> bool {
        true
    }

    fn add_to_tile(&self, tile: usize, at: Instant<'_>, forces: &mut NodeVectors) -> f64 {
        let (positions, forces) = (Columns::of(at.positions), ColumnsMut::of(forces));
        self.width.run_batches(Pull { springs: self, tile, positions, forces })
    }

    /// The integral of the tension from the rest length.
    fn energy(&self, at: Instant<'_>) -> f64 {
        let positions = Columns::of(at.positions);
        tiles(positions.rows()).map(|tile| self.width.run_batches(Store { springs: self, tile, positions })).sum()
    }

    /// k e e^T + max(N, 0)/l (1 - e e^T): along the spring its constant, across it what its tension adds.
    fn add_stiffness_product(&self, at: Instant<'_>, p: &NodeVectors, out: &mut NodeVectors) {
        let (positions, p) = (Columns::of(at.positions), Columns::of(p));
        for tile in tiles(p.rows()) {
            self.width.run_batches(Stiffen { springs: self, tile, positions, p, out: ColumnsMut::of(out) });
        }
    }

    fn first_excess(&self, at: Instant<'_>) -> Option<Excess> {
        let positions = Columns::of(at.positions);
        let count = |tile| self.width.run_batches(Exceed { springs: self, tile, positions });
        if tiles(positions.rows()).all(|tile| count(tile) == 0.0) {
            return None;
        }
        let mut excesses = self.batches(at, |batch, l| {
            let [rest, limit] = [self.parameters[batch].rest_length, self.strain_limit[batch]];
            let lane = (0..l.0.len()).find(|&lane| l.0[lane] > rest.0[lane] * (1.0 + limit.0[lane]))?;
            let (percent, bound) = (100.0 * (l.0[lane] / rest.0[lane] - 1.0), 100.0 * limit.0[lane]);
            let length = rest.0[lane];
            let what =
                format!("a spring of {length:.4e} m is stretched by {percent:.3} %, over its bound of {bound:.3} %");
            Some(Excess { nodes: self.elements.nodes(batch, lane), what })
        });
        excesses.find_map(|excess| excess)
    }

    fn readings(&self, at: Instant<'_>) -> Readings {
        let strain = self.batches(at, |batch, l| l / self.parameters[batch].rest_length - F64x8::all(1.0));
        let buckled =
            self.batches(at, |batch, l| l.below(self.parameters[batch].critical_length, F64x8::all(1.0), F64x8::ZERO));
        let buckled = self.elements.unpack(buckled).into_iter().map(|flag| flag != 0.0).collect();
        Readings::Springs { strain: self.elements.unpack(strain), buckled }
    }

    fn visit_couplings(&self, visit: &mut dyn FnMut(&[u32])) {
        self.elements.each().for_each(|(.., nodes)| visit(&nodes));
    }

    fn add_jacobian(&self, at: Instant<'_>, jacobian: &mut dyn JacobianBlocks) {
        self.jacobian(at, jacobian);
    }

    fn springs(&self) -> Option<&Springs> {
        Some(self)
    }

    fn lanes(&self) -> Option<[usize; 2]> {
        Some(self.elements.lanes())
    }

    fn contiguous_share(&self) -> Option<f64> {
        Some(self.elements.contiguous_share())
    }

    fn remedy(&self) -> &'static str {
        if self.has_negative {
            "negative spring constants let motions grow that no step can tame: use a mesh without angles above 90 degrees"
        } else {
            "use a smaller dt, a start with less strain, or a higher strain limit if the stretch is meant"
        }
    }
}
