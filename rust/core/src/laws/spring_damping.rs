//! Structural damping: a dashpot along each spring, tethers included.
//!
//!     c = 2 zeta sqrt(k m)   [N s/m],      F_j = -c ((v_j - v_i) . e) e   [N]
//!
//! with e the unit vector along the spring. A rigid motion changes no length and dissipates nothing. The mass m is that
//! of the two nodes of the spring, their mean in the paper (see `mass`), or for springs of the film, if a length l_d is
//! given, that of two nodes with the mass rho h l_d^2 of a square of film of side l_d. With the nodes' masses c is
//! proportional to L, and the dissipation at a given rate of strain tends to zero on finer meshes. With l_d neither
//! depends on the mesh: the film has one viscosity. The two agree where each node has the mass of that square. A film
//! of triangles is damped by its rate of strain instead (see `triangle_damping`).
//!
//! Limit: a slack cord has no force, and a column bears no more than its buckling force. A limited dashpot obeys
//!
//!     |F| <= k (max(l, l_cr) - l_cr)   [N]
//!
//! the tension above that of buckling, which for a cord (l_cr = L) is its tension. So the force of spring and dashpot
//! is continuous and never below that of buckling, and the power of the dashpot is never positive. The dashpot is one
//! with a coefficient between 0 and c, so that c bounds the damping of the stability limit. A vibration of amplitude a
//! about an elongation s beyond that of buckling is damped in full where 2 zeta a < s.
//! Source: Okuizumi et al. (2012), section 3.4; the length, the reduced mass and the limit are added here.

mod mass;
mod tangent;

use std::sync::Arc;

use serde::Deserialize;

pub use self::mass::DashpotMass;
use super::rectangles;
use super::springs::{self, Springs};
use super::triangle_damping::TriangleDamping;
use super::{
    Context, FilmElements, Inspection, Instant, Kernels, Law, LawParameters, LawSpec, Linearisation, LinkForce,
    LinkResponse, Properties, WorkClass,
};
use crate::arrays::blocks::tiles;
use crate::arrays::columns::{Columns, ColumnsMut};
use crate::arrays::jacobian::JacobianBlocks;
use crate::arrays::state::NodeVectors;
use crate::assembly::Assembly;
use crate::elements::link::{Links, Span};
use crate::error::{Error, Result};
use crate::layout::{Coded, merged};
use crate::model::checks::{non_negative, positive};
use crate::simd::dispatch::BatchKernel;
use crate::simd::lanes::{F64x8, SimdF64, negate, scale};

/// The dashpots whose resistance is limited by the elastic force.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Limited {
    /// None: the form of the paper.
    None,
    /// Those of the cords.
    Cords,
    /// Those of the cords and of the springs of the film.
    All,
}

/// Parameters of the dashpots.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DampingParameters {
    /// zeta, the damping ratio.
    pub ratio: f64,
    /// l_d, side of the square of film with the mass of each node \[m\]; `None`: the nodes have their own masses.
    pub length: Option<f64>,
    /// The mass in c.
    pub mass: DashpotMass,
    /// The dashpots with a limit.
    pub limited: Limited,
}

