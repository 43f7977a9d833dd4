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

use nalgebra::{Matrix3, Vector3};

use self::measures::{Exceed, Stiffen, Store};
use super::buckling::Buckling;
use super::damped_springs::Nets;
use super::{Excess, Law, Readings};
use crate::columns::{Columns, ColumnsMut};
use crate::error::{Error, Result};
use crate::lanes::{Lanes, Point, Vector, dot, negate, scale, sub};
use crate::layout::Elements;
use crate::mesh::Mesh;
use crate::model::{Assembly, positive};
use crate::slopes::Slopes;
use crate::state::{Instant, Vectors, tiles};
use crate::width::{GroupKernel, Width};

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

/// The law: a set of springs and what they are called. One entry per group of eight.
pub struct Springs {
    pub(super) name: &'static str,
    pub(super) elements: Arc<Elements<2>>,
    pub(super) parameters: Vec<Parameters>,
    strain_limit: Vec<Lanes>,
    /// Whether any constant is negative.
    has_negative: bool,
    pub(super) width: Width,
}

/// What the pull of a group of eight springs depends on.
#[derive(Debug, Clone, Copy)]
pub(super) struct Parameters {
    stiffness: Lanes,
    rest_length: Lanes,
    critical_length: Lanes,
}

impl Parameters {
    /// What springs of length `l` pull with, over their length \[N/m\], and the inverse of that length \[1/m\]. A spring of no
    /// length has no direction: its force fades out over the last 1e-12 of its rest length.
    #[inline(always)]
    pub(super) fn pull<V: Vector>(&self, l: V) -> (V, V) {
        let rest_length = V::load(&self.rest_length);
        let tension = V::load(&self.stiffness) * (l.max(V::load(&self.critical_length)) - rest_length);
        let inverse = V::all(1.0) / l.max(V::all(1e-12) * rest_length);
        (tension * inverse, inverse)
    }
}

impl Mesh {
    /// Spring constant of each edge by eq. (1), summed over its triangles \[N/m\].
    ///
    /// # Errors
    /// `DegenerateTriangle`, `SingularTriangle`.
    pub fn spring_constants(&self, youngs_modulus: f64, poisson_ratio: f64, thickness: f64) -> Result<Vec<f64>> {
        let mut constants = vec![0.0; self.edges.len()];
        for (triangle, edges) in self.triangle_edges.iter().enumerate() {
            let area = self.area(triangle)?;
            let squares = self.side_lengths(triangle).map(|side| side * side);
            let a = Matrix3::from_fn(|i, j| {
                let off_diagonal = if i == j { 0.0 } else { 1.0 };
                let root = 1.0 - off_diagonal * 4.0 * (1.0 + poisson_ratio) * area * area / (squares[i] * squares[j]);
                root * root
            });
            let sums = a.lu().solve(&Vector3::repeat(1.0)).filter(|sums| sums.iter().all(|sum| sum.is_finite()));
            let nodes = self.triangles[triangle];
            let sums = sums.ok_or(Error::SingularTriangle { triangle, nodes, poisson_ratio })?;
            for side in 0..3 {
                constants[edges[side] as usize] += youngs_modulus * thickness * area / squares[side] * sums[side];
            }
        }
        Ok(constants)
    }
}

impl Springs {
    /// The springs of the film.
    pub(super) fn membrane(parameters: SpringParameters, assembly: &Assembly, nets: &Nets) -> Result<Self> {
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
        Ok(Self::arranged("springs", nets.film(assembly), &springs.collect::<Vec<_>>(), assembly.width))
    }

    /// The tethers.
    pub(super) fn tethers(assembly: &Assembly, nets: &Nets) -> Self {
        let cords = assembly.model.cords.iter().map(|cord| Spring {
            stiffness: cord.stiffness,
            rest_length: cord.rest_length,
            critical_length: cord.rest_length,
            strain_limit: cord.strain_limit,
        });
        Self::arranged("tethers", nets.cords(assembly), &cords.collect::<Vec<_>>(), assembly.width)
    }

    fn arranged(name: &'static str, elements: Arc<Elements<2>>, springs: &[Spring], width: Width) -> Self {
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

    /// The vector from the first to the second end of each spring of a group, and its length [m].
    fn span(&self, x: Columns<'_>, group: usize) -> (Point, Lanes) {
        let [a, b] = self.elements.read_any(x, group);
        let d = sub(b, a);
        (d, dot(d, d).sqrt())
    }

    fn groups<T>(&self, at: Instant<'_>, take: impl Fn(usize, Lanes) -> T) -> impl Iterator<Item = T> {
        let x = Columns::of(at.positions);
        (0..self.elements.group_count()).map(move |group| take(group, self.span(x, group).1))
    }
}

/// Adds the springs' tensions to the forces.
struct Pull<'a> {
    springs: &'a Springs,
    tile: usize,
    positions: Columns<'a>,
    forces: ColumnsMut<'a>,
}

