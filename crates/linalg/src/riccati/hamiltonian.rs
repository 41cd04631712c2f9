//! The continuous equation by the stable invariant subspace of the Hamiltonian matrix `[A -G; -Q -A']` (Laub, IEEE TAC
//! 24, 1979).
//!
//! Its eigenvalues lie symmetrically about the imaginary axis. If none lies on it, the n stable ones have an invariant
//! subspace spanned by `[U1; U2]`, and `X = U2 U1^-1` exists iff `(A, B)` is stabilizable. This holds for `R > 0`. For
//! an indefinite R stabilizability is necessary only: U1 can be singular.

use super::popov;
use super::scaled::Scaled;
use crate::argument::symmetric_part;
use crate::{LinalgError, Result, Schur, schur};
use nalgebra::{Complex, DMatrix};

pub(super) fn solve(problem: &Scaled) -> Result<DMatrix<f64>> {
    stable(problem, &matrix(problem), |eigenvalue| eigenvalue)
}

/// X of the stable invariant subspace of the Hamiltonian matrix `h`; `back` takes its eigenvalues to those of the
/// closed loop.
pub(super) fn stable(
    problem: &Scaled,
    h: &DMatrix<f64>,
    back: impl Fn(Complex<f64>) -> Complex<f64>,
) -> Result<DMatrix<f64>> {
    let form = schur(h)?;
    let values = form.eigenvalues();
    // Eigenvalues of the Hamiltonian matrix on the axis are double, and accurate to the root of eps.
    let near = f64::EPSILON.sqrt() * values.iter().map(|value| value.norm()).fold(0.0, f64::max);
    let explain = || {
        let nearest = values.iter().copied().min_by(|x, y| x.re.abs().total_cmp(&y.re.abs()));
        popov::explain(problem, nearest.filter(|nearest| nearest.re.abs() <= near).map(&back))
    };
    match left_of(form, 0.0, problem.a.nrows()) {
        Ok(Some(basis)) if problem.is_definite() => basis.solution().ok_or_else(explain),
        Ok(Some(basis)) => {
            let x = basis.solution();
            let sigma_min = x.as_ref().map_or(0.0, |x| sigma_min(x.norm()));
            // The rounding error of an orthonormal basis.
            x.filter(|_| sigma_min > 10.0 * h.nrows() as f64 * f64::EPSILON).ok_or(LinalgError::NotGraph { sigma_min })
        }
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
    left_of(form, 0.5 * (last + next), n).ok().flatten()?.solution()
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

/// Smallest singular value of X1 in an orthonormal basis `[X1; X2]` of the subspace `[I; X]`, from the norm of X.
pub(super) fn sigma_min(size: f64) -> f64 {
    1.0 / size.hypot(1.0)
}

/// Orthonormal basis `[U1; U2]` of an invariant subspace.
struct Basis {
    u1: DMatrix<f64>,
    u2: DMatrix<f64>,
}

impl Basis {
    /// X with `X U1 = U2`; `None` if U1 is singular.
    fn solution(&self) -> Option<DMatrix<f64>> {
        // Transposed.
        let x = self.u1.transpose().lu().solve(&self.u2.transpose())?;
        x.iter().all(|e| e.is_finite()).then(|| symmetric_part(&x))
    }
}

/// The invariant subspace of the eigenvalues left of `boundary`; `None` if there are not n of them.
fn left_of(form: Schur, boundary: f64, n: usize) -> Result<Option<Basis>> {
    let (ordered, count) = form.ordered(|lambda| lambda.re < boundary)?;
    if count != n {
        return Ok(None);
    }
    let u1 = ordered.q.view((0, 0), (n, n)).into_owned();
    let u2 = ordered.q.view((n, 0), (n, n)).into_owned();
    Ok(Some(Basis { u1, u2 }))
}
