//! What can go wrong, each with its numbers and its remedy.
//! (The fields of the variants are named in the texts.)
#![allow(missing_docs)]

use thiserror::Error as ThisError;

/// Result of everything in this crate that can fail.
pub type Result<T> = std::result::Result<T, Error>;

/// Every error of the core. The text is written for the user who has to mend the scene.
#[derive(Debug, Clone, PartialEq, ThisError)]
pub enum Error {
    /// An index that points outside its array.
    #[error("{what} {row} names node {node}, but there are only {node_count} nodes (0 to {}); mend the index", node_count.saturating_sub(1))]
    IndexOutOfRange { what: &'static str, row: usize, node: usize, node_count: usize },

    /// Arrays that should have equally many rows.
    #[error("{what} has {found} rows but {expected} are needed; give one row per {per}")]
    LengthMismatch { what: &'static str, found: usize, expected: usize, per: &'static str },

    /// A triangle that spans no area.
    #[error(
        "triangle {triangle} (nodes {nodes:?}) has an area of {area:e} m2, too small for its longest side of {side:e} m; remove it or move its nodes apart"
    )]
    DegenerateTriangle { triangle: usize, nodes: [u32; 3], area: f64, side: f64 },

    /// A triangle whose spring constants eq. (1) leaves undefined.
    #[error(
        "triangle {triangle} (nodes {nodes:?}) has no spring constants at Poisson's ratio {poisson_ratio}: the matrix of eq. (1) is singular; change its shape or the ratio"
    )]
    SingularTriangle { triangle: usize, nodes: [u32; 3], poisson_ratio: f64 },

    /// Springs with a negative constant: the mesh is unstable at rest.
    #[error(
        "{count} of {spring_count} spring constants are negative, the worst {worst:e} N/m on edge {edge:?}; obtuse triangles cause this: use a mesh without angles above 90 degrees, or ask the law of the springs to clip or keep them"
    )]
    NegativeSprings { count: usize, spring_count: usize, worst: f64, edge: [usize; 2] },

    /// A dashpot whose coefficient would be the root of a negative number.
    #[error(
        "the dashpot on spring {edge:?} is undefined: its constant is {stiffness:e} N/m and c = 2 zeta sqrt(k m) needs k >= 0; clip negative springs to zero or leave spring damping out"
    )]
    DampingOnNegativeSpring { edge: [usize; 2], stiffness: f64 },

    /// A crease that is not an edge between two triangles.
    #[error(
        "crease {crease} (nodes {nodes:?}) {reason}; a crease needs an edge with exactly two triangles of the same winding"
    )]
    NotAHinge { crease: usize, nodes: [usize; 2], reason: &'static str },

    /// A node that nothing gives a mass.
    #[error(
        "node {node} has a mass of {mass:e} kg; give it mass by a triangle, a tether or a tip mass, or hold it fixed"
    )]
    MasslessNode { node: usize, mass: f64 },

    /// A number that must be finite.
    #[error("{what} of node {node} is {value}; every coordinate must be finite")]
    NotFinite { what: &'static str, node: usize, value: f64 },

    /// A parameter outside its range.
    #[error("{what} = {value:e} is not allowed: {range}")]
    OutOfRange { what: &'static str, value: f64, range: &'static str },

    /// A law that a scene holds twice.
    #[error("law {law} is there twice; a scene holds one of each kind: leave one out")]
    LawTwice { law: &'static str },

    /// A matrix that does not fit.
    #[error(
        "there is no memory for the tangent matrix of {nodes} free nodes; use a coarser mesh or an explicit integrator"
    )]
    NoMemory { nodes: usize },

    /// A name that no list knows.
    #[error("there is no {what} named {name:?}; choose one of: {known}")]
    UnknownName { what: &'static str, name: String, known: String },

    /// A scene without stiffness has no stability limit to take the step from.
    #[error("nothing in this scene is stiff, so no step follows from it; give dt in seconds")]
    NoStiffness,

    /// A step far beyond the stability limit.
    #[error("dt = {dt:e} s is {:.1e} times the stability limit of {integrator} here, {limit:e} s, which {part} sets; leave dt out or choose it below the limit", dt / limit)]
    HopelessStep { dt: f64, limit: f64, integrator: &'static str, part: String },

    /// The watch stopped a run.
    #[error(
        "stopped at t = {time:.6e} s, step {step}: {what} ({place}, {law}). {remedy}. The state was set back to the last good check at t = {good_time:.6e} s"
    )]
    Unstable { time: f64, step: u64, good_time: f64, what: String, place: String, law: String, remedy: String },
}
