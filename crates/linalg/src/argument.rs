//! Checks of arguments: shape, finite entries, symmetry.

use crate::{LinalgError, Result};
use nalgebra::{DMatrix, DMatrixView, Dyn};

/// The argument type of the functions of this crate: a reference to any `nalgebra` matrix of doubles converts into
/// it, of static or dynamic size, owned or a view with any strides. A reference to a reference does not.
///
/// ```
/// use luenberger_linalg::{eigenvalues, place_observer};
/// use nalgebra::{Matrix2, RowVector2, dmatrix};
///
/// let a = Matrix2::new(0.0, 1.0, 0.0, 0.0);
/// let placed = place_observer(&a, &RowVector2::new(1.0, 0.0), &[-2.0, -5.0])?;
/// assert!((placed.gain - dmatrix![7.0; 10.0]).norm() < 1e-14);
/// let larger = dmatrix![-1.0, 0.0, 2.0; 0.0, 5.0, 0.0; 0.0, 0.0, -3.0];
/// let part = eigenvalues(&larger.view_with_steps((0, 0), (2, 2), (1, 1)))?;
/// assert_eq!(part.iter().map(|l| l.re).sum::<f64>(), -4.0);
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
pub type RealMatrixView<'a> = DMatrixView<'a, f64, Dyn, Dyn>;

/// The argument as a dynamic matrix: a copy is nothing beside the O(n^3) of what is done with it, and all that follows
/// is compiled once.
pub(crate) fn owned<'a>(m: impl Into<RealMatrixView<'a>>) -> DMatrix<f64> {
    m.into().into_owned()
}

/// Every entry is a finite number.
pub(crate) fn finite(what: &'static str, m: &DMatrix<f64>) -> Result<()> {
    // Without a branch in the loop: nearly always there is nothing to name.
    if m.as_slice().iter().fold(true, |all, x| all & x.is_finite()) {
        return Ok(());
    }
    for col in 0..m.ncols() {
        for row in 0..m.nrows() {
            let value = m[(row, col)];
            if !value.is_finite() {
                return Err(LinalgError::NotFinite { what, row, col, value });
            }
        }
    }
    Ok(())
}

/// Square and finite; returns the order.
pub(crate) fn square(what: &'static str, m: &DMatrix<f64>) -> Result<usize> {
    let (rows, cols) = m.shape();
    if rows != cols {
        return Err(LinalgError::NotSquare { what, rows, cols });
    }
    finite(what, m)?;
    Ok(rows)
}

/// Of the shape the other arguments ask for, and finite.
pub(crate) fn shaped(what: &'static str, m: &DMatrix<f64>, rows: usize, cols: usize) -> Result<()> {
    if m.shape() != (rows, cols) {
        return Err(LinalgError::DimensionMismatch { what, expected: (rows, cols), found: m.shape() });
    }
    finite(what, m)
}

/// Square, finite and symmetric up to the rounding of the products that it may come from; returns the exactly symmetric
/// mean of the matrix and its transpose.
///
/// The tolerance of symmetry of this crate: mirrored entries may differ by `8 n eps` of the largest entry. An entry of
/// `C'WC`, two products of n terms each, has an error of 2n roundings, `n eps`, of `(|C'| |W| |C|)_ij`; mirrored
/// entries differ by twice that, and cancellation within an entry may make this sum four times the largest entry.
///
/// ```
/// use luenberger_linalg::{LinalgError, symmetric};
/// use nalgebra::dmatrix;
/// let below = 1.0f64.next_down();
/// assert_eq!(symmetric("Q", &dmatrix![2.0, 1.0; below, 2.0])?, dmatrix![2.0, 1.0; 1.0, 2.0]);
/// let refused = symmetric("Q", &dmatrix![2.0, 1.0; 1.5, 2.0]);
/// assert!(matches!(refused, Err(LinalgError::NotSymmetric { row: 1, col: 0, asymmetry: 0.5, .. })));
/// # Ok::<(), LinalgError>(())
/// ```
/// # Errors
/// [`LinalgError::NotSquare`], [`LinalgError::NotFinite`]; [`LinalgError::NotSymmetric`] names the entries that differ
/// most.
pub fn symmetric(what: &'static str, m: &DMatrix<f64>) -> Result<DMatrix<f64>> {
    let mut mean = DMatrix::zeros(m.nrows(), m.ncols());
    symmetric_into(what, m, &mut mean)?;
    Ok(mean)
}

/// As [`symmetric`], into a matrix of the same shape.
pub(crate) fn symmetric_into(what: &'static str, m: &DMatrix<f64>, mean: &mut DMatrix<f64>) -> Result<()> {
    let n = square(what, m)?;
    let allowed = 8.0 * n as f64 * f64::EPSILON * m.amax();
    let mut worst = 0.0_f64;
    for col in 0..n {
        mean[(col, col)] = m[(col, col)];
        for row in col + 1..n {
            let (lower, upper) = (m[(row, col)], m[(col, row)]);
            worst = worst.max((lower - upper).abs());
            let entry = average(upper, lower);
            (mean[(row, col)], mean[(col, row)]) = (entry, entry);
        }
    }
    if worst > allowed {
        let pairs = (0..n).flat_map(|col| (col + 1..n).map(move |row| (row, col)));
        let asymmetry = |&(row, col): &(usize, usize)| (m[(row, col)] - m[(col, row)]).abs();
        if let Some((row, col)) = pairs.max_by(|x, y| asymmetry(x).total_cmp(&asymmetry(y)).then(y.cmp(x))) {
            return Err(LinalgError::NotSymmetric { what, row, col, asymmetry: worst, allowed });
        }
    }
    Ok(())
}

/// Exact where both are equal, and without overflow.
fn average(upper: f64, lower: f64) -> f64 {
    if upper == lower { upper } else { 0.5 * upper + 0.5 * lower }
}

/// `(M + M')/2` of a square matrix, exactly symmetric, without overflow.
pub fn symmetric_part(m: &DMatrix<f64>) -> DMatrix<f64> {
    DMatrix::from_fn(m.nrows(), m.ncols(), |i, j| {
        let (upper, lower) = if i <= j { (m[(i, j)], m[(j, i)]) } else { (m[(j, i)], m[(i, j)]) };
        average(upper, lower)
    })
}

/// The power of two that brings the largest entry of `m` to about one; one for a zero or empty matrix. Multiplying
/// by it is exact, except for entries so small beside the largest that they underflow.
pub fn unit_scale(m: &DMatrix<f64>) -> f64 {
    let largest = m.amax();
    if largest == 0.0 || !largest.is_finite() {
        return 1.0;
    }
    // The exponent is clamped so that neither the scale nor its inverse leaves the normal range.
    2.0_f64.powi(-(largest.log2().floor().clamp(-1022.0, 1022.0) as i32))
}
