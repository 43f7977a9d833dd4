//! Rectangles of a mesh: pairs of right triangles with a common longest side, and their springs.
//!
//! A rectangle a x b has a spring along each of its four sides and along both diagonals d. Its energy in a uniform
//! strain is that of the film in plane stress for each strain alone, along a, along b, and in shear, if
//!
//!     k_a = E h [b / (2 a (1 - nu^2)) - a / (4 (1 + nu) b)],   k_b the same with a and b exchanged   [N/m]
//!     k_d = E h d^2 / (4 (1 + nu) a b)                                                               [N/m]
//!
//! and rectangles with a common side add their constants. Springs have one modulus for shear and for the coupling of
//! both strains, so that the latter, nu eps_a eps_b / (1 - nu^2) times E h, is eps_a eps_b / (2 (1 + nu)) instead: the
//! two agree at nu = 1/3. k_a is negative where a/b exceeds sqrt(2 / (1 - nu)), sqrt(3) at nu = 1/3.
//! Source: derived here from the energies; the element that the springs of Okuizumi et al. (2012) generalise to
//! triangles.

use super::film::Film;
use super::mesh::{Hinge, Mesh, dot, sub};
use crate::error::{Error, Result};

/// Deviation of a rectangle from its shape: the cosine of its right angles, and the distance between its fourth corner
/// and that of the parallelogram of the others, relative to its diagonal.
const TOLERANCE: f64 = 1e-3;

const OBLIQUE: &str = "has no right angle";
const ALONE: &str = "shares its longest side with no other triangle";
const BRANCHED: &str = "shares its longest side with more than one other triangle";
const KITE: &str = "forms no rectangle with the other triangle at its longest side";
const FOLDED: &str = "has a crease along its longest side, the diagonal of a rectangle";

/// Corners of a triangle by their places in it: the right angle, the other end of its side a, that of its side b.
pub(crate) type Legs = [usize; 3];

/// Two triangles that form a rectangle.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Rectangle {
    /// Its triangles, the lower row first, with their legs.
    pub(crate) halves: [(u32, Legs); 2],
    /// Corners in turn, from the right angle of the first triangle on; its winding.
    pub(crate) corners: [u32; 4],
    /// Its springs, by rows of `Rectangles::ends`: both sides a, both sides b, both diagonals.
    pub(crate) springs: [[u32; 2]; 3],
    /// a and b \[m\].
    pub(crate) sides: [f64; 2],
}

/// The rectangles of a mesh, of which each triangle is a half.
#[derive(Debug, Clone)]
pub struct Rectangles {
    pub(crate) all: Vec<Rectangle>,
    /// Nodes of all springs: the edges of the mesh, then the second diagonal of each rectangle, the lower node first.
    pub(crate) ends: Vec<[u32; 2]>,
}

impl Mesh {
    /// The rectangles that its triangles form in pairs.
    ///
    /// # Errors
    /// `NotRectangles`, `DegenerateTriangle`.
    pub fn rectangles(&self, creases: &[Hinge]) -> Result<Rectangles> {
        let count = self.edges.len();
        let mut is_crease = vec![false; count];
        creases.iter().for_each(|hinge| is_crease[hinge.edge as usize] = true);
        let mut refusals = Vec::new();
        let mut all = Vec::with_capacity(self.triangles.len() / 2);
        // The first two triangles at each edge, and how many there are.
        let mut at_edges = vec![([0_u32; 2], 0_u32); count];
        for (triangle, edges) in self.triangle_edges.iter().enumerate() {
            self.area(triangle)?;
            for &edge in edges {
                let (rows, found) = &mut at_edges[edge as usize];
                if let Some(row) = rows.get_mut(*found as usize) {
                    *row = triangle as u32;
                }
                *found += 1;
            }
        }
        for triangle in 0..self.triangles.len() {
            let lengths = self.side_lengths(triangle);
            let longest = (0..3).fold(0, |most, side| if lengths[side] > lengths[most] { side } else { most });
            let edge = self.triangle_edges[triangle][longest];
            let found = match at_edges[edge as usize] {
                _ if !self.is_right(triangle, longest) => Err(OBLIQUE),
                (_, 0 | 1) => Err(ALONE),
                (_, 2) if is_crease[edge as usize] => Err(FOLDED),
                (rows, 2) => Ok(rows),
                _ => Err(BRANCHED),
            };
            match found.and_then(|rows| self.rectangle(rows, edge, count + all.len()).ok_or(KITE)) {
                Ok(rectangle) if rectangle.halves[0].0 as usize == triangle => all.push(rectangle),
                Ok(_) => {}
                Err(reason) => refusals.push((triangle, reason)),
            }
        }
        if let Some(&(triangle, reason)) = refusals.first() {
            let (nodes, of) = (self.triangles[triangle], self.triangles.len());
            return Err(Error::NotRectangles { count: refusals.len(), of, triangle, nodes, reason });
        }
        let seconds = all.iter().map(|rectangle| second_diagonal(rectangle.corners));
        let ends = self.edges.iter().copied().chain(seconds).collect();
        Ok(Rectangles { all, ends })
    }

