//! In-plane elasticity by constant-strain triangles: a film that is isotropic at any Poisson's ratio, on any mesh, and that
//! wrinkles.
//!
//! With F = [f1 f2] the deformation gradient in an orthonormal frame (1, 2) of the flat triangle, St. Venant and
//! Kirchhoff's law in plane stress:
//!
//!     E = (F^T F - 1)/2,     S = E_Y/(1 - nu^2) [(1 - nu) E + nu tr(E) 1]   [Pa],     U = h A0 (S : E)/2   [J]
//!
//! A film cannot bear compression beyond the stress sigma_c at which it buckles. Its energy is then the least that
//! wrinkles, a shortening W >= 0 (any symmetric tensor without negative eigenvalue) at the price of sigma_c, can reach:
//!
//!     U_r(E) = min over W of  U(E + W) + h A0 sigma_c tr(W)
//!
//! The minimum is convex in E and has one continuous derivative, so forces are -dU_r/dx and no energy is made. In
//! principal strains e1 >= e2 and the stresses s1 >= s2 that they have without wrinkles, it is
//!
//!     taut      s2 >= -sigma_c                                 stress (s1, s2)
//!     wrinkled  else, E_Y e1 + (1 - nu) sigma_c > 0            stress (E_Y e1 - nu sigma_c, -sigma_c)
//!     slack     else                                           stress (-sigma_c, -sigma_c)
//!
//! At sigma_c = 0 this is tension-field theory: a wrinkled film bears uniaxial tension only. Under uniaxial compression
//! it is eq. (2): the stress grows to sigma_c = E_Y eps_c and stays, with eps_c Euler's strain of a slender column
//! (see `buckling`), here the mean over the triangle's three sides. A share c of the stiffness can be kept in compression:
//! U = c U_taut + (1 - c) U_r.
//!
//! Sources: Pipkin, IMA J. Appl. Math. 36 (1986), and Le Dret and Raoult, J. Math. Pures Appl. 74 (1995), for sigma_c = 0;
//! the price of wrinkles, which makes eq. (2) of Okuizumi et al. (2012) a case of it, is ours.

use super::buckling::Buckling;
use super::{Excess, Law, Readings};
use crate::error::Result;
use crate::lanes::{Lanes, Point, dot, negate, scale, sub, sum};
use crate::layout::Elements;
use crate::mesh;
use crate::model::{Assembly, positive, within};
use crate::state::{Instant, Vectors, columns, columns_mut};
use crate::width::{Sweep, Width};

/// Parameters of the triangles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TriangleParameters {
    /// Share of the stiffness that is left in compression, from 0 (a film) to 1 (a plate that cannot buckle).
    pub compression: f64,
    /// Buckling parameter alpha of eq. (2).
    pub buckling: f64,
    /// alpha on sides that are creases.
    pub buckling_on_creases: f64,
    /// Length in place of each side's own in eq. (2) \[m\]; `None`: its own.
    pub buckling_length: Option<f64>,
    /// Principal strain, by length, at which a run stops.
    pub strain_limit: f64,
}

/// Flat triangles, eight to a group, and how strain follows from where their nodes are.
pub(super) struct Flat {
    pub(super) elements: Elements<3>,
    /// The gradient's columns are f1 = p u, f2 = q u + r v, with u and v the sides from the first node [1/m].
    p: Vec<Lanes>,
    q: Vec<Lanes>,
    r: Vec<Lanes>,
    /// E_Y h A0 [J]; 0 in lanes without a triangle.
    pub(super) stiffness: Vec<Lanes>,
    nu: Lanes,
}

/// A symmetric 2 x 2 tensor: 11, 22, 12.
pub(super) type Tensor = [Lanes; 3];

