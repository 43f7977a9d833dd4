//! In-plane elasticity by constant-strain triangles: a film, isotropic at any Poisson's ratio, that wrinkles.
//!
//! With F = [f1 f2] the deformation gradient in an orthonormal frame (1, 2) of the flat triangle, the law is that of
//! St. Venant and Kirchhoff in plane stress:
//!
//!     E = (F^T F - 1)/2,     S = E_Y/(1 - nu^2) [(1 - nu) E + nu tr(E) 1]   [Pa],     U = h A0 (S : E)/2   [J]
//!
//! A film bears no compression beyond the stress P >= 0 at which it buckles. Its energy is the minimum over all wrinkle
//! states. A wrinkle shortens the film by W, a symmetric tensor without negative eigenvalue, against the stress P:
//!
//!     U_r(E) = min over W of  U(E + W) + h A0 P : W
//!
//! U_r is convex in E with a continuous derivative, so that the forces -dU_r/dx conserve energy. With s1 >= s2 the
//! principal values of S(E) + P, and e1 = s1 - nu s2,
//!
//!     taut      s2 >= 0             stress S
//!     wrinkled  s2 < 0, e1 > 0      stress with principal values e1 and 0 along the same axes, less P
//!     slack     s2 < 0, e1 <= 0     stress -P
//!     U_r = U - h A0/(2 E_Y) [(1 - nu^2) min(s2, 0)^2 + min(e1, 0)^2]
//!
//! At P = 0 this is tension-field theory: a wrinkled film bears uniaxial tension only. With P = E_Y eps_c in all
//! directions it is eq. (2) under uniaxial compression: the stress grows to E_Y eps_c and remains constant. eps_c is
//! the mean over the sides of a triangle of Euler's critical strain of a slender column (see `buckling`). Along a side
//! that is a crease it is that of the crease, so that a crease stiffens the film along the crease and not across it.
//! With a share c of the stiffness in compression, U = c U_taut + (1 - c) U_r.
//!
//! Sources: Pipkin, IMA J. Appl. Math. 36 (1986), and Le Dret and Raoult, J. Math. Pures Appl. 74 (1995), for P = 0;
//! the stress P, with eq. (2) of Okuizumi et al. (2012) as a special case, is added here.

mod measures;
mod tangent;
mod wrinkles;

use serde::Deserialize;

use self::wrinkles::principal;
use super::buckling::{Buckling, Edge, edges};
use super::{
    Context, Excess, FilmElements, FilmStates, Inspection, Instant, Kernels, Law, LawParameters, Linearisation,
    Properties, WorkClass,
};
use crate::arrays::columns::{Columns, ColumnsMut};
use crate::arrays::jacobian::JacobianBlocks;
use crate::arrays::state::NodeVectors;
use crate::assembly::Assembly;
use crate::elements::stress::TriangleStress;
use crate::elements::triangle::{Corners, FlatTriangles, Tensor, strain, strain_rate};
use crate::error::Result;
use crate::model::checks::{positive, within};
use crate::simd::dispatch::{BatchKernel, InstructionSet};
use crate::simd::lanes::{SimdF64, Vec3, negate};

/// Parameters of the triangles.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TriangleParameters {
    /// c, the share of the stiffness in compression, from 0 (a film) to 1 (a plate without buckling).
    pub compression: f64,
    /// Buckling parameter alpha of eq. (2).
    pub buckling: f64,
    /// alpha on sides that are creases.
    pub buckling_on_creases: f64,
    /// l0 in place of the length of each side in eq. (2) \[m\]; `None`: the length of each side.
    pub buckling_length: Option<f64>,
    /// l_c of the buckling force of creases \[m\]; `None`: a critical strain.
    pub crease_length: Option<f64>,
    /// Principal engineering strain at which a run stops.
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

/// The law: all triangles, in batches of eight.
struct Triangles {
    flat: FlatTriangles,
    /// P / E_Y, the critical strain.
    critical_strain: Vec<Tensor>,
    compression: f64,
    strain_limit: f64,
    /// E_Y of each triangle, in external order [Pa].
    moduli: Vec<f64>,
    /// The edges opposite the corners of each triangle, and the number of edges, in external order.
    sides: Vec<[u32; 3]>,
    edge_count: usize,
    instructions: InstructionSet,
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
        let buckling = Buckling { parameter: buckling, on_creases: buckling_on_creases, length, crease_length };
        buckling.check()?;
        let all_edges = edges(assembly);
        let flat = FlatTriangles::new(assembly)?;
        if compression < 1.0 {
            let what = "triangles that wrinkle";
            let remedy =
                "set compression of the triangles to 1, and let the mesh resolve wrinkles by the law \"bending\"";
            assembly.film.as_ref().map_or(Ok(()), |film| film.require_one_modulus("triangles", what, remedy))?;
        }
        let mut sides = Vec::with_capacity(assembly.mesh.triangles.len());
        let mut critical_strains = Vec::with_capacity(sides.capacity());
        for (triangle, corners) in Corners::all(assembly).enumerate() {
            let film = assembly.film.as_ref().map(|film| film.of(triangle));
            let strain_of = |edge: Edge| film.map_or(0.0, |film| buckling.shortening(film, edge) / edge.length);
            let edges = corners.edges.map(|edge| all_edges[edge as usize]);
            let plain = edges.map(|edge| strain_of(Edge { is_crease: false, ..edge }));
            let creased = edges.map(strain_of);
            let mean = plain.iter().zip(creased).map(|(&plain, creased)| plain.min(creased)).sum::<f64>() / 3.0;
            let mut critical = [mean, mean, 0.0];
            for (k, direction) in corners.directions().into_iter().enumerate() {
                // Along a crease, its own critical strain; the tensor is positive in every direction.
                let difference = if creased[k] > plain[k] { (creased[k] - mean).max(0.0) } else { 0.0 };
                (0..3).for_each(|i| critical[i] += difference * direction[i]);
            }
            sides.push(corners.edges);
            critical_strains.push(critical);
        }
        let [a, b, c] = [0, 1, 2].map(|i| flat.elements.pack(0.0, |row| critical_strains[row][i]));
        let critical_strain = a.into_iter().zip(b).zip(c).map(|((a, b), c)| [a, b, c]).collect();
        let modulus = |row| assembly.film.as_ref().map_or(0.0, |film| film.of(row).film.youngs_modulus);
        Ok(Self {
            flat,
            critical_strain,
            compression,
            strain_limit,
            moduli: (0..assembly.mesh.triangles.len()).map(modulus).collect(),
            sides,
            edge_count: assembly.mesh.edges.len(),
            instructions: assembly.instructions,
        })
    }

    /// Number and deformation gradients of every batch.
    fn gradients<'a>(&'a self, x: Columns<'a>) -> impl Iterator<Item = (usize, [Vec3; 2])> + 'a {
        let FlatTriangles { elements, .. } = &self.flat;
        (0..elements.batch_count()).map(move |batch| (batch, self.flat.gradient(batch, elements.read_any(x, batch))))
    }
}

