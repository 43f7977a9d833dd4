//! Geometry of contact: which triangles cross. No physics: neither stiffness nor distance at which a force begins.

mod box_tree;
mod crossings;
mod facet;
mod first_pairs;
mod orientation;
mod triangle_pair;

pub use crossings::{Crossings, crossings};
