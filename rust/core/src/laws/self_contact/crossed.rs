//! Exact checks: triangles that cross, and cords that pierce triangles.

use std::convert::Infallible;
use std::ops::ControlFlow;
use std::time::Instant;

use super::SelfContact;
use crate::arrays::state::{NodeVectors, columns};
use crate::contact::{crossings, first_piercing};
use crate::laws::Excess;

/// What has passed through what.
pub(super) enum Crossed {
    /// The first two of so many pairs of triangles, by their places.
    Triangles { pair: [usize; 2], count: u64 },
    /// Two nodes of a cord, and the place of a triangle.
    Cord { nodes: [u32; 2], triangle: usize },
}

impl SelfContact {
    /// What crosses at some positions, if anything.
    pub(super) fn crossed(&self, positions: &NodeVectors) -> Option<Crossed> {
        let [x, y, z] = columns(positions);
        let points: Vec<[f64; 3]> = (0..x.len()).map(|row| [x[row], y[row], z[row]]).collect();
        let pause = || ControlFlow::<Infallible>::Continue(());
        let ControlFlow::Continue(found) = crossings(&points, &self.surface.triangles, 1, pause).ok()?;
        if let Some(pair) = found.pairs.first() {
            return Some(Crossed::Triangles { pair: pair.map(|place| place as usize), count: found.count });
        }
        let segments = self.surface.segments();
        let [segment, triangle] = first_piercing(&points, &self.surface.triangles, segments).ok()??;
        Some(Crossed::Cord { nodes: segments[segment], triangle })
    }

    /// The same in words, by external numbers.
    pub(super) fn described(&self, crossed: &Crossed) -> String {
        let number = |place: usize| self.surface.numbers[place];
        match *crossed {
            Crossed::Triangles { pair: [first, second], count } => {
                let pairs = if count == 1 { "1 pair".to_owned() } else { format!("{count} pairs") };
                format!("triangles {} and {} of the film cross, {pairs} in all", number(first), number(second))
            }
            Crossed::Cord { nodes, triangle } => {
                let [a, b] = nodes.map(|node| self.numbering.to_external(node as usize));
                format!("the cord between nodes {a} and {b} goes through triangle {}", number(triangle))
            }
        }
    }

    /// A fault where something crosses, if nothing did before.
    pub(super) fn check_crossings(&mut self, positions: &NodeVectors) {
        self.early_check = None;
        if self.fault.is_some() {
            return;
        }
        let began = Instant::now();
        let crossed = self.crossed(positions);
        self.statistics.checks += 1;
        self.statistics.check_time += began.elapsed();
        self.fault = crossed.map(|crossed| {
            let corner = |place: usize| self.surface.triangles[place][0];
            let nodes = match crossed {
                Crossed::Triangles { pair, .. } => pair.map(corner).to_vec(),
                Crossed::Cord { nodes, .. } => nodes.to_vec(),
            };
            Excess { nodes, what: self.described(&crossed) }
        });
    }
}
