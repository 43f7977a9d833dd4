//! Bending by hinges: one constant for each edge.
//!
//! On two lattices hinges represent an isotropic plate: equilateral triangles of side e, and rectangles a x b with
//! alternating diagonals d, with
//!
//!     k   = 2 D / sqrt(3)                                   equilateral triangles
//!     k_a = 8/3 D a b / (3 b^2 - a^2),  k_b alike,  k_d = 8/3 D a b / d^2     rectangles; 4/3 D on squares
//!
//! The cylinder has D in every direction, and Poisson's ratio of bending is -1/3: a hinge has one normal curvature, and
//! no constants of these lattices give another ratio. A narrow strip, whose sides are free, has 8/9 D, the film's own
//! (1 - nu^2) D at nu = 1/3.
//!
//! The lattice of rectangles has two kinds of nodes, where four and eight edges meet. Under a curvature those of four
//! move out of the surface by some w, which minimises the energy: the fold angles are kappa_yy b - 2 w/b on a, likewise
//! on b, and +-kappa_xy d - 2 w d/(a b) on the diagonals. With the constants of a surface that all nodes follow, D a/b
//! and 2 D a b/d^2, a lattice of squares has 3/4 D only.
//!
//! Where the mesh is not a lattice, a b is the area of both facets of an edge, and k = D e^2 / (a b) where they are not
//! right-angled; 3 b^2 - a^2 is at least b^2. Between two films D is the harmonic mean by the areas of the facets: both
//! bear one moment, and the fold angle is the sum of what it bends each. Where one facet is rigid, the curvature is
//! that of the other one alone: k is larger by the ratio of both areas to its own.

use super::edges::{InnerEdge, films_of, inner_edges, natural_fold};
use super::{BendingParameters, PROPERTIES, remedy};
use crate::arrays::columns::Columns;
use crate::arrays::jacobian::{JacobianBlocks, at, of_differences};
use crate::arrays::state::NodeVectors;
use crate::assembly::Assembly;
use crate::elements::hinge::Facets;
use crate::elements::hinge_set::{HingeParameters, HingePotential, HingeSet};
use crate::elements::hinge_tangent::WeightedAngle;
use crate::error::Result;
use crate::laws::{Inspection, Instant, Kernels, Law, Linearisation, Properties};
use crate::model::mesh::{dot, sub};
use crate::model::regions::{FilmOfTriangles, RegionFilm};
use crate::simd::dispatch::InstructionSet;
use crate::simd::lanes::{F64x8, SimdF64};

/// Square of the cosine of an angle from which on it is a right one, 85 to 95 degrees: as the check of the form has it.
const RIGHT: f64 = 0.007_596_123_493_895_97;

/// The law.
pub(super) struct HingeBending {
    hinges: HingeSet,
    /// Sine and cosine of the natural fold angle of each hinge, by batch; `None` where all are naturally flat.
    natural: Option<Vec<[F64x8; 2]>>,
    is_singular: bool,
    instructions: InstructionSet,
}

impl HingeBending {
    /// # Errors
    /// `CurvatureBeyondMesh`, `TwoModuli`.
    pub(super) fn new(parameters: BendingParameters, assembly: &Assembly) -> Result<Self> {
        let BendingParameters { stiffness, fold_limit, collapse, .. } = parameters;
        let remedy = "take the form \"curvature\"";
        assembly.film.as_ref().map_or(Ok(()), |film| film.require_one_modulus("bending", "its hinges", remedy))?;
        let mut edges = inner_edges(assembly, fold_limit);
        edges.retain(|edge| edge.bends != [false; 2]);
        let hinges: Vec<_> = edges.iter().map(|edge| edge.hinge).collect();
        let constant = |row: usize, _| {
            let rigidity = stiffness * assembly.film.as_ref().map_or(0.0, |films| mean_rigidity(films, &edges[row]));
            rigidity * relative_constant(&edges[row], &assembly.mesh.reference)
        };
        let hinges = HingeSet::new(assembly, &hinges, collapse, |_| 1.0, constant);
        let curled = assembly.film.as_ref().filter(|films| films.any(RegionFilm::is_curved));
        let natural = curled.map(|films| {
            let of_edge = |edge: &InnerEdge| natural_fold(assembly, films, edge, edge.hinge.triangles);
            let angles = edges.iter().map(of_edge).collect::<Result<Vec<f64>>>()?;
            let sines = hinges.elements.pack(0.0, |row| angles[row].sin()).into_iter();
            let cosines = hinges.elements.pack(1.0, |row| angles[row].cos());
            Ok(sines.zip(cosines).map(|(sine, cosine)| [sine, cosine]).collect())
        });
        Ok(Self {
            natural: natural.transpose()?,
            hinges,
            is_singular: collapse == 0.0,
            instructions: assembly.instructions,
        })
    }

