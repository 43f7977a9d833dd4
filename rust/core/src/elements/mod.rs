//! Kinematics of elements and its transpose: from the motion of the nodes to the deformation of an element, and from
//! its stress to forces on the nodes. Elements are oriented here, by their lowest node.

pub(crate) mod facet;
pub(crate) mod hinge;
pub(crate) mod hinge_set;
pub(crate) mod hinge_tangent;
pub mod link;
pub mod stress;
pub(crate) mod triangle;
pub(crate) mod triangle_tangent;