    /// Whether the angle at a corner of a triangle is a right one.
    fn is_right(&self, triangle: usize, corner: usize) -> bool {
        let [u, v] = [1, 2].map(|step| {
            let ends = [(corner + step) % 3, corner].map(|place| self.triangles[triangle][place] as usize);
            sub(self.reference[ends[0]], self.reference[ends[1]])
        });
        dot(u, v).abs() <= TOLERANCE * (dot(u, u) * dot(v, v)).sqrt()
    }

    /// The rectangle of two triangles at an edge; `second` is the row of its second diagonal.
    fn rectangle(&self, rows: [u32; 2], edge: u32, second: usize) -> Option<Rectangle> {
        let place_of = |row: u32, node: u32| self.triangles[row as usize].iter().position(|&other| other == node);
        let right = rows.map(|row| self.triangle_edges[row as usize].iter().position(|&other| other == edge));
        let [k, l] = [right[0]?, right[1]?];
        let first = [k, (k + 1) % 3, (k + 2) % 3];
        let [r, p, q] = first.map(|place| self.triangles[rows[0] as usize][place]);
        let s = self.triangles[rows[1] as usize][l];
        let other = [l, place_of(rows[1], q)?, place_of(rows[1], p)?];
        let [at_r, at_p, at_q, at_s] = [r, p, q, s].map(|node| self.reference[node as usize]);
        let [across, gap] = [sub(at_q, at_p), [0, 1, 2].map(|i| (at_r[i] - at_p[i]) + (at_s[i] - at_q[i]))];
        if !self.is_right(rows[0] as usize, k) || dot(gap, gap) > TOLERANCE * TOLERANCE * dot(across, across) {
            return None;
        }
        // The side from the right angle to one leg's end lies opposite the end of the other leg.
        let halves = [(rows[0], first), (rows[1], other)];
        let opposite = |leg: usize| halves.map(|(row, legs)| self.triangle_edges[row as usize][legs[leg]]);
        let lengths = halves.map(|(row, legs)| legs.map(|place| self.side_lengths(row as usize)[place]));
        let sides = [2, 1].map(|leg: usize| 0.5 * (lengths[0][leg] + lengths[1][leg]));
        let springs = [opposite(2), opposite(1), [edge, second as u32]];
        Some(Rectangle { halves, corners: [r, p, s, q], springs, sides })
    }
}

/// The ends of the diagonal of a rectangle that is no edge of the mesh, the lower first.
fn second_diagonal([r, _, s, _]: [u32; 4]) -> [u32; 2] {
    [r.min(s), r.max(s)]
}

impl Rectangle {
    /// k_a, k_b and k_d \[N/m\].
    pub(crate) fn constants(&self, film: Film) -> [f64; 3] {
        let Film { youngs_modulus, poisson_ratio: nu, thickness, .. } = film;
        let [a, b] = self.sides;
        let (stretch, shear) = (1.0 / (2.0 * (1.0 - nu * nu)), 1.0 / (4.0 * (1.0 + nu)));
        [stretch * b / a - shear * a / b, stretch * a / b - shear * b / a, shear * (a * a + b * b) / (a * b)]
            .map(|constant| youngs_modulus * thickness * constant)
    }
}

impl Rectangles {
    /// Corners of each rectangle in turn; the first and the third are the ends of its second diagonal, which is no edge
    /// of the mesh.
    pub fn corners(&self) -> Vec<[u32; 4]> {
        self.all.iter().map(|rectangle| rectangle.corners).collect()
    }

    /// The part of each triangle in the spring constants of its sides, side k opposite corner k \[N/m\]: of its legs
    /// that of the rectangle, of the diagonal by its own film.
    pub(crate) fn side_constants(&self, film_of: impl Fn(usize) -> Film) -> Vec<[f64; 3]> {
        let mut parts = vec![[0.0; 3]; 2 * self.all.len()];
        for rectangle in &self.all {
            let own = rectangle.halves.map(|(triangle, _)| rectangle.constants(film_of(triangle as usize)));
            for ((triangle, legs), [.., diagonal]) in rectangle.halves.into_iter().zip(own) {
                let mean = |k: usize| 0.5 * (own[0][k] + own[1][k]);
                let part = &mut parts[triangle as usize];
                (part[legs[0]], part[legs[1]], part[legs[2]]) = (diagonal, mean(1), mean(0));
            }
        }
        parts
    }