impl Flat {
    /// The triangles of the mesh.
    ///
    /// # Errors
    /// `DegenerateTriangle`.
    pub(super) fn new(assembly: &Assembly) -> Result<Self> {
        // Taken from its lowest node: turned by a third of a turn, a triangle is the same triangle.
        let turned = assembly.mesh.triangles.iter().map(|&nodes| {
            let inside = assembly.layout.inward(nodes);
            let lowest = (0..3).min_by_key(|&k| inside[k]).unwrap_or(0);
            [nodes, inside].map(|mut nodes| {
                nodes.rotate_left(lowest);
                nodes
            })
        });
        let (outside, inside): (Vec<_>, Vec<_>) = turned.map(|[outside, inside]| (outside, inside)).unzip();
        let elements = Elements::new(&inside, assembly.masses.len());
        let (stretch, nu) =
            assembly.model.film.map_or((0.0, 0.0), |film| (film.youngs_modulus * film.thickness, film.poisson_ratio));
        let mut rows = Vec::with_capacity(outside.len());
        for (triangle, nodes) in outside.iter().enumerate() {
            let area = assembly.mesh.area(triangle)?;
            let [a, b, c] = nodes.map(|node| assembly.mesh.reference[node as usize]);
            let (u, v) = (mesh::sub(b, a), mesh::sub(c, a));
            let side = mesh::dot(u, u).sqrt();
            // In the frame along u: u = (side, 0), v = (along, height).
            let (along, height) = (mesh::dot(u, v) / side, 2.0 * area / side);
            rows.push([1.0 / side, -along / (side * height), 1.0 / height, stretch * area]);
        }
        Ok(Self {
            p: elements.pack(1.0, |row| rows[row][0]),
            q: elements.pack(0.0, |row| rows[row][1]),
            r: elements.pack(1.0, |row| rows[row][2]),
            stiffness: elements.pack(0.0, |row| rows[row][3]),
            nu: Lanes::all(nu),
            elements,
        })
    }

    /// The columns of the gradient of a vector at the nodes.
    #[inline(always)]
    pub(super) fn gradient(&self, group: usize, [a, b, c]: [Point; 3]) -> [Point; 2] {
        let (u, v) = (sub(b, a), sub(c, a));
        [scale(self.p[group], u), sum(scale(self.q[group], u), scale(self.r[group], v))]
    }

    /// What stress s, times E_Y h A0, pulls the nodes by: the negative derivative of the strain energy.
    #[inline(always)]
    pub(super) fn pull(&self, group: usize, [f1, f2]: [Point; 2], s: Tensor) -> [Point; 3] {
        let k = self.stiffness[group];
        let [s11, s22, s12] = [k * s[0], k * s[1], k * s[2]];
        let along_1 = sum(scale(s11, f1), scale(s12, f2));
        let along_2 = sum(scale(s12, f1), scale(s22, f2));
        let at_b = sum(scale(self.p[group], along_1), scale(self.q[group], along_2));
        let at_c = scale(self.r[group], along_2);
        [sum(at_b, at_c), negate(at_b), negate(at_c)]
    }

    /// The stress of a film that does not wrinkle, over E_Y.
    #[inline(always)]
    pub(super) fn stress(&self, e: Tensor) -> Tensor {
        let one = Lanes::all(1.0);
        let shear = one / (one + self.nu);
        let factor = shear / (one - self.nu);
        [factor * (e[0] + self.nu * e[1]), factor * (e[1] + self.nu * e[0]), shear * e[2]]
    }
}

/// Green's strain of a gradient.
#[inline(always)]
fn strain([f1, f2]: [Point; 2]) -> Tensor {
    let (half, one) = (Lanes::all(0.5), Lanes::all(1.0));
    [half * (dot(f1, f1) - one), half * (dot(f2, f2) - one), half * dot(f1, f2)]
}

/// The change of Green's strain as the gradient changes by `rate`.
#[inline(always)]
pub(super) fn strain_rate([f1, f2]: [Point; 2], [g1, g2]: [Point; 2]) -> Tensor {
    [dot(f1, g1), dot(f2, g2), Lanes::all(0.5) * (dot(f1, g2) + dot(f2, g1))]
}

/// Mean of the principal values of a tensor, and half of their difference.
#[inline(always)]
fn principal(t: Tensor) -> (Lanes, Lanes) {
    let half = Lanes::all(0.5);
    let difference = half * (t[0] - t[1]);
    (half * (t[0] + t[1]), (difference * difference + t[2] * t[2]).sqrt())
}

/// The law: all triangles, eight to a group.
pub(super) struct Triangles {
    flat: Flat,
    /// sigma_c / E_Y: the critical strain in uniaxial compression.
    critical: Vec<Lanes>,
    compression: Lanes,
    strain_limit: f64,
    width: Width,
}

