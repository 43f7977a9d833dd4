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

use super::Law;
use super::triangle_damping::TriangleDamping;
use crate::columns::{Columns, ColumnsMut};
use crate::error::{Error, Result};
use crate::lanes::{Lanes, dot, negate, scale, sub};
use crate::layout::{BATCH, Elements};
use crate::model::{Assembly, non_negative, positive};
use crate::slopes::Slopes;
use crate::state::{Instant, Vectors};
use crate::width::{Sweep, Width};

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

/// The law: one dashpot per spring, eight to a group.
pub(super) struct SpringDamping {
    elements: Elements<2>,
    /// c [N s/m].
    coefficient: Vec<Lanes>,
    /// Damping of the film where it is no net of springs.
    film: Option<TriangleDamping>,
    width: Width,
}

impl SpringDamping {
    pub(super) fn new(parameters: DampingParameters, has_triangles: bool, assembly: &Assembly) -> Result<Self> {
        let DampingParameters { ratio, length } = parameters;
        non_negative("damping ratio", ratio)?;
        if let Some(length) = length {
            positive("length of the damping [m]", length)?;
        }
        let edges = if has_triangles { &[] } else { &assembly.mesh.edges[..] };
        let film = edges.iter().copied().zip(assembly.edge_stiffness.iter().copied());
        let springs: Vec<_> =
            film.chain(assembly.model.cords.iter().map(|cord| (cord.nodes, cord.stiffness))).collect();
        if let Some(&(edge, stiffness)) = springs.iter().find(|(_, stiffness)| *stiffness < 0.0) {
            return Err(Error::DampingOnNegativeSpring { edge: edge.map(|node| node as usize), stiffness });
        }
        let pairs = assembly.layout.inward_pairs(springs.iter().map(|(nodes, _)| *nodes));
        let elements = Elements::new(&pairs, assembly.masses.len());
        let square = assembly.square_of_film(length);
        let coefficient = elements.pack(0.0, |row| {
            let [i, j] = pairs[row].map(|node| assembly.masses[node as usize]);
            let mass = square.filter(|_| row < edges.len()).unwrap_or(0.5 * (i + j));
            2.0 * ratio * (springs[row].1 * mass).sqrt()
        });
        let film = if has_triangles { Some(TriangleDamping::new(parameters, assembly)?) } else { None };
        Ok(Self { elements, coefficient, film, width: assembly.width })
    }

    fn resist(&self, x: &Vectors, v: &Vectors, out: &mut Vectors, sign: f64) -> f64 {
        let by_film = self.film.as_ref().map_or(0.0, |film| film.resist(x, v, out, sign));
        by_film
            + self.width.run(Resist {
                damping: self,
                positions: Columns::of(x),
                velocities: Columns::of(v),
                out: ColumnsMut::of(out),
                sign,
            })
    }
}

/// Adds -sign C v to `out`, and gives the power of -C v on v.
struct Resist<'a> {
    damping: &'a SpringDamping,
    positions: Columns<'a>,
    velocities: Columns<'a>,
    out: ColumnsMut<'a>,
    sign: f64,
}

impl Resist<'_> {
    #[inline(always)]
    fn part<const LOOSE: bool>(&mut self) -> Lanes {
        let SpringDamping { elements, coefficient, .. } = self.damping;
        let mut power = Lanes::ZERO;
        for batch in elements.batches::<LOOSE>() {
            let mut powers = [Lanes::ZERO; BATCH];
            for (group, power) in batch.zip(&mut powers) {
                let [a, b] = elements.read::<LOOSE>(self.positions, group);
                let [u, v] = elements.read::<LOOSE>(self.velocities, group);
                let d = sub(b, a);
                let closing = dot(d, sub(v, u));
                let pull = coefficient[group] * closing / dot(d, d).max(Lanes::all(f64::MIN_POSITIVE));
                *power = -(pull * closing);
                let force = scale(Lanes::all(self.sign) * pull, d);
                elements.add::<LOOSE>(&mut self.out, group, [force, negate(force)]);
            }
            powers.iter().for_each(|&of_group| power += of_group);
        }
        power
    }
}

impl Sweep for Resist<'_> {
    type Output = f64;

    #[inline(always)]
    fn sweep(mut self) -> f64 {
        (self.part::<false>() + self.part::<true>()).sum()
    }
}

impl Law for SpringDamping {
    fn name(&self) -> &'static str {
        "spring_damping"
    }

    fn is_conservative(&self) -> bool {
        false
    }

    fn add_forces(&self, at: Instant<'_>, forces: &mut Vectors) -> f64 {
        self.resist(at.positions, at.velocities, forces, 1.0)
    }

    fn add_damping_product(&self, at: Instant<'_>, p: &Vectors, out: &mut Vectors) {
        self.resist(at.positions, p, out, -1.0);
    }

    fn visit_couplings(&self, visit: &mut dyn FnMut(&[u32])) {
        if let Some(film) = &self.film {
            film.nodes(visit);
        }
        self.elements.each().for_each(|(.., nodes)| visit(&nodes));
    }

    fn add_slopes(&self, at: Instant<'_>, slopes: &mut dyn Slopes) {
        self.slopes(at, slopes);
    }

    fn share_in_runs(&self) -> Option<f64> {
        let elements = self.elements.share_in_runs();
        Some(self.film.as_ref().map_or(elements, TriangleDamping::share_in_runs))
    }

    fn cure(&self) -> &'static str {
        "use a smaller dt or a smaller damping ratio"
    }
}
