//! Invariant subspace of selected eigenvalues, and its sensitivity to perturbations (Stewart, SIAM Review 15, 1973;
//! Bai, Demmel and McKenney, ACM TOMS 19, 1993; LAPACK dtrsen).
//!
//! With `T = [T11 T12; 0 T22]`, T11 holding the selected eigenvalues, and `T11 R - R T22 = T12`, the spectral projector
//! has the norm `sqrt(1 + ||R||^2)`. Its reciprocal s determines the error of the mean of the selected eigenvalues, and
//! `sep(T11, T22)` that of the subspace.

use super::Schur;
use crate::argument::unit_scale;
use crate::product::{view, view_mut};
use crate::separation::separation;
use crate::triangular::{self, Coefficient, Equation};
use crate::{LinalgError, Result};
use nalgebra::{Complex, DMatrix};

/// A Schur form with the selected eigenvalues first, and the condition of their invariant subspace.
#[derive(Debug, Clone, PartialEq)]
pub struct Reordered {
    /// The factorisation; the first `dimension` columns of its `Q` span the subspace.
    pub schur: Schur,
    /// Dimension of the subspace: the number of selected eigenvalues, conjugates included.
    pub dimension: usize,
    /// Reciprocal condition number s of the mean of the selected eigenvalues, `1 / sqrt(1 + ||R||_F^2) <= 1`: a change
    /// of `A` of norm `e` moves the mean by at most `e / s` to first order. A lower bound, at most a factor of
    /// `sqrt(min(k, n - k))` too small.
    pub average: f64,
    /// Estimate of `sep = min ||T11 X - X T22||_1 / ||X||_1` (entries summed): a change of `A` of norm `e` rotates the
    /// subspace by an angle of about `e / sep`. It is an upper bound, seldom more than three times too large, and
    /// within a factor of `sqrt(k (n - k))` of the separation in the Frobenius norm. `||T||_1` for a trivial subspace.
    pub separation: f64,
}

impl Schur {
    /// The same factorisation with the eigenvalues for which `select` is true first, as [`Schur::ordered`], and the
    /// condition of their invariant subspace.
    ///
    /// `select` is called once per real eigenvalue and once per conjugate pair (with the one above the real axis),
    /// before any exchange. Up to `6 n` flops for each of the at most `n^2/4` exchanges, and about `6 k (n - k) n` for
    /// the condition of a subspace of dimension k.
    ///
    /// # Errors
    /// [`LinalgError::SwapRejected`] names two eigenvalues that are too close to be separated.
    ///
    /// # Example
    /// ```
    /// use nalgebra::dmatrix;
    /// let a = dmatrix![2.0, 1.0, 3.0; 0.0, -1.0, 1.0; 0.0, 0.0, -4.0];
    /// let stable = luenberger_linalg::schur(&a)?.reorder(|l| l.re < 0.0)?;
    /// let basis = stable.schur.q.columns(0, stable.dimension).into_owned();
    /// // A maps the subspace into itself.
    /// let image = &a * &basis;
    /// let residual = (&image - &basis * (basis.transpose() * &image)).norm() / a.norm();
    /// println!("{residual:e}, s = {}, sep = {}", stable.average, stable.separation);
    /// assert!(stable.dimension == 2 && residual <= 60.0 * f64::EPSILON);
    /// # Ok::<(), luenberger_linalg::LinalgError>(())
    /// ```
    pub fn reorder(self, select: impl Fn(Complex<f64>) -> bool) -> Result<Reordered> {
        let (schur, dimension) = self.ordered(select)?;
        let (average, separation) = condition(&schur.t, dimension)?;
        Ok(Reordered { schur, dimension, average, separation })
    }
}

/// Reciprocal condition number of the mean of the eigenvalues of the leading block of order `k`, and the separation of
/// this block from the rest.
fn condition(t: &DMatrix<f64>, k: usize) -> Result<(f64, f64)> {
    let n = t.nrows();
    let scale = unit_scale(t);
    if k == 0 || k == n {
        let norm = t.column_iter().map(|c| c.iter().map(|e| e.abs() * scale).sum::<f64>()).fold(0.0, f64::max);
        return Ok((1.0, norm / scale));
    }
    let block = |i: usize, j: usize, rows: usize, cols: usize| t.view((i, j), (rows, cols)).into_owned() * scale;
    let (first, second) = (block(0, 0, k, k), -block(k, k, n - k, n - k));
    let sylvester = |s, t, d: &mut DMatrix<f64>| {
        triangular::solve(Equation::Sylvester, s, t, view_mut(d), &mut []);
    };
    let (s, t) = (view(&first), view(&second));
    let solve = |d: &mut DMatrix<f64>| sylvester(Coefficient::plain(s), Coefficient::plain(t), d);
    let adjoint = |d: &mut DMatrix<f64>| sylvester(Coefficient::transposed(s), Coefficient::transposed(t), d);
    let mut r = block(0, k, k, n - k);
    solve(&mut r);
    let largest = r.amax();
    let norm = if largest > 0.0 { (&r / largest).norm() * largest } else { 0.0 };
    let average = if norm.is_nan() { 0.0 } else { 1.0 / 1.0_f64.hypot(norm) };
    let separation = separation(k, n - k, solve, adjoint) / scale;
    if separation.is_finite() {
        Ok((average, separation))
    } else {
        Err(LinalgError::Overflow { what: "the separation of an invariant subspace" })
    }
}
