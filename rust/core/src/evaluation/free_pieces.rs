//! The pieces of a scene that nothing holds, and their motion without what they do as rigid bodies.
//!
//! With v the velocities in inertial space, and x_c and v_c those of the centre of mass of a piece,
//!
//!     K       = M v_c^2/2 + K_int,         K_int = sum m (v - v_c)^2/2
//!     K_rigid = (L . I^-1 L)/2,            L = sum m (x - x_c) x (v - v_c)              [J]
//!
//! where I is the tensor of inertia about the centre. Velocities are subtracted before they are squared, so that K_int
//! has the rounding of its own size however fast the piece flies.

use nalgebra::{Matrix3, Vector3};

use crate::arrays::jacobian::at as row;
use crate::arrays::state::{PhasePoint, State};
use crate::laws::{Instant, Law};

/// Eigenvalue of a tensor of inertia below which a piece has no extent across that axis, relative to the largest.
const NO_EXTENT: f64 = 1e-12;

/// Rigid motion of the free pieces.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct RigidMotion {
    /// Kinetic energy of the translations \[J\].
    pub translation: f64,
    /// Kinetic energy of the rotations \[J\].
    pub rotation: f64,
    /// The largest rate of rotation \[rad/s\].
    pub rate: f64,
    /// Kinetic energy of the rotations if the pieces turned with the frame \[J\].
    pub carried: f64,
}

/// The free pieces: sets of nodes that elements connect, without a held node.
#[derive(Debug, Clone, Default)]
pub struct FreePieces {
    pieces: Vec<Vec<u32>>,
    /// The other nodes.
    others: Vec<u32>,
}

impl FreePieces {
    /// The free pieces of a scene; held nodes have an inverse mass of 0.
    pub fn new(laws: &[Box<dyn Law>], inverse_masses: &[f64]) -> Self {
        let mut parent: Vec<u32> = (0..inverse_masses.len() as u32).collect();
        for law in laws.iter().filter_map(|law| law.linearisation()) {
            law.visit_couplings(&mut |nodes| {
                for &node in nodes {
                    let (a, b) = (root(&mut parent, nodes[0]), root(&mut parent, node));
                    parent[a.max(b) as usize] = a.min(b);
                }
            });
        }
        let mut members: Vec<Vec<u32>> = vec![Vec::new(); parent.len()];
        for node in 0..parent.len() as u32 {
            members[root(&mut parent, node) as usize].push(node);
        }
        let is_free = |nodes: &Vec<u32>| nodes.iter().all(|&node| inverse_masses[node as usize] > 0.0);
        let (pieces, held): (Vec<_>, Vec<_>) = members.into_iter().filter(|nodes| !nodes.is_empty()).partition(is_free);
        Self { pieces, others: held.concat() }
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.pieces.is_empty()
    }

    /// Whether every node belongs to a free piece.
    pub fn are_all(&self) -> bool {
        self.others.is_empty()
    }

    /// Kinetic energy without the translation of free pieces \[J\]: K_int of each, in inertial space, plus that of the
    /// other nodes in the turning frame.
    pub fn internal_kinetic(&self, masses: &[f64], at: Instant<'_>) -> f64 {
        let of_pieces = self.pieces.iter().map(|piece| {
            let (_, velocity) = centre(piece, masses, at);
            let squares = piece.iter().map(|&i| masses[i as usize] * (inertial(at, i) - velocity).norm_squared());
            0.5 * squares.sum::<f64>()
        });
        let of_others = self.others.iter().map(|&i| 0.5 * masses[i as usize] * row(at.velocities, i).norm_squared());
        of_pieces.sum::<f64>() + of_others.sum::<f64>()
    }

    /// Positions \[m\] and velocities \[m/s\], of free pieces relative to those of their centres of mass.
    pub fn about_centres(&self, masses: &[f64], at: PhasePoint<'_>) -> State {
        let mut state = State { positions: at.positions.clone(), velocities: at.velocities.clone() };
        for piece in &self.pieces {
            for vectors in [&mut state.positions, &mut state.velocities] {
                let own = mean(piece, masses, |i| row(vectors, i)).transpose();
                piece.iter().for_each(|&i| vectors.row_mut(i as usize).zip_apply(&own, |value, own| *value -= own));
            }
        }
        state
    }

    /// The rigid motion of the free pieces, in inertial space.
    pub fn rigid_motion(&self, masses: &[f64], at: Instant<'_>) -> RigidMotion {
        let mut motion = RigidMotion::default();
        for piece in &self.pieces {
            let (position, velocity) = centre(piece, masses, at);
            let (mut mass, mut momentum, mut inertia) = (0.0, Vector3::zeros(), Matrix3::zeros());
            for &i in piece {
                let (m, x, v) = (masses[i as usize], row(at.positions, i) - position, inertial(at, i) - velocity);
                mass += m;
                momentum += m * x.cross(&v);
                inertia += m * (Matrix3::identity() * x.norm_squared() - x * x.transpose());
            }
            motion.translation += 0.5 * mass * velocity.norm_squared();
            motion.carried += 0.5 * at.frame.rate * at.frame.rate * inertia[(2, 2)];
            // No eigenvalues of what is not finite.
            if !(momentum.sum() + inertia.sum()).is_finite() {
                continue;
            }
            let principal = inertia.symmetric_eigen();
            let (mut square, most) = (0.0, principal.eigenvalues.amax());
            for k in (0..3).filter(|&k| principal.eigenvalues[k] > NO_EXTENT * most) {
                let (own, moment) = (principal.eigenvectors.column(k).dot(&momentum), principal.eigenvalues[k]);
                motion.rotation += 0.5 * own * own / moment;
                square += (own / moment) * (own / moment);
            }
            motion.rate = motion.rate.max(f64::sqrt(square));
        }
        motion
    }
}

/// The root of a node in a forest, with paths halved.
fn root(parent: &mut [u32], mut node: u32) -> u32 {
    while parent[node as usize] != node {
        parent[node as usize] = parent[parent[node as usize] as usize];
        node = parent[node as usize];
    }
    node
}

/// The velocity of a node in inertial space, v + omega x x + V \[m/s\].
fn inertial(at: Instant<'_>, node: u32) -> Vector3<f64> {
    let (rates, of_origin) = at.frame.carried();
    row(at.velocities, node) + rates.cross(&row(at.positions, node)) + of_origin
}

/// Position \[m\] and velocity in inertial space \[m/s\] of the centre of mass.
fn centre(piece: &[u32], masses: &[f64], at: Instant<'_>) -> (Vector3<f64>, Vector3<f64>) {
    (mean(piece, masses, |i| row(at.positions, i)), mean(piece, masses, |i| inertial(at, i)))
}

/// The mean of a value of nodes by their masses, relative to the first node, so that equal values have exactly that
/// mean.
fn mean(piece: &[u32], masses: &[f64], value: impl Fn(u32) -> Vector3<f64>) -> Vector3<f64> {
    let first = value(piece[0]);
    let (mut mass, mut sum) = (0.0, Vector3::zeros());
    for &i in piece {
        mass += masses[i as usize];
        sum += masses[i as usize] * (value(i) - first);
    }
    first + sum / mass
}
