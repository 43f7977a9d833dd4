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

use super::Springs;
use crate::arrays::columns::Columns;
use crate::arrays::state::columns;
use crate::assembly::Assembly;
use crate::elements::stress::TriangleStress;
use crate::laws::Instant;
use crate::model::input::NegativeSprings;
use crate::model::mesh::sub;
use crate::simd::lanes::{F64x8, SimdF64};

/// A triangle of the film.
struct Triangle {
    /// Internal numbers.
    nodes: [u32; 3],
    /// The edges opposite its corners, external rows.
    sides: [u32; 3],
    /// Its own part of the spring constant of each side; 0 where the spring was clipped [N/m].
    constants: [f64; 3],
}

/// All triangles of the film, in external order.
pub(super) struct FilmTriangles {
    triangles: Vec<Triangle>,
    /// h [m].
    thickness: f64,
}

impl FilmTriangles {
    /// The triangles of the mesh; `None` without springs.
    pub(super) fn new(assembly: &Assembly) -> Option<Self> {
        let (mesh, numbering) = (&assembly.mesh, &assembly.numbering);
        let has_springs = assembly.model.negative_springs != NegativeSprings::Unused;
        let film = assembly.model.film.filter(|_| has_springs)?;
        let triangle = |((&nodes, &sides), &constants): ((&[u32; 3], &[u32; 3]), &[f64; 3])| {
            let mut constants = constants;
            for (constant, side) in constants.iter_mut().zip(sides) {
                if assembly.edge_stiffness[side as usize] == 0.0 {
                    *constant = 0.0;
                }
            }
            Triangle { nodes: numbering.to_internal(nodes), sides, constants }
        };
        let triangles = mesh.triangles.iter().zip(&mesh.triangle_edges).zip(&assembly.side_stiffness).map(triangle);
        Some(Self { triangles: triangles.collect(), thickness: film.thickness })
    }
}

/// A spring as the stress needs it.
#[derive(Clone, Copy)]
struct Side {
    /// L [m].
    rest_length: f64,
    /// (max(l, l_cr) - L) L^2 / l [m2].
    pull: f64,
}

impl Springs {
    /// The stress of each triangle, in external order.
    pub(super) fn triangle_stress(&self, at: Instant<'_>, film: &FilmTriangles) -> Vec<TriangleStress> {
        let lengths = self.links.lengths(Columns::of(at.positions)).zip(self.parameters.iter());
        let pulls = lengths.map(|(l, spring)| {
            let rest = spring.rest_length;
            let least = F64x8::all(1e-12) * rest;
            [rest, (l.max(spring.critical_length) - rest) * rest * rest / l.max(least)]
        });
        let sides = self.links.elements.unpack_rows(pulls);
        let sides: Vec<Side> = sides.into_iter().map(|[rest_length, pull]| Side { rest_length, pull }).collect();
        let x = columns(at.positions);
        let point = |node: u32| x.map(|column| column[node as usize]);
        let of_triangle = |triangle: &Triangle| {
            triangle.stress(film.thickness, triangle.sides.map(|side| sides[side as usize]), triangle.nodes.map(point))
        };
        film.triangles.iter().map(of_triangle).collect()
    }
}

impl Triangle {
    /// The stress, in a frame with the first node of the reference triangle at the origin and the second on axis 1.
    fn stress(&self, thickness: f64, sides: [Side; 3], [a, b, c]: [[f64; 3]; 3]) -> TriangleStress {
        let [opposite_a, opposite_b, base] = sides.map(|side| side.rest_length);
        let along = (base * base + opposite_b * opposite_b - opposite_a * opposite_a) / (2.0 * base);
        let height = (opposite_b * opposite_b - along * along).max(0.0).sqrt();
        let volume = 0.5 * base * height * thickness;
        let mut stress = [0.0; 3];
        let vectors = [[along - base, height], [along, height], [base, 0.0]];
        for ((side, constant), [dx, dy]) in sides.into_iter().zip(self.constants).zip(vectors) {
            let weight = constant * side.pull / (side.rest_length * side.rest_length * volume);
            for (component, product) in stress.iter_mut().zip([dx * dx, dy * dy, dx * dy]) {
                *component += weight * product;
            }
        }
        let (u, v) = (sub(b, a), sub(c, a));
        let f1 = u.map(|component| component / base);
        let f2 = [0, 1, 2].map(|axis| (v[axis] - along * f1[axis]) / height);
        TriangleStress { stress, gradient: [f1, f2] }
    }
}
