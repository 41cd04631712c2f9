//! Real Schur form `A = Q T Q'`: `Q` orthogonal, `T` upper quasi-triangular.
//!
//! `T` has 1 x 1 diagonal blocks for the real eigenvalues of `A` and standardised 2 x 2 blocks (equal diagonal entries, off-diagonal
//! entries of opposite sign) for the complex pairs. It exists for every real matrix. Every dense equation of this crate is solved in it.
//!
//! Method: Householder reduction to Hessenberg form, then the implicit double-shift QR iteration of Francis with
//! exceptional shifts and a hard cap on the number of sweeps; about 25 n^3 flops.

mod francis;
mod hessenberg;
mod reorder;
mod standard;

use crate::argument::{square, unit_scale};
use crate::{LinalgError, Result};
use nalgebra::{Complex, DMatrix};

/// `A = Q T Q'`.
#[derive(Debug, Clone, PartialEq)]
pub struct Schur {
    /// Orthogonal; its first k columns span an invariant subspace of `A` wherever `T` has a zero below entry (k, k).
    pub q: DMatrix<f64>,
    /// Upper quasi-triangular, its 2 x 2 blocks in standard form. What is below the blocks is exactly zero.
    pub t: DMatrix<f64>,
}

/// Real Schur form `A = Q T Q'` of a square matrix.
///
/// Backward stable: `||A - Q T Q'||` and `||Q'Q - I||` are a small multiple of `n eps` (relative to `||A||`). Entries of any size are
/// allowed; a matrix whose largest entry is beyond 2^+-300 is scaled by a power of two for the computation. A matrix of order zero
/// has the Schur form of order zero. About 25 n^3 flops.
///
/// # Errors
/// [`LinalgError::NotSquare`], [`LinalgError::NotFinite`]; [`LinalgError::NotConverged`] after 30 n sweeps (none is known);
/// [`LinalgError::Overflow`] if an eigenvalue is beyond the range of binary64.
///
/// # Example
/// ```
/// use nalgebra::dmatrix;
/// let a = dmatrix![0.0, -1.0, 0.0; -3.0, -3.0, 1.0; 0.0, 3.0, 0.0];
/// let schur = luenberger_linalg::schur(&a)?;
/// let residual = (&schur.q * &schur.t * schur.q.transpose() - &a).norm() / a.norm();
/// println!("{residual:e}");
/// assert!(residual <= 10.0 * 3.0 * f64::EPSILON);
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
///
/// Source: Golub and Van Loan, Matrix Computations, 4th ed., 7.5; LAPACK dlahqr, dlanv2.
pub fn schur(a: &DMatrix<f64>) -> Result<Schur> {
    square("a", a)?;
    let largest = a.amax();
    let in_range = largest == 0.0 || (2.0_f64.powi(-300)..=2.0_f64.powi(300)).contains(&largest);
    let scale = if in_range { 1.0 } else { unit_scale(a) };
    let (mut t, mut q) = hessenberg::hessenberg(a * scale);
    francis::francis(&mut t, &mut q)?;
    t /= scale;
    if t.iter().any(|e| !e.is_finite()) {
        return Err(LinalgError::Overflow { what: "the Schur form of a" });
    }
    Ok(Schur { q, t })
}

impl Schur {
    /// The eigenvalues, in the order of the diagonal of `T`; of a complex pair, the one above the real axis first.
    pub fn eigenvalues(&self) -> Vec<Complex<f64>> {
        let mut found = Vec::with_capacity(self.t.nrows());
        for (k, size) in blocks(&self.t) {
            let (first, second) = block_eigenvalues(&self.t, k, size);
            found.push(first);
            found.extend(second);
        }
        found
    }
}

/// Where the diagonal blocks of a quasi-triangular matrix start, and their order (one or two).
pub(crate) fn blocks(t: &DMatrix<f64>) -> Vec<(usize, usize)> {
    let n = t.nrows();
    let mut found = Vec::with_capacity(n);
    let mut k = 0;
    while k < n {
        let size = if k + 1 < n && t[(k + 1, k)] != 0.0 { 2 } else { 1 };
        found.push((k, size));
        k += size;
    }
    found
}

/// The eigenvalue of the standardised block of order `size` at `k`, and its conjugate if there is one.
pub(crate) fn block_eigenvalues(t: &DMatrix<f64>, k: usize, size: usize) -> (Complex<f64>, Option<Complex<f64>>) {
    let re = t[(k, k)];
    if size == 1 {
        return (Complex::new(re, 0.0), None);
    }
    let im = t[(k, k + 1)].abs().sqrt() * t[(k + 1, k)].abs().sqrt();
    (Complex::new(re, im), Some(Complex::new(re, -im)))
}
