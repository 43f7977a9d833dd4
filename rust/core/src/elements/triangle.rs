//! Triangles with a flat reference: deformation gradient, Green's strain, plane stress, and nodal forces of a stress.
//! Common to the elasticity of a film of triangles and its damping.

use super::facet::from_lowest;
use crate::assembly::Assembly;
use crate::error::Result;
use crate::layout::ElementSet;
use crate::model::mesh;
use crate::model::orthotropy::{Orthotropy, symmetric};
use crate::model::regions::FilmOfTriangles;
use crate::simd::lanes::{F64x8, SimdF64, Vec3, dot, negate, scale, sub, sum};

/// Triangles in batches of eight, with the coefficients of their deformation gradients.
pub(crate) struct FlatTriangles {
    pub(crate) elements: ElementSet<3>,
    /// The gradient's columns are f1 = p u, f2 = q u + r v, with u and v the sides from the first node [1/m].
    pub(super) p: Vec<F64x8>,
    pub(super) q: Vec<F64x8>,
    pub(super) r: Vec<F64x8>,
    /// E_Y h A0 [J]; 0 in padding lanes.
    pub(crate) stiffness: Vec<F64x8>,
    pub(crate) nu: f64,
    /// Of a film of two moduli the stiffness over E_Y in the frame of each triangle: with u and v its axes the products
    /// uu:C:uu, vv:C:vv, uu:C:vv, uu:C:uv, vv:C:uv and uv:C:uv.
    pub(super) moduli: Option<Vec<[F64x8; 6]>>,
}

/// A triangle free of stress in a frame of its own, with its nodes in cyclic order from the lowest internal number.
pub(crate) struct Corners {
    /// External numbers.
    pub(crate) nodes: [u32; 3],
    /// The first node at the origin, the second on axis 1 [m].
    pub(crate) points: [[f64; 2]; 3],
    /// Unit vectors of axes 1 and 2 in the reference.
    axes: [[f64; 3]; 2],
    /// The edges opposite the corners.
    pub(crate) edges: [u32; 3],
}

impl Corners {
    pub(crate) fn all(assembly: &Assembly) -> impl Iterator<Item = Self> {
        let each = assembly.mesh.triangles.iter().zip(&assembly.mesh.triangle_edges).enumerate();
        each.map(|(row, (&nodes, &edges))| {
            let (_, places) = from_lowest(assembly.numbering.to_internal(nodes));
            let [nodes, edges] = [nodes, edges].map(|mut corners| {
                corners.rotate_left(places);
                corners
            });
            let [a, b, c] = nodes.map(|node| assembly.mesh.reference[node as usize]);
            let (mut u, mut v) = (mesh::sub(b, a), mesh::sub(c, a));
            if let Some(film) = &assembly.film {
                (u, v) = (film.of(row).natural(u), film.of(row).natural(v));
            }
            let (side, normal) = (mesh::dot(u, u).sqrt(), mesh::cross(u, v));
            let apex = [mesh::dot(u, v) / side, mesh::dot(normal, normal).sqrt() / side];
            let first = u.map(|component| component / side);
            let second = [0, 1, 2].map(|k| (v[k] - apex[0] * first[k]) / apex[1]);
            Self { nodes, points: [[0.0; 2], [side, 0.0], apex], axes: [first, second], edges }
        })
    }

    /// t t^T of the unit vector t along the side opposite each corner: 11, 22, 12.
    pub(crate) fn directions(&self) -> [[f64; 3]; 3] {
        [0, 1, 2].map(|k| {
            let [[x, y], [to_x, to_y]] = [self.points[(k + 1) % 3], self.points[(k + 2) % 3]];
            let (dx, dy) = (to_x - x, to_y - y);
            let square = dx * dx + dy * dy;
            [dx * dx / square, dy * dy / square, dx * dy / square]
        })
    }
}

/// A symmetric 2 x 2 tensor: 11, 22, 12.
pub(crate) type Tensor<V = F64x8> = [V; 3];

impl FlatTriangles {
    /// The triangles of the mesh.
    ///
    /// # Errors
    /// `DegenerateTriangle`.
    pub(crate) fn new(assembly: &Assembly) -> Result<Self> {
        let corners: Vec<Corners> = Corners::all(assembly).collect();
        let internal: Vec<[u32; 3]> =
            corners.iter().map(|corners| assembly.numbering.to_internal(corners.nodes)).collect();
        let elements = ElementSet::new(&internal, assembly.masses.len());
        let nu = assembly.film.as_ref().map_or(0.0, |film| film.of_no_region().film.poisson_ratio);
        let mut rows = Vec::with_capacity(corners.len());
        for (triangle, corners) in corners.iter().enumerate() {
            let area = assembly.mesh.area(triangle)?;
            let film = assembly.film.as_ref().map(|film| film.of(triangle));
            let modulus = film.map_or(0.0, |film| film.membrane_stiffness() * film.natural_area());
            let [_, [side, _], [along, height]] = corners.points;
            rows.push([1.0 / side, -along / (side * height), 1.0 / height, modulus * area]);
        }
        let moduli = assembly.film.as_ref().and_then(FilmOfTriangles::orthotropy).map(|moduli| {
            let products: Vec<[f64; 6]> = corners.iter().map(|corners| products(moduli, nu, corners.axes)).collect();
            let columns = [0, 1, 2, 3, 4, 5].map(|k| elements.pack(0.0, |row| products[row][k]));
            (0..elements.batch_count()).map(|batch| columns.each_ref().map(|values| values[batch])).collect()
        });
        Ok(Self {
            moduli,
            p: elements.pack(1.0, |row| rows[row][0]),
            q: elements.pack(0.0, |row| rows[row][1]),
            r: elements.pack(1.0, |row| rows[row][2]),
            stiffness: elements.pack(0.0, |row| rows[row][3]),
            nu,
            elements,
        })
    }

