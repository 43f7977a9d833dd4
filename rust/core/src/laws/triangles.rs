//! In-plane elasticity by constant-strain triangles: a film that is isotropic at any Poisson's ratio, on any mesh, and that
//! wrinkles.
//!
//! With F = [f1 f2] the deformation gradient in an orthonormal frame (1, 2) of the flat triangle, St. Venant and
//! Kirchhoff's law in plane stress:
//!
//!     E = (F^T F - 1)/2,     S = E_Y/(1 - nu^2) [(1 - nu) E + nu tr(E) 1]   [Pa],     U = h A0 (S : E)/2   [J]
//!
//! A film cannot bear compression beyond the stress at which it buckles. Its energy is then the least that wrinkles, a
//! shortening W >= 0 (any symmetric tensor without negative eigenvalue) at the price of a stress P >= 0, can reach:
//!
//!     U_r(E) = min over W of  U(E + W) + h A0 P : W
//!
//! The minimum is convex in E and has one continuous derivative, so forces are -dU_r/dx and no energy is made. With
//! s1 >= s2 the principal values of S(E) + P, and e1 = s1 - nu s2, it is
//!
//!     taut      s2 >= 0             stress S
//!     wrinkled  s2 < 0, e1 > 0      stress with principal values e1 and 0 along the same axes, less P
//!     slack     s2 < 0, e1 <= 0     stress -P
//!     U_r = U - h A0/(2 E_Y) [(1 - nu^2) min(s2, 0)^2 + min(e1, 0)^2]
//!
//! At P = 0 this is tension-field theory: a wrinkled film bears uniaxial tension only. With P = E_Y eps_c in all directions
//! it is eq. (2) under uniaxial compression: the stress grows to E_Y eps_c and stays. eps_c is Euler's strain of a slender
//! column (see `buckling`), the mean over the triangle's sides; along a side that is a crease it is that of the crease,
//! so that a crease stiffens the film along itself and not across. A share c of the stiffness can be kept in
//! compression: U = c U_taut + (1 - c) U_r.
//!
//! Sources: Pipkin, IMA J. Appl. Math. 36 (1986), and Le Dret and Raoult, J. Math. Pures Appl. 74 (1995), for P = 0; the
//! price of wrinkles, which makes eq. (2) of Okuizumi et al. (2012) a case of it, is ours.

mod tangent;

use serde::Deserialize;

use super::buckling::Buckling;
use super::{
    Context, Excess, FilmElements, Inspection, Instant, Kernels, Law, LawParameters, Linearisation, Properties,
    Readings, WorkClass,
};
use crate::arrays::columns::{Columns, ColumnsMut};
use crate::arrays::jacobian::JacobianBlocks;
use crate::arrays::state::NodeVectors;
use crate::assembly::Assembly;
use crate::elements::triangle::{Corners, FlatTriangles, Tensor, strain, strain_rate};
use crate::error::Result;
use crate::model::checks::{positive, within};
use crate::simd::dispatch::{BatchKernel, InstructionSet};
use crate::simd::lanes::{F64x8, SimdF64, Vec3, negate};

/// Parameters of the triangles.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub struct TriangleParameters {
    /// Share of the stiffness that is left in compression, from 0 (a film) to 1 (a plate that cannot buckle).
    pub compression: f64,
    /// Buckling parameter alpha of eq. (2).
    pub buckling: f64,
    /// alpha on sides that are creases.
    pub buckling_on_creases: f64,
    /// Length in place of each side's own in eq. (2) \[m\]; `None`: its own.
    pub buckling_length: Option<f64>,
    /// Length that gives creases a buckling force of their own \[m\]; `None`: a critical strain.
    pub crease_length: Option<f64>,
    /// Principal strain, by length, at which a run stops.
    pub strain_limit: f64,
}

impl LawParameters for TriangleParameters {
    fn build(&self, context: &Context<'_>) -> Result<Box<dyn Law>> {
        Ok(Box::new(Triangles::new(*self, context.assembly)?))
    }

