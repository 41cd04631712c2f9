//! The continuous equation by the stable invariant subspace of the Hamiltonian matrix `[A -G; -Q -A']` (Laub, IEEE TAC 24, 1979).
//!
//! Its eigenvalues lie symmetric to the imaginary axis. If none lies on it, the n stable ones have an invariant subspace spanned by
//! `[U1; U2]`, and `X = U2 U1^-1` exists iff `(A, B)` is stabilizable.

use super::popov;
use super::scaled::Scaled;
use crate::argument::symmetric_part;
use crate::{LinalgError, Result, schur};
use nalgebra::DMatrix;

pub(super) fn solve(problem: &Scaled) -> Result<DMatrix<f64>> {
    let n = problem.a.nrows();
    let mut h = DMatrix::zeros(2 * n, 2 * n);
    h.view_mut((0, 0), (n, n)).copy_from(&problem.a);
    h.view_mut((0, n), (n, n)).copy_from(&-&problem.g);
    h.view_mut((n, 0), (n, n)).copy_from(&-&problem.q);
    h.view_mut((n, n), (n, n)).copy_from(&-problem.a.transpose());
    let form = schur(&h)?;
    let values = form.eigenvalues();
    let explain = |problem: &Scaled| {
        let nearest = values.iter().copied().min_by(|x, y| x.re.abs().total_cmp(&y.re.abs())).unwrap_or_default();
        popov::explain(problem, nearest)
    };
    let (ordered, stable) = match form.ordered(|l| l.re < 0.0) {
        Ok(found) => found,
        Err(LinalgError::SwapRejected { .. }) => return Err(explain(problem)),
        Err(other) => return Err(other),
    };
    if stable != n {
        return Err(explain(problem));
    }
    let u1 = ordered.q.view((0, 0), (n, n)).into_owned();
    let u2 = ordered.q.view((n, 0), (n, n)).into_owned();
    // X U1 = U2, transposed.
    match u1.transpose().lu().solve(&u2.transpose()) {
        Some(x) if x.iter().all(|e| e.is_finite()) => Ok(symmetric_part(&x)),
        _ => Err(explain(problem)),
    }
}
