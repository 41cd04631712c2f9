//! A minimal dense row-major matrix.

use std::fmt;

use crate::error::ProofError;

/// Dense matrix, row by row. Entries are any type: `f64` data, intervals, exact numbers.
///
/// Matrices of nalgebra are converted by `proof_matrix` and `dynamic_matrix` of `luenberger-lmi`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Matrix<T> {
    rows: usize,
    cols: usize,
    data: Vec<T>,
}

/// `[2, 1; 1, 2]`, as the matrix is typed in MATLAB.
///
/// ```
/// use luenberger_proof::Matrix;
/// assert_eq!(Matrix::from_rows([[2.0, 1.0], [1.0, 0.5]]).to_string(), "[2, 1; 1, 0.5]");
/// ```
impl<T: fmt::Display> fmt::Display for Matrix<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("[")?;
        for (k, entry) in self.data.iter().enumerate() {
            let separator = match k {
                0 => "",
                _ if k % self.cols == 0 => "; ",
                _ => ", ",
            };
            write!(f, "{separator}{entry}")?;
        }
        f.write_str("]")
    }
}

impl<T> Matrix<T> {
    /// The matrix with entry `f(i, j)` at row i, column j (from 0).
    pub fn from_fn(rows: usize, cols: usize, mut f: impl FnMut(usize, usize) -> T) -> Self {
        let mut data = Vec::with_capacity(rows * cols);
        for i in 0..rows {
            data.extend((0..cols).map(|j| f(i, j)));
        }
        Self { rows, cols, data }
    }

    /// The matrix of the given rows: `Matrix::from_rows([[0.0, 1.0], [0.0, 0.0]])`.
    pub fn from_rows<const R: usize, const C: usize>(rows: [[T; C]; R]) -> Self {
        Self { rows: R, cols: C, data: rows.into_iter().flatten().collect() }
    }

    /// The matrix whose entries are listed row by row.
    /// # Errors
    /// [`ProofError::DimensionMismatch`] when the list is not `rows * cols` long.
    pub fn from_row_major(rows: usize, cols: usize, data: Vec<T>) -> Result<Self, ProofError> {
        if rows.checked_mul(cols) == Some(data.len()) {
            Ok(Self { rows, cols, data })
        } else {
            let found = (data.len(), 1);
            Err(ProofError::DimensionMismatch { what: "the list of entries", expected: (rows, cols), found })
        }
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Number of columns.
    pub fn cols(&self) -> usize {
        self.cols
    }

    /// Rows and columns.
    pub fn shape(&self) -> (usize, usize) {
        (self.rows, self.cols)
    }

    /// The entry at row i, column j, if there is one.
    pub fn get(&self, i: usize, j: usize) -> Option<&T> {
        if i < self.rows && j < self.cols { self.data.get(i * self.cols + j) } else { None }
    }

    /// Row i as a slice.
    /// # Panics
    /// When `i` is not below the number of rows, as indexing does.
    pub fn row(&self, i: usize) -> &[T] {
        &self.data[i * self.cols..(i + 1) * self.cols]
    }

    /// Row i, to be written to.
    pub(crate) fn row_mut(&mut self, i: usize) -> &mut [T] {
        &mut self.data[i * self.cols..(i + 1) * self.cols]
    }

    /// All entries, row by row, to be written to.
    pub(crate) fn as_mut_slice(&mut self) -> &mut [T] {
        &mut self.data
    }

    /// All entries, row by row.
    pub fn as_slice(&self) -> &[T] {
        &self.data
    }

    /// The same shape with every entry translated.
    pub fn map<U>(&self, f: impl FnMut(&T) -> U) -> Matrix<U> {
        Matrix { rows: self.rows, cols: self.cols, data: self.data.iter().map(f).collect() }
    }

    /// An error unless the shape is the one expected of the quantity called `what`.
    /// # Errors
    /// [`ProofError::DimensionMismatch`].
    pub fn expect_shape(&self, what: &'static str, expected: (usize, usize)) -> Result<(), ProofError> {
        if self.shape() == expected {
            Ok(())
        } else {
            Err(ProofError::DimensionMismatch { what, expected, found: self.shape() })
        }
    }
}

impl<T: Clone> Matrix<T> {
    /// The matrix whose entries are listed column by column, as nalgebra and LAPACK store them.
    /// # Errors
    /// [`ProofError::DimensionMismatch`] when the list is not `rows * cols` long.
    pub fn from_column_major(rows: usize, cols: usize, data: &[T]) -> Result<Self, ProofError> {
        if rows.checked_mul(cols) == Some(data.len()) {
            Ok(Self::from_fn(rows, cols, |i, j| data[j * rows + i].clone()))
        } else {
            let found = (data.len(), 1);
            Err(ProofError::DimensionMismatch { what: "the list of entries", expected: (rows, cols), found })
        }
    }

    /// The transpose.
    #[must_use]
    pub fn transpose(&self) -> Self {
        Self::from_fn(self.cols, self.rows, |i, j| self[(j, i)].clone())
    }
}

impl<T> core::ops::Index<(usize, usize)> for Matrix<T> {
    type Output = T;

    fn index(&self, (i, j): (usize, usize)) -> &T {
        assert!(j < self.cols, "column {j} of a matrix with {} columns", self.cols);
        &self.data[i * self.cols + j]
    }
}

impl<T> core::ops::IndexMut<(usize, usize)> for Matrix<T> {
    fn index_mut(&mut self, (i, j): (usize, usize)) -> &mut T {
        assert!(j < self.cols, "column {j} of a matrix with {} columns", self.cols);
        &mut self.data[i * self.cols + j]
    }
}
