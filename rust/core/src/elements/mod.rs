//! Kinematics of elements and their transposes: what motion of the nodes does to an element, and what a force on it does to the
//! nodes. Orientation is settled here, once: each element is taken from its lowest node.

pub(crate) mod facet;
pub(crate) mod hinge;
pub mod link;
pub(crate) mod triangle;
pub(crate) mod triangle_tangent;
