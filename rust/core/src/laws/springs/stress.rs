//! Stress of a film of springs: the mean stress of each triangle, by the tensions along its sides.
//!
//! Eq. (1) gives each triangle three springs of its own, k_i, and a common side the sum of both. So a side of present
//! length l with the elongation max(l, l_cr) - L pulls in this triangle with N_i = k_i (max(l, l_cr) - L), and the
//! triangle's energy as a function of Green's strain E has the derivative
//!
//!     S = dU/dE / (h A0) = 1/(h A0) sum_i N_i (L_i^2 / l_i) t_i t_i^T   [Pa]
//!
//! with t_i the unit vectors along the sides in the reference, since l_i^2 = L_i^2 (1 + 2 t_i . E t_i). Pushed forward
//! this is the virial stress 1/(h A) sum_i N_i l_i e_i e_i^T. A spring that is shortened to less than 1e-12 of its
//! rest length is taken as that long, as in its force.

use super::{Parameters, Springs};
use crate::arrays::blocks::tiles;
use crate::arrays::columns::Columns;
use crate::arrays::state::columns;
use crate::assembly::Assembly;
use crate::elements::link::Span;
use crate::elements::stress::{TriangleStress, largest_principal};
use crate::laws::Instant;
use crate::model::input::NegativeSprings;
use crate::model::mesh::sub;
use crate::simd::dispatch::BatchKernel;
use crate::simd::lanes::{F64x8, SimdF64};

/// A triangle of the film.
struct Triangle {
    /// Internal numbers.
    nodes: [u32; 3],
    /// The edges opposite its corners, external rows.
    sides: [u32; 3],
    /// k_i/(h A0 L_i^2) of its own part of each side, 0 where the spring was clipped [N/m6].
    weights: [f64; 3],
    /// The third node of the reference and the length of the base [m], with the first node at the origin and the second
    /// on axis 1.
    apex: [f64; 2],
    base: f64,
}

/// All triangles of the film, in external order.
pub(super) struct FilmTriangles {
    triangles: Vec<Triangle>,
}

impl FilmTriangles {
    /// The triangles of the mesh; `None` without springs.
    pub(super) fn new(assembly: &Assembly) -> Option<Self> {
        let (mesh, numbering) = (&assembly.mesh, &assembly.numbering);
        let has_springs = assembly.model.negative_springs != NegativeSprings::Unused;
        let film = assembly.film.as_ref().filter(|_| has_springs)?;
        let triangle = |(row, (&sides, &constants)): (usize, (&[u32; 3], &[f64; 3]))| {
            let lengths = mesh.side_lengths(row);
            let [opposite_a, opposite_b, base] = lengths;
            let along = (base * base + opposite_b * opposite_b - opposite_a * opposite_a) / (2.0 * base);
            let height = (opposite_b * opposite_b - along * along).max(0.0).sqrt();
            let volume = 0.5 * base * height * film.of(row).film.thickness;
            let weights = [0, 1, 2].map(|k| {
                let is_clipped = assembly.edge_stiffness[sides[k] as usize] == 0.0;
                if is_clipped { 0.0 } else { constants[k] / (lengths[k] * lengths[k] * volume) }
            });
            let nodes = numbering.to_internal(mesh.triangles[row]);
            Triangle { nodes, sides, weights, apex: [along, height], base }
        };
        let triangles = mesh.triangle_edges.iter().zip(&assembly.side_stiffness).enumerate().map(triangle);
        Some(Self { triangles: triangles.collect() })
    }
}

/// Stores (max(l, l_cr) - L) L^2 / l of the springs of one tile [m2].
struct PullKernel<'a> {
    springs: &'a Springs,
    tile: usize,
    positions: Columns<'a>,
    pulls: &'a mut [F64x8],
}

impl BatchKernel for PullKernel<'_> {
    #[inline(always)]
    fn sweep_kind<V: SimdF64, const KIND: usize>(&mut self) -> V {
        let pass = self.springs.links.elements.pass::<KIND>(self.tile, self.positions.rows());
        let positions = pass.reader(self.positions);
        let parameters = self.springs.parameters.of(&pass);
        for batch in 0..pass.len() {
            let Parameters { rest_length, critical_length, .. } = &parameters[batch];
            let (rest, critical_length) = (V::load(rest_length), V::load(critical_length));
            let length = Span::between(positions.read::<V>(batch)).length();
            let pull = (length.max(critical_length) - rest) * rest * rest / length.max(V::all(1e-12) * rest);
            self.pulls[pass.place(batch)] = pull.lanes();
        }
        V::zero()
    }
}

impl Springs {
    /// (max(l, l_cr) - L) L^2 / l of each spring, in external order [m2].
    fn pulls(&self, at: Instant<'_>) -> Vec<f64> {
        let elements = &self.links.elements;
        let (positions, mut pulls) = (Columns::of(at.positions), vec![F64x8::ZERO; elements.batch_count()]);
        for tile in tiles(at.positions.nrows()) {
            self.links.instructions.run_batches(PullKernel { springs: self, tile, positions, pulls: &mut pulls });
        }
        elements.unpack(pulls.into_iter())
    }

    /// The stress of each triangle, in external order.
    pub(super) fn triangle_stress(&self, at: Instant<'_>, film: &FilmTriangles) -> Vec<TriangleStress> {
        let (pulls, x) = (self.pulls(at), columns(at.positions));
        let of_triangle = |triangle: &Triangle| {
            let nodes = triangle.nodes.map(|node| x.map(|column| column[node as usize]));
            TriangleStress { stress: triangle.stress(&pulls), gradient: triangle.gradient(nodes) }
        };
        film.triangles.iter().map(of_triangle).collect()
    }

    /// The largest principal stress, at least 0; `None` without triangles [Pa].
    pub(super) fn largest_triangle_stress(&self, at: Instant<'_>, film: &FilmTriangles) -> Option<f64> {
        let pulls = self.pulls(at);
        largest_principal(film.triangles.iter().map(|triangle| triangle.stress(&pulls)))
    }
}

impl Triangle {
    /// S, by the pulls of all springs.
    fn stress(&self, pulls: &[f64]) -> [f64; 3] {
        let ([along, height], base) = (self.apex, self.base);
        let sides = [[along - base, height], [along, height], [base, 0.0]];
        let mut stress = [0.0; 3];
        for (k, [dx, dy]) in sides.into_iter().enumerate() {
            let weight = self.weights[k] * pulls[self.sides[k] as usize];
            for (component, product) in stress.iter_mut().zip([dx * dx, dy * dy, dx * dy]) {
                *component += weight * product;
            }
        }
        stress
    }

    /// The columns of F, by the present nodes.
    fn gradient(&self, [a, b, c]: [[f64; 3]; 3]) -> [[f64; 3]; 2] {
        let ([along, height], base) = (self.apex, self.base);
        let (u, v) = (sub(b, a), sub(c, a));
        let f1 = u.map(|component| component / base);
        [f1, [0, 1, 2].map(|axis| (v[axis] - along * f1[axis]) / height)]
    }
}
