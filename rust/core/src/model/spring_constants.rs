//! Spring constants of the sides of a triangle, eq. (1): the energy of its three springs equals the strain energy of
//! the film in each of the three uniaxial stress states parallel to a side,
//!
//!     A_ij = [1 - (1 - delta_ij) 4 (1 + nu) S^2 / (L_i^2 L_j^2)]^2,   k_i = (E h S / L_i^2) sum_j (A^-1)_ij   [N/m]
//!
//! and triangles with a common side add their constants.
//! Source: Okuizumi et al., Trans. JSASS Aerospace Tech. Japan 10 (2012), section 3.1.

use nalgebra::{Matrix3, Vector3};

use super::film::Film;
use super::mesh::Mesh;
use crate::error::{Error, Result};

impl Mesh {
    /// Spring constant of each edge by eq. (1), summed over its triangles \[N/m\]. `film_of` is the film of a triangle.
    ///
    /// # Errors
    /// `DegenerateTriangle`, `SingularTriangle`.
    pub fn spring_constants(&self, film_of: impl Fn(usize) -> Film) -> Result<Vec<f64>> {
        Ok(self.sums_on_edges(&self.all_side_constants(film_of)?))
    }

    /// Spring constants of the sides of each triangle of these films by eq. (1) \[N/m\].
    ///
    /// # Errors
    /// `DegenerateTriangle`, `SingularTriangle`.
    pub(crate) fn all_side_constants(&self, film: impl Fn(usize) -> Film) -> Result<Vec<[f64; 3]>> {
        let of_triangle = |triangle| {
            let Film { youngs_modulus, poisson_ratio, thickness, .. } = film(triangle);
            self.side_constants(triangle, youngs_modulus, poisson_ratio, thickness)
        };
        (0..self.triangles.len()).map(of_triangle).collect()
    }

    /// Sums over the sides at each edge.
    pub(crate) fn sums_on_edges(&self, of_sides: &[[f64; 3]]) -> Vec<f64> {
        let mut sums = vec![0.0; self.edges.len()];
        for (edges, shares) in self.triangle_edges.iter().zip(of_sides) {
            for side in 0..3 {
                sums[edges[side] as usize] += shares[side];
            }
        }
        sums
    }

    /// Spring constants of the sides of a triangle by eq. (1), side k opposite corner k \[N/m\].
    ///
    /// # Errors
    /// `DegenerateTriangle`, `SingularTriangle`.
    pub fn side_constants(
        &self,
        triangle: usize,
        youngs_modulus: f64,
        poisson_ratio: f64,
        thickness: f64,
    ) -> Result<[f64; 3]> {
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
        Ok([0, 1, 2].map(|side| youngs_modulus * thickness * area / squares[side] * sums[side]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One triangle with a base of 1 m and its apex at (x, y).
    fn triangle(x: f64, y: f64) -> Mesh {
        Mesh::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [x, y, 0.0]], vec![[0, 1, 2]]).unwrap()
    }

    fn constants(mesh: &Mesh, youngs_modulus: f64, poisson_ratio: f64, thickness: f64) -> Vec<f64> {
        mesh.spring_constants(|_| Film { youngs_modulus, poisson_ratio, thickness, density: 1.0 }).unwrap()
    }

    #[test]
    fn equilateral_springs_are_those_of_the_isotropic_lattice() {
        let constants = constants(&triangle(0.5, 0.75_f64.sqrt()), 2.0, 1.0 / 3.0, 3.0);
        let expected = 2.0 * 3.0 * 0.75_f64.sqrt() / 2.0;
        assert!(constants.iter().all(|k| (k / expected - 1.0).abs() < 1e-14), "{constants:?}");
    }

    #[test]
    fn springs_store_the_films_energy_in_uniaxial_stress_along_each_side() {
        let (e, nu, h) = (3.2e9, 0.34, 7.5e-6);
        let mesh = triangle(0.4, 0.8);
        let constants = constants(&mesh, e, nu, h);
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
    fn an_obtuse_corner_makes_a_spring_constant_negative() {
        assert!(constants(&triangle(0.5, 0.12), 1.0, 0.34, 1.0).iter().any(|&k| k < 0.0));
    }
}
