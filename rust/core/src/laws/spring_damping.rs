//! Structural damping: a dashpot along each spring, tethers included.
//!
//!     c = 2 zeta sqrt(k m)   [N s/m],      F_j = -c ((v_j - v_i) . e) e   [N]
//!
//! with e the unit vector along the spring. A rigid motion changes no length and dissipates nothing. The mass m is
//!
//!     m = (m_i + m_j)/2     that of the two nodes of the spring: the form of the paper
//!     m = rho h l_d^2        that of a square of film of side l_d, for springs of the film, if a length l_d is given
//!
//! In the first form c is proportional to L, and the dissipation at a given rate of strain tends to zero on finer
//! meshes. In the second neither depends on the mesh: the film has one viscosity. The two agree where each node has the
//! mass of that square. A film of triangles is damped by its rate of strain instead (see `triangle_damping`).
//! Source: Okuizumi et al. (2012), section 3.4; the length is added here.

mod tangent;

use std::sync::Arc;

use serde::Deserialize;

use super::triangle_damping::TriangleDamping;
use super::{
    Context, FilmElements, Inspection, Instant, Kernels, Law, LawParameters, Linearisation, LinkForce, LinkResponse,
    Properties, WorkClass,
};
use crate::arrays::blocks::tiles;
use crate::arrays::columns::{Columns, ColumnsMut};
use crate::arrays::jacobian::JacobianBlocks;
use crate::arrays::state::NodeVectors;
use crate::assembly::Assembly;
use crate::elements::link::{Links, Span};
use crate::error::{Error, Result};
use crate::model::checks::{non_negative, positive};
use crate::simd::dispatch::BatchKernel;
use crate::simd::lanes::{F64x8, SimdF64, negate, scale};

/// Parameters of the dashpots.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DampingParameters {
    /// zeta, the damping ratio.
    pub ratio: f64,
    /// l_d, side of the square of film with the mass m \[m\]; `None`: m is the mean mass of the nodes.
    pub length: Option<f64>,
}

impl From<f64> for DampingParameters {
    /// The form of the paper.
    fn from(ratio: f64) -> Self {
        Self { ratio, length: None }
    }
}

impl LawParameters for DampingParameters {
    fn build(&self, context: &Context<'_>) -> Result<Box<dyn Law>> {
        Ok(Box::new(SpringDamping::new(*self, context)?))
    }

    fn example() -> Self {
        0.02.into()
    }
}

/// The law: a dashpot along each spring of each network, or damping of the film itself.
struct SpringDamping {
    networks: Vec<Dashpots>,
    /// Damping of a film of triangles.
    film: Option<TriangleDamping>,
}

/// The dashpots of the film or of the tethers, in batches of eight.
struct Dashpots {
    links: Arc<Links>,
    /// c [N s/m].
    coefficient: Arc<Vec<F64x8>>,
}

impl Dashpots {
    /// `mass` is m of each dashpot; without it, m is the mean mass of its two nodes.
    fn new(
        links: Arc<Links>,
        pairs: &[([u32; 2], f64)],
        ratio: f64,
        mass: Option<f64>,
        assembly: &Assembly,
    ) -> Result<Self> {
        if let Some(&(edge, stiffness)) = pairs.iter().find(|(_, stiffness)| *stiffness < 0.0) {
            return Err(Error::DampingOnNegativeSpring { edge: edge.map(|node| node as usize), stiffness });
        }
        let coefficient = links.elements.pack(0.0, |row| {
            let (nodes, stiffness) = pairs[row];
            let [i, j] = assembly.numbering.to_internal(nodes).map(|node| assembly.masses[node as usize]);
            2.0 * ratio * (stiffness * mass.unwrap_or(0.5 * (i + j))).sqrt()
        });
        Ok(Self { links, coefficient: Arc::new(coefficient) })
    }
}

/// Resistance of dashpots over their length l \[N/m\], from l times its rate, and 1/l^2.
#[inline(always)]
pub(crate) fn resistance_per_length<V: SimdF64>(coefficient: &F64x8, length_times_rate: V, inverse_square: V) -> V {
    V::load(coefficient) * length_times_rate * inverse_square
}

impl SpringDamping {
    fn new(parameters: DampingParameters, context: &Context<'_>) -> Result<Self> {
        let DampingParameters { ratio, length } = parameters;
        non_negative("damping ratio", ratio)?;
        if let Some(length) = length {
            positive("length of the damping [m]", length)?;
        }
        let Context { assembly, networks, specs } = context;
        let has_springs = !specs.iter().any(|spec| spec.film() == Some(FilmElements::Triangles));
        let mut dashpots = Vec::new();
        if has_springs {
            let edges: Vec<_> =
                assembly.mesh.edges.iter().copied().zip(assembly.edge_stiffness.iter().copied()).collect();
            let square = assembly.square_of_film(length);
            dashpots.push(Dashpots::new(networks.film(assembly), &edges, ratio, square, assembly)?);
        }
        if !assembly.model.cords.is_empty() {
            let cords: Vec<_> = assembly.model.cords.iter().map(|cord| (cord.nodes, cord.stiffness)).collect();
            dashpots.push(Dashpots::new(networks.cords(assembly), &cords, ratio, None, assembly)?);
        }
        let film = if has_springs { None } else { Some(TriangleDamping::new(parameters, assembly)?) };
        Ok(Self { networks: dashpots, film })
    }
}

