//! Structural damping: a dashpot along each spring, tethers included.
//!
//!     c = 2 zeta sqrt(k m)   [N s/m],      F_j = -c ((v_j - v_i) . e) e   [N]
//!
//! with e the unit vector along the spring. A rigid motion changes no length and so loses nothing. The mass m is
//!
//!     m = (m_i + m_j)/2     that of the spring's two nodes: the paper's form
//!     m = rho h l0^2        that of a square of film of side l0, for springs of the film, if a length l0 is given
//!
//! In the first form c falls with L as the mesh gets finer, and a film loses less and less by the same rate of strain. In
//! the second c is the same on every mesh, and so is what the film loses: it is a film of one viscosity. Where
//! each node has the mass of that square the two agree. A film of triangles in place of springs is damped by its rate of strain instead
//! (see `triangle_damping`). Source: Okuizumi et al. (2012), section 3.4; the length is ours.

mod tangent;

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::Law;
use super::triangle_damping::TriangleDamping;
use crate::arrays::blocks::tiles;
use crate::arrays::columns::{Columns, ColumnsMut};
use crate::arrays::jacobian::JacobianBlocks;
use crate::arrays::state::{Instant, NodeVectors};
use crate::assembly::Assembly;
use crate::elements::link::SpringNetworks;
use crate::error::{Error, Result};
use crate::layout::Elements;
use crate::model::checks::{non_negative, positive};
use crate::simd::dispatch::{BatchKernel, InstructionSet};
use crate::simd::lanes::{F64x8, SimdF64, dot, negate, scale, sub};

/// Parameters of the dashpots.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DampingParameters {
    /// zeta, the damping ratio.
    pub ratio: f64,
    /// l0, side of the square of film whose mass stands in place of the nodes' \[m\]; `None`: the nodes'.
    pub length: Option<f64>,
}

impl From<f64> for DampingParameters {
    /// The paper's form, by its ratio.
    fn from(ratio: f64) -> Self {
        Self { ratio, length: None }
    }
}

/// The law: a dashpot along each spring of each net, or damping of the film itself.
pub struct SpringDamping {
    networks: Vec<Dashpots>,
    /// Damping of the film where it is no net of springs.
    film: Option<TriangleDamping>,
    width: InstructionSet,
}

/// The dashpots of the film or of the tethers, eight to a batch.
pub(crate) struct Dashpots {
    /// The law of these springs.
    pub(crate) springs: &'static str,
    elements: Arc<Elements<2>>,
    /// c [N s/m].
    pub(crate) coefficient: Vec<F64x8>,
    /// What each dashpot pulled with last, over its length \[N/m\]; empty unless that is cached.
    pulls: Mutex<Vec<F64x8>>,
}

impl Dashpots {
    /// `mass` is that of each dashpot; without it, half of what its two nodes have.
    fn new(
        springs: &'static str,
        elements: Arc<Elements<2>>,
        pairs: &[([u32; 2], f64)],
        ratio: f64,
        mass: Option<f64>,
        assembly: &Assembly,
    ) -> Result<Self> {
        if let Some(&(edge, stiffness)) = pairs.iter().find(|(_, stiffness)| *stiffness < 0.0) {
            return Err(Error::DampingOnNegativeSpring { edge: edge.map(|node| node as usize), stiffness });
        }
        let coefficient = elements.pack(0.0, |row| {
            let (nodes, stiffness) = pairs[row];
            let [i, j] = assembly.layout.to_internal(nodes).map(|node| assembly.masses[node as usize]);
            2.0 * ratio * (stiffness * mass.unwrap_or(0.5 * (i + j))).sqrt()
        });
        Ok(Self { springs, elements, coefficient, pulls: Mutex::default() })
    }

    /// Room for what each dashpot pulls with, if that is cached. What a panic left behind is written anew.
    pub(crate) fn pulls(&self) -> MutexGuard<'_, Vec<F64x8>> {
        self.pulls.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// What dashpots pull with, over their length \[N/m\], from the speed times length at which they open and the inverse square of
/// that length.
#[inline(always)]
pub(crate) fn pull<V: SimdF64>(coefficient: &F64x8, opening: V, inverse_square: V) -> V {
    V::load(coefficient) * opening * inverse_square
}

impl SpringDamping {
    pub(crate) fn new(
        parameters: DampingParameters,
        has_triangles: bool,
        assembly: &Assembly,
        networks: &SpringNetworks,
    ) -> Result<Self> {
        let DampingParameters { ratio, length } = parameters;
        non_negative("damping ratio", ratio)?;
        if let Some(length) = length {
            positive("length of the damping [m]", length)?;
        }
        let mut found = Vec::new();
        if !has_triangles {
            let edges: Vec<_> =
                assembly.mesh.edges.iter().copied().zip(assembly.edge_stiffness.iter().copied()).collect();
            let square = assembly.square_of_film(length);
            found.push(Dashpots::new("springs", networks.film(assembly), &edges, ratio, square, assembly)?);
        }
        if !assembly.model.cords.is_empty() {
            let cords: Vec<_> = assembly.model.cords.iter().map(|cord| (cord.nodes, cord.stiffness)).collect();
            found.push(Dashpots::new("tethers", networks.cords(assembly), &cords, ratio, None, assembly)?);
        }
        let film = if has_triangles { Some(TriangleDamping::new(parameters, assembly)?) } else { None };
        Ok(Self { networks: found, film, width: assembly.width })
    }

    /// The dashpots along the springs of this law.
    pub(crate) fn along(&self, springs: &str) -> Option<&Dashpots> {
        self.networks.iter().find(|dashpots| dashpots.springs == springs)
    }

