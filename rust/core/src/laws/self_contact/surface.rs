//! What may touch: triangles of the film, cords, and pairs of their nodes and edges.

use std::collections::BTreeMap;

use crate::assembly::Assembly;

/// Marks the pair of two edges; without it, that of a node and a triangle.
const EDGES: u64 = 1 << 63;
/// Bits of the second of a pair.
const SHIFT: u32 = 31;
const SECOND: u64 = (1 << SHIFT) - 1;

/// A pair of a node and a triangle, or of two edges: a number by whose order impulses are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Pair(u64);

impl Pair {
    pub(super) fn of_node(node: u32, triangle: u32) -> Self {
        Self(u64::from(node) << SHIFT | u64::from(triangle))
    }

    pub(super) fn of_edges(first: u32, second: u32) -> Self {
        let (first, second) = (first.min(second), first.max(second));
        Self(EDGES | u64::from(first) << SHIFT | u64::from(second))
    }

    /// Whether it is one of two edges.
    #[inline(always)]
    pub(super) fn has_edges(self) -> bool {
        self.0 & EDGES != 0
    }

    /// The node and the triangle, or both edges.
    #[inline(always)]
    pub(super) fn parts(self) -> [usize; 2] {
        [((self.0 & !EDGES) >> SHIFT) as usize, (self.0 & SECOND) as usize]
    }
}

/// An element of the tree of boxes, with the nodes and edges that belong to it and to no other.
pub(super) struct Element {
    /// Corners; the last two of a segment of a cord are one.
    pub(super) corners: [u32; 3],
    /// The triangle; `None` for a segment of a cord.
    triangle: Option<u32>,
    nodes: Vec<u32>,
    edges: Vec<u32>,
}

/// Triangles and cords that feel each other; nodes by internal numbers.
pub(super) struct Surface {
    /// Corners of each triangle, and its external number.
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) numbers: Vec<u32>,
    /// Edges of the triangles, then segments of cords.
    pub(super) edges: Vec<[u32; 2]>,
    pub(super) elements: Vec<Element>,
    /// The place of each node: that of the lowest one to which bridges join it.
    places: Vec<u32>,
    /// Whether each node is one of a cord, and of no triangle.
    is_of_cord: Vec<bool>,
    /// The first edge that is a segment of a cord.
    first_segment: usize,
    /// Distances at which two layers, and a cord and a layer, touch \[m\].
    touching: [f64; 2],
    /// Whether there are pairs of two edges.
    has_edges: bool,
}

impl Surface {
    /// Those of a model; with its cords or without.
    pub(super) fn new(assembly: &Assembly, with_cords: bool, touching: [f64; 2], has_edges: bool) -> Self {
        let (model, numbering) = (&assembly.model, &assembly.numbering);
        let numbers = model.layers.clone();
        let corners_of = |&number: &u32| numbering.to_internal(assembly.mesh.triangles[number as usize]);
        let triangles: Vec<[u32; 3]> = numbers.iter().map(corners_of).collect();
        let mut elements = Vec::new();
        let mut edges: Vec<[u32; 2]> = Vec::new();
        let mut known = BTreeMap::new();
        let mut has_owner = vec![false; assembly.masses.len()];
        for (number, corners) in (0..).zip(&triangles) {
            let mut own = Vec::new();
            for [a, b] in [[0, 1], [1, 2], [2, 0]].map(|side| side.map(|k: usize| corners[k])) {
                let side = [a.min(b), a.max(b)];
                known.entry(side).or_insert_with(|| {
                    edges.push(side);
                    own.push(edges.len() as u32 - 1);
                });
            }
            let nodes = owned(corners, &mut has_owner);
            elements.push(Element { corners: *corners, triangle: Some(number), nodes, edges: own });
        }
        let first_segment = edges.len();
        let mut is_of_cord = vec![false; assembly.masses.len()];
        if with_cords && !triangles.is_empty() {
            // A cord along edges of the film touches as these do.
            let is_edge = |&[a, b]: &[u32; 2]| known.contains_key(&[a.min(b), a.max(b)]);
            let segments = model.cord_nodes().into_iter().map(|nodes| numbering.to_internal(nodes));
            for nodes in segments.filter(|nodes| !is_edge(nodes)) {
                let own = owned(&nodes, &mut has_owner);
                own.iter().for_each(|&node| is_of_cord[node as usize] = true);
                edges.push(nodes);
                let [a, b] = nodes;
                elements.push(Element {
                    corners: [a, b, b],
                    triangle: None,
                    nodes: own,
                    edges: vec![edges.len() as u32 - 1],
                });
            }
        }
        let mut places: Vec<u32> = (0..assembly.masses.len() as u32).collect();
        let bridges: Vec<[u32; 2]> = model.bridges.nodes.iter().map(|&nodes| numbering.to_internal(nodes)).collect();
        // Each pass joins neighbours; chains of bridges are short.
        while bridges.iter().fold(false, |is_changed, nodes| {
            let [a, b] = nodes.map(|node| node as usize);
            let lower = places[a].min(places[b]);
            let is_joined = places[a] == places[b];
            (places[a], places[b]) = (lower, lower);
            is_changed || !is_joined
        }) {}
        Self { triangles, numbers, edges, elements, places, is_of_cord, first_segment, touching, has_edges }
    }

