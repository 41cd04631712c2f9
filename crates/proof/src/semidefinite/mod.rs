//! Semidefinite programs: rigorous bounds from given approximate points, without a solver.
//!
//! ```text
//! (P)  minimise  c'x          subject to  X = x_1 F_1 + ... + x_m F_m - F_0 >= 0
//! (D)  maximise  tr(F_0 Y)    subject to  tr(F_i Y) = c_i,  Y >= 0
//! ```
//! in the sign convention of SDPA. The data are intervals, so that a proved statement holds for the decimal numbers of
//! a file and not only for their binary64 roundings. Four statements, each valid for *every* program within the
//! intervals:
//!
//! | given | when | then |
//! |---|---|---|
//! | x | X(x) >= 0 | the optimum of (P) is at most c'x: [`Program::upper_bound`] |
//! | Y near a feasible point | see below | the optimum of (P) is at least tr(F_0 Y) - error: [`Program::lower_bound`] |
//! | Y | tr(F_i Y) = 0, tr(F_0 Y) > 0, Y >= 0 | (P) has no feasible point: [`Program::is_primal_infeasible`] |
//! | x | x_1 F_1 + .. >= 0, c'x < 0 | (D) has no feasible point: [`Program::is_dual_infeasible`] |
//!
//! **Equations.** No binary64 matrix Y satisfies `tr(F_i Y) = c_i` exactly, but a nearby matrix does. With the
//! residuals `r_i = c_i - tr(F_i Y)` and the Gram matrix `G_ij = tr(F_i F_j)` it is `Y* = Y + sum_i (G^-1 r)_i F_i`, at
//! the Frobenius distance `sqrt(r'G^-1 r) <= |r| / sqrt(lambda_min(G)) =: delta`. Hence `Y >= delta I` proves that a
//! feasible Y* >= 0 exists, with `tr(F_0 Y*) >= tr(F_0 Y) - delta |F_0|`. Every quantity is bounded with outward
//! rounding, after scaling the constraints by powers of two, which changes no statement. If few constraints share
//! entries, `lambda_min(G)` is bounded by Gershgorin circles, otherwise by Cholesky. For linearly dependent constraints
//! (a singular G) nothing is proved.
//!
//! Sources: C. Jansson, D. Chaykin, C. Keil, Rigorous error bounds for the optimal value in semidefinite programming,
//! SIAM J. Numer. Anal. 46, 2007, for the statements; the distance above is derived here.

mod bounds;
pub(crate) mod gram;

pub use bounds::{DualBound, PrimalBound};

use std::sync::OnceLock;

pub use gram::LARGEST_GRAM;

use gram::Equations;

use crate::error::ProofError;
use crate::interval::Interval;
use crate::matrix::Matrix;
use luenberger_wording::entry;
use thiserror::Error;

/// A diagonal block of the matrices of a program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Block {
    /// A symmetric matrix of this order.
    Dense(usize),
    /// A diagonal matrix of this order.
    Diagonal(usize),
}

impl Block {
    /// Number of rows.
    pub fn order(self) -> usize {
        match self {
            Self::Dense(n) | Self::Diagonal(n) => n,
        }
    }
}

/// An entry of the upper triangle of a symmetric block matrix; the mirrored entry is implied.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Entry {
    /// Index of the block, from 0.
    pub block: usize,
    /// Row within the block, from 0.
    pub row: usize,
    /// Column within the block, from 0, at least the row.
    pub column: usize,
    /// The value.
    pub value: Interval,
}

/// A block of an approximate dual matrix.
#[derive(Debug, Clone, PartialEq)]
pub enum DualBlock {
    /// A symmetric matrix.
    Dense(Matrix<f64>),
    /// The diagonal of a diagonal matrix.
    Diagonal(Vec<f64>),
}

impl DualBlock {
    pub(super) fn at(&self, row: usize, column: usize) -> f64 {
        match self {
            Self::Dense(y) => y[(row, column)],
            Self::Diagonal(y) => y[row],
        }
    }
}

/// The program of the [module](self)'s head.
#[derive(Debug, Clone)]
pub struct Program {
    blocks: Vec<Block>,
    costs: Vec<Interval>,
    /// F_0, F_1, ..., F_m; entries sorted by position, without duplicates.
    matrices: Vec<Vec<Entry>>,
    /// Properties of the equations of (D), computed at the first use; they do not depend on Y.
    equations: OnceLock<Result<Option<Equations>, ProofError>>,
}

impl PartialEq for Program {
    fn eq(&self, other: &Self) -> bool {
        (&self.blocks, &self.costs, &self.matrices) == (&other.blocks, &other.costs, &other.matrices)
    }
}