    /// Spring constant of each of `ends`, summed over the rectangles \[N/m\]. `film_of` is the film of a triangle; a
    /// rectangle has the mean of the constants by both of its films.
    ///
    /// # Errors
    /// `SlenderRectangles`.
    pub fn stiffness(&self, film_of: impl Fn(usize) -> Film) -> Result<Vec<f64>> {
        let mut sums = vec![0.0; self.ends.len()];
        for rectangle in &self.all {
            let [first, second] = rectangle.halves.map(|(triangle, _)| rectangle.constants(film_of(triangle as usize)));
            for (springs, (one, other)) in rectangle.springs.iter().zip(first.into_iter().zip(second)) {
                springs.iter().for_each(|&row| sums[row as usize] += 0.5 * (one + other));
            }
        }
        let count = sums.iter().filter(|&&k| k < 0.0).count();
        match (0..sums.len()).min_by(|&i, &j| sums[i].total_cmp(&sums[j])) {
            Some(row) if count > 0 => Err(Error::SlenderRectangles {
                count,
                of: sums.len(),
                worst: sums[row],
                edge: self.ends[row].map(|node| node as usize),
                most: (2.0 / (1.0 - film_of(0).poisson_ratio)).sqrt(),
            }),
            _ => Ok(sums),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILM: Film = Film { youngs_modulus: 3.0, poisson_ratio: 0.2, density: 1.0, thickness: 0.5 };

    /// One rectangle from (0, 0) to (a, b), by the diagonal from (0, 0) or the other one.
    fn rectangle(a: f64, b: f64, is_first: bool) -> Mesh {
        let reference = vec![[0.0; 3], [a, 0.0, 0.0], [a, b, 0.0], [0.0, b, 0.0]];
        Mesh::new(reference, if is_first { vec![[0, 1, 2], [0, 2, 3]] } else { vec![[0, 1, 3], [2, 3, 1]] }).unwrap()
    }

    /// Energy of the springs in a uniform strain e_x, e_y and shear strain g, over E h and the area.
    fn energy(mesh: &Mesh, film: Film, [ex, ey, g]: [f64; 3]) -> f64 {
        let rectangles = mesh.rectangles(&[]).unwrap();
        let constants = rectangles.stiffness(|_| film).unwrap();
        let of_spring = |(&nodes, k): (&[u32; 2], &f64)| {
            let [i, j] = nodes.map(|node| mesh.reference[node as usize]);
            let [x, y, _] = sub(j, i);
            let stretch = (ex * x * x + ey * y * y + g * x * y) / (x * x + y * y).sqrt();
            0.5 * k * stretch * stretch
        };
        let area = 2.0 * mesh.area(0).unwrap();
        let energy: f64 = rectangles.ends.iter().zip(&constants).map(of_spring).sum();
        energy / (film.youngs_modulus * film.thickness * area)
    }

    /// The same of the film in plane stress.
    fn plane_stress(nu: f64, [ex, ey, g]: [f64; 3]) -> f64 {
        (ex * ex + ey * ey + 2.0 * nu * ex * ey) / (2.0 * (1.0 - nu * nu)) + g * g / (4.0 * (1.0 + nu))
    }

    #[test]
    fn each_strain_alone_stores_the_energy_of_plane_stress_at_any_ratio_and_shape() {
        for nu in [-0.3, 0.0, 0.2, 1.0 / 3.0, 0.34, 0.45] {
            for (a, b, is_first) in [(1.0, 1.0, true), (1.0, 1.2, false), (0.3, 0.36, true), (1.1, 1.0, false)] {
                let (mesh, film) = (rectangle(a, b, is_first), Film { poisson_ratio: nu, ..FILM });
                for strain in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.7], [0.0, -1.0, 0.7]] {
                    let share = energy(&mesh, film, strain) / plane_stress(nu, strain);
                    assert!((share - 1.0).abs() < 1e-14, "{nu} {a} {b} {strain:?} {share}");
                }
            }
        }
    }

    #[test]
    fn cap_and_saddle_are_off_by_the_coupling_alone() {
        for nu in [0.0, 0.2, 1.0 / 3.0, 0.34, 0.45] {
            let film = Film { poisson_ratio: nu, ..FILM };
            let share = |strain| energy(&rectangle(1.0, 1.3, true), film, strain) / plane_stress(nu, strain);
            assert!((share([1.0, 1.0, 0.0]) - (3.0 - nu) / (2.0 + 2.0 * nu)).abs() < 1e-14);
            assert!((share([1.0, -1.0, 0.0]) - (1.0 + nu) / (2.0 - 2.0 * nu)).abs() < 1e-14);
        }
    }