    fn example() -> Self {
        Self {
            compression: 0.1,
            buckling: 100.0,
            buckling_on_creases: 1000.0,
            buckling_length: None,
            crease_length: None,
            strain_limit: 1e9,
        }
    }

    fn film(&self) -> Option<FilmElements> {
        Some(FilmElements::Triangles)
    }
}

/// Mean of the principal values of a tensor, and half of their difference.
#[inline(always)]
fn principal<V: SimdF64>(t: Tensor<V>) -> (V, V) {
    let half = V::all(0.5);
    let difference = half * (t[0] - t[1]);
    (half * (t[0] + t[1]), (difference * difference + t[2] * t[2]).sqrt())
}

/// The law: all triangles, eight to a batch.
struct Triangles {
    flat: FlatTriangles,
    /// P / E_Y, the price of wrinkles: the critical strain.
    price: Vec<Tensor>,
    compression: f64,
    strain_limit: f64,
    instructions: InstructionSet,
}

/// What wrinkles a batch's films have.
struct Wrinkles<V> {
    /// min(s2, 0) and min(e1, 0) over E_Y.
    second: V,
    first: V,
    /// S + P over E_Y, and half the difference of its principal values.
    stress: Tensor<V>,
    spread: V,
}

impl Triangles {
    fn new(parameters: TriangleParameters, assembly: &Assembly) -> Result<Self> {
        let TriangleParameters {
            compression,
            buckling,
            buckling_on_creases,
            buckling_length: length,
            crease_length,
            strain_limit,
        } = parameters;
        let inside = (0.0..=1.0).contains(&compression);
        within("compression of the triangles", compression, inside, "it lies between 0 and 1")?;
        positive("strain limit of the triangles", strain_limit)?;
        let of = |on_creases| {
            let buckling = Buckling { parameter: buckling, on_creases, length, crease_length };
            let shortenings = buckling.shortenings(assembly)?;
            Ok(shortenings.into_iter().map(|(length, shortening)| shortening / length).collect::<Vec<f64>>())
        };
        let (plain, creased) = (of(buckling)?, of(buckling_on_creases)?);
        let flat = FlatTriangles::new(assembly)?;
        let prices: Vec<[f64; 3]> = Corners::all(assembly)
            .map(|corners| {
                let edges = corners.edges.map(|edge| edge as usize);
                let mean = edges.iter().map(|&edge| plain[edge].min(creased[edge])).sum::<f64>() / 3.0;
                let mut price = [mean, mean, 0.0];
                for (&edge, direction) in edges.iter().zip(corners.directions()) {
                    // Along a crease what the crease can bear; prices stay positive in every direction.
                    let more = if creased[edge] > plain[edge] { (creased[edge] - mean).max(0.0) } else { 0.0 };
                    (0..3).for_each(|i| price[i] += more * direction[i]);
                }
                price
            })
            .collect();
        let [a, b, c] = [0, 1, 2].map(|i| flat.elements.pack(0.0, |row| prices[row][i]));
        let price = a.into_iter().zip(b).zip(c).map(|((a, b), c)| [a, b, c]).collect();
        Ok(Self { flat, price, compression, strain_limit, instructions: assembly.instructions })
    }

    #[inline(always)]
    fn wrinkles<V: SimdF64>(&self, batch: usize, s: Tensor<V>) -> Wrinkles<V> {
        let price = &self.price[batch];
        let stress = [s[0] + V::load(&price[0]), s[1] + V::load(&price[1]), s[2] + V::load(&price[2])];
        let (mean, spread) = principal(stress);
        let (s1, s2) = (mean + spread, mean - spread);
        let first = s1 - V::all(self.flat.nu) * s2;
        Wrinkles { second: s2.min(V::zero()), first: first.min(V::zero()), stress, spread }
    }

    /// Stress over E_Y, wrinkles and all.
    #[inline(always)]
    fn stress<V: SimdF64>(&self, batch: usize, e: Tensor<V>) -> Tensor<V> {
        let s = self.flat.stress(e);
        let Wrinkles { second, first, stress, spread } = self.wrinkles(batch, s);
        // What wrinkles take off the principal stresses, half of their sum and of their difference.
        let half = V::all(0.5 * (self.compression - 1.0));
        let (d1, d2) = (V::all(self.flat.nu) * second + first, second);
        let off = half * (d1 + d2);
        let turn = half * (d1 - d2) / spread.max(V::all(f64::MIN_POSITIVE));
        let lean = V::all(0.5) * turn * (stress[0] - stress[1]);
        [s[0] + off + lean, s[1] + off - lean, s[2] + turn * stress[2]]
    }