/// Invalid data of a semidefinite program.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum ProgramError {
    /// No unknowns, no blocks, or a block without rows.
    #[error(
        "a semidefinite program needs an unknown, a block, and a row in every block: {unknowns} unknowns, {rows} rows in {blocks} blocks"
    )]
    Empty {
        /// Number of unknowns.
        unknowns: usize,
        /// Number of blocks.
        blocks: usize,
        /// Number of rows of all blocks.
        rows: usize,
    },
    /// The number of matrices is not the number of unknowns plus one.
    #[error("{unknowns} unknowns need as many matrices and one more; there are {found}")]
    Matrices {
        /// Number of unknowns.
        unknowns: usize,
        /// Number of matrices given.
        found: usize,
    },
    /// An entry outside its block, below the diagonal, or off the diagonal of a diagonal block.
    #[error(
        "entry {} of block {} of matrix {matrix} lies outside the upper triangle of that block, or off its diagonal",
        entry(*row, *column), block + 1
    )]
    Misplaced {
        /// The matrix, from 0.
        matrix: usize,
        /// The block, from 0.
        block: usize,
        /// The row, from 0.
        row: usize,
        /// The column, from 0.
        column: usize,
    },
    /// Two entries at one position.
    #[error("entry {} of block {} of matrix {matrix} is given twice", entry(*row, *column), block + 1)]
    Repeated {
        /// The matrix, from 0.
        matrix: usize,
        /// The block, from 0.
        block: usize,
        /// The row, from 0.
        row: usize,
        /// The column, from 0.
        column: usize,
    },
    /// A value is not bounded.
    #[error(
        "a value of matrix {matrix} is unbounded (the costs count as matrix {matrix} when it is the number of matrices)"
    )]
    Unbounded {
        /// The matrix, from 0.
        matrix: usize,
    },
}

impl Program {
    /// The program with the given blocks, costs c and matrices F_0, F_1, ..., F_m.
    ///
    /// ```
    /// use luenberger_proof::Interval;
    /// use luenberger_proof::semidefinite::{Block, DualBlock, Entry, Program};
    /// use luenberger_proof::Matrix;
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// // minimise x subject to [[x, 1], [1, x]] >= 0: the optimum is 1.
    /// let entry = |row, column, value| Entry { block: 0, row, column, value: Interval::around(value, 0.0).unwrap() };
    /// let f0 = vec![entry(0, 1, -1.0)];
    /// let f1 = vec![entry(0, 0, 1.0), entry(1, 1, 1.0)];
    /// let program = Program::new(vec![Block::Dense(2)], vec![Interval::around(1.0, 0.0).unwrap()], vec![f0, f1])?;
    /// let upper = program.upper_bound(&[1.0 + 1e-9]).unwrap();
    /// let y = Matrix::from_rows([[0.5, -0.5 + 1e-9], [-0.5 + 1e-9, 0.5]]);
    /// let lower = program.lower_bound(&[DualBlock::Dense(y)]).unwrap();
    /// assert!(lower.value <= 1.0 && 1.0 <= upper.value && upper.value - lower.value < 4e-9);
    /// # Ok(())
    /// # }
    /// ```
    /// # Errors
    /// [`ProgramError`].
    pub fn new(blocks: Vec<Block>, costs: Vec<Interval>, mut matrices: Vec<Vec<Entry>>) -> Result<Self, ProgramError> {
        let (unknowns, found) = (costs.len(), matrices.len());
        if unknowns == 0 || blocks.is_empty() || blocks.iter().any(|block| block.order() == 0) {
            let rows = blocks.iter().map(|block| block.order()).sum();
            return Err(ProgramError::Empty { unknowns, blocks: blocks.len(), rows });
        }
        if found != unknowns + 1 {
            return Err(ProgramError::Matrices { unknowns, found });
        }
        if !costs.iter().all(Interval::is_bounded) {
            return Err(ProgramError::Unbounded { matrix: found });
        }
        for (matrix, entries) in matrices.iter_mut().enumerate() {
            for &Entry { block, row, column, value } in entries.iter() {
                let inside = match blocks.get(block) {
                    Some(Block::Dense(n)) => row <= column && column < *n,
                    Some(Block::Diagonal(n)) => row == column && column < *n,
                    None => false,
                };
                if !inside {
                    return Err(ProgramError::Misplaced { matrix, block, row, column });
                }
                if !value.is_bounded() {
                    return Err(ProgramError::Unbounded { matrix });
                }
            }
            entries.sort_by_key(position);
            if let Some(pair) = entries.windows(2).find(|pair| position(&pair[0]) == position(&pair[1])) {
                let Entry { block, row, column, .. } = pair[0];
                return Err(ProgramError::Repeated { matrix, block, row, column });
            }
        }
        Ok(Self { blocks, costs, matrices, equations: OnceLock::new() })
    }

    /// The blocks.
    pub fn blocks(&self) -> &[Block] {
        &self.blocks
    }

    /// The costs c.
    pub fn costs(&self) -> &[Interval] {
        &self.costs
    }

    /// The entries of F_k in the upper triangles, sorted by block, row and column. Empty if k exceeds the number of
    /// unknowns.
    pub fn matrix(&self, k: usize) -> &[Entry] {
        self.matrices.get(k).map_or(&[], Vec::as_slice)
    }

    fn equations(&self) -> Option<&Equations> {
        self.solved_equations().as_ref().ok()?.as_ref()
    }

    fn solved_equations(&self) -> &Result<Option<Equations>, ProofError> {
        self.equations.get_or_init(|| Equations::of(self))
    }

    /// Whether [`Self::lower_bound`] and [`Self::is_primal_infeasible`] can work for a program of this size; if not,
    /// they return `None`.
    ///
    /// # Errors
    /// [`ProofError::TooLarge`] for more unknowns than [`LARGEST_GRAM`], unless Gershgorin circles suffice, so that the
    /// Gram matrix is not formed.
    pub fn within_limits(&self) -> Result<(), ProofError> {
        self.solved_equations().as_ref().map(|_| ()).map_err(Clone::clone)
    }

    /// Number of unknowns, m.
    pub fn unknowns(&self) -> usize {
        self.costs.len()
    }
}

/// Sort key of an entry: block, row, column.
pub(super) fn position(entry: &Entry) -> (usize, usize, usize) {
    (entry.block, entry.row, entry.column)
}