/// Adds the nodal forces of the stress.
struct StressKernel<'a> {
    triangles: &'a Triangles,
    tile: usize,
    positions: Columns<'a>,
    forces: ColumnsMut<'a>,
}

/// The same for a plate without wrinkles.
struct PlateKernel<'a>(StressKernel<'a>);

impl StressKernel<'_> {
    #[inline(always)]
    fn add_forces<V: SimdF64, const KIND: usize, const WRINKLES: bool>(&mut self) -> V {
        let Triangles { flat, .. } = self.triangles;
        let pass = flat.elements.pass::<KIND>(self.tile, self.positions.rows());
        let positions = pass.reader(self.positions);
        let mut sums = pass.adder(&mut self.forces);
        for place in 0..pass.len() {
            let batch = pass.place(place);
            let gradient = flat.gradient(batch, positions.read::<V>(place));
            let e = strain(gradient);
            let stress = if WRINKLES { self.triangles.stress(batch, e) } else { flat.stress(batch, e) };
            sums.add(place, flat.nodal_forces(batch, gradient, stress));
        }
        V::zero()
    }
}

impl BatchKernel for StressKernel<'_> {
    #[inline(always)]
    fn sweep_kind<V: SimdF64, const KIND: usize>(&mut self) -> V {
        self.add_forces::<V, KIND, true>()
    }
}

impl BatchKernel for PlateKernel<'_> {
    #[inline(always)]
    fn sweep_kind<V: SimdF64, const KIND: usize>(&mut self) -> V {
        self.0.add_forces::<V, KIND, false>()
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

    fn reach(&self, tile: usize) -> usize {
        self.flat.elements.reach(tile)
    }

    fn add_to_tile(&mut self, tile: usize, at: Instant<'_>, forces: &mut NodeVectors) -> f64 {
        let (positions, forces) = (Columns::of(at.positions), ColumnsMut::of(forces));
        let kernel = StressKernel { triangles: self, tile, positions, forces };
        if self.compression == 1.0 {
            self.instructions.run_batches(PlateKernel(kernel))
        } else {
            self.instructions.run_batches(kernel)
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
    /// The stiffness of the taut film, without its geometric part.
    fn add_stiffness_product(&self, at: Instant<'_>, p: &NodeVectors, out: &mut NodeVectors) {
        let p = Columns::of(p);
        let mut out = ColumnsMut::of(out);
        for (batch, f) in self.gradients(Columns::of(at.positions)) {
            let rate = self.flat.gradient(batch, self.flat.elements.read_any(p, batch));
            let stress = self.flat.stress(batch, strain_rate(f, rate));
            let product = self.flat.nodal_forces(batch, f, stress).map(negate);
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
        // Engineering strain: (1 + strain)^2 = 1 + 2 e1.
        let bound = 0.5 * ((1.0 + self.strain_limit).powi(2) - 1.0);
        let mut excesses = self.gradients(Columns::of(at.positions)).filter_map(|(batch, f)| {
            let (mean, spread) = principal(strain(f));
            let stiffness = self.flat.stiffness[batch];
            let largest = mean + spread;
            let lane = (0..stiffness.0.len()).find(|&lane| stiffness.0[lane] > 0.0 && largest.0[lane] > bound)?;
            let percent = 100.0 * ((1.0 + 2.0 * largest.0[lane]).sqrt() - 1.0);
            let [a, b, _] = self.flat.elements.nodes(batch, lane);
            let what = format!(
                "a triangle is stretched by {percent:.3} %, over its bound of {:.3} %",
                100.0 * self.strain_limit
            );
            Some(Excess { nodes: vec![a, b], what })
        });
        excesses.next()
    }

    fn film_stress(&self, at: Instant<'_>) -> Option<Vec<TriangleStress>> {
        Some(self.triangle_stress(at))
    }

    fn film_states(&self, at: Instant<'_>) -> Option<FilmStates> {
        Some(self.states(at))
    }

    fn lanes(&self) -> [usize; 2] {
        self.flat.elements.lanes()
    }

    fn contiguous_share(&self) -> Option<f64> {
        Some(self.flat.elements.contiguous_share())
    }
}
