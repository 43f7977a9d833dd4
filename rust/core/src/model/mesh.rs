//! Triangles, their unique edges, the hinges of creases, and lumped masses.

use crate::error::{Error, Result};

/// A triangulated reference shape and its connectivity.
#[derive(Debug, Clone)]
pub struct Mesh {
    /// Stress-free node positions \[m\].
    pub reference: Vec<[f64; 3]>,
    /// Node triples.
    pub triangles: Vec<[u32; 3]>,
    /// Unique node pairs, lower index first, sorted.
    pub edges: Vec<[u32; 2]>,
    /// For each triangle its three edges; edge k is opposite corner k.
    pub triangle_edges: Vec<[u32; 3]>,
}

/// Two triangles with a common edge. Facet C lies to the left of A -> B, seen from the side of the normals.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Hinge {
    /// The nodes A, B of the common edge and the apexes C, D of the facets.
    pub nodes: [u32; 4],
    /// The triangles of facets C and D.
    pub triangles: [u32; 2],
    /// Index of the common edge in `Mesh::edges`.
    pub edge: u32,
}

/// No triangle on one side of an edge, and more than one.
const NONE: u32 = u32::MAX;
const TWICE: u32 = u32::MAX - 1;

/// Unique sorted edges of `triangles`, and the three edges of each triangle (edge k opposite corner k).
pub fn unique_edges(triangles: &[[u32; 3]]) -> (Vec<[u32; 2]>, Vec<[u32; 3]>) {
    let sides_of = |&[a, b, c]: &[u32; 3]| [(b, c), (c, a), (a, b)].map(|(i, j)| (i.min(j), i.max(j)));
    let sides = || triangles.iter().flat_map(sides_of).zip(0_u32..);
    // Sides by their lower node: those of node n begin at ends[n], and fill the room up to those of the next one.
    let node_count = triangles.as_flattened().iter().max().map_or(0, |&node| node as usize + 1);
    let mut ends = vec![0; node_count + 1];
    sides().for_each(|((lower, _), _)| ends[lower as usize + 1] += 1);
    (0..node_count).for_each(|node| ends[node + 1] += ends[node]);
    let mut by_lower = vec![(0, 0); 3 * triangles.len()];
    for ((lower, higher), side) in sides() {
        let end = &mut ends[lower as usize];
        by_lower[*end] = (higher, side);
        *end += 1;
    }
    let mut edges: Vec<[u32; 2]> = Vec::with_capacity(3 * triangles.len() / 2);
    let mut triangle_edges = vec![[0; 3]; triangles.len()];
    let mut begin = 0;
    for (lower, &end) in (0..).zip(&ends[..node_count]) {
        let of_node = &mut by_lower[begin..end];
        of_node.sort_unstable();
        let mut last = None;
        for &mut (higher, side) in of_node {
            if last != Some(higher) {
                edges.push([lower, higher]);
                last = Some(higher);
            }
            triangle_edges.as_flattened_mut()[side as usize] = edges.len() as u32 - 1;
        }
        begin = end;
    }
    (edges, triangle_edges)
}

impl Mesh {
    /// Builds the connectivity.
    ///
    /// # Errors
    /// `IndexOutOfRange` for a triangle with an unknown node; `NotFinite` for a coordinate.
    pub fn new(reference: Vec<[f64; 3]>, triangles: Vec<[u32; 3]>) -> Result<Self> {
        check_indices("triangle", &triangles, reference.len())?;
        check_finite("the reference position", &reference)?;
        let (edges, triangle_edges) = unique_edges(&triangles);
        Ok(Self { reference, triangles, edges, triangle_edges })
    }

    /// Lengths of the three sides, side k opposite corner k \[m\].
    pub fn side_lengths(&self, triangle: usize) -> [f64; 3] {
        let [a, b, c] = self.triangles[triangle].map(|i| self.reference[i as usize]);
        [sub(c, b), sub(a, c), sub(b, a)].map(|d| dot(d, d).sqrt())
    }