    /// Energy of a batch over E_Y h A0.
    fn density(&self, batch: usize, e: Tensor) -> F64x8 {
        let s = self.flat.stress(e);
        let Wrinkles { second, first, .. } = self.wrinkles(batch, s);
        let [one, half, nu] = [1.0, 0.5, self.flat.nu].map(F64x8::all);
        let whole = half * (s[0] * e[0] + s[1] * e[1]) + s[2] * e[2];
        let saved = half * ((one - nu * nu) * second * second + first * first);
        whole - F64x8::all(1.0 - self.compression) * saved
    }

    fn gradients<'a>(&'a self, x: Columns<'a>) -> impl Iterator<Item = (usize, [Vec3; 2])> + 'a {
        let FlatTriangles { elements, .. } = &self.flat;
        (0..elements.batch_count()).map(move |batch| (batch, self.flat.gradient(batch, elements.read_any(x, batch))))
    }
}

/// Adds the triangles' pulls to the forces.
struct StressKernel<'a> {
    triangles: &'a Triangles,
    tile: usize,
    positions: Columns<'a>,
    forces: ColumnsMut<'a>,
}

/// The same for a plate that does not wrinkle: wrinkles would take nothing off.
struct PlateKernel<'a>(StressKernel<'a>);

impl StressKernel<'_> {
    #[inline(always)]
    fn go<V: SimdF64, const KIND: usize, const WRINKLES: bool>(&mut self) -> V {
        let Triangles { flat, .. } = self.triangles;
        let pass = flat.elements.pass::<KIND>(self.tile, self.positions.rows());
        for place in 0..pass.len() {
            let batch = pass.place(place);
            let gradient = flat.gradient(batch, pass.read::<V, 3>(self.positions, place));
            let e = strain(gradient);
            let stress = if WRINKLES { self.triangles.stress(batch, e) } else { flat.stress(e) };
            let pull = flat.pull(batch, gradient, stress);
            pass.add(&mut self.forces, place, pull);
        }
        V::zero()
    }
}

impl BatchKernel for StressKernel<'_> {
    #[inline(always)]
    fn part<V: SimdF64, const KIND: usize>(&mut self) -> V {
        self.go::<V, KIND, true>()
    }
}

impl BatchKernel for PlateKernel<'_> {
    #[inline(always)]
    fn part<V: SimdF64, const KIND: usize>(&mut self) -> V {
        self.0.go::<V, KIND, false>()
    }
}

impl Law for Triangles {
    fn properties(&self) -> Properties {
        Properties {
            name: "triangles",
            work_class: WorkClass::Conservative,
            depends_on_velocity: false,
            is_internal: true,
        }
    }

    fn kernels(&self) -> Kernels {
        Kernels::of_elements()
    }

    fn add_to_tile(&mut self, tile: usize, at: Instant<'_>, forces: &mut NodeVectors) -> f64 {
        let (positions, forces) = (Columns::of(at.positions), ColumnsMut::of(forces));
        let pull = StressKernel { triangles: self, tile, positions, forces };
        if self.compression == 1.0 {
            self.instructions.run_batches(PlateKernel(pull))
        } else {
            self.instructions.run_batches(pull)
        }
    }

    fn energy(&self, at: Instant<'_>) -> f64 {
        let energies = self.gradients(Columns::of(at.positions));
        energies.map(|(batch, f)| (self.flat.stiffness[batch] * self.density(batch, strain(f))).sum()).sum()
    }

    fn linearisation(&self) -> Option<&dyn Linearisation> {
        Some(self)
    }

    fn inspection(&self) -> Option<&dyn Inspection> {
        Some(self)
    }

