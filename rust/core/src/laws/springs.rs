//! In-plane elasticity: springs along the sides of triangles, which buckle; and tethers, which become slack.
//!
//! Spring constants, eq. (1): the energy of the three springs of a triangle equals the strain energy of the film in
//! each of the three uniaxial stress states parallel to a side,
//!
//!     A_ij = [1 - (1 - delta_ij) 4 (1 + nu) S^2 / (L_i^2 L_j^2)]^2,   k_i = (E h S / L_i^2) sum_j (A^-1)_ij   [N/m]
//!
//! and triangles with a common side add their constants. Buckling, eq. (2): the force is constant below a critical
//! length, by Euler's critical strain of a slender column,
//!
//!     l_cr = L - alpha pi^2 h^2 / (12 L)   [m],     N(l) = k (max(l, l_cr) - L)   [N], tension positive
//!
//! or, with a physical length in place of L, at one critical strain on every mesh (see `buckling`). A tether is the
//! same law with l_cr = L: it bears no compression.
//! Source: Okuizumi et al., Trans. JSASS Aerospace Tech. Japan 10 (2012), sections 3.1 and 3.2.

mod measures;
mod stress;
mod tangent;

use std::sync::Arc;

use serde::Deserialize;

use self::measures::{EnergyKernel, ExcessKernel, StiffnessKernel};
pub(super) use self::stress::FilmTriangles;
use super::buckling::Buckling;
use super::{
    Context, Excess, FilmElements, Inspection, Instant, Kernels, Law, LawParameters, Linearisation, LinkForce,
    LinkReadings, LinkResponse, Properties, WorkClass,
};
use crate::arrays::blocks::tiles;
use crate::arrays::columns::{Columns, ColumnsMut};
use crate::arrays::jacobian::JacobianBlocks;
use crate::arrays::state::NodeVectors;
use crate::assembly::Assembly;
use crate::elements::link::{Links, Span};
use crate::elements::stress::TriangleStress;
use crate::error::Result;
use crate::layout::{Coded, Entry, merged};
use crate::model::checks::positive;
use crate::simd::dispatch::BatchKernel;
use crate::simd::lanes::{F64x8, LANES, SimdF64, negate, scale};

/// Parameters of the membrane's springs.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpringParameters {
    /// Buckling parameter alpha of eq. (2).
    pub buckling: f64,
    /// alpha on edges that are creases.
    pub buckling_on_creases: f64,
    /// l0 in place of the length of each spring in eq. (2) \[m\]; `None`: the length of each spring.
    pub buckling_length: Option<f64>,
    /// l_c of the buckling force of creases \[m\]; `None`: a critical strain.
    pub crease_length: Option<f64>,
    /// Tensile strain at which a run stops.
    pub strain_limit: f64,
}

/// One spring, before the arrangement in batches.
#[derive(Debug, Clone, Copy)]
pub(super) struct Spring {
    pub(super) stiffness: f64,
    pub(super) rest_length: f64,
    pub(super) critical_length: f64,
    pub(super) strain_limit: f64,
}

/// The law: a set of springs, with one entry per batch, and its name.
pub struct Springs {
    name: &'static str,
    links: Arc<Links>,
    parameters: Arc<Coded<Parameters>>,
    strain_limit: Coded<F64x8>,
    /// Whether any constant is negative.
    has_negative: bool,
    /// The triangles of a film.
    pub(super) film: Option<FilmTriangles>,
}

/// Parameters of a batch of springs.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Parameters {
    stiffness: F64x8,
    rest_length: F64x8,
    critical_length: F64x8,
}

impl Parameters {
    /// Tension of springs of length `l` over that length \[N/m\], and 1/l \[1/m\]. A spring of zero length has no
    /// direction: its force tends to zero over the last 1e-12 of its rest length.
    #[inline(always)]
    pub(crate) fn tension_per_length<V: SimdF64>(&self, l: V) -> (V, V) {
        let rest_length = V::load(&self.rest_length);
        let tension = V::load(&self.stiffness) * (l.max(V::load(&self.critical_length)) - rest_length);
        let inverse = V::all(1.0) / l.max(V::all(1e-12) * rest_length);
        (tension * inverse, inverse)
    }

    /// The tension above that of buckling, k (max(l, l_cr) - l_cr), of springs of length `l` \[N\].
    #[inline(always)]
    pub(crate) fn excess<V: SimdF64>(&self, l: V) -> V {
        let critical_length = V::load(&self.critical_length);
        V::load(&self.stiffness) * (l.max(critical_length) - critical_length)
    }

    /// The tension above that of buckling of one spring of length `l` \[N\], and its derivative by the length \[N/m\].
    pub(super) fn excess_at(&self, lane: usize, l: f64) -> (f64, f64) {
        let (k, critical_length) = (self.stiffness.0[lane], self.critical_length.0[lane]);
        if l > critical_length { (k * (l - critical_length), k) } else { (0.0, 0.0) }
    }
}