    /// The fold angles of the batch at this place, less their natural ones [rad].
    #[inline(always)]
    fn angle<V: SimdF64>(&self, place: usize, facets: &Facets<V>) -> V {
        match &self.natural {
            None => facets.fold_angle(),
            Some(natural) => facets.fold_beyond([V::load(&natural[place][0]), V::load(&natural[place][1])]),
        }
    }
}

/// D of an edge: of the facets that bend, the harmonic mean by their areas [N m].
fn mean_rigidity(films: &FilmOfTriangles, edge: &InnerEdge) -> f64 {
    let [c, d] = films_of(films, edge.hinge.triangles).map(RegionFilm::bending_stiffness);
    match edge.bends {
        [true, false] => c,
        [false, true] => d,
        _ if c == d => c,
        _ if c == 0.0 || d == 0.0 => 0.0,
        _ => {
            let [of_c, of_d] = edge.size.areas;
            (of_c + of_d) / (of_c / c + of_d / d)
        }
    }
}

/// k/D of an edge.
fn relative_constant(edge: &InnerEdge, reference: &[[f64; 3]]) -> f64 {
    let [a, b, c, d] = edge.hinge.nodes.map(|node| reference[node as usize]);
    let is_right = |corner: [f64; 3], others: [[f64; 3]; 2]| {
        let [u, v] = others.map(|other| sub(other, corner));
        dot(u, v).powi(2) < RIGHT * dot(u, u) * dot(v, v)
    };
    let [whole, bending] = [[true; 2], edge.bends].map(|counts| {
        edge.size.areas.into_iter().zip(counts).map(|(area, counts)| if counts { area } else { 0.0 }).sum::<f64>()
    });
    let square = edge.size.length * edge.size.length;
    let other_square = whole * whole / square;
    let constant = if [c, d].into_iter().all(|apex| is_right(apex, [a, b])) {
        8.0 / 3.0 * whole / square
    } else if [c, d].into_iter().all(|apex| is_right(a, [b, apex]) || is_right(b, [a, apex])) {
        8.0 / 3.0 * whole / (3.0 * other_square - square).max(other_square)
    } else {
        square / whole
    };
    constant * whole / bending
}

/// k (phi - phi_0)^2 / 2.
impl HingePotential for HingeBending {
    #[inline(always)]
    fn of_batch<V: SimdF64>(&self, place: usize, parameters: &HingeParameters, facets: &Facets<V>) -> (V, V) {
        let angle = self.angle(place, facets);
        let moment = V::load(&parameters.stiffness) * angle;
        (V::all(0.5) * moment * angle, -moment)
    }
}

impl Law for HingeBending {
    fn properties(&self) -> Properties {
        PROPERTIES
    }

    fn kernels(&self) -> Kernels {
        Kernels::of_elements()
    }

    fn reach(&self, tile: usize) -> usize {
        self.hinges.elements.reach(tile)
    }

    fn add_to_tile(&mut self, tile: usize, at: Instant<'_>, forces: &mut NodeVectors) -> f64 {
        self.hinges.add_to_tile(self, self.instructions, tile, at.positions, forces)
    }

    fn energy(&self, at: Instant<'_>) -> f64 {
        self.hinges.energy(self, self.instructions, at.positions)
    }

    fn linearisation(&self) -> Option<&dyn Linearisation> {
        Some(self)
    }

    fn inspection(&self) -> Option<&dyn Inspection> {
        Some(self)
    }

    fn remedy(&self) -> &'static str {
        remedy(self.is_singular)
    }
}

impl Linearisation for HingeBending {
    /// k g g^T, with g the gradient of the angle.
    fn add_stiffness_product(&self, at: Instant<'_>, p: &NodeVectors, out: &mut NodeVectors) {
        self.hinges.add_stiffness_product(self, self.instructions, at.positions, p, out);
    }

    fn visit_couplings(&self, visit: &mut dyn FnMut(&[u32])) {
        self.hinges.elements.each().for_each(|(.., nodes)| visit(&nodes));
    }

    fn add_jacobian(&self, instant: Instant<'_>, jacobian: &mut dyn JacobianBlocks) {
        let x = Columns::of(instant.positions);
        for (batch, lane, nodes) in self.hinges.elements.each() {
            let parameters = self.hinges.parameters[batch];
            let angle = self.angle::<F64x8>(batch, &Facets::new(self.hinges.elements.read_any(x, batch))).0[lane];
            let stiffness = parameters.stiffness.0[lane];
            let corners = nodes.map(|node| at(instant.positions, node));
            let weighted = WeightedAngle::new(corners, parameters.softening.map(|lanes| lanes.0[lane]));
            let hessian = weighted.hessian(0.5 * stiffness * angle * angle, stiffness * angle, stiffness);
            of_differences(nodes, &hessian, |i, j, block| jacobian.by_position(i, j, block));
        }
    }
}

impl Inspection for HingeBending {
    fn lanes(&self) -> [usize; 2] {
        self.hinges.elements.lanes()
    }

    fn contiguous_share(&self) -> Option<f64> {
        Some(self.hinges.elements.contiguous_share())
    }
}
