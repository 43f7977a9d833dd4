//! Nodes that links tie together, and the shortest paths along links.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::mesh::check_indices;
use crate::error::{Error, Result};

/// The number of the group that each node is in, when links tie nodes together. Groups are numbered by their lowest
/// nodes.
///
/// # Errors
/// `IndexOutOfRange` for a link with an unknown node.
pub fn groups(links: &[[u32; 2]], node_count: usize) -> Result<Vec<u32>> {
    check_indices("link", links, node_count)?;
    // A lower node of the group, or the node itself: the lowest one.
    let mut lower: Vec<u32> = (0..node_count as u32).collect();
    for &[a, b] in links {
        let (a, b) = (lowest(&mut lower, a), lowest(&mut lower, b));
        lower[a.max(b) as usize] = a.min(b);
    }
    let (mut numbers, mut count) = (vec![0; node_count], 0);
    for node in 0..node_count {
        let first = lower[node] as usize;
        if first == node {
            numbers[node] = count;
            count += 1;
        } else {
            numbers[node] = numbers[first];
        }
    }
    Ok(numbers)
}

/// The lowest node of the group of `node`; paths to it are halved on the way.
fn lowest(lower: &mut [u32], mut node: u32) -> u32 {
    while lower[node as usize] != node {
        let next = lower[lower[node as usize] as usize];
        lower[node as usize] = next;
        node = next;
    }
    node
}

/// Nodes joined by links that have lengths.
pub struct Network {
    /// Where the neighbours of each node begin, and where those of the last one end.
    begins: Vec<usize>,
    /// Of each node, one after the other: the node at the other end of a link, and the length of the link.
    neighbours: Vec<(u32, f64)>,
}

impl Network {
    /// Links between nodes, and their lengths.
    ///
    /// # Errors
    /// `LengthMismatch` for another number of lengths than of links; `IndexOutOfRange` for a link with an unknown node.
    pub fn new(links: &[[u32; 2]], lengths: &[f64], node_count: usize) -> Result<Self> {
        check_indices("link", links, node_count)?;
        if lengths.len() != links.len() {
            let (found, expected) = (lengths.len(), links.len());
            return Err(Error::LengthMismatch { what: "lengths", found, expected, per: "link" });
        }
        let mut begins = vec![0; node_count + 1];
        links.as_flattened().iter().for_each(|&node| begins[node as usize + 1] += 1);
        (0..node_count).for_each(|node| begins[node + 1] += begins[node]);
        let mut neighbours = vec![(0, 0.0); 2 * links.len()];
        let mut ends = begins.clone();
        for (&[a, b], &length) in links.iter().zip(lengths) {
            for (node, other) in [(a, b), (b, a)] {
                neighbours[ends[node as usize]] = (other, length);
                ends[node as usize] += 1;
            }
        }
        Ok(Self { begins, neighbours })
    }

    /// The length of the shortest path to each node from any of the starts, each with the length that its paths have
    /// already, in one search by Dijkstra's method; infinite where there is none up to `longest`. A link whose length
    /// is not a number at or above zero joins nothing, and from such a start nothing is reached.
    ///
    /// # Errors
    /// `IndexOutOfRange` for an unknown node.
    pub fn shortest_paths(&self, starts: &[(u32, f64)], longest: f64) -> Result<Vec<f64>> {
        let node_count = self.begins.len() - 1;
        let mut found = vec![f64::INFINITY; node_count];
        // Numbers at or above zero are ordered as their bits are, once -0 is 0.
        let mut open = BinaryHeap::new();
        for &(start, length) in starts {
            check_indices("start", &[[start]], node_count)?;
            let length = length + 0.0;
            if length >= 0.0 && length <= longest && length < found[start as usize] {
                found[start as usize] = length;
                open.push(Reverse((length.to_bits(), start)));
            }
        }
        while let Some(Reverse((bits, node))) = open.pop() {
            let path = f64::from_bits(bits);
            if path > found[node as usize] {
                continue;
            }
            for &(other, length) in &self.neighbours[self.begins[node as usize]..self.begins[node as usize + 1]] {
                let through = path + length;
                if length >= 0.0 && through <= longest && through < found[other as usize] {
                    found[other as usize] = through;
                    open.push(Reverse((through.to_bits(), other)));
                }
            }
        }
        Ok(found)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_are_numbered_by_their_lowest_nodes() {
        // 1-5-3 and 2-4 in links of any direction; 0 and 6 alone.
        assert_eq!(groups(&[[5, 3], [4, 2], [1, 5], [3, 1]], 7).unwrap(), [0, 1, 2, 1, 2, 1, 3]);
        assert_eq!(groups(&[], 2).unwrap(), [0, 1]);
        let chain: Vec<[u32; 2]> = (0..99).rev().map(|node| [node, node + 1]).collect();
        assert_eq!(groups(&chain, 100).unwrap(), [0; 100]);
        assert!(matches!(groups(&[[0, 2]], 2), Err(Error::IndexOutOfRange { node: 2, .. })));
    }

    #[test]
    fn the_shortest_of_several_paths_is_taken() {
        //  0 -1- 1 -1- 2 -1- 3   and   0 -2.5- 3, 0 -9- 2; 4 alone
        let network = Network::new(&[[1, 0], [1, 2], [2, 3], [3, 0], [0, 2]], &[1.0, 1.0, 1.0, 2.5, 9.0], 5).unwrap();
        let (inf, nan) = (f64::INFINITY, f64::NAN);
        let paths = |starts: &[(u32, f64)], longest| network.shortest_paths(starts, longest).unwrap();
        assert_eq!(paths(&[(0, 0.0)], inf), [0.0, 1.0, 2.0, 2.5, inf]);
        assert_eq!(paths(&[(3, -0.0)], 2.0), [inf, 2.0, 1.0, 0.0, inf]);
        assert_eq!(paths(&[(4, 0.0)], -1.0), [inf; 5]);
        assert_eq!(paths(&[(0, 0.5), (3, 0.25), (4, 3.0), (0, 0.75)], 2.0), [0.5, 1.5, 1.25, 0.25, inf]);
        assert_eq!(paths(&[(0, 1.5), (1, 0.0), (2, nan), (4, -1.0)], inf), [1.0, 0.0, 1.0, 2.0, inf]);
        assert_eq!(paths(&[], inf), [inf; 5]);
        assert!(network.shortest_paths(&[(5, 0.0)], 1.0).is_err());
        assert!(matches!(Network::new(&[[0, 1]], &[], 2), Err(Error::LengthMismatch { .. })));
    }

    #[test]
    fn links_without_a_length_join_nothing() {
        let network = Network::new(&[[0, 1], [0, 2], [0, 3]], &[f64::NAN, -1.0, 0.0], 4).unwrap();
        assert_eq!(network.shortest_paths(&[(0, 0.0)], 1.0).unwrap(), [0.0, f64::INFINITY, f64::INFINITY, 0.0]);
    }
}
