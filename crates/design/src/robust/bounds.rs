//! Margins that need no LMI: (23), its exact form for a fixed P, the spectral abscissa, and the error bound for a
//! forced plant.

use luenberger_linalg::{LinalgError, RealMatrixView, lambda_max, lambda_min, symmetric_part};
use nalgebra::DMatrix;

use crate::check;
use crate::error::DesignError;

/// The bound (23) of Theorem 5: `eps_max = lambda_min(Q) / (2 lambda_max(P))`.
///
/// Sufficient for the P and Q at hand. Cost: two symmetric eigenproblems.
///
/// # Errors
/// [`LinalgError::NotPositiveDefinite`](luenberger_linalg::LinalgError::NotPositiveDefinite) and its kin when P or Q is
/// not what (9) gives.
pub fn theorem5_bound<'a>(
    p: impl Into<RealMatrixView<'a>>,
    q: impl Into<RealMatrixView<'a>>,
) -> Result<f64, DesignError> {
    let (p, q) = (&check::owned(p), &check::owned(q));
    check::positive_definite("P", p, p.nrows())?;
    check::positive_definite("Q", q, p.nrows())?;
    Ok(lambda_min(q)? / (2.0 * lambda_max(p)?))
}

/// The exact margin for this P: the supremum of eps with `F'P + PF + 2 eps P < 0`, which is
/// `lambda_min(P^-1/2 Q P^-1/2) / 2`.
///
/// Equals [`theorem5_bound`] when Q is a multiple of I, and is never smaller.
///
/// # Errors
/// As [`theorem5_bound`].
pub fn fixed_lyapunov_margin<'a>(
    p: impl Into<RealMatrixView<'a>>,
    q: impl Into<RealMatrixView<'a>>,
) -> Result<f64, DesignError> {
    let (p, q) = (&check::owned(p), &check::owned(q));
    check::positive_definite("Q", q, p.nrows())?;
    check::symmetric("P", p, p.nrows())?;
    match greatest_rate(p, q)? {
        Some(rate) => Ok(rate),
        None => Err(LinalgError::NotPositiveDefinite { what: "P", lambda_min: lambda_min(p)? }.into()),
    }
}

/// The greatest r with `Q - 2 r P >= 0`, which is `lambda_min(P^-1/2 Q P^-1/2) / 2`, in floating point; `None` where P
/// is not positive definite.
pub(crate) fn greatest_rate(p: &DMatrix<f64>, q: &DMatrix<f64>) -> Result<Option<f64>, DesignError> {
    // G^-1 Q G^-T for P = G G' has the eigenvalues of P^-1/2 Q P^-1/2.
    let Some(g) = p.clone().cholesky().map(|cholesky| cholesky.l()) else { return Ok(None) };
    let solve = |m: &DMatrix<f64>| g.solve_lower_triangular(m);
    let Some(whitened) = solve(q).and_then(|half| solve(&half.transpose())) else { return Ok(None) };
    Ok(Some(0.5 * lambda_min(&symmetric_part(&whitened))?))
}

/// The margin when N is redesigned for every eps: minus the spectral abscissa of `F = A - L C`.
///
/// # Errors
/// [`DesignError::NotHurwitz`] when there is no margin at all, decided exactly; [`DesignError::StabilityUndecided`]
/// when rounding hides it.
pub fn redesigned_margin<'a>(f: impl Into<RealMatrixView<'a>>) -> Result<f64, DesignError> {
    let f = &check::owned(f);
    let what = "A - L C";
    let nothing = (DMatrix::zeros(f.nrows(), 0), DMatrix::zeros(0, f.ncols()));
    let abscissa = check::hurwitz(what, (f, &nothing.0, &nothing.1))?;
    if abscissa < 0.0 {
        Ok(-abscissa)
    } else {
        Err(DesignError::StabilityUndecided { what, size: abscissa, limit: 0.0 })
    }
}

/// Ultimate bound of the error per unit of forcing: `limsup |e| <= gain * sup |(A(eps) - A) x|`.
///
/// With `2 alpha = lambda_min(P^-1/2 Q P^-1/2)`, `V = e'Pe` obeys
/// `(sqrt V)' <= -alpha sqrt V + |P^1/2 (A(eps) - A) x|`, hence `gain = sqrt(lambda_max(P) / lambda_min(P)) / alpha`.
/// The same bound holds for the linear observer; the cubic term only helps in it.
///
/// # Errors
/// As [`theorem5_bound`].
pub fn input_to_state_gain<'a>(
    p: impl Into<RealMatrixView<'a>>,
    q: impl Into<RealMatrixView<'a>>,
) -> Result<f64, DesignError> {
    let (p, q) = (&check::owned(p), &check::owned(q));
    let alpha = fixed_lyapunov_margin(p, q)?;
    Ok((lambda_max(p)? / lambda_min(p)?).sqrt() / alpha)
}