impl GroupKernel for Pull<'_> {
    #[inline(always)]
    fn part<V: Vector, const KIND: usize>(&mut self) -> V {
        let pass = self.springs.elements.pass::<KIND>(self.tile, self.positions.rows());
        let parameters = pass.of(&self.springs.parameters);
        for group in 0..pass.len() {
            let [a, b] = pass.read::<V, 3>(self.positions, group);
            let d = sub(b, a);
            let pull = scale(parameters[group].pull(dot(d, d).sqrt()).0, d);
            pass.add(&mut self.forces, group, [pull, negate(pull)]);
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

    fn add_to_tile(&self, tile: usize, at: Instant<'_>, forces: &mut Vectors) -> f64 {
        let (positions, forces) = (Columns::of(at.positions), ColumnsMut::of(forces));
        self.width.run_groups(Pull { springs: self, tile, positions, forces })
    }

    /// The integral of the tension from the rest length.
    fn energy(&self, at: Instant<'_>) -> f64 {
        let positions = Columns::of(at.positions);
        tiles(positions.rows()).map(|tile| self.width.run_groups(Store { springs: self, tile, positions })).sum()
    }

    /// k e e^T + max(N, 0)/l (1 - e e^T): along the spring its constant, across it what its tension adds.
    fn add_stiffness_product(&self, at: Instant<'_>, p: &Vectors, out: &mut Vectors) {
        let (positions, p) = (Columns::of(at.positions), Columns::of(p));
        for tile in tiles(p.rows()) {
            self.width.run_groups(Stiffen { springs: self, tile, positions, p, out: ColumnsMut::of(out) });
        }
    }

    fn first_excess(&self, at: Instant<'_>) -> Option<Excess> {
        let positions = Columns::of(at.positions);
        let count = |tile| self.width.run_groups(Exceed { springs: self, tile, positions });
        if tiles(positions.rows()).all(|tile| count(tile) == 0.0) {
            return None;
        }
        let mut excesses = self.groups(at, |group, l| {
            let [rest, limit] = [self.parameters[group].rest_length, self.strain_limit[group]];
            let lane = (0..l.0.len()).find(|&lane| l.0[lane] > rest.0[lane] * (1.0 + limit.0[lane]))?;
            let (percent, bound) = (100.0 * (l.0[lane] / rest.0[lane] - 1.0), 100.0 * limit.0[lane]);
            let length = rest.0[lane];
            let what =
                format!("a spring of {length:.4e} m is stretched by {percent:.3} %, over its bound of {bound:.3} %");
            Some(Excess { nodes: self.elements.nodes(group, lane), what })
        });
        excesses.find_map(|excess| excess)
    }

    fn readings(&self, at: Instant<'_>) -> Readings {
        let strain = self.groups(at, |group, l| l / self.parameters[group].rest_length - Lanes::all(1.0));
        let buckled =
            self.groups(at, |group, l| l.below(self.parameters[group].critical_length, Lanes::all(1.0), Lanes::ZERO));
        let buckled = self.elements.unpack(buckled).into_iter().map(|flag| flag != 0.0).collect();
        Readings::Springs { strain: self.elements.unpack(strain), buckled }
    }

    fn visit_couplings(&self, visit: &mut dyn FnMut(&[u32])) {
        self.elements.each().for_each(|(.., nodes)| visit(&nodes));
    }

    fn add_slopes(&self, at: Instant<'_>, slopes: &mut dyn Slopes) {
        self.slopes(at, slopes);
    }

    fn springs(&self) -> Option<&Springs> {
        Some(self)
    }

    fn lanes(&self) -> Option<[usize; 2]> {
        Some(self.elements.lanes())
    }

    fn share_in_runs(&self) -> Option<f64> {
        Some(self.elements.share_in_runs())
    }

    fn cure(&self) -> &'static str {
        if self.has_negative {
            "negative spring constants let motions grow that no step can tame: use a mesh without angles above 90 degrees"
        } else {
            "use a smaller dt, a start with less strain, or a higher strain limit if the stretch is meant"
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One triangle with a base of 1 m and its apex at (x, y).
    fn triangle(x: f64, y: f64) -> Mesh {
        Mesh::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [x, y, 0.0]], vec![[0, 1, 2]]).unwrap()
    }

    #[test]
    fn equilateral_springs_are_those_of_the_isotropic_lattice() {
        let constants = triangle(0.5, 0.75_f64.sqrt()).spring_constants(2.0, 1.0 / 3.0, 3.0).unwrap();
        let expected = 2.0 * 3.0 * 0.75_f64.sqrt() / 2.0;
        assert!(constants.iter().all(|k| (k / expected - 1.0).abs() < 1e-14), "{constants:?}");
    }

    #[test]
    fn springs_store_the_films_energy_in_uniaxial_stress_along_each_side() {
        let (e, nu, h) = (3.2e9, 0.34, 7.5e-6);
        let mesh = triangle(0.4, 0.8);
        let constants = mesh.spring_constants(e, nu, h).unwrap();
        let area = mesh.area(0).unwrap();
        let points: Vec<_> = mesh.reference.iter().map(|p| [p[0], p[1]]).collect();
        let direction = |i: u32, j: u32| {
            let d = [points[j as usize][0] - points[i as usize][0], points[j as usize][1] - points[i as usize][1]];
            (d, (d[0] * d[0] + d[1] * d[1]).sqrt())
        };
        for &[i, j] in &mesh.edges {
            let (along, length) = direction(i, j);
            let strain = 1e-3;
            let springs: f64 = mesh
                .edges
                .iter()
                .zip(&constants)
                .map(|(&[i, j], k)| {
                    let (d, l) = direction(i, j);
                    let cosine = (d[0] * along[0] + d[1] * along[1]) / (l * length);
                    let stretch = l * strain * (cosine * cosine - nu * (1.0 - cosine * cosine));
                    0.5 * k * stretch * stretch
                })
                .sum();
            let film = 0.5 * e * h * area * strain * strain;
            assert!((springs / film - 1.0).abs() < 1e-12, "{springs} {film}");
        }
    }

    #[test]
    fn an_obtuse_corner_turns_a_spring_negative() {
        assert!(triangle(0.5, 0.12).spring_constants(1.0, 0.34, 1.0).unwrap().iter().any(|&k| k < 0.0));
    }
}