/// Adds sign times the resistances of dashpots to `out`, and stores them per length in `cache`; returns their power.
pub(crate) struct ResistanceKernel<'a> {
    pub(crate) links: &'a Links,
    pub(crate) coefficient: &'a [F64x8],
    pub(crate) tile: usize,
    pub(crate) positions: Columns<'a>,
    pub(crate) velocities: Columns<'a>,
    pub(crate) out: ColumnsMut<'a>,
    pub(crate) cache: Option<&'a mut [F64x8]>,
    pub(crate) sign: f64,
}

impl BatchKernel for ResistanceKernel<'_> {
    #[inline(always)]
    fn sweep_kind<V: SimdF64, const KIND: usize>(&mut self) -> V {
        let pass = self.links.elements.pass::<KIND>(self.tile, self.positions.rows());
        let coefficient = pass.of(self.coefficient);
        let mut power = V::zero();
        for batch in 0..pass.len() {
            let span = Span::between(pass.read::<V, 3>(self.positions, batch));
            let rate = span.opening(pass.read::<V, 3>(self.velocities, batch));
            let inverse_square = V::all(1.0) / span.square().max(V::all(f64::MIN_POSITIVE));
            let resistance = resistance_per_length(&coefficient[batch], rate, inverse_square);
            power -= resistance * rate;
            if let Some(cache) = &mut self.cache {
                cache[pass.place(batch)] = resistance.lanes();
            }
            let force = scale(V::all(self.sign) * resistance, span.d);
            pass.add(&mut self.out, batch, [force, negate(force)]);
        }
        power
    }
}

/// The power of stored resistances on other velocities.
pub(crate) struct PowerKernel<'a> {
    pub(crate) links: &'a Links,
    pub(crate) tile: usize,
    pub(crate) resistances: &'a [F64x8],
    pub(crate) positions: Columns<'a>,
    pub(crate) velocities: Columns<'a>,
}

impl BatchKernel for PowerKernel<'_> {
    #[inline(always)]
    fn sweep_kind<V: SimdF64, const KIND: usize>(&mut self) -> V {
        let pass = self.links.elements.pass::<KIND>(self.tile, self.positions.rows());
        let resistances = pass.of(self.resistances);
        let mut power = V::zero();
        for batch in 0..pass.len() {
            let span = Span::between(pass.read::<V, 3>(self.positions, batch));
            power -= V::load(&resistances[batch]) * span.opening(pass.read::<V, 3>(self.velocities, batch));
        }
        power
    }
}

impl Law for SpringDamping {
    fn properties(&self) -> Properties {
        Properties {
            name: "spring_damping",
            work_class: WorkClass::Dissipative,
            depends_on_velocity: true,
            is_internal: true,
        }
    }

    fn kernels(&self) -> Kernels {
        let along = |Dashpots { links, coefficient }: &Dashpots| LinkForce {
            links: links.clone(),
            response: LinkResponse::Viscous(coefficient.clone()),
        };
        Kernels { elements: self.film.is_some(), links: self.networks.iter().map(along).collect() }
    }

    fn add_to_tile(&mut self, tile: usize, at: Instant<'_>, forces: &mut NodeVectors) -> f64 {
        self.film.as_ref().map_or(0.0, |film| film.add_forces(tile, at.positions, at.velocities, forces, 1.0))
    }

    fn linearisation(&self) -> Option<&dyn Linearisation> {
        Some(self)
    }

    fn inspection(&self) -> Option<&dyn Inspection> {
        let has_elements = self.film.is_some() || !self.networks.is_empty();
        has_elements.then_some(self as &dyn Inspection)
    }

    fn remedy(&self) -> &'static str {
        "use a smaller dt or a smaller damping ratio"
    }
}

impl Linearisation for SpringDamping {
    fn add_damping_product(&self, at: Instant<'_>, p: &NodeVectors, out: &mut NodeVectors) {
        for tile in tiles(p.nrows()) {
            if let Some(film) = &self.film {
                film.add_forces(tile, at.positions, p, out, -1.0);
            }
            for Dashpots { links, coefficient } in &self.networks {
                let (positions, velocities, out) = (Columns::of(at.positions), Columns::of(p), ColumnsMut::of(out));
                let (cache, sign) = (None, -1.0);
                links.instructions.run_batches(ResistanceKernel {
                    links,
                    coefficient,
                    tile,
                    positions,
                    velocities,
                    out,
                    cache,
                    sign,
                });
            }
        }
    }

    fn visit_couplings(&self, visit: &mut dyn FnMut(&[u32])) {
        if let Some(film) = &self.film {
            film.visit_couplings(visit);
        }
        for dashpots in &self.networks {
            dashpots.links.elements.each().for_each(|(.., nodes)| visit(&nodes));
        }
    }

    fn add_jacobian(&self, at: Instant<'_>, jacobian: &mut dyn JacobianBlocks) {
        self.jacobian(at, jacobian);
    }
}

impl Inspection for SpringDamping {
    fn contiguous_share(&self) -> Option<f64> {
        let film = self.film.as_ref().map(TriangleDamping::contiguous_share);
        let first = || self.networks.first().map_or(1.0, |dashpots| dashpots.links.elements.contiguous_share());
        Some(film.unwrap_or_else(first))
    }
}
