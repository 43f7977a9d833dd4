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
//!
//! A rectangle has six springs of its own and one mean stress, by the same equation with its area, which both of its
//! triangles have.

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
use crate::model::rectangles::{Rectangle, Rectangles};
use crate::simd::dispatch::BatchKernel;
use crate::simd::lanes::{F64x8, SimdF64};

/// A triangle of the film.
struct Triangle {
    /// Internal numbers.
    nodes: [u32; 3],
    /// The third node of the reference and the length of the base [m], with the first node at the origin and the second
    /// on axis 1.
    apex: [f64; 2],
    base: f64,
}

/// The part of a spring in the stress of a triangle.
struct Part {
    /// External row.
    spring: u32,
    /// k_i/(h A0 L_i^2) of its own part of the constant, 0 where the spring was clipped [N/m6].
    weight: f64,
    /// The vector along the spring in the frame of the triangle [m].
    along: [f64; 2],
}

/// All triangles of the film, in external order.
pub(in crate::laws) struct FilmTriangles {
    triangles: Vec<Triangle>,
    /// Those of the first triangle, of the second, ...
    parts: Vec<Part>,
    /// Number of parts of each triangle.
    parts_each: usize,
}

impl FilmTriangles {
    /// The triangles of the mesh; `None` without springs.
    pub(super) fn new(assembly: &Assembly) -> Option<Self> {
        let mesh = &assembly.mesh;
        let has_springs = assembly.model.negative_springs != NegativeSprings::Unused;
        let film = assembly.film.as_ref().filter(|_| has_springs)?;
        let triangles: Vec<_> = (0..mesh.triangles.len()).map(|row| Triangle::new(row, assembly)).collect();
        let parts_of = |(row, (&sides, &constants)): (usize, (&[u32; 3], &[f64; 3]))| {
            let (lengths, along) = (mesh.side_lengths(row), triangles[row].sides());
            let volume = 0.5 * triangles[row].base * triangles[row].apex[1] * film.of(row).film.thickness;
            [0, 1, 2].map(|k| {
                let is_clipped = assembly.edge_stiffness[sides[k] as usize] == 0.0;
                let weight = if is_clipped { 0.0 } else { constants[k] / (lengths[k] * lengths[k] * volume) };
                Part { spring: sides[k], weight, along: along[k] }
            })
        };
        let parts = mesh.triangle_edges.iter().zip(&assembly.side_stiffness).enumerate().flat_map(parts_of).collect();
        Some(Self { triangles, parts, parts_each: 3 })
    }

    /// The triangles of a mesh of rectangles; `None` without film.
    pub(in crate::laws) fn of_rectangles(rectangles: &Rectangles, assembly: &Assembly) -> Option<Self> {
        let films = assembly.film.as_ref()?;
        let triangles: Vec<_> = (0..assembly.mesh.triangles.len()).map(|row| Triangle::new(row, assembly)).collect();
        let mut halves: Vec<_> = rectangles.all.iter().flat_map(|own| own.halves.map(|half| (half, own))).collect();
        halves.sort_unstable_by_key(|((triangle, _), _)| *triangle);
        let parts_of = |((triangle, legs), own): ((u32, [usize; 3]), &Rectangle)| {
            let [right, end_a, end_b] = legs.map(|place| triangles[triangle as usize].corners()[place]);
            let [a, b] = [end_a, end_b].map(|end| [end[0] - right[0], end[1] - right[1]]);
            let along = [[a, a], [b, b], [[a[0] - b[0], a[1] - b[1]], [a[0] + b[0], a[1] + b[1]]]];
            let film = films.of(triangle as usize).film;
            let volume = film.thickness * own.sides[0] * own.sides[1];
            let constants = own.constants(film);
            [0, 1, 2, 3, 4, 5].map(|k| {
                let along: [f64; 2] = along[k / 2][k % 2];
                let weight = constants[k / 2] / ((along[0] * along[0] + along[1] * along[1]) * volume);
                Part { spring: own.springs[k / 2][k % 2], weight, along }
            })
        };
        let parts = halves.into_iter().flat_map(parts_of).collect();
        Some(Self { triangles, parts, parts_each: 6 })
    }

    /// S of each triangle, by the pulls of all springs \[Pa\].
    fn stresses<'a>(&'a self, pulls: &'a [f64]) -> impl Iterator<Item = [f64; 3]> + 'a {
        self.parts.chunks_exact(self.parts_each).map(|parts| {
            let mut stress = [0.0; 3];
            for Part { spring, weight, along: [dx, dy] } in parts {
                let weight = weight * pulls[*spring as usize];
                for (component, product) in stress.iter_mut().zip([dx * dx, dy * dy, dx * dy]) {
                    *component += weight * product;
                }
            }
            stress
        })
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
        let of_triangle = |(triangle, stress): (&Triangle, [f64; 3])| {
            let nodes = triangle.nodes.map(|node| x.map(|column| column[node as usize]));
            TriangleStress { stress, gradient: triangle.gradient(nodes) }
        };
        film.triangles.iter().zip(film.stresses(&pulls)).map(of_triangle).collect()
    }

    /// The largest principal stress, at least 0; `None` without triangles [Pa].
    pub(super) fn largest_triangle_stress(&self, at: Instant<'_>, film: &FilmTriangles) -> Option<f64> {
        largest_principal(film.stresses(&self.pulls(at)))
    }
}

impl Triangle {
    /// A triangle of the mesh.
    fn new(row: usize, assembly: &Assembly) -> Self {
        let [opposite_a, opposite_b, base] = assembly.mesh.side_lengths(row);
        let along = (base * base + opposite_b * opposite_b - opposite_a * opposite_a) / (2.0 * base);
        let height = (opposite_b * opposite_b - along * along).max(0.0).sqrt();
        let nodes = assembly.numbering.to_internal(assembly.mesh.triangles[row]);
        Self { nodes, apex: [along, height], base }
    }

    /// Its corners in its frame.
    fn corners(&self) -> [[f64; 2]; 3] {
        [[0.0; 2], [self.base, 0.0], self.apex]
    }

    /// The vectors along its sides, each opposite a corner.
    fn sides(&self) -> [[f64; 2]; 3] {
        let ([along, height], base) = (self.apex, self.base);
        [[along - base, height], [along, height], [base, 0.0]]
    }

    /// The columns of F, by the present nodes.
    fn gradient(&self, [a, b, c]: [[f64; 3]; 3]) -> [[f64; 3]; 2] {
        let ([along, height], base) = (self.apex, self.base);
        let (u, v) = (sub(b, a), sub(c, a));
        let f1 = u.map(|component| component / base);
        [f1, [0, 1, 2].map(|axis| (v[axis] - along * f1[axis]) / height)]
    }
}
