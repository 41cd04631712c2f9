//! Balancing of a matrix for its eigenvalues: a permutation that splits off isolated eigenvalues, then a diagonal
//! scaling by powers of two that makes the norms of each row and its column nearly equal.
//!
//! Osborne, J. ACM 7, 1960; Parlett and Reinsch, Numer. Math. 13, 1969. Norms are Euclidean and include the diagonal,
//! after James, Langou and Lowery (2014, "On matrix balancing and eigenvector computation"): with the 1-norm a matrix
//! with small off-diagonal entries can get worse. Neither step rounds, but the scaling is not an orthogonal similarity:
//! balancing is an option for eigenvalues and not part of the Schur form.

use crate::argument::{RealMatrixView, owned, square};
use crate::{LinalgError, Result};
use core::ops::Range;
use nalgebra::DMatrix;

/// Maximum number of cycles over the rows. Each accepted step reduces a sum of norms by at least 5 %; a few cycles are
/// usual.
const CYCLES: usize = 100;
/// Scalings stay within `2^+-LARGEST`, so that ratios of two of them do not overflow.
const LARGEST: i32 = 500;

/// `S^-1 A S` with `S = P D`, P a permutation and D diagonal, of powers of two.
#[derive(Debug, Clone, PartialEq)]
pub struct Balanced {
    /// Upper triangular outside the rows and columns `active`.
    pub matrix: DMatrix<f64>,
    /// Rows and columns of the block that is not split off.
    pub active: Range<usize>,
    /// Row of `A` that became row i of the balanced matrix.
    pub permutation: Vec<usize>,
    /// Diagonal of D.
    pub scaling: Vec<f64>,
}

/// Balances a square matrix: see [`Balanced`]. Its eigenvalues are exactly those of `a`, unless an entry underflows;
/// those of a badly scaled matrix become far better conditioned.
///
/// About `n^2` operations for each of a few cycles.
///
/// # Errors
/// [`LinalgError::NotSquare`], [`LinalgError::NotFinite`].
///
/// # Example
/// ```
/// use luenberger_linalg::{balanced, eigenvalues};
/// use nalgebra::dmatrix;
/// // Volts and microvolts: eigenvalues 1 +- 1.
/// let a = dmatrix![1.0, 1e12; 1e-12, 1.0];
/// let b = balanced(&a)?;
/// assert!(b.matrix.amax() <= 2.0);
/// let smallest = eigenvalues(&b.matrix)?.iter().map(|l| l.norm()).fold(f64::MAX, f64::min);
/// println!("{smallest:e}");
/// assert!(smallest <= 20.0 * f64::EPSILON);
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
pub fn balanced<'a>(a: impl Into<RealMatrixView<'a>>) -> Result<Balanced> {
    split_and_scaled(owned(a))
}

fn split_and_scaled(a: DMatrix<f64>) -> Result<Balanced> {
    let n = square("A", &a)?;
    let mut found = Balanced { matrix: a, active: 0..n, permutation: (0..n).collect(), scaling: vec![1.0; n] };
    found.split_off();
    found.scale();
    Ok(found)
}

impl Balanced {
    /// `S X`: transforms the columns of `x` (eigenvectors or a basis in the balanced coordinates) to the coordinates of
    /// `A`.
    ///
    /// # Errors
    /// [`LinalgError::DimensionMismatch`] if `x` has not n rows; [`LinalgError::Overflow`].
    pub fn back(&self, x: &DMatrix<f64>) -> Result<DMatrix<f64>> {
        let n = self.scaling.len();
        if x.nrows() != n {
            return Err(LinalgError::DimensionMismatch { what: "X", expected: (n, x.ncols()), found: x.shape() });
        }
        let mut found = DMatrix::zeros(n, x.ncols());
        for (i, (&from, d)) in self.permutation.iter().zip(&self.scaling).enumerate() {
            for j in 0..x.ncols() {
                found[(from, j)] = d * x[(i, j)];
            }
        }
        if found.iter().any(|e| e.is_infinite()) {
            return Err(LinalgError::Overflow { what: "the basis in the coordinates of a" });
        }
        Ok(found)
    }

    /// Moves rows that are zero off the diagonal to the bottom, and such columns to the left.
    fn split_off(&mut self) {
        let m = &mut self.matrix;
        let exchange = |m: &mut DMatrix<f64>, permutation: &mut [usize], i: usize, j: usize| {
            m.swap_rows(i, j);
            m.swap_columns(i, j);
            permutation.swap(i, j);
        };
        let Range { mut start, mut end } = self.active;
        while let Some(i) = (start..end).rev().find(|&i| (start..end).all(|j| j == i || m[(i, j)] == 0.0)) {
            end -= 1;
            exchange(m, &mut self.permutation, i, end);
        }
        while let Some(j) = (start..end).find(|&j| (start..end).all(|i| i == j || m[(i, j)] == 0.0)) {
            exchange(m, &mut self.permutation, j, start);
            start += 1;
        }
        self.active = start..end;
    }

    /// Makes the norms of the rows and columns of the active block nearly equal.
    fn scale(&mut self) {
        let n = self.scaling.len();
        let mut exponents = vec![0_i32; n];
        for _ in 0..CYCLES {
            let mut moved = false;
            for i in self.active.clone() {
                let (column, row) = (
                    norm(self.active.clone().map(|k| self.matrix[(k, i)])),
                    norm(self.active.clone().map(|k| self.matrix[(i, k)])),
                );
                if column == 0.0 || row == 0.0 || !column.is_finite() || !row.is_finite() {
                    continue;
                }
                let step = (0.5 * (row.log2() - column.log2())).round() as i32;
                let next = (exponents[i] + step).clamp(-LARGEST, LARGEST);
                let step = next - exponents[i];
                // 2^step as two factors, each within range.
                let (half, rest) = (2.0_f64.powi(step / 2), 2.0_f64.powi(step - step / 2));
                if step == 0 || column * half * rest + row / half / rest >= 0.95 * (column + row) {
                    continue;
                }
                moved = true;
                exponents[i] = next;
                for k in 0..n {
                    if k != i {
                        self.matrix[(k, i)] *= half * rest;
                        self.matrix[(i, k)] /= half * rest;
                    }
                }
            }
            if !moved {
                break;
            }
        }
        for (d, e) in self.scaling.iter_mut().zip(exponents) {
            *d = 2.0_f64.powi(e);
        }
    }
}

/// Euclidean norm, without intermediate overflow or underflow.
fn norm(entries: impl Iterator<Item = f64> + Clone) -> f64 {
    let largest = entries.clone().fold(0.0_f64, |m, e| m.max(e.abs()));
    if largest == 0.0 { 0.0 } else { largest * entries.map(|e| (e / largest) * (e / largest)).sum::<f64>().sqrt() }
}
