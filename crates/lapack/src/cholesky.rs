//! Cholesky factorisation and the solution that uses it: `potrf`, `potrs`.

use faer::linalg::cholesky::llt::factor::LltError;
use faer::linalg::triangular_solve::{solve_lower_triangular_in_place, solve_upper_triangular_in_place};
use faer::{MatMut, MatRef, Par, Side};

use crate::abi::Triangle;
use crate::element::Element;

/// Overwrites the stored triangle with L or U of `A = L L' = U'U`. On failure A is as it was, and the order of the
/// first leading minor that is not positive is returned.
pub(crate) fn potrf<T: Element>(stored: Triangle, mut a: MatMut<'_, T>) -> Result<(), usize> {
    // faer's in-place factorisation overwrites the other triangle too, which belongs to the caller: this one copies.
    let side = match stored {
        Triangle::Lower => Side::Lower,
        Triangle::Upper => Side::Upper,
    };
    let factor = a.as_ref().llt(side).map_err(|LltError::NonPositivePivot { index }| index + 1)?;
    let l = factor.L();
    for j in 0..a.ncols() {
        for i in j..a.nrows() {
            match stored {
                Triangle::Lower => a[(i, j)] = l[(i, j)],
                Triangle::Upper => a[(j, i)] = l[(i, j)],
            }
        }
    }
    Ok(())
}

/// Overwrites B with the solution of `A X = B`, given what [`potrf`] left of A.
pub(crate) fn potrs<T: Element>(stored: Triangle, a: MatRef<'_, T>, mut b: MatMut<'_, T>) {
    if b.nrows() == 0 || b.ncols() == 0 {
        return;
    }
    let (lower, upper) = match stored {
        Triangle::Lower => (a, a.transpose()),
        Triangle::Upper => (a.transpose(), a),
    };
    solve_lower_triangular_in_place(lower, b.as_mut(), Par::Seq);
    solve_upper_triangular_in_place(upper, b, Par::Seq);
}