/// What a group's films bear: principal stresses over E_Y without wrinkles and with them, and principal strains.
struct Film {
    /// Half the difference of the principal stresses without wrinkles.
    spread: Lanes,
    taut: [Lanes; 2],
    relaxed: [Lanes; 2],
    strain: [Lanes; 2],
}

impl Triangles {
    pub(super) fn new(parameters: TriangleParameters, assembly: &Assembly) -> Result<Self> {
        let TriangleParameters { compression, buckling, buckling_on_creases, buckling_length, strain_limit } =
            parameters;
        let inside = (0.0..=1.0).contains(&compression);
        within("compression of the triangles", compression, inside, "it lies between 0 and 1")?;
        positive("strain limit of the triangles", strain_limit)?;
        let buckling = Buckling { parameter: buckling, on_creases: buckling_on_creases, length: buckling_length };
        let strains: Vec<f64> =
            buckling.shortenings(assembly)?.into_iter().map(|(length, shortening)| shortening / length).collect();
        let flat = Flat::new(assembly)?;
        let critical = flat.elements.pack(0.0, |row| {
            assembly.mesh.triangle_edges[row].iter().map(|&edge| strains[edge as usize]).sum::<f64>() / 3.0
        });
        Ok(Self { flat, critical, compression: Lanes::all(compression), strain_limit, width: assembly.width })
    }

    #[inline(always)]
    fn film(&self, group: usize, e: Tensor, s: Tensor) -> Film {
        let (mean_strain, strain_spread) = principal(e);
        let (mean, spread) = principal(s);
        let taut = [mean + spread, mean - spread];
        let strain = [mean_strain + strain_spread, mean_strain - strain_spread];
        let (nu, bound) = (self.flat.nu, -self.critical[group]);
        let wrinkled = (strain[0] + nu * bound).max(bound);
        let relaxed = [taut[1].below(bound, wrinkled, taut[0]), taut[1].max(bound)];
        Film { spread, taut, relaxed, strain }
    }

    /// Stress over E_Y, wrinkles and all.
    #[inline(always)]
    fn stress(&self, group: usize, e: Tensor) -> Tensor {
        let s = self.flat.stress(e);
        let Film { spread, taut: [s1, s2], relaxed: [r1, r2], .. } = self.film(group, e, s);
        // What wrinkles take off: d1 and d2 of the principal stresses, in the same directions.
        let share = Lanes::all(0.5) * (Lanes::all(1.0) - self.compression);
        let (d1, d2) = (share * (r1 - s1), share * (r2 - s2));
        let (off, turn) = (d1 + d2, (d1 - d2) / spread.max(Lanes::all(f64::MIN_POSITIVE)));
        let lean = Lanes::all(0.5) * turn * (s[0] - s[1]);
        [s[0] + off + lean, s[1] + off - lean, s[2] + turn * s[2]]
    }

    /// Energy of a group over E_Y h A0.
    fn density(&self, group: usize, e: Tensor) -> Lanes {
        let Film { taut: [s1, s2], relaxed: [r1, r2], strain: [e1, e2], .. } = self.film(group, e, self.flat.stress(e));
        let (nu, half, bound) = (self.flat.nu, Lanes::all(0.5), -self.critical[group]);
        let whole = half * (s1 * e1 + s2 * e2);
        // The elastic part of the strain, and the wrinkles' part at its price.
        let (elastic_1, elastic_2) = (r1 - nu * r2, r2 - nu * r1);
        let wrinkles = elastic_1 - e1 + elastic_2 - e2;
        let relaxed = half * (r1 * elastic_1 + r2 * elastic_2) - bound * wrinkles;
        let relaxed = s2.below(bound, relaxed, whole);
        self.compression * whole + (Lanes::all(1.0) - self.compression) * relaxed
    }

    fn gradients<'a>(&'a self, x: [&'a [f64]; 3]) -> impl Iterator<Item = (usize, [Point; 2])> + 'a {
        let Flat { elements, .. } = &self.flat;
        (0..elements.group_count()).map(move |group| (group, self.flat.gradient(group, elements.read_any(x, group))))
    }
}

/// Adds the triangles' pulls to the forces.
struct Pull<'a> {
    triangles: &'a Triangles,
    positions: [&'a [f64]; 3],
    forces: [&'a mut [f64]; 3],
}

impl Pull<'_> {
    #[inline(always)]
    fn part<const LOOSE: bool>(&mut self) {
        let Triangles { flat, .. } = self.triangles;
        for group in flat.elements.groups::<LOOSE>() {
            let gradient = flat.gradient(group, flat.elements.read::<LOOSE>(self.positions, group));
            let pull = flat.pull(group, gradient, self.triangles.stress(group, strain(gradient)));
            flat.elements.add::<LOOSE>(&mut self.forces, group, pull);
        }
    }
}

impl Sweep for Pull<'_> {
    type Output = ();