    /// Reference area of a triangle \[m2\].
    ///
    /// # Errors
    /// `DegenerateTriangle` below 1e-12 of the longest side squared.
    pub fn area(&self, triangle: usize) -> Result<f64> {
        let nodes = self.triangles[triangle];
        let [a, b, c] = nodes.map(|i| self.reference[i as usize]);
        let normal = cross(sub(b, a), sub(c, a));
        let area = 0.5 * dot(normal, normal).sqrt();
        let side = self.side_lengths(triangle).into_iter().fold(0.0, f64::max);
        if !area.is_finite() || area <= 1e-12 * side * side {
            return Err(Error::DegenerateTriangle { triangle, nodes, area, side });
        }
        Ok(area)
    }

    /// Whether a triangle lies in a plane of constant z, to 1e-3 rad.
    pub(crate) fn is_level(&self, triangle: usize) -> bool {
        let [a, b, c] = self.triangles[triangle].map(|node| self.reference[node as usize]);
        let [x, y, z] = cross(sub(b, a), sub(c, a));
        x.hypot(y) <= 1e-3 * z.abs()
    }

    /// Mass of each node: the sum of m S / 3 over its triangles, with the mass m per area of each \[kg\].
    ///
    /// # Errors
    /// `DegenerateTriangle`.
    pub fn lumped_masses(&self, areal_density: impl Fn(usize) -> f64) -> Result<Vec<f64>> {
        let mut masses = vec![0.0; self.reference.len()];
        for (row, nodes) in self.triangles.iter().enumerate() {
            let share = areal_density(row) * self.area(row)? / 3.0;
            for &node in nodes {
                masses[node as usize] += share;
            }
        }
        Ok(masses)
    }

    /// Triangles on the left [0] and on the right [1] of each edge, directed from its lower to its higher node.
    fn facets(&self) -> Vec<[u32; 2]> {
        let mut facets = vec![[NONE; 2]; self.edges.len()];
        for ((nodes, edges), triangle) in self.triangles.iter().zip(&self.triangle_edges).zip(0_u32..) {
            for k in 0..3 {
                let side = usize::from(nodes[(k + 1) % 3] > nodes[(k + 2) % 3]);
                let slot = &mut facets[edges[k] as usize][side];
                *slot = if *slot == NONE { triangle } else { TWICE };
            }
        }
        facets
    }

    /// The hinge of an edge between two triangles, each on its own side.
    fn hinge(&self, edge: usize, triangles: [u32; 2]) -> Hinge {
        let [a, b] = self.edges[edge];
        let [c, d] = triangles.map(|triangle| {
            let [p, q, r] = self.triangles[triangle as usize];
            if p != a && p != b {
                p
            } else if q != a && q != b {
                q
            } else {
                r
            }
        });
        Hinge { nodes: [a, b, c, d], triangles, edge: edge as u32 }
    }

    /// The hinges of all edges between two triangles of the same winding, in the order of the edges.
    pub fn inner_hinges(&self) -> Vec<Hinge> {
        let inner =
            self.facets().into_iter().enumerate().filter(|(_, facets)| facets.iter().all(|&facet| facet < TWICE));
        inner.map(|(edge, facets)| self.hinge(edge, facets)).collect()
    }

    /// The hinges of `creases` (node pairs in any order).
    ///
    /// # Errors
    /// `NotAHinge` for a pair that is no edge, or has other than two triangles of the same winding.
    pub fn hinges(&self, creases: &[[u32; 2]]) -> Result<Vec<Hinge>> {
        check_indices("crease", creases, self.reference.len())?;
        if creases.is_empty() {
            return Ok(Vec::new());
        }
        let facets = self.facets();
        let mut hinges = Vec::with_capacity(creases.len());
        for (crease, &[a, b]) in creases.iter().enumerate() {
            let fail = |reason| Error::NotAHinge { crease, nodes: [a as usize, b as usize], reason };
            let pair = [a.min(b), a.max(b)];
            let edge = self.edges.binary_search(&pair).map_err(|_| fail("is no edge of the mesh"))?;
            let [c, d] = facets[edge];
            if c == TWICE || d == TWICE {
                return Err(fail("has triangles of opposite winding, or more than two"));
            }
            if c == NONE || d == NONE {
                return Err(fail("lies on the boundary"));
            }
            hinges.push(self.hinge(edge, [c, d]));
        }
        Ok(hinges)
    }
}

