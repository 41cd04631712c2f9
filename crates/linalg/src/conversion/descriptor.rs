//! A descriptor plant `E x' = A x + B u` with a regular E in standard form.

use super::inverse_condition;
use crate::argument::{RealMatrixView, owned, shaped, square};
use crate::equilibration::Equilibrated;
use crate::units::shift;
use crate::{LinalgError, Result};
use nalgebra::DMatrix;

/// `x' = E^-1 A x + E^-1 B u`.
#[derive(Debug, Clone, PartialEq)]
pub struct StandardForm {
    /// `E^-1 A`, n x n.
    pub a: DMatrix<f64>,
    /// `E^-1 B`, n x m.
    pub b: DMatrix<f64>,
    /// Condition number of E in the Frobenius norm, in units in which its rows and columns have entries of about one.
    /// The relative errors of `a` and `b` are about so many eps.
    pub condition: f64,
}

/// The plant `E x' = A x + B u`, in discrete time `E x+ = A x + B u`, as `x' = E^-1 A x + E^-1 B u`.
///
/// `e` and `a` are n x n, `b` n x m; m may be 0. The state and with it the output are the same. Units of states and
/// equations do not matter. About `(8/3) n^3 + 2 n^2 (n + m)` flops.
///
/// # Errors
/// [`LinalgError::Singular`] if `e` is singular to working precision; [`LinalgError::NotSquare`],
/// [`LinalgError::DimensionMismatch`], [`LinalgError::NotFinite`], [`LinalgError::Overflow`].
///
/// # Example
/// ```
/// use nalgebra::dmatrix;
/// // Mass 2, damping 0.5 and stiffness 8.
/// let (e, a) = (dmatrix![1.0, 0.0; 0.0, 2.0], dmatrix![0.0, 1.0; -8.0, -0.5]);
/// let found = luenberger_linalg::standard_form(&e, &a, &dmatrix![0.0; 1.0])?;
/// println!("residual {:e}", (&e * &found.a - &a).amax());
/// assert_eq!((found.a, found.b), (dmatrix![0.0, 1.0; -4.0, -0.25], dmatrix![0.0; 0.5]));
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
pub fn standard_form<'a>(
    e: impl Into<RealMatrixView<'a>>,
    a: impl Into<RealMatrixView<'a>>,
    b: impl Into<RealMatrixView<'a>>,
) -> Result<StandardForm> {
    let (e, a, b) = (owned(e), owned(a), owned(b));
    let n = square("E", &e)?;
    shaped("A", &a, n, n)?;
    shaped("B", &b, n, b.ncols())?;
    let equilibrated = Equilibrated::new(&e);
    let (_, condition) = inverse_condition("E", &equilibrated.matrix)?;
    let lu = equilibrated.matrix.lu();
    // E^-1 M = C (R E C)^-1 R M.
    let solve = |m: &DMatrix<f64>| {
        let scaled = DMatrix::from_fn(n, m.ncols(), |i, j| shift(m[(i, j)], equilibrated.rows[i]));
        let solved = lu.solve(&scaled)?;
        let found = DMatrix::from_fn(n, m.ncols(), |i, j| shift(solved[(i, j)], equilibrated.columns[i]));
        found.iter().all(|x| x.is_finite()).then_some(found)
    };
    let (a, b) = solve(&a).zip(solve(&b)).ok_or(LinalgError::Overflow { what: "the plant in standard form" })?;
    Ok(StandardForm { a, b, condition })
}