    #[inline(always)]
    fn sweep(mut self) {
        self.part::<false>();
        self.part::<true>();
    }
}

impl Law for Triangles {
    fn name(&self) -> &'static str {
        "triangles"
    }

    fn is_conservative(&self) -> bool {
        true
    }

    fn add_forces(&self, at: Instant<'_>, forces: &mut Vectors) -> f64 {
        self.width.run(Pull { triangles: self, positions: columns(at.positions), forces: columns_mut(forces) });
        0.0
    }

    fn energy(&self, at: Instant<'_>) -> f64 {
        let energies = self.gradients(columns(at.positions));
        energies.map(|(group, f)| (self.flat.stiffness[group] * self.density(group, strain(f))).sum()).sum()
    }

    /// That of the taut film.
    fn add_stiffness_product(&self, at: Instant<'_>, p: &Vectors, out: &mut Vectors) {
        let p = columns(p);
        let mut out = columns_mut(out);
        for (group, f) in self.gradients(columns(at.positions)) {
            let change = self.flat.gradient(group, self.flat.elements.read_any(p, group));
            let stress = self.flat.stress(strain_rate(f, change));
            let product = self.flat.pull(group, f, stress).map(negate);
            self.flat.elements.add_any(&mut out, group, product);
        }
    }

    fn first_excess(&self, at: Instant<'_>) -> Option<Excess> {
        // By length: (1 + strain)^2 = 1 + 2 e1.
        let bound = 0.5 * ((1.0 + self.strain_limit).powi(2) - 1.0);
        let mut excesses = self.gradients(columns(at.positions)).filter_map(|(group, f)| {
            let (mean, spread) = principal(strain(f));
            let held = self.flat.stiffness[group];
            let largest = mean + spread;
            let lane = (0..held.0.len()).find(|&lane| held.0[lane] > 0.0 && largest.0[lane] > bound)?;
            let percent = 100.0 * ((1.0 + 2.0 * largest.0[lane]).sqrt() - 1.0);
            let [a, b, _] = self.flat.elements.nodes(group, lane);
            let what = format!(
                "a triangle is stretched by {percent:.3} %, over its bound of {:.3} %",
                100.0 * self.strain_limit
            );
            Some(Excess { nodes: [a, b], what })
        });
        excesses.next()
    }

    fn readings(&self, at: Instant<'_>) -> Readings {
        let films: Vec<(Film, Lanes)> = self
            .gradients(columns(at.positions))
            .map(|(group, f)| {
                let e = strain(f);
                (self.film(group, e, self.flat.stress(e)), -self.critical[group])
            })
            .collect();
        let unpack = |take: &dyn Fn(&(Film, Lanes)) -> Lanes| self.flat.elements.unpack(films.iter().map(take));
        let (larger, smaller) = (unpack(&|(film, _)| film.strain[0]), unpack(&|(film, _)| film.strain[1]));
        let (zero, one) = (Lanes::ZERO, Lanes::all(1.0));
        let state = unpack(&|(film, bound)| {
            let slack = bound.below(film.relaxed[0], zero, one);
            film.taut[1].below(*bound, one + slack, zero)
        });
        Readings::Triangles {
            strain: larger.into_iter().zip(smaller).map(|(larger, smaller)| [larger, smaller]).collect(),
            state: state.into_iter().map(|state| state as u8).collect(),
        }
    }

    fn share_in_runs(&self) -> Option<f64> {
        Some(self.flat.elements.share_in_runs())
    }

    fn cure(&self) -> &'static str {
        "use a smaller dt, a start with less strain, or a higher strain limit if the stretch is meant"
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Film as Material, Model};
    use crate::width::Width;

    const NU: f64 = 0.3;

    /// One triangle of unit stiffness and area, with a critical strain that `buckling` sets.
    fn triangle(compression: f64, buckling: f64) -> Triangles {
        let points = vec![[0.0; 3], [2.0, 0.0, 0.0], [0.7, 1.0, 0.0]];
        let film = Material { youngs_modulus: 1.0, poisson_ratio: NU, density: 1.0, thickness: 1.0 };
        let model = Model {
            positions: points.clone(),
            velocities: vec![[0.0; 3]; 3],
            reference: points,
            triangles: vec![[0, 1, 2]],
            film: Some(film),
            extra_masses: vec![0.0; 3],
            ..Model::default()
        };
        let assembly = Assembly::new(model, Width::Baseline).unwrap();
        let parameters = TriangleParameters {
            compression,
            buckling,
            buckling_on_creases: buckling,
            buckling_length: Some(1.0),
            strain_limit: 0.1,
        };
        Triangles::new(parameters, &assembly).unwrap()
    }

    fn tensor(e: [f64; 3]) -> Tensor {
        e.map(Lanes::all)
    }

    fn stress(law: &Triangles, e: [f64; 3]) -> [f64; 3] {
        law.stress(0, tensor(e)).map(|lanes| lanes.0[0])
    }

    #[test]
    fn a_taut_film_is_hookes_and_a_wrinkled_one_bears_uniaxial_tension() {
        let law = triangle(0.0, 0.0);
        let taut = stress(&law, [0.02, 0.01, 0.0]);
        let factor = 1.0 / (1.0 - NU * NU);
        assert!((taut[0] - factor * (0.02 + NU * 0.01)).abs() < 1e-16);
        assert!((taut[1] - factor * (0.01 + NU * 0.02)).abs() < 1e-16);
        // Beyond the natural narrowing of -nu e the film wrinkles across.
        let wrinkled = stress(&law, [0.02, -0.015, 0.0]);
        assert!((wrinkled[0] - 0.02).abs() < 1e-16 && wrinkled[1].abs() < 1e-16, "{wrinkled:?}");
        assert!(stress(&law, [-0.02, -0.01, 0.003]).iter().all(|s| s.abs() < 1e-16));
    }

    #[test]
    fn uniaxial_compression_is_that_of_equation_2() {
        let critical = std::f64::consts::PI.powi(2) / 12.0 * 1e-2;
        let law = triangle(0.0, 1e-2);
        for (strain, expected) in [(-0.5 * critical, -0.5 * critical), (-3.0 * critical, -critical)] {
            // Free to widen.
            let found = stress(&law, [strain, -NU * expected, 0.0]);
            assert!((found[0] - expected).abs() < 1e-15 && found[1].abs() < 1e-15, "{found:?}");
        }
    }

    #[test]
    fn stress_is_the_slope_of_the_energy_and_continuous_over_every_state() {
        for (compression, buckling) in [(0.0, 0.0), (0.0, 0.01), (0.3, 0.01), (1.0, 0.0)] {
            let law = triangle(compression, buckling);
            let mut seen = [false; 3];
            for k in 0..400 {
                let angle = 0.05 * f64::from(k);
                let (mean, spread) = (0.02 * (0.37 * angle).sin(), 0.02 * (0.61 * angle).cos());
                let e = [mean + spread * angle.cos(), mean - spread * angle.cos(), spread * angle.sin()];
                let s = stress(&law, e);
                for i in 0..3 {
                    let step = 1e-6;
                    let mut sides = [e, e];
                    sides[0][i] += step;
                    sides[1][i] -= step;
                    let [above, below] = sides.map(|e| law.density(0, tensor(e)).0[0]);
                    let slope = (above - below) / (2.0 * step);
                    // The off-diagonal term counts twice.
                    let expected = if i == 2 { 2.0 * s[2] } else { s[i] };
                    // Over a kink of the second derivative: an error of the step's size.
                    assert!((slope - expected).abs() < 2.0 * step, "{e:?}: {slope} {expected}");
                }
                let film = law.film(0, tensor(e), law.flat.stress(tensor(e)));
                let bound = -law.critical[0].0[0];
                let state = if film.taut[1].0[0] >= bound { 0 } else { 1 + usize::from(film.relaxed[0].0[0] <= bound) };
                seen[state] = true;
            }
            assert_eq!(seen, [true; 3]);
        }
    }
}