/// a - b
#[inline]
pub fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// a . b
#[inline]
pub fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// a x b
#[inline]
pub fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Checks that every index of `rows` is below `node_count`.
///
/// # Errors
/// `IndexOutOfRange`.
pub fn check_indices<const N: usize>(what: &'static str, rows: &[[u32; N]], node_count: usize) -> Result<()> {
    for (row, nodes) in rows.iter().enumerate() {
        if let Some(&node) = nodes.iter().find(|&&node| node as usize >= node_count) {
            return Err(Error::IndexOutOfRange { what, row, node: node as usize, node_count });
        }
    }
    Ok(())
}

/// Checks that every coordinate is finite.
///
/// # Errors
/// `NotFinite`.
pub fn check_finite(what: &'static str, points: &[[f64; 3]]) -> Result<()> {
    for (node, point) in points.iter().enumerate() {
        if let Some(&value) = point.iter().find(|value| !value.is_finite()) {
            return Err(Error::NotFinite { what, node, value });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square() -> Mesh {
        let reference = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        Mesh::new(reference, vec![[0, 1, 2], [0, 2, 3]]).unwrap()
    }

    #[test]
    fn edges_are_unique_and_sorted_and_triangles_list_them() {
        let mesh = square();
        assert_eq!(mesh.edges, [[0, 1], [0, 2], [0, 3], [1, 2], [2, 3]]);
        assert_eq!(mesh.triangle_edges, [[3, 1, 0], [4, 2, 1]]);
    }

    #[test]
    fn the_left_facet_follows_the_winding() {
        let hinge = square().hinges(&[[2, 0]]).unwrap()[0];
        assert_eq!(hinge, Hinge { nodes: [0, 2, 3, 1], triangles: [1, 0], edge: 1 });
    }

    #[test]
    fn inner_hinges_are_those_of_edges_between_two_triangles_of_the_same_winding() {
        let mesh = square();
        assert_eq!(mesh.inner_hinges(), mesh.hinges(&[[0, 2]]).unwrap());
        let twisted = Mesh::new(mesh.reference.clone(), vec![[0, 1, 2], [0, 3, 2]]).unwrap();
        assert!(twisted.inner_hinges().is_empty());
    }

    #[test]
    fn a_crease_that_is_no_hinge_is_refused_with_the_reason() {
        let mesh = square();
        for (crease, word) in [([0, 1], "boundary"), ([1, 3], "no edge")] {
            assert!(mesh.hinges(&[crease]).unwrap_err().to_string().contains(word));
        }
        let twisted = Mesh::new(mesh.reference.clone(), vec![[0, 1, 2], [0, 3, 2]]).unwrap();
        assert!(twisted.hinges(&[[0, 2]]).unwrap_err().to_string().contains("winding"));
    }

    #[test]
    fn masses_sum_to_the_film() {
        let masses = square().lumped_masses(|_| 3.0).unwrap();
        assert_eq!(masses, [1.0, 0.5, 1.0, 0.5]);
    }

    #[test]
    fn a_flat_triangle_is_refused_by_number() {
        let reference = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]];
        let mesh = Mesh::new(reference, vec![[0, 1, 2]]).unwrap();
        assert!(matches!(mesh.lumped_masses(|_| 1.0), Err(Error::DegenerateTriangle { triangle: 0, .. })));
    }
}