impl Entry for Parameters {
    type Key = [[u64; LANES]; 3];

    fn key(&self) -> Self::Key {
        [self.stiffness, self.rest_length, self.critical_length].map(|values| values.key())
    }
}

impl LawParameters for SpringParameters {
    fn film(&self) -> Option<FilmElements> {
        Some(FilmElements::Links)
    }

    fn springs(&self, context: &Context<'_>) -> Option<Result<Springs>> {
        Some(Springs::membrane(*self, context))
    }

    fn build(&self, context: &Context<'_>) -> Result<Box<dyn Law>> {
        Ok(Box::new(Springs::membrane(*self, context)?))
    }

    fn example() -> Self {
        Self {
            buckling: 100.0,
            buckling_on_creases: 1000.0,
            buckling_length: None,
            crease_length: None,
            strain_limit: 1e9,
        }
    }
}

impl Springs {
    /// The springs of the film.
    pub(super) fn membrane(parameters: SpringParameters, context: &Context<'_>) -> Result<Self> {
        let SpringParameters { buckling, buckling_on_creases, buckling_length, crease_length, strain_limit } =
            parameters;
        positive("strain limit of the springs", strain_limit)?;
        let (parameter, on_creases, length) = (buckling, buckling_on_creases, buckling_length);
        let buckling = Buckling { parameter, on_creases, length, crease_length };
        let assembly = context.assembly;
        Self::require_one_modulus("springs", assembly)?;
        let springs = assembly.edge_stiffness.iter().zip(buckling.shortenings(assembly, &assembly.side_stiffness)?);
        let springs = springs.map(|(&stiffness, (rest_length, shortening))| Spring {
            stiffness,
            rest_length,
            critical_length: rest_length - shortening,
            strain_limit,
        });
        let own = Self::in_batches("springs", context.networks.film(assembly), &springs.collect::<Vec<_>>());
        Ok(Self { film: FilmTriangles::new(assembly), ..own })
    }

    /// Refuses a film of two moduli.
    ///
    /// # Errors
    /// `TwoModuli`.
    pub(super) fn require_one_modulus(law: &'static str, assembly: &Assembly) -> Result<()> {
        let remedy = "take the law \"triangles\" with compression = 1";
        assembly.film.as_ref().map_or(Ok(()), |film| film.require_one_modulus(law, "its springs", remedy))
    }

    /// The tethers.
    pub(super) fn tethers(context: &Context<'_>) -> Self {
        let cords = context.assembly.model.cords.iter().map(|cord| Spring {
            stiffness: cord.spring_constant(),
            rest_length: cord.rest_length,
            critical_length: cord.rest_length * (1.0 - cord.critical_strain),
            strain_limit: if cord.winch.is_some() { f64::INFINITY } else { cord.strain_limit },
        });
        Self::in_batches("tethers", context.networks.cords(context.assembly), &cords.collect::<Vec<_>>())
    }

    /// One entry per batch of the links.
    pub(super) fn parameters(&self) -> Arc<Coded<Parameters>> {
        self.parameters.clone()
    }

    pub(super) fn in_batches(name: &'static str, links: Arc<Links>, springs: &[Spring]) -> Self {
        let pack = |padding: f64, of: fn(&Spring) -> f64| {
            let values = merged(springs.iter().map(of).collect());
            links.elements.pack(padding, |row| values[row]).into_iter()
        };
        let stiffness = pack(0.0, |spring| spring.stiffness);
        let lengths = pack(1.0, |spring| spring.rest_length).zip(pack(1.0, |spring| spring.critical_length));
        let parameters =
            |(stiffness, (rest_length, critical_length))| Parameters { stiffness, rest_length, critical_length };
        Self {
            name,
            parameters: Arc::new(Coded::new(stiffness.zip(lengths).map(parameters))),
            strain_limit: Coded::new(pack(f64::INFINITY, |spring| spring.strain_limit)),
            links,
            has_negative: springs.iter().any(|spring| spring.stiffness < 0.0),
            film: None,
        }
    }
}

/// Adds the tension of springs to the forces.
pub(crate) struct TensionKernel<'a> {
    pub(crate) links: &'a Links,
    pub(crate) parameters: &'a Coded<Parameters>,
    pub(crate) tile: usize,
    pub(crate) positions: Columns<'a>,
    pub(crate) forces: ColumnsMut<'a>,
}

impl BatchKernel for TensionKernel<'_> {
    #[inline(always)]
    fn sweep_kind<V: SimdF64, const KIND: usize>(&mut self) -> V {
        let pass = self.links.elements.pass::<KIND>(self.tile, self.positions.rows());
        let positions = pass.reader(self.positions);
        let mut sums = pass.adder(&mut self.forces);
        let parameters = self.parameters.of(&pass);
        for batch in 0..pass.len() {
            let span = Span::between(positions.read::<V>(batch));
            let force = scale(parameters[batch].tension_per_length(span.length()).0, span.d);
            sums.add(batch, [force, negate(force)]);
        }
        V::zero()
    }
}

