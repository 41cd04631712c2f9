//! The unknowns of a linear matrix inequality: symmetric, rectangular, diagonal and scalar.
//!
//! An unknown matrix is a handle. Its scalar unknowns are counted once each: a symmetric P of order n has n(n+1)/2,
//! stored by its lower triangle column by column, a diagonal one has n, a rectangular one rows times columns, column by
//! column.

use std::fmt;
use std::sync::Arc;

use nalgebra::DMatrix;

/// Structure of an unknown matrix.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Structure {
    /// `X = X'`, n(n+1)/2 unknowns.
    Symmetric,
    /// No structure, rows times columns unknowns.
    Rectangular,
    /// Zero outside the diagonal, n unknowns.
    Diagonal,
    /// One unknown; in products it scales a matrix of any shape.
    Scalar,
}

#[derive(Debug)]
struct Declaration {
    name: String,
    structure: Structure,
    rows: usize,
    columns: usize,
    position: usize,
}

/// A handle on an unknown matrix of a [`Problem`](crate::Problem), cheap to clone.
///
/// Use it in expressions by reference: `&a * &p + 2.0 * &y`.
#[derive(Clone)]
pub struct Variable {
    declaration: Arc<Declaration>,
}

impl Variable {
    pub(crate) fn new(name: &str, structure: Structure, rows: usize, columns: usize, position: usize) -> Self {
        Self { declaration: Arc::new(Declaration { name: name.to_owned(), structure, rows, columns, position }) }
    }

    /// The name it was declared with.
    pub fn name(&self) -> &str {
        &self.declaration.name
    }

    /// Its structure.
    pub fn structure(&self) -> Structure {
        self.declaration.structure
    }

    /// Rows and columns.
    pub fn shape(&self) -> (usize, usize) {
        (self.declaration.rows, self.declaration.columns)
    }

    /// The number of scalar unknowns.
    pub fn unknowns(&self) -> usize {
        let (rows, columns) = self.shape();
        match self.structure() {
            Structure::Symmetric => rows * (rows + 1) / 2,
            Structure::Rectangular => rows * columns,
            Structure::Diagonal => rows,
            Structure::Scalar => 1,
        }
    }

    /// The order in which the problem declared it.
    pub(crate) fn position(&self) -> usize {
        self.declaration.position
    }

    /// Whether two handles refer to the same unknown.
    pub(crate) fn is_same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.declaration, &other.declaration)
    }

    /// Index of the scalar unknown at (row, column); none for a structural zero.
    pub(crate) fn unknown_at(&self, row: usize, column: usize) -> Option<usize> {
        let (rows, _) = self.shape();
        match self.structure() {
            Structure::Scalar => Some(0),
            Structure::Rectangular => Some(column * rows + row),
            Structure::Diagonal => (row == column).then_some(row),
            Structure::Symmetric => {
                let (high, low) = (row.max(column), row.min(column));
                // Columns before `low` of the lower triangle hold rows + (rows - 1) + ... entries.
                Some(low * rows - low * low.saturating_sub(1) / 2 + high - low)
            }
        }
    }

    /// The matrix that has the given scalar unknowns.
    pub(crate) fn assemble(&self, unknowns: &[f64]) -> DMatrix<f64> {
        let (rows, columns) = self.shape();
        DMatrix::from_fn(rows, columns, |i, j| {
            self.unknown_at(i, j).and_then(|k| unknowns.get(k)).copied().unwrap_or_default()
        })
    }
}

impl fmt::Debug for Variable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (rows, columns) = self.shape();
        write!(f, "{} ({rows} x {columns} {:?})", self.name(), self.structure())
    }
}
