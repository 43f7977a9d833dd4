//! The tangent of the equations of motion: a sparse matrix with a pattern fixed by the scene, and its factor.
//!
//!     A = a M - b dF/dv - c dF/dx        over the free nodes
//!
//! Its symmetric part is stored and factorised by Cholesky's method, in approximate minimum degree order (AMD; Amestoy,
//! Davis and Duff 1996), with a symbolic factor made once. The antisymmetric part (force of Coriolis, rotation of
//! dashpots, drag) is small beside M/dt at reasonable steps; the iteration that solves with A accounts for it. A factor
//! exists only if A is positive definite. If it is not, the end of the step need not be unique.
//!
//! The factorisation is the scalar one of `faer`, without vector instructions and threads, with the same bits in every
//! run on every machine.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::linalg::amd;
use faer::sparse::linalg::cholesky::simplicial::{
    SimplicialLltRef, SymbolicSimplicialCholesky, factorize_simplicial_numeric_llt,
    factorize_simplicial_numeric_llt_scratch, factorize_simplicial_symbolic_cholesky,
    factorize_simplicial_symbolic_cholesky_scratch, prefactorize_symbolic_cholesky,
    prefactorize_symbolic_cholesky_scratch,
};
use faer::sparse::{FaerError, SparseColMatRef, SymbolicSparseColMat};
use faer::{Conj, MatMut, Par};

use crate::arrays::jacobian::{Block, JacobianBlocks};
use crate::arrays::state::NodeVectors;
use crate::error::{Error, Result};

/// Weights of masses and Jacobian.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Weights {
    /// a.
    pub mass: f64,
    /// b \[s\].
    pub damping: f64,
    /// c \[s2\].
    pub stiffness: f64,
}

/// Rank of a held node.
const HELD: u32 = u32::MAX;

/// The matrix and its factor. Columns hold the rows above and on the diagonal.
pub struct Tangent {
    /// Place of each node in the order of elimination, or `HELD`.
    rank: Vec<u32>,
    /// The node rows of each node column, ascending, the diagonal last; and the start of each column.
    rows: Vec<u32>,
    starts: Vec<usize>,
    pattern: SymbolicSparseColMat<usize>,
    values: Vec<f64>,
    symbolic: SymbolicSimplicialCholesky<usize>,
    factor: Vec<f64>,
    memory: MemBuffer,
    right_hand_side: Vec<f64>,
}

/// Visits the nodes of each element that couples nodes.
pub type Couplings<'a> = &'a dyn Fn(&mut dyn FnMut(&[u32]));

/// The rows of each column of the graph of nodes, on and above the diagonal, ascending.
fn graph(couplings: Couplings<'_>, rank: &[u32], free: usize) -> Vec<Vec<u32>> {
    let mut columns: Vec<Vec<u32>> = (0..free as u32).map(|node| vec![node]).collect();
    couplings(&mut |nodes| {
        for (k, &i) in nodes.iter().enumerate() {
            for &j in &nodes[..k] {
                let (i, j) = (rank[i as usize], rank[j as usize]);
                if i != HELD && j != HELD {
                    columns[i.max(j) as usize].push(i.min(j));
                }
            }
        }
    });
    for column in &mut columns {
        column.sort_unstable();
        column.dedup();
    }
    columns
}

fn pattern_of(size: usize, starts: Vec<usize>, rows: Vec<usize>) -> SymbolicSparseColMat<usize> {
    SymbolicSparseColMat::new_checked(size, size, starts, None, rows)
}

/// The rank of each node of a graph in an order of elimination that keeps the factor sparse.
fn order(columns: &[Vec<u32>]) -> std::result::Result<Vec<usize>, FaerError> {
    let size = columns.len();
    let mut starts = vec![0];
    let mut rows = Vec::new();
    for column in columns {
        rows.extend(column.iter().map(|&row| row as usize));
        starts.push(rows.len());
    }
    let (mut order, mut rank) = (vec![0; size], vec![0; size]);
    let mut memory = MemBuffer::try_new(amd::order_scratch::<usize>(size, rows.len()))?;
    let pattern = pattern_of(size, starts, rows);
    let control = amd::Control::default();
    amd::order(&mut order, &mut rank, pattern.as_ref(), control, MemStack::new(&mut memory))?;
    Ok(rank)
}

/// The symbolic factor of a matrix.
fn symbolic_of(
    pattern: &SymbolicSparseColMat<usize>,
) -> std::result::Result<SymbolicSimplicialCholesky<usize>, FaerError> {
    let (size, count) = (pattern.nrows(), pattern.row_idx().len());
    let request = prefactorize_symbolic_cholesky_scratch::<usize>(size, count)
        .or(factorize_simplicial_symbolic_cholesky_scratch::<usize>(size));
    let mut memory = MemBuffer::try_new(request)?;
    let stack = MemStack::new(&mut memory);
    let (mut tree, mut counts) = (vec![0; size], vec![0; size]);
    let tree = prefactorize_symbolic_cholesky(&mut tree, &mut counts, pattern.as_ref(), stack);
    factorize_simplicial_symbolic_cholesky(pattern.as_ref(), tree, &counts, stack)
}

impl Tangent {
    /// The pattern of these couplings; held nodes have an inverse mass of 0.
    ///
    /// # Errors
    /// `NoMemory`.
    pub fn new(couplings: Couplings<'_>, inverse_masses: &[f64]) -> Result<Self> {
        let mut rank: Vec<u32> = vec![HELD; inverse_masses.len()];
        let free = (0..rank.len()).filter(|&node| inverse_masses[node] > 0.0);
        let free: Vec<usize> = free.collect();
        for (place, &node) in free.iter().enumerate() {
            rank[node] = place as u32;
        }
        Self::with(couplings, rank, &free).map_err(|_| Error::NoMemory { nodes: free.len() })
    }

