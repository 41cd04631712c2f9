//! Errors of the formulation of a problem.

use luenberger_proof::wording::{entry, significant};
use thiserror::Error;

use crate::solver::NotBuiltIn;

/// An error inside a matrix expression, stored there until the problem is solved, since operators cannot return errors.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[non_exhaustive]
pub enum Fault {
    /// Two operands of incompatible shapes.
    #[error("{operation} of a {} x {} and a {} x {} matrix", left.0, left.1, right.0, right.1)]
    ShapeMismatch {
        /// The operation, as a noun: "sum", "product", "row of blocks".
        operation: &'static str,
        /// Rows and columns of the left operand.
        left: (usize, usize),
        /// Rows and columns of the right operand.
        right: (usize, usize),
    },
    /// The operand must be square.
    #[error("{operation} of a {rows} x {columns} matrix, which is not square")]
    NotSquare {
        /// The operation, as a noun.
        operation: &'static str,
        /// Rows of the operand.
        rows: usize,
        /// Columns of the operand.
        columns: usize,
    },
    /// A constant is NaN or infinite.
    #[error("the constant's entry {} is {value}", entry(*row, *column))]
    NotFinite {
        /// Row of the entry, from zero.
        row: usize,
        /// Column of the entry, from zero.
        column: usize,
        /// The entry.
        value: f64,
    },
}

/// Why a problem is ill-posed.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum LmiError {
    /// A certificate file cannot be written: the result is not proved.
    #[error("no certificate file: {0}")]
    CertificateFile(Box<luenberger_proof::certificate::Rejection>),
    /// An expression is ill-formed.
    #[error("{place}: {fault}")]
    Malformed {
        /// The constraint's name, or "objective".
        place: String,
        /// The error of the expression.
        fault: Fault,
    },
    /// A matrix that should be definite is not symmetric.
    #[error("{constraint}: not symmetric, entries {} and {} differ by {}", entry(*row, *column), entry(*column, *row), significant(*difference, 6))]
    NotSymmetric {
        /// The constraint's name.
        constraint: String,
        /// Row of the worst entry, from zero.
        row: usize,
        /// Column of the worst entry, from zero.
        column: usize,
        /// The largest difference between the coefficients of one unknown in the two entries.
        difference: f64,
    },
    /// A matrix without rows.
    #[error("{name} is empty: {rows} x {columns}")]
    Empty {
        /// Name of the variable or of the constraint.
        name: String,
        /// Its rows.
        rows: usize,
        /// Its columns.
        columns: usize,
    },
    /// No variables or no constraints.
    #[error("the problem has {variables} variables and {constraints} constraints; it needs at least one of each")]
    NothingToSolve {
        /// Number of variables declared.
        variables: usize,
        /// Number of constraints.
        constraints: usize,
    },
    /// Two variables or two constraints share a name.
    #[error("two {what} are named {name}")]
    DuplicateName {
        /// "variables" or "constraints".
        what: &'static str,
        /// The shared name.
        name: String,
    },
    /// An expression mentions a variable of another problem.
    #[error("{place}: variable {variable} belongs to another problem")]
    ForeignVariable {
        /// The constraint's name, or "objective".
        place: String,
        /// The variable's name.
        variable: String,
    },
    /// The objective is a matrix.
    #[error("the objective is {rows} x {columns}; it must be a scalar expression, such as a trace")]
    ObjectiveNotScalar {
        /// Its rows.
        rows: usize,
        /// Its columns.
        columns: usize,
    },
    /// With homogeneous constraints every objective is either without lower bound or approached at the zero solution.
    #[error("all constraints are homogeneous, so the objective has no optimum: add a normalisation such as P >> 1")]
    HomogeneousObjective,
    /// A coefficient overflowed when the constants were multiplied out.
    #[error("{place}: a coefficient left the range of binary64")]
    Overflow {
        /// The constraint's name, or "objective".
        place: String,
    },
    /// The solver is not compiled in.
    #[error(transparent)]
    NotBuiltIn(#[from] NotBuiltIn),
    /// The bracket or the tolerance of a bisection is invalid.
    #[error("bisection over [{low}, {high}] with tolerance {tolerance}: needs finite low <= high and tolerance > 0")]
    BadBracket {
        /// Lower end.
        low: f64,
        /// Upper end.
        high: f64,
        /// Width at which to stop.
        tolerance: f64,
    },
}
