//! Matrices of `nalgebra` as those of `luenberger-proof`, which knows no other crate, and back.

use luenberger_proof::Matrix;
use nalgebra::{DMatrix, Dim, RawStorage, Scalar};

/// The same entries as a matrix for the prover: a copy, without rounding. `m` has any shape and storage.
///
/// ```
/// use luenberger_lmi::{dynamic_matrix, proof_matrix};
/// use luenberger_proof::definite::positive_definite;
/// use nalgebra::Matrix2;
///
/// let p = Matrix2::new(2.0, 1.0, 1.0, 2.0);
/// assert!(positive_definite(&proof_matrix(&p))?.is_proved());
/// assert_eq!(dynamic_matrix(&proof_matrix(&p)), p);
/// # Ok::<(), luenberger_proof::ProofError>(())
/// ```
pub fn proof_matrix<T: Scalar, R: Dim, C: Dim, S: RawStorage<T, R, C>>(m: &nalgebra::Matrix<T, R, C, S>) -> Matrix<T> {
    Matrix::from_fn(m.nrows(), m.ncols(), |i, j| m[(i, j)].clone())
}

/// The same entries as a matrix of `nalgebra`: a copy, the inverse of [`proof_matrix`].
pub fn dynamic_matrix<T: Scalar>(m: &Matrix<T>) -> DMatrix<T> {
    DMatrix::from_row_slice(m.rows(), m.cols(), m.as_slice())
}