    /// The four nodes of a pair, whose weights are those of `contact::closest`.
    #[inline(always)]
    pub(super) fn nodes(&self, pair: Pair) -> [u32; 4] {
        if pair.has_edges() { self.nodes_of::<true>(pair) } else { self.nodes_of::<false>(pair) }
    }

    /// The same, of a pair that has edges or not.
    #[inline(always)]
    pub(super) fn nodes_of<const EDGES: bool>(&self, pair: Pair) -> [u32; 4] {
        let [first, second] = pair.parts();
        if EDGES {
            let ([a, b], [c, d]) = (self.edges[first], self.edges[second]);
            [a, b, c, d]
        } else {
            let [a, b, c] = self.triangles[second];
            [first as u32, a, b, c]
        }
    }

    /// Whether a pair is one of a cord and the film.
    pub(super) fn has_cord(&self, pair: Pair) -> bool {
        let [first, second] = pair.parts();
        if pair.has_edges() { second >= self.first_segment } else { self.is_of_cord[first] }
    }

    /// The segments of cords.
    pub(super) fn segments(&self) -> &[[u32; 2]] {
        &self.edges[self.first_segment..]
    }

    /// The distance at which a pair touches \[m\].
    pub(super) fn touching(&self, pair: Pair) -> f64 {
        self.touching[usize::from(self.has_cord(pair))]
    }

    /// The largest of these distances \[m\].
    pub(super) fn most_touching(&self) -> f64 {
        let has_cords = self.first_segment < self.edges.len();
        if has_cords { self.touching[0].max(self.touching[1]) } else { self.touching[0] }
    }

    /// Calls `visit` with each pair of nodes and edges that belong to two elements, but for two cords and for pairs
    /// with a common node: each pair of all elements comes once.
    pub(super) fn visit_pairs(&self, first: usize, second: usize, visit: &mut impl FnMut(Pair)) {
        let [first, second] = [first, second].map(|element| &self.elements[element]);
        if first.triangle.is_none() && second.triangle.is_none() {
            return;
        }
        for (one, other) in [(first, second), (second, first)] {
            let Some(triangle) = other.triangle else { continue };
            for &node in &one.nodes {
                if !self.triangles[triangle as usize].iter().any(|&corner| self.is_one_place(node, corner)) {
                    visit(Pair::of_node(node, triangle));
                }
            }
        }
        if !self.has_edges {
            return;
        }
        for &one in &first.edges {
            for &other in &second.edges {
                let others = self.edges[other as usize];
                let shares = |&node: &u32| others.iter().any(|&other| self.is_one_place(node, other));
                if !self.edges[one as usize].iter().any(shares) {
                    visit(Pair::of_edges(one, other));
                }
            }
        }
    }

    fn is_one_place(&self, node: u32, other: u32) -> bool {
        self.places[node as usize] == self.places[other as usize]
    }
}

/// The nodes that have no owner yet.
fn owned(nodes: &[u32], has_owner: &mut [bool]) -> Vec<u32> {
    nodes.iter().copied().filter(|&node| !std::mem::replace(&mut has_owner[node as usize], true)).collect()
}
