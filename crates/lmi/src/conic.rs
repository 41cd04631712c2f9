//! The conic program passed to a [`Solver`](crate::Solver).

use nalgebra::DMatrix;

use crate::variable::Variable;

/// A linear term of one scalar unknown.
pub(crate) type Term = (usize, f64);

/// One lower-triangular entry of a symmetric matrix that depends affinely on the unknowns.
#[derive(Debug, Clone)]
pub(crate) struct BlockEntry {
    pub(crate) row: usize,
    pub(crate) column: usize,
    pub(crate) constant: f64,
    pub(crate) terms: Vec<Term>,
}

/// A symmetric affine matrix that is to be positive semidefinite.
#[derive(Debug, Clone)]
pub struct Block {
    pub(crate) order: usize,
    pub(crate) entries: Vec<BlockEntry>,
    /// What is known of the structure of some unknowns, whose coefficients are among the entries all the same.
    pub products: Vec<ScaledProduct>,
}

/// `sym(L X R)` of an unknown matrix X, with `sym M = (M + M')/2`.
#[derive(Debug, Clone)]
pub struct Product {
    /// X.
    pub variable: Variable,
    /// L, as many rows as the block has.
    pub left: DMatrix<f64>,
    /// R, as many columns as the block has.
    pub right: DMatrix<f64>,
}

/// `sym(L X R)` of an unknown matrix X, of which each unknown is multiplied by a factor of its own.
#[derive(Debug, Clone)]
pub struct ScaledProduct {
    pub(crate) product: Product,
    /// The first unknown of X.
    pub(crate) offset: usize,
    /// One for each unknown of X.
    pub(crate) factors: Vec<f64>,
}

impl Block {
    /// The block with these entries, of whose structure nothing is known.
    pub(crate) fn of(order: usize, entries: Vec<BlockEntry>) -> Self {
        Self { order, entries, products: Vec::new() }
    }

    /// `constant + terms >= 0`.
    pub(crate) fn number(constant: f64, terms: Vec<Term>) -> Self {
        Self::of(1, vec![BlockEntry { row: 0, column: 0, constant, terms }])
    }
}

/// Minimise a linear cost under semidefinite constraints.
#[derive(Debug)]
pub struct ConicProgram {
    pub(crate) cost: Vec<f64>,
    pub(crate) blocks: Vec<Block>,
    /// A point of negative cost is good enough if no other is below it by more than this share; 0 for the optimum.
    pub(crate) enough: f64,
}

impl ConicProgram {
    /// The program of which the optimum is wanted.
    pub fn new(cost: Vec<f64>, blocks: Vec<Block>) -> Self {
        Self { cost, blocks, enough: 0.0 }
    }

    /// The cost of the dual program at these multipliers, `- sum tr(constant Y)`: the optimum, if they are optimal.
    pub(crate) fn dual_cost(&self, multipliers: &[DMatrix<f64>]) -> f64 {
        let entry = |e: &BlockEntry, y: &DMatrix<f64>| {
            let weight = if e.row == e.column { 1.0 } else { 2.0 };
            weight * e.constant * y[(e.row, e.column)]
        };
        let blocks = self.blocks.iter().zip(multipliers);
        -blocks.map(|(block, y)| block.entries.iter().map(|e| entry(e, y)).sum::<f64>()).sum::<f64>()
    }
}

/// Status reported by the solver.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Ending {
    /// It returned a point of unknown quality.
    Point,
    /// It reports infeasibility.
    NoPoint,
    /// It reports an unbounded cost.
    Unbounded,
}
