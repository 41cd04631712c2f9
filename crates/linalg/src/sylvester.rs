//! Sylvester equation `A X + X B = C`.
//!
//! `X` exists and is unique iff no eigenvalue of `A` is the negative of one of `B`. It is the change of coordinates that
//! decouples a block-triangular system, and what turns a plant into the coordinates of a Luenberger observer with prescribed dynamics.
//!
//! Method: real Schur forms `A = U S U'`, `B = V T V'`, then `S Y + Y T = U'C V` by back-substitution (Bartels and Stewart, CACM 15, 1972).

use crate::argument::{shaped, square, unit_scale};
use crate::separation::{nearly_singular, relative, rescaled, separation};
use crate::triangular::{self, flip_cols, flip_rows, flipped};
use crate::{Result, schur};
use nalgebra::DMatrix;

/// Solution of `A X + X B = C` with its evidence.
#[derive(Debug, Clone, PartialEq)]
pub struct Sylvester {
    /// The solution, n x m.
    pub x: DMatrix<f64>,
    /// `||A X + X B - C|| / ((||A|| + ||B||) ||X|| + ||C||)` in the Frobenius norm.
    pub residual: f64,
    /// Estimate of the separation of `A` and `-B`, `min ||A X + X B||_1 / ||X||_1` (entries summed, in the coordinates of the
    /// Schur forms). An upper bound, seldom more than three times too large.
    pub separation: f64,
    /// `(||A|| + ||B||) / separation`: about how much `X` may change, relative to its norm, for a unit relative change of `A` and `B`.
    pub condition: f64,
}

/// Solves `A X + X B = C`.
///
/// `a` is n x n, `b` m x m, `c` n x m. A unique `X` exists iff `lambda_i(A) + lambda_j(B) != 0` for all i, j. The answer does not depend on the
/// units of the data. About `25 (n^3 + m^3) + 5 n m (n + m)` flops, and at most `11 n m (n + m)` for the separation.
///
/// # Errors
/// [`NearlySingular`](crate::LinalgError::NearlySingular) names the eigenvalues of `a` and `b` whose sum is nearest to zero, when
/// the separation is not above `max(n, m) eps (||A|| + ||B||)`; [`NotSquare`](crate::LinalgError::NotSquare),
/// [`DimensionMismatch`](crate::LinalgError::DimensionMismatch), [`NotFinite`](crate::LinalgError::NotFinite),
/// [`Overflow`](crate::LinalgError::Overflow), and those of [`schur()`].
///
/// # Example
/// ```
/// use nalgebra::dmatrix;
/// let a = dmatrix![0.0, 1.0; -2.0, -3.0];
/// let b = dmatrix![-4.0];
/// let c = dmatrix![1.0; 2.0];
/// let sylvester = luenberger_linalg::sylvester(&a, &b, &c)?;
/// let defect = &a * &sylvester.x + &sylvester.x * &b - &c;
/// println!("residual {:e}, {:e}", sylvester.residual, defect.norm());
/// assert!(sylvester.residual <= 10.0 * 2.0 * f64::EPSILON);
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
///
/// Source: Bartels and Stewart, CACM 15, 1972; Golub and Van Loan, Matrix Computations, 7.6.3; SLICOT SB04MD.
pub fn sylvester(a: &DMatrix<f64>, b: &DMatrix<f64>, c: &DMatrix<f64>) -> Result<Sylvester> {
    let n = square("a", a)?;
    let m = square("b", b)?;
    shaped("c", c, n, m)?;
    // One unit for both coefficients: that of the larger. A coefficient of order zero, or zero, has none.
    let units = match (a.amax() > 0.0, b.amax() > 0.0) {
        (true, true) => unit_scale(a).min(unit_scale(b)),
        (true, false) => unit_scale(a),
        _ => unit_scale(b),
    };
    let units_c = unit_scale(c);
    let (a, b, c) = (a * units, b * units, c * units_c);
    let (left, right) = (schur(&a)?, schur(&b)?);
    let (left_flipped, right_flipped) = (flipped(&left.t), flipped(&right.t));
    let solve = |d: &mut DMatrix<f64>| triangular::sylvester(&left.t, &right.t, d);
    let solve_adjoint = |d: &mut DMatrix<f64>| {
        flip_rows(d);
        flip_cols(d);
        triangular::sylvester(&left_flipped, &right_flipped, d);
        flip_cols(d);
        flip_rows(d);
    };
    let mut y = left.q.transpose() * &c * &right.q;
    let regular = solve(&mut y);
    let x = &left.q * y * right.q.transpose();
    let found = separation(n, m, |d| _ = solve(d), solve_adjoint);
    let size = a.norm() + b.norm();
    let finite = x.iter().all(|e| e.is_finite());
    if n * m > 0 && (!regular || !finite || found <= n.max(m) as f64 * f64::EPSILON * size) {
        let unscaled = |s: &crate::Schur| s.eigenvalues().iter().map(|l| l / units).collect::<Vec<_>>();
        return Err(nearly_singular("Sylvester", &unscaled(&left), &unscaled(&right), found / units, |x, y| {
            (x + y).norm()
        }));
    }
    let defect = &a * &x + &x * &b - &c;
    Ok(Sylvester {
        residual: relative(defect.norm(), size * x.norm() + c.norm()),
        x: rescaled("the solution x", &x, units, units_c)?,
        separation: found / units,
        condition: size / found,
    })
}
