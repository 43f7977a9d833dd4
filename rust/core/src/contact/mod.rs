//! Geometry of contact: which triangles cross, and how far apart nodes, edges and triangles are. No physics: neither
//! stiffness nor distance at which a force begins.

pub(crate) mod box_tree;
pub(crate) mod closest;
mod crossings;
mod facet;
mod first_pairs;
mod orientation;
mod piercings;
pub(crate) mod separation;
mod triangle_pair;

pub use crossings::{Crossings, crossings};
pub use piercings::first_piercing;
