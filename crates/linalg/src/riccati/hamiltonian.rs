//! The continuous equation by the stable invariant subspace of the Hamiltonian matrix `[A -G; -Q -A']` (Laub, IEEE TAC
//! 24, 1979).
//!
//! Its eigenvalues lie symmetrically about the imaginary axis. If none lies on it, the n stable ones have an invariant
//! subspace spanned by `[U1; U2]`, and `X = U2 U1^-1` exists iff `(A, B)` is stabilizable.

use super::popov;
use super::scaled::Scaled;
use crate::argument::symmetric_part;
use crate::{LinalgError, Result, Schur, schur};
use nalgebra::DMatrix;

pub(super) fn solve(problem: &Scaled) -> Result<DMatrix<f64>> {
    let form = schur(&matrix(problem))?;
    let values = form.eigenvalues();
    // Eigenvalues of the Hamiltonian matrix on the axis are double, and accurate to the root of eps.
    let near = f64::EPSILON.sqrt() * values.iter().map(|value| value.norm()).fold(0.0, f64::max);
    let explain = || {
        let nearest = values.iter().copied().min_by(|x, y| x.re.abs().total_cmp(&y.re.abs()));
        popov::explain(problem, nearest.filter(|nearest| nearest.re.abs() <= near))
    };
    match left_of(form, 0.0, problem.a.nrows()) {
        Ok(Some(x)) => Ok(x),
        Ok(None) | Err(LinalgError::SwapRejected { .. }) => Err(explain()),
        Err(other) => Err(other),
    }
}

/// As [`solve`], from the n leftmost eigenvalues even if rounding has put some on the wrong side of the axis: a
/// starting point, not a solution.
pub(super) fn guess(problem: &Scaled) -> Option<DMatrix<f64>> {
    leftmost(&matrix(problem))
}

/// X of the n leftmost eigenvalues of a Hamiltonian matrix of order 2n. Rounding can merge a slow eigenvalue and its
/// mirror image into a complex pair on the axis. If so, `A - s I` replaces A: its eigenvalues are at least s from the
/// axis, and X keeps its order of magnitude.
pub(super) fn leftmost(h: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let n = h.nrows() / 2;
    split(h).or_else(|| {
        // Eigenvalues of this ill-conditioned pair are accurate to about the square root of eps.
        let shift = 64.0 * f64::EPSILON.sqrt() * h.norm();
        let mut apart = h.clone();
        for i in 0..n {
            apart[(i, i)] -= shift;
            apart[(n + i, n + i)] += shift;
        }
        split(&apart)
    })
}

fn split(h: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let n = h.nrows() / 2;
    let form = schur(h).ok()?;
    let mut abscissae: Vec<f64> = form.eigenvalues().iter().map(|lambda| lambda.re).collect();
    abscissae.sort_by(f64::total_cmp);
    let (last, next) = (abscissae.get(n.checked_sub(1)?)?, abscissae.get(n)?);
    left_of(form, 0.5 * (last + next), n).ok().flatten()
}

/// `[A -G; -Q -A']`.
fn matrix(problem: &Scaled) -> DMatrix<f64> {
    let n = problem.a.nrows();
    let mut h = DMatrix::zeros(2 * n, 2 * n);
    h.view_mut((0, 0), (n, n)).copy_from(&problem.a);
    h.view_mut((0, n), (n, n)).copy_from(&-&problem.g);
    h.view_mut((n, 0), (n, n)).copy_from(&-&problem.q);
    h.view_mut((n, n), (n, n)).copy_from(&-problem.a.transpose());
    h
}

/// X of the invariant subspace of the eigenvalues left of `boundary`; `None` if there are not n of them or U1 is
/// singular.
fn left_of(form: Schur, boundary: f64, n: usize) -> Result<Option<DMatrix<f64>>> {
    let (ordered, count) = form.ordered(|lambda| lambda.re < boundary)?;
    if count != n {
        return Ok(None);
    }
    let u1 = ordered.q.view((0, 0), (n, n)).into_owned();
    let u2 = ordered.q.view((n, 0), (n, n)).into_owned();
    // Solves X U1 = U2, transposed.
    let x = u1.transpose().lu().solve(&u2.transpose());
    Ok(x.filter(|x| x.iter().all(|e| e.is_finite())).map(|x| symmetric_part(&x)))
}