impl Law for Springs {
    fn properties(&self) -> Properties {
        Properties {
            name: self.name,
            work_class: WorkClass::Conservative,
            depends_on_velocity: false,
            is_internal: true,
        }
    }

    fn kernels(&self) -> Kernels {
        let response = LinkResponse::Elastic(self.parameters.clone());
        Kernels { elements: false, links: vec![LinkForce { links: self.links.clone(), response }] }
    }

    /// The integral of the tension from the rest length.
    fn energy(&self, at: Instant<'_>) -> f64 {
        let positions = Columns::of(at.positions);
        let of_tile = |tile| self.links.instructions.run_batches(EnergyKernel { springs: self, tile, positions });
        tiles(positions.rows()).map(of_tile).sum()
    }

    fn linearisation(&self) -> Option<&dyn Linearisation> {
        Some(self)
    }

    fn inspection(&self) -> Option<&dyn Inspection> {
        Some(self)
    }

    fn remedy(&self) -> &'static str {
        if self.has_negative {
            "negative spring constants cause unstable motions at any step: use a mesh without angles above 90 degrees"
        } else {
            "use a smaller dt, a start with less strain, or a higher strain limit if the stretch is meant"
        }
    }
}

impl Linearisation for Springs {
    /// k e e^T + max(N, 0)/l (1 - e e^T): the spring constant along e, the geometric stiffness of tension across it.
    fn add_stiffness_product(&self, at: Instant<'_>, p: &NodeVectors, out: &mut NodeVectors) {
        let (positions, p) = (Columns::of(at.positions), Columns::of(p));
        for tile in tiles(p.rows()) {
            let out = ColumnsMut::of(out);
            self.links.instructions.run_batches(StiffnessKernel { springs: self, tile, positions, p, out });
        }
    }

    fn visit_couplings(&self, visit: &mut dyn FnMut(&[u32])) {
        self.links.elements.each().for_each(|(.., nodes)| visit(&nodes));
    }

    fn add_jacobian(&self, at: Instant<'_>, jacobian: &mut dyn JacobianBlocks) {
        self.jacobian(at, jacobian);
    }
}

impl Inspection for Springs {
    fn first_excess(&self, at: Instant<'_>) -> Option<Excess> {
        let positions = Columns::of(at.positions);
        let count = |tile| self.links.instructions.run_batches(ExcessKernel { springs: self, tile, positions });
        if tiles(positions.rows()).all(|tile| count(tile) == 0.0) {
            return None;
        }
        let mut excesses = self.links.lengths(positions).enumerate().map(|(batch, l)| {
            let [rest, limit] = [self.parameters[batch].rest_length, self.strain_limit[batch]];
            let lane = (0..l.0.len()).find(|&lane| l.0[lane] > rest.0[lane] * (1.0 + limit.0[lane]))?;
            let (percent, bound) = (100.0 * (l.0[lane] / rest.0[lane] - 1.0), 100.0 * limit.0[lane]);
            let length = rest.0[lane];
            let what =
                format!("a spring of {length:.4e} m is stretched by {percent:.3} %, over its bound of {bound:.3} %");
            Some(Excess { nodes: self.links.elements.nodes(batch, lane).to_vec(), what })
        });
        excesses.find_map(|excess| excess)
    }

    fn links(&self, at: Instant<'_>) -> Option<LinkReadings> {
        let lengths = self.links.lengths(Columns::of(at.positions)).zip(self.parameters.iter());
        let of_batch = |(l, spring): (F64x8, &Parameters)| {
            let strain = l / spring.rest_length - F64x8::all(1.0);
            let tension = spring.stiffness * (l.max(spring.critical_length) - spring.rest_length);
            [strain, tension, l.below(spring.critical_length, F64x8::all(1.0), F64x8::ZERO)]
        };
        let rows = self.links.elements.unpack_rows(lengths.map(of_batch));
        Some(LinkReadings {
            strain: rows.iter().map(|&[strain, ..]| strain).collect(),
            tension: rows.iter().map(|&[_, tension, _]| tension).collect(),
            buckled: rows.iter().map(|&[.., buckled]| buckled != 0.0).collect(),
        })
    }

    fn film_stress(&self, at: Instant<'_>) -> Option<Vec<TriangleStress>> {
        self.film.as_ref().map(|film| self.triangle_stress(at, film))
    }

    fn largest_film_stress(&self, at: Instant<'_>) -> Option<f64> {
        self.film.as_ref().and_then(|film| self.largest_triangle_stress(at, film))
    }

    fn lanes(&self) -> [usize; 2] {
        self.links.elements.lanes()
    }

    fn contiguous_share(&self) -> Option<f64> {
        Some(self.links.elements.contiguous_share())
    }
}
