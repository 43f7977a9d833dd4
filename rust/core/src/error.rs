//! The errors of the core, each with value, place and remedy. (The messages name the fields of the variants.)
#![allow(missing_docs)]

use thiserror::Error as ThisError;

/// Result type of this crate.
pub type Result<T> = std::result::Result<T, Error>;

/// An error of the core. Its message addresses the author of the scene.
#[derive(Debug, Clone, PartialEq, ThisError)]
pub enum Error {
    /// An index out of range.
    #[error(
        "{what} {row} names node {node}, but there are only {node_count} nodes (0 to {}); mend the index",
        node_count.saturating_sub(1)
    )]
    IndexOutOfRange { what: &'static str, row: usize, node: usize, node_count: usize },

    /// A triangle out of range.
    #[error(
        "{what} {row} names triangle {triangle}, but there are only {triangle_count} triangles (0 to {}); mend the \
         index",
        triangle_count.saturating_sub(1)
    )]
    TriangleOutOfRange { what: &'static str, row: usize, triangle: usize, triangle_count: usize },

    /// A triangle of two regions.
    #[error("triangle {triangle} belongs to {first} and to {second}; leave it out of one of them")]
    RegionsOverlap { triangle: usize, first: String, second: String },

    /// A film with directions in x and y on a triangle that does not lie in a plane of constant z.
    #[error(
        "triangle {triangle} of the flat shape is tilted to the xy plane, in which {what} is given; turn the flat \
         shape into that plane"
    )]
    TiltedFilm { triangle: usize, what: String },

    /// A natural curvature beyond what an edge of the mesh can follow.
    #[error(
        "the law bending: the natural curvature of {region} folds edge {edge:?} by {degrees:.0} degrees, and a mesh \
         follows at most 90 from triangle to triangle; make it finer there, or the curvature smaller"
    )]
    CurvatureBeyondMesh { region: String, edge: [usize; 2], degrees: f64 },

    /// An array with a wrong number of rows.
    #[error("{what} has {found} rows but {expected} are needed; give one row per {per}")]
    LengthMismatch { what: &'static str, found: usize, expected: usize, per: &'static str },

    /// A saved history that its law or method refuses.
    #[error("the saved history of {owner} does not fit it; resume with the scene and the integrator of the saved run")]
    HistoryMisfit { owner: &'static str },

    /// A triangle without area.
    #[error(
        "triangle {triangle} (nodes {nodes:?}) has an area of {area:e} m2, too small for its \
         longest side of {side:e} m; remove it or move its nodes apart"
    )]
    DegenerateTriangle { triangle: usize, nodes: [u32; 3], area: f64, side: f64 },

    /// A triangle without spring constants by eq. (1).
    #[error(
        "triangle {triangle} (nodes {nodes:?}) has no spring constants at Poisson's ratio \
         {poisson_ratio}: the matrix of eq. (1) is singular; change its shape or the ratio"
    )]
    SingularTriangle { triangle: usize, nodes: [u32; 3], poisson_ratio: f64 },

    /// Springs with a negative constant: the mesh is unstable at rest.
    #[error(
        "{count} of {spring_count} spring constants are negative, the worst {worst:e} N/m on edge {edge:?}; \
         obtuse triangles cause this: use a mesh without angles above 90 degrees, or ask the law of the springs to \
         clip or keep them"
    )]
    NegativeSprings { count: usize, spring_count: usize, worst: f64, edge: [usize; 2] },

    /// Triangles that do not form rectangles in pairs.
    #[error(
        "{count} of {of} triangles are no halves of rectangles, first triangle {triangle} (nodes {nodes:?}): it \
         {reason}; the law rectangles needs right triangles in pairs, without a crease between them: use such a mesh, \
         or the law springs or triangles"
    )]
    NotRectangles { count: usize, of: usize, triangle: usize, nodes: [u32; 3], reason: &'static str },

    /// Rectangles with a negative spring constant: the mesh is unstable at rest.
    #[error(
        "{count} of {of} spring constants of rectangles are negative, the worst {worst:e} N/m on edge {edge:?}; \
         rectangles whose sides differ by more than sqrt(2/(1 - nu)) = {most:.4} times cause this: use squarer ones, \
         or the law springs or triangles"
    )]
    SlenderRectangles { count: usize, of: usize, worst: f64, edge: [usize; 2], most: f64 },

    /// A dashpot with the square root of a negative number as its coefficient.
    #[error(
        "the dashpot on spring {edge:?} is undefined: its constant is {stiffness:e} N/m and c = 2 zeta \
         sqrt(k m) needs k >= 0; clip negative springs to zero or leave spring damping out"
    )]
    DampingOnNegativeSpring { edge: [usize; 2], stiffness: f64 },

    /// Dashpots of the film with a limit, in a scene without springs of the film.
    #[error(
        "limited = \"all\" limits the dashpots of the film by the tension of its springs, but the scene has no law \
         \"springs\"; set limited to \"cords\", or model the film as springs"
    )]
    LimitWithoutSprings,

    /// A film of two moduli with a law for one.
    #[error(
        "the law {law}: {what} represent a film of one Young's modulus, and across its direction this one has {across} \
         times that along it; {remedy}, or give the film one modulus"
    )]
    TwoModuli { law: &'static str, what: &'static str, across: f64, remedy: &'static str },

    /// A crease that is no edge between two triangles.
    #[error(
        "crease {crease} (nodes {nodes:?}) {reason}; a crease needs an edge with exactly two triangles of the same \
         winding"
    )]
    NotAHinge { crease: usize, nodes: [usize; 2], reason: &'static str },

    /// Triangles without a film.
    #[error("the model has {triangles} triangles and no film; give it one, or leave the triangles out")]
    NoFilm { triangles: usize },

    /// A node without mass.
    #[error(
        "node {node}, {part} at {place:?} m, has a mass of {mass:e} kg; give it mass by a triangle, a tether or a tip \
         mass, or hold it fixed"
    )]
    MasslessNode { node: usize, part: &'static str, place: [f64; 3], mass: f64 },

    /// A node that follows two motions.
    #[error("node {node} is to follow two motions; leave it out of one of them")]
    MovedTwice { node: usize },

    /// A number that is not finite.
    #[error("{what} of node {node} is {value}; every coordinate must be finite")]
    NotFinite { what: &'static str, node: usize, value: f64 },

    /// A parameter outside its range.
    #[error("{what} = {value:e} is not allowed: {range}")]
    OutOfRange { what: &'static str, value: f64, range: &'static str },

    /// A name that cannot be kept.
    #[error("the name {name:?} cannot be taken: {reason}")]
    BadName { name: String, reason: &'static str },

    /// A knot of a schedule outside its range.
    #[error("{what}[{index}] = {value:e} of a schedule is not allowed: {range}")]
    Knot { what: &'static str, index: usize, value: f64, range: &'static str },

    /// A second law of one kind.
    #[error("law {law} is there twice; a scene holds one of each kind, and bodies of different names: leave one out")]
    LawTwice { law: &'static str },

    /// Two laws for the in-plane elasticity of the film.
    #[error("{first} and {second} are both laws for the elasticity of the film; a scene holds one: leave one out")]
    TwoFilms { first: &'static str, second: &'static str },

    /// A nodal law with other forces.
    #[error("law {law} is nodal and has kernels of elements or links too; make two laws of it")]
    MixedKernels { law: &'static str },

    /// A matrix too large for the memory.
    #[error(
        "there is no memory for the tangent matrix of {nodes} free nodes; use a coarser mesh or an explicit integrator"
    )]
    NoMemory { nodes: usize },

    /// An unknown name.
    #[error("there is no {what} named {name:?}; choose one of: {known}")]
    UnknownName { what: &'static str, name: String, known: String },

    /// A scene without stiffness, and therefore without stability limit, and no given step.
    #[error("nothing in this scene is stiff, so no step follows from it; give dt in seconds")]
    NoStiffness,

    /// A step far beyond the stability limit.
    #[error(
        "dt = {dt:e} s is {:.1e} times the stability limit of {integrator} here, {limit:e} s, which {part} sets; leave \
         dt out or choose it below the limit",
        dt / limit
    )]
    HopelessStep { dt: f64, limit: f64, integrator: &'static str, part: String },

    /// What a free hub does not go with.
    #[error("{what} does not go with a free hub; {remedy}, or drive the hub: leave its inertia out")]
    FreeHub { what: String, remedy: &'static str },

    /// What contact between layers does not go with.
    #[error(
        "{what} does not go with {law}, which acts by impulses in the kicks of leapfrog; {remedy}, or leave it out"
    )]
    Impulses { what: String, law: &'static str, remedy: &'static str },

    /// A start with layers that cross.
    #[error(
        "at the start {what}: what cannot pass through each other cannot start so; mend the shape, leave the triangles \
         out by `only` or `without` of self_contact or the cords by `cords`, or leave self_contact out"
    )]
    StartsCrossed { what: String },

    /// A run stopped by the monitor.
    #[error(
        "stopped at t = {time:.6e} s, step {step}: {what} ({place}, {law}). {remedy}. The state was set \
         back to the last good check at t = {good_time:.6e} s"
    )]
    Unstable { time: f64, step: u64, good_time: f64, what: String, place: String, law: String, remedy: String },
}