    fn with(couplings: Couplings<'_>, mut rank: Vec<u32>, free: &[usize]) -> std::result::Result<Self, FaerError> {
        let places = order(&graph(couplings, &rank, free.len()))?;
        for &node in free {
            rank[node] = places[rank[node] as usize] as u32;
        }
        let columns = graph(couplings, &rank, free.len());
        let (mut starts, mut rows) = (vec![0], Vec::new());
        let (mut scalar_starts, mut scalar_rows) = (vec![0], Vec::new());
        for (column, above) in columns.iter().enumerate() {
            rows.extend_from_slice(above);
            starts.push(rows.len());
            for axis in 0..3 {
                let all = above.iter().flat_map(|&row| (0..3).map(move |k| 3 * row as usize + k));
                scalar_rows.extend(all.take_while(|&row| row <= 3 * column + axis));
                scalar_starts.push(scalar_rows.len());
            }
        }
        let size = 3 * free.len();
        let pattern = pattern_of(size, scalar_starts, scalar_rows);
        let symbolic = symbolic_of(&pattern)?;
        let request = factorize_simplicial_numeric_llt_scratch::<usize, f64>(size);
        Ok(Self {
            rank,
            rows,
            starts,
            values: vec![0.0; pattern.row_idx().len()],
            pattern,
            factor: vec![0.0; symbolic.len_val()],
            symbolic,
            memory: MemBuffer::try_new(request)?,
            right_hand_side: vec![0.0; size],
        })
    }

    /// Number of entries of the factor.
    pub fn factor_size(&self) -> usize {
        self.factor.len()
    }

    /// Assembles the matrix from masses and the blocks of dF/dx and dF/dv that `add_blocks` adds, without
    /// factorisation.
    pub fn assemble(&mut self, masses: &[f64], weights: Weights, add_blocks: impl Fn(&mut dyn JacobianBlocks)) {
        self.values.fill(0.0);
        for (node, &mass) in masses.iter().enumerate() {
            self.add(node as u32, node as u32, weights.mass * mass, &Block::identity());
        }
        add_blocks(&mut Weighted { tangent: self, weights });
    }

    /// Factorises the matrix. Whether it is positive definite.
    pub fn factorise(&mut self) -> bool {
        let matrix = SparseColMatRef::new(self.pattern.as_ref(), &self.values[..]);
        let stack = MemStack::new(&mut self.memory);
        factorize_simplicial_numeric_llt(&mut self.factor, matrix, Default::default(), &self.symbolic, stack).is_ok()
    }

    /// Replaces `vectors` by the solution u of A u = M vectors; held nodes get 0.
    pub fn solve(&mut self, masses: &[f64], vectors: &mut NodeVectors) {
        for (node, &rank) in self.rank.iter().enumerate().filter(|(_, rank)| **rank != HELD) {
            for axis in 0..3 {
                self.right_hand_side[3 * rank as usize + axis] = masses[node] * vectors[(node, axis)];
            }
        }
        let size = self.right_hand_side.len();
        let vector = MatMut::from_column_major_slice_mut(&mut self.right_hand_side, size, 1);
        let stack = MemStack::new(&mut self.memory);
        SimplicialLltRef::new(&self.symbolic, &self.factor).solve_in_place_with_conj(Conj::No, vector, Par::Seq, stack);
        for (node, &rank) in self.rank.iter().enumerate() {
            for axis in 0..3 {
                let value = if rank == HELD { 0.0 } else { self.right_hand_side[3 * rank as usize + axis] };
                vectors[(node, axis)] = value;
            }
        }
    }

    /// Adds the symmetric part of `factor` times a block.
    fn add(&mut self, on: u32, of: u32, factor: f64, block: &Block) {
        let (i, j) = (self.rank[on as usize], self.rank[of as usize]);
        if i == HELD || j == HELD {
            return;
        }
        let (row, column) = (i.min(j), i.max(j) as usize);
        let rows = &self.rows[self.starts[column]..self.starts[column + 1]];
        // A coupling outside the pattern has no entry.
        let Ok(place) = rows.binary_search(&row) else {
            debug_assert!(false, "nodes {on} and {of} are not coupled");
            return;
        };
        let half = 0.5 * factor;
        for axis in 0..3 {
            let start = self.pattern.col_ptr()[3 * column + axis] + 3 * place;
            if i == j {
                for k in 0..=axis {
                    self.values[start + k] += half * (block[(k, axis)] + block[(axis, k)]);
                }
            } else {
                for k in 0..3 {
                    self.values[start + k] += half * if i < j { block[(k, axis)] } else { block[(axis, k)] };
                }
            }
        }
    }
}

/// A receiver of blocks that adds them with their weights; their sign in the tangent is negative.
struct Weighted<'a> {
    tangent: &'a mut Tangent,
    weights: Weights,
}

impl JacobianBlocks for Weighted<'_> {
    fn by_position(&mut self, on: u32, of: u32, block: &Block) {
        self.tangent.add(on, of, -self.weights.stiffness, block);
    }

    fn by_velocity(&mut self, on: u32, of: u32, block: &Block) {
        self.tangent.add(on, of, -self.weights.damping, block);
    }
}