    /// Adds -sign C v of the dashpots of a tile to `out`, and gives the power of -C v on v; without the networks of springs
    /// that are `done`.
    pub(crate) fn resist(
        &self,
        tile: usize,
        x: &NodeVectors,
        v: &NodeVectors,
        out: &mut NodeVectors,
        sign: f64,
        is_done: impl Fn(&str) -> bool,
    ) -> f64 {
        let mut power = self.film.as_ref().map_or(0.0, |film| film.resist(tile, x, v, out, sign));
        for dashpots in self.networks.iter().filter(|dashpots| !is_done(dashpots.springs)) {
            let mut pulls = (sign > 0.0).then(|| dashpots.pulls());
            let pulls = pulls.as_deref_mut().filter(|pulls| !pulls.is_empty()).map(Vec::as_mut_slice);
            let (positions, velocities, out) = (Columns::of(x), Columns::of(v), ColumnsMut::of(out));
            power += self.width.run_batches(Resist { dashpots, tile, positions, velocities, out, pulls, sign });
        }
        power
    }
}

/// Adds -sign C v to `out`, and gives the power of -C v on v; and remembers the pulls.
struct Resist<'a> {
    dashpots: &'a Dashpots,
    tile: usize,
    positions: Columns<'a>,
    velocities: Columns<'a>,
    out: ColumnsMut<'a>,
    pulls: Option<&'a mut [F64x8]>,
    sign: f64,
}

impl BatchKernel for Resist<'_> {
    #[inline(always)]
    fn part<V: SimdF64, const KIND: usize>(&mut self) -> V {
        let pass = self.dashpots.elements.pass::<KIND>(self.tile, self.positions.rows());
        let coefficient = pass.of(&self.dashpots.coefficient);
        let mut power = V::zero();
        for batch in 0..pass.len() {
            let [a, b] = pass.read::<V, 3>(self.positions, batch);
            let [u, v] = pass.read::<V, 3>(self.velocities, batch);
            let d = sub(b, a);
            let opening = dot(d, sub(v, u));
            let inverse_square = V::all(1.0) / dot(d, d).max(V::all(f64::MIN_POSITIVE));
            let pull = pull(&coefficient[batch], opening, inverse_square);
            power -= pull * opening;
            if let Some(pulls) = &mut self.pulls {
                pulls[pass.place(batch)] = pull.lanes();
            }
            let force = scale(V::all(self.sign) * pull, d);
            pass.add(&mut self.out, batch, [force, negate(force)]);
        }
        power
    }
}

/// Gives the power of the pulls that are cached on other velocities.
struct PowerKernel<'a> {
    dashpots: &'a Dashpots,
    tile: usize,
    pulls: &'a [F64x8],
    positions: Columns<'a>,
    velocities: Columns<'a>,
}

impl BatchKernel for PowerKernel<'_> {
    #[inline(always)]
    fn part<V: SimdF64, const KIND: usize>(&mut self) -> V {
        let pass = self.dashpots.elements.pass::<KIND>(self.tile, self.positions.rows());
        let pulls = pass.of(self.pulls);
        let mut power = V::zero();
        for batch in 0..pass.len() {
            let [a, b] = pass.read::<V, 3>(self.positions, batch);
            let [u, v] = pass.read::<V, 3>(self.velocities, batch);
            power -= V::load(&pulls[batch]) * dot(sub(b, a), sub(v, u));
        }
        power
    }
}

impl Law for SpringDamping {
    fn name(&self) -> &'static str {
        "spring_damping"
    }

    fn is_conservative(&self) -> bool {
        false
    }

    fn add_to_tile(&self, tile: usize, at: Instant<'_>, forces: &mut NodeVectors) -> f64 {
        self.resist(tile, at.positions, at.velocities, forces, 1.0, |_| false)
    }

    fn add_damping_product(&self, at: Instant<'_>, p: &NodeVectors, out: &mut NodeVectors) {
        for tile in tiles(p.nrows()) {
            self.resist(tile, at.positions, p, out, -1.0, |_| false);
        }
    }

    /// Only what goes through one pass with the springs is cached.
    fn caches_forces(&mut self) -> bool {
        if self.film.is_some() {
            return false;
        }
        for dashpots in &mut self.networks {
            let count = dashpots.coefficient.len();
            dashpots.pulls = Mutex::new(vec![F64x8::ZERO; count]);
        }
        true
    }

    fn power_at(&self, at: Instant<'_>) -> f64 {
        let mut power = 0.0;
        let (positions, velocities) = (Columns::of(at.positions), Columns::of(at.velocities));
        for dashpots in &self.networks {
            let pulls = &dashpots.pulls()[..];
            for tile in tiles(positions.rows()) {
                power += self.width.run_batches(PowerKernel { dashpots, tile, pulls, positions, velocities });
            }
        }
        power
    }

    fn dashpots(&self) -> Option<&SpringDamping> {
        Some(self)
    }

    fn visit_couplings(&self, visit: &mut dyn FnMut(&[u32])) {
        if let Some(film) = &self.film {
            film.nodes(visit);
        }
        for dashpots in &self.networks {
            dashpots.elements.each().for_each(|(.., nodes)| visit(&nodes));
        }
    }

    fn add_jacobian(&self, at: Instant<'_>, jacobian: &mut dyn JacobianBlocks) {
        self.jacobian(at, jacobian);
    }

    fn contiguous_share(&self) -> Option<f64> {
        let film = self.film.as_ref().map(TriangleDamping::contiguous_share);
        film.or_else(|| self.networks.first().map(|dashpots| dashpots.elements.contiguous_share()))
    }

    fn remedy(&self) -> &'static str {
        "use a smaller dt or a smaller damping ratio"
    }
}
