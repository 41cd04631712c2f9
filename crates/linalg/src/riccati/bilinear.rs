//! The discrete Riccati equation as a Hamiltonian eigenproblem, relative to a known gain `K0`.
//!
//! With `K = K0 + L` and `F = A - B K0`, the equation is that of the plant `(F, B)` with the state weight
//! `Q + K0'R K0`, the cross weight `S = -K0'R` and R. X is the same.
//!
//! ```text
//!     [F        0  B ]     [I  0   0]
//! M = [-Q-K0'RK0 I -S],  N = [0  F'  0],       (M - z N) has the closed loop's poles z, their inverses, and m infinite eigenvalues.
//!     [S'       0  R ]     [0 -B'  0]
//! ```
//! The bilinear map `w = (z - 1)/(z + 1)` gives the matrix `(M + N)^-1 (M - N)`. Its leading 2n rows and columns are
//! Hamiltonian, with the stable subspace `[I; X]`; the infinite eigenvalues become ones of the last m columns. `M + N`
//! is regular iff -1 is not a pole of the closed loop; `A + I` may be singular. With a good K0 no entry is larger than
//! the closed loop; A itself, in coordinates in which X is near the identity, can be as large as its unstable modes are
//! fast.

use super::hamiltonian;
use super::scaled::Scaled;
use crate::{LinalgError, Result};
use nalgebra::{DMatrix, DVector};

/// Data of the shifted equation.
pub(super) struct Shifted<'a> {
    /// `F`.
    pub(super) f: &'a DMatrix<f64>,
    pub(super) b: &'a DMatrix<f64>,
    /// `Q + K0'R K0`.
    pub(super) q: &'a DMatrix<f64>,
    /// `K0`.
    pub(super) k: &'a DMatrix<f64>,
    pub(super) r: &'a DMatrix<f64>,
}

/// X of the n poles nearest to stability: a starting point, and a solution if these poles are stable.
pub(super) fn guess(shifted: &Shifted<'_>) -> Option<DMatrix<f64>> {
    hamiltonian::leftmost(&mapped(shifted)?.0)
}

/// The solution for an indefinite R, which is not inverted.
pub(super) fn solve(problem: &Scaled) -> Result<DMatrix<f64>> {
    let Scaled { a, b, q, r, .. } = problem;
    let k = &DMatrix::zeros(b.ncols(), a.nrows());
    let Some((h, sign)) = mapped(&Shifted { f: a, b, q, k, r }) else {
        return Err(LinalgError::Overflow { what: "the bilinear map of the Riccati equation" });
    };
    hamiltonian::stable(problem, &h, |w| (w + 1.0) / (-w + 1.0) * sign)
}

/// The Hamiltonian matrix of one of two bilinear maps, `w = (z - s)/(z + s)`, and s: 1 or -1.
fn mapped(shifted: &Shifted<'_>) -> Option<(DMatrix<f64>, f64)> {
    // The first map is ill-conditioned for a pole near -1, the second for a pole near 1.
    let trusted = f64::EPSILON.sqrt().recip();
    let first = hamiltonian(shifted, 1.0);
    match first {
        Some(h) if h.norm() <= trusted => Some((h, 1.0)),
        first => {
            let second = hamiltonian(shifted, -1.0).map(|h| (h, -1.0));
            first.map(|h| (h, 1.0)).into_iter().chain(second).min_by(|x, y| x.0.norm().total_cmp(&y.0.norm()))
        }
    }
}

/// The leading block of `(M + sign N)^-1 (M - sign N)`.
fn hamiltonian(shifted: &Shifted<'_>, sign: f64) -> Option<DMatrix<f64>> {
    let Shifted { f, b, q, k, r } = *shifted;
    let (n, m) = b.shape();
    // Inputs scaled so that B and R together have norm about one.
    let units = DVector::from_fn(m, |j, _| b.column(j).norm().hypot(r[(j, j)].abs().sqrt()))
        .map(|x| if x > 0.0 { 1.0 / x } else { 1.0 });
    let scaled = DMatrix::from_diagonal(&units);
    let (b, r) = (b * &scaled, &scaled * r * &scaled);
    let cross = -(&scaled * shifted.r * k);
    let order = 2 * n + m;
    let (mut plus, mut minus) = (DMatrix::zeros(order, order), DMatrix::zeros(order, 2 * n));
    for (target, sign) in [(&mut plus, sign), (&mut minus, -sign)] {
        target.view_mut((0, 0), (n, n)).copy_from(f);
        target.view_mut((n, 0), (n, n)).copy_from(&-q);
        target.view_mut((2 * n, 0), (m, n)).copy_from(&cross);
        target.view_mut((n, n), (n, n)).copy_from(&(f.transpose() * sign));
        target.view_mut((2 * n, n), (m, n)).copy_from(&(b.transpose() * -sign));
        for i in 0..n {
            target[(i, i)] += sign;
            target[(n + i, n + i)] += 1.0;
        }
    }
    plus.view_mut((0, 2 * n), (n, m)).copy_from(&b);
    plus.view_mut((n, 2 * n), (n, m)).copy_from(&-cross.transpose());
    plus.view_mut((2 * n, 2 * n), (m, m)).copy_from(&r);
    let h = plus.lu().solve(&minus)?.view((0, 0), (2 * n, 2 * n)).into_owned();
    h.iter().all(|e| e.is_finite()).then_some(h)
}