    fn remedy(&self) -> &'static str {
        "use a smaller dt, a start with less strain, or a higher strain limit if the stretch is meant"
    }
}

impl Linearisation for Triangles {
    /// That of the taut film.
    fn add_stiffness_product(&self, at: Instant<'_>, p: &NodeVectors, out: &mut NodeVectors) {
        let p = Columns::of(p);
        let mut out = ColumnsMut::of(out);
        for (batch, f) in self.gradients(Columns::of(at.positions)) {
            let change = self.flat.gradient(batch, self.flat.elements.read_any(p, batch));
            let stress = self.flat.stress(strain_rate(f, change));
            let product = self.flat.pull(batch, f, stress).map(negate);
            self.flat.elements.add_any(&mut out, batch, product);
        }
    }

    fn visit_couplings(&self, visit: &mut dyn FnMut(&[u32])) {
        self.flat.elements.each().for_each(|(.., nodes)| visit(&nodes));
    }

    fn add_jacobian(&self, at: Instant<'_>, jacobian: &mut dyn JacobianBlocks) {
        self.jacobian(at, jacobian);
    }
}

impl Inspection for Triangles {
    fn first_excess(&self, at: Instant<'_>) -> Option<Excess> {
        // By length: (1 + strain)^2 = 1 + 2 e1.
        let bound = 0.5 * ((1.0 + self.strain_limit).powi(2) - 1.0);
        let mut excesses = self.gradients(Columns::of(at.positions)).filter_map(|(batch, f)| {
            let (mean, spread) = principal(strain(f));
            let held = self.flat.stiffness[batch];
            let largest = mean + spread;
            let lane = (0..held.0.len()).find(|&lane| held.0[lane] > 0.0 && largest.0[lane] > bound)?;
            let percent = 100.0 * ((1.0 + 2.0 * largest.0[lane]).sqrt() - 1.0);
            let [a, b, _] = self.flat.elements.nodes(batch, lane);
            let what = format!(
                "a triangle is stretched by {percent:.3} %, over its bound of {:.3} %",
                100.0 * self.strain_limit
            );
            Some(Excess { nodes: [a, b], what })
        });
        excesses.next()
    }

    fn readings(&self, at: Instant<'_>) -> Readings {
        let films = self.gradients(Columns::of(at.positions)).map(|(batch, f)| {
            let e = strain(f);
            let (mean, spread) = principal(e);
            let Wrinkles { second, first, .. } = self.wrinkles(batch, self.flat.stress(e));
            let (zero, one) = (F64x8::ZERO, F64x8::all(1.0));
            [mean + spread, mean - spread, second.below(zero, one, zero) + first.below(zero, one, zero)]
        });
        let films: Vec<[F64x8; 3]> = films.collect();
        let [larger, smaller, state] = [0, 1, 2].map(|k| self.flat.elements.unpack(films.iter().map(|film| film[k])));
        Readings::Triangles {
            strain: larger.into_iter().zip(smaller).map(|(larger, smaller)| [larger, smaller]).collect(),
            state: state.into_iter().map(|state| state as u8).collect(),
        }
    }

    fn lanes(&self) -> [usize; 2] {
        self.flat.elements.lanes()
    }

    fn contiguous_share(&self) -> f64 {
        self.flat.elements.contiguous_share()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::input::{Film as Material, Model};
    use crate::simd::dispatch::InstructionSet;

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
        let assembly = Assembly::new(model, InstructionSet::Baseline).unwrap();
        let parameters = TriangleParameters {
            compression,
            buckling,
            buckling_on_creases: buckling,
            buckling_length: Some(1.0),
            crease_length: None,
            strain_limit: 0.1,
        };
        Triangles::new(parameters, &assembly).unwrap()
    }

    fn tensor(e: [f64; 3]) -> Tensor {
        e.map(F64x8::all)
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
                let wrinkles = law.wrinkles(0, law.flat.stress(tensor(e)));
                let [second, first] = [wrinkles.second, wrinkles.first].map(|lanes| usize::from(lanes.0[0] < 0.0));
                seen[second + first] = true;
            }
            assert_eq!(seen, [true; 3]);
        }
    }
}