    #[test]
    fn a_square_at_one_third_has_six_equal_springs_and_common_sides_add() {
        let third = Film { poisson_ratio: 1.0 / 3.0, ..FILM };
        let all = rectangle(2.0, 2.0, true).rectangles(&[]).unwrap().stiffness(|_| third).unwrap();
        assert_eq!(all.len(), 6);
        assert!(all.iter().all(|k| (k / (0.375 * 1.5) - 1.0).abs() < 1e-14), "{all:?}");
        let reference = (0..6).map(|i| [f64::from(i % 3), f64::from(i / 3), 0.0]).collect();
        let mesh = Mesh::new(reference, vec![[0, 1, 4], [0, 4, 3], [1, 2, 4], [2, 5, 4]]).unwrap();
        let rectangles = mesh.rectangles(&[]).unwrap();
        let common = mesh.edges.iter().position(|&edge| edge == [1, 4]).unwrap();
        for (row, k) in rectangles.stiffness(|_| third).unwrap().into_iter().enumerate() {
            assert!((k / (0.375 * 1.5) - if row == common { 2.0 } else { 1.0 }).abs() < 1e-14);
        }
        assert_eq!(rectangles.ends[mesh.edges.len()..], [[1, 3], [1, 5]]);
    }

    #[test]
    fn a_rectangle_of_two_films_has_the_mean_of_their_constants() {
        let rectangles = rectangle(1.0, 1.2, true).rectangles(&[]).unwrap();
        let film_of = |row: usize| Film { thickness: [0.5, 0.1][row], ..FILM };
        let plain = rectangles.stiffness(|_| FILM).unwrap();
        for (k, plain) in rectangles.stiffness(film_of).unwrap().into_iter().zip(plain) {
            assert!((k / plain - 0.6).abs() < 1e-15);
        }
    }

    #[test]
    fn a_slender_rectangle_is_refused_with_its_edge_and_the_limit() {
        for nu in [0.0, 1.0 / 3.0, 0.34] {
            let (film, limit) = (Film { poisson_ratio: nu, ..FILM }, (2.0_f64 / (1.0 - nu)).sqrt());
            let of = |ratio: f64| rectangle(ratio, 1.0, true).rectangles(&[]).unwrap().stiffness(|_| film);
            assert!(of(0.999 * limit).is_ok());
            match of(1.001 * limit).unwrap_err() {
                Error::SlenderRectangles { count, of, edge, worst, most } => {
                    assert_eq!((count, of, edge), (2, 6, [0, 1]));
                    assert!(worst < 0.0 && (most - limit).abs() < 1e-15);
                }
                other => panic!("{other}"),
            }
        }
    }

    #[test]
    fn what_is_no_rectangle_is_refused_with_the_triangle_and_the_reason() {
        let reason = |reference: &[[f64; 2]], triangles: &[[u32; 3]], crease: &[[u32; 2]]| {
            let mesh = Mesh::new(reference.iter().map(|&[x, y]| [x, y, 0.0]).collect(), triangles.to_vec()).unwrap();
            let hinges = mesh.hinges(crease).unwrap();
            match mesh.rectangles(&hinges).unwrap_err() {
                Error::NotRectangles { triangle, reason, .. } => (triangle, reason),
                other => panic!("{other}"),
            }
        };
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [2.0, 0.0]];
        let halves = [[0, 1, 2], [0, 2, 3]];
        assert_eq!(reason(&square, &[halves[0], halves[1], [1, 4, 2]], &[]), (2, ALONE));
        assert_eq!(reason(&square[..4], &halves, &[[0, 2]]), (0, FOLDED));
        assert_eq!(reason(&[[0.0, 0.0], [1.0, 0.0], [0.4, 0.8]], &[[0, 1, 2]], &[]), (0, OBLIQUE));
        // Two right triangles with a common longest side, mirrored in it.
        let kite = [[0.0, 0.0], [2.0, 0.0], [0.4, 0.8], [0.4, -0.8]];
        assert_eq!(reason(&kite, &[[0, 1, 2], [1, 0, 3]], &[]), (0, KITE));
        let three = [square[0], square[1], square[2], square[3], [1.0, 1e-4]];
        assert_eq!(reason(&three, &[halves[0], halves[1], [0, 4, 2]], &[]), (0, BRANCHED));
    }

    #[test]
    fn a_mesh_with_rounded_coordinates_is_taken() {
        let mesh = Mesh::new(
            vec![[0.0; 3], [1.0, 3e-4, 0.0], [1.0002, 1.0, 0.0], [-2e-4, 1.0, 1e-4]],
            vec![[0, 1, 2], [0, 2, 3]],
        );
        assert_eq!(mesh.unwrap().rectangles(&[]).unwrap().corners(), [[1, 2, 3, 0]]);
    }
}