    /// The columns of the gradient of a vector at the nodes.
    #[inline(always)]
    pub(crate) fn gradient<V: SimdF64>(&self, batch: usize, [a, b, c]: [Vec3<V>; 3]) -> [Vec3<V>; 2] {
        let (u, v) = (sub(b, a), sub(c, a));
        let (p, q, r) = (V::load(&self.p[batch]), V::load(&self.q[batch]), V::load(&self.r[batch]));
        [scale(p, u), sum(scale(q, u), scale(r, v))]
    }

    /// Green's strain along the side opposite each corner. In the frame of the gradient, p r times the sides v - u, v
    /// and u are (-q - r, p), (-q, p) and (r, 0).
    pub(crate) fn side_strains(&self, batch: usize, e: Tensor) -> [F64x8; 3] {
        let (p, q, r) = (self.p[batch], self.q[batch], self.r[batch]);
        [[-q - r, p], [-q, p], [r, F64x8::ZERO]].map(|[x, y]| {
            let along = x * x * e[0] + y * y * e[1] + F64x8::all(2.0) * x * y * e[2];
            along / (x * x + y * y)
        })
    }

    /// The nodal forces of a stress s over E_Y: the negative gradient of the strain energy [N].
    #[inline(always)]
    pub(crate) fn nodal_forces<V: SimdF64>(&self, batch: usize, [f1, f2]: [Vec3<V>; 2], s: Tensor<V>) -> [Vec3<V>; 3] {
        let k = V::load(&self.stiffness[batch]);
        let (p, q, r) = (V::load(&self.p[batch]), V::load(&self.q[batch]), V::load(&self.r[batch]));
        let [s11, s22, s12] = [k * s[0], k * s[1], k * s[2]];
        let along_1 = sum(scale(s11, f1), scale(s12, f2));
        let along_2 = sum(scale(s12, f1), scale(s22, f2));
        let at_b = sum(scale(p, along_1), scale(q, along_2));
        let at_c = scale(r, along_2);
        [sum(at_b, at_c), negate(at_b), negate(at_c)]
    }

    /// The stress of a film without wrinkles, over E_Y.
    #[inline(always)]
    pub(crate) fn stress<V: SimdF64>(&self, batch: usize, e: Tensor<V>) -> Tensor<V> {
        if let Some(moduli) = &self.moduli {
            let [p11, p22, p12, p1s, p2s, pss] = &moduli[batch];
            let twice = e[2] + e[2];
            return [
                V::load(p11) * e[0] + V::load(p12) * e[1] + V::load(p1s) * twice,
                V::load(p12) * e[0] + V::load(p22) * e[1] + V::load(p2s) * twice,
                V::load(p1s) * e[0] + V::load(p2s) * e[1] + V::load(pss) * twice,
            ];
        }
        let shear = 1.0 / (1.0 + self.nu);
        let (nu, factor) = (V::all(self.nu), V::all(shear / (1.0 - self.nu)));
        [factor * (e[0] + nu * e[1]), factor * (e[1] + nu * e[0]), V::all(shear) * e[2]]
    }
}

/// See `FlatTriangles::moduli`.
fn products(moduli: &Orthotropy, nu: f64, axes: [[f64; 3]; 2]) -> [f64; 6] {
    let [u, v] = axes.map(|axis| moduli.components(axis));
    let [uu, vv, uv] = [symmetric(u, u), symmetric(v, v), symmetric(u, v)];
    [(uu, uu), (vv, vv), (uu, vv), (uu, uv), (vv, uv), (uv, uv)].map(|(a, b)| moduli.product(nu, a, b))
}

/// Green's strain of a deformation gradient.
#[inline(always)]
pub(crate) fn strain<V: SimdF64>([f1, f2]: [Vec3<V>; 2]) -> Tensor<V> {
    let (half, one) = (V::all(0.5), V::all(1.0));
    [half * (dot(f1, f1) - one), half * (dot(f2, f2) - one), half * dot(f1, f2)]
}

/// The rate of Green's strain for a rate (g1, g2) of the gradient.
#[inline(always)]
pub(crate) fn strain_rate<V: SimdF64>([f1, f2]: [Vec3<V>; 2], [g1, g2]: [Vec3<V>; 2]) -> Tensor<V> {
    [dot(f1, g1), dot(f2, g2), V::all(0.5) * (dot(f1, g2) + dot(f2, g1))]
}
