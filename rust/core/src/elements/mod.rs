//! Kinematics of elements: what their nodes' positions and velocities make of them, and what a force on an element does to its nodes.

pub(crate) mod link;
pub(crate) mod triangle;
pub(crate) mod triangle_tangent;