impl From<f64> for DampingParameters {
    /// The form of the paper for the film; cords do not resist where they are slack.
    fn from(ratio: f64) -> Self {
        Self { ratio, length: None, mass: DashpotMass::Mean, limited: Limited::Cords }
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
    networks: Vec<Network>,
    /// Damping of a film of triangles.
    film: Option<TriangleDamping>,
}

/// The links of the film or of the cords, with their dashpots.
struct Network {
    links: Arc<Links>,
    dashpots: Arc<Dashpots>,
}

/// Dashpots along links, in batches of eight.
pub(crate) struct Dashpots {
    /// c [N s/m].
    pub(crate) coefficient: Coded<F64x8>,
    /// The springs along the same links, whose tension limits the resistance; `None`: no limit.
    pub(crate) limit: Option<Arc<Coded<springs::Parameters>>>,
}

impl Network {
    /// With the dashpots along springs of these ends and constants \[N/m\]. `square` is the mass of each node \[kg\]
    /// in place of its own.
    fn new(
        links: Arc<Links>,
        pairs: &[([u32; 2], f64)],
        parameters: DampingParameters,
        square: Option<f64>,
        limit: Option<Springs>,
        assembly: &Assembly,
    ) -> Result<Self> {
        if let Some(&(edge, stiffness)) = pairs.iter().find(|(_, stiffness)| *stiffness < 0.0) {
            return Err(Error::DampingOnNegativeSpring { edge: edge.map(|node| node as usize), stiffness });
        }
        let DampingParameters { ratio, mass, .. } = parameters;
        let coefficients = pairs.iter().map(|&(nodes, stiffness)| {
            let nodes = assembly.numbering.to_internal(nodes);
            let of = |values: &[f64]| nodes.map(|node| values[node as usize]);
            let of_nodes = || mass.of(&of(&assembly.masses), &of(&assembly.inverse_masses));
            2.0 * ratio * (stiffness * square.map_or_else(of_nodes, |square| mass.of_equal(square))).sqrt()
        });
        let values = merged(coefficients.collect());
        let coefficient = Coded::new(links.elements.pack(0.0, |row| values[row]));
        let limit = limit.map(|springs| springs.parameters());
        Ok(Self { links, dashpots: Arc::new(Dashpots { coefficient, limit }) })
    }
}

/// Resistance of dashpots over their length l \[N/m\], from l times its rate, and 1/l^2.
#[inline(always)]
pub(crate) fn resistance_per_length<V: SimdF64>(coefficient: &F64x8, length_times_rate: V, inverse_square: V) -> V {
    V::load(coefficient) * length_times_rate * inverse_square
}

/// A resistance within +-bound; not a number where it is none.
#[inline(always)]
pub(crate) fn limited<V: SimdF64>(resistance: V, bound: V) -> V {
    bound.min((-bound).max(resistance))
}

impl SpringDamping {
    fn new(parameters: DampingParameters, context: &Context<'_>) -> Result<Self> {
        let DampingParameters { ratio, length, limited, .. } = parameters;
        non_negative("damping ratio", ratio)?;
        if let Some(length) = length {
            positive("length of the damping [m]", length)?;
        }
        let Context { assembly, networks, specs } = context;
        let elements = specs.iter().find_map(LawSpec::film);
        let has_springs = elements != Some(FilmElements::Triangles);
        let has_film = !assembly.mesh.triangles.is_empty();
        let is_limited = limited == Limited::All && has_springs;
        let limit = specs.iter().filter(|_| is_limited).find_map(|spec| spec.springs(context)).transpose()?;
        if limited == Limited::All && has_film && limit.is_none() {
            return Err(Error::LimitWithoutSprings);
        }
        let mut own = Vec::new();
        if has_springs {
            let (links, ends, stiffness) = if elements == Some(FilmElements::Rectangles) {
                let rectangles = assembly.mesh.rectangles(&assembly.hinges)?;
                let stiffness = rectangles::stiffness(&rectangles, assembly)?;
                (networks.rectangles(&rectangles, assembly), rectangles.ends, stiffness)
            } else {
                (networks.film(assembly), assembly.mesh.edges.clone(), assembly.edge_stiffness.clone())
            };
            let springs: Vec<_> = ends.into_iter().zip(stiffness).collect();
            let square = assembly.square_of_film(length);
            own.push(Network::new(links, &springs, parameters, square, limit, assembly)?);
        }
        if !assembly.model.cords.is_empty() {
            let cords: Vec<_> = assembly.model.cords.iter().map(|cord| (cord.nodes, cord.spring_constant())).collect();
            let limit = (limited != Limited::None).then(|| Springs::tethers(context));
            own.push(Network::new(networks.cords(assembly), &cords, parameters, None, limit, assembly)?);
        }
        let film = if has_springs { None } else { Some(TriangleDamping::new(parameters, assembly)?) };
        Ok(Self { networks: own, film })
    }
}

/// Adds sign times the resistances of dashpots to `out`, and stores them per length in `cache`; returns their power.
pub(crate) struct ResistanceKernel<'a> {
    pub(crate) links: &'a Links,
    pub(crate) dashpots: &'a Dashpots,
    /// Whether the limit of the dashpots applies.
    pub(crate) is_limited: bool,
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
        let positions = pass.reader(self.positions);
        let velocities = pass.reader(self.velocities);
        let mut sums = pass.adder(&mut self.out);
        let coefficient = self.dashpots.coefficient.of(&pass);
        let limit = self.dashpots.limit.as_ref().filter(|_| self.is_limited).map(|springs| springs.of(&pass));
        let mut power = V::zero();
        for batch in 0..pass.len() {
            let span = Span::between(positions.read::<V>(batch));
            let rate = span.opening(velocities.read::<V>(batch));
            let inverse_square = V::all(1.0) / span.square().max(V::all(f64::MIN_POSITIVE));
            let mut resistance = resistance_per_length(&coefficient[batch], rate, inverse_square);
            if let Some(springs) = &limit {
                let (springs, l) = (&springs[batch], span.length());
                resistance = limited(resistance, springs.excess(l) * springs.tension_per_length(l).1);
            }
            power -= resistance * rate;
            if let Some(cache) = &mut self.cache {
                cache[pass.place(batch)] = resistance.lanes();
            }
            let force = scale(V::all(self.sign) * resistance, span.d);
            sums.add(batch, [force, negate(force)]);
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
        let positions = pass.reader(self.positions);
        let velocities = pass.reader(self.velocities);
        let resistances = pass.of(self.resistances);
        let mut power = V::zero();
        for batch in 0..pass.len() {
            let span = Span::between(positions.read::<V>(batch));
            power -= V::load(&resistances[batch]) * span.opening(velocities.read::<V>(batch));
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
        let along = |Network { links, dashpots }: &Network| LinkForce {
            links: links.clone(),
            response: LinkResponse::Viscous(dashpots.clone()),
        };
        Kernels { elements: self.film.is_some(), links: self.networks.iter().map(along).collect() }
    }

    fn reach(&self, tile: usize) -> usize {
        self.film.as_ref().map_or(0, |film| film.reach(tile))
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
    /// Every dashpot resists in full, as where its spring is taut.
    fn add_damping_product(&self, factor: f64, at: Instant<'_>, p: &NodeVectors, out: &mut NodeVectors) {
        for tile in tiles(p.nrows()) {
            if let Some(film) = &self.film {
                film.add_forces(tile, at.positions, p, out, -factor);
            }
            for Network { links, dashpots } in &self.networks {
                let (positions, velocities, out) = (Columns::of(at.positions), Columns::of(p), ColumnsMut::of(out));
                let (cache, sign, is_limited) = (None, -factor, false);
                links.instructions.run_batches(ResistanceKernel {
                    links,
                    dashpots,
                    is_limited,
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
        for network in &self.networks {
            network.links.elements.each().for_each(|(.., nodes)| visit(&nodes));
        }
    }

    fn add_jacobian(&self, at: Instant<'_>, jacobian: &mut dyn JacobianBlocks) {
        self.jacobian(at, jacobian);
    }
}

impl Inspection for SpringDamping {
    fn contiguous_share(&self) -> Option<f64> {
        let film = self.film.as_ref().map(TriangleDamping::contiguous_share);
        let first = || self.networks.first().map_or(1.0, |network| network.links.elements.contiguous_share());
        Some(film.unwrap_or_else(first))
    }
}
