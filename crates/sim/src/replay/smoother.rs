//! The fixed-interval smoother of Rauch, Tung and Striebel: estimates from the whole log.
//!
//! A filter goes through the log once, and keeps for each step of its prediction the estimate and covariance before it,
//! `(x, P)`, those after it, `(x-, P-)`, and the covariance between both, `E e e-'`. Backwards, from the last row on,
//!
//! ```text
//! G = E e e-' (P-)^-1
//! xs <- x + G (xs+ - x-),  Ps <- P + G (Ps+ - P-) G'
//! ```
//!
//! with the smoothed estimate xs+ after the step. For a linear plant, `E e e-' = P A'`, and xs is the solution of the
//! least-squares problem of all measurements; for the extended filter A is the transition matrix along its estimate,
//! and the unscented filter has the covariance of its sigma points before and after. Where `P-` is singular, its
//! pseudo-inverse takes the place of the inverse.
//!
//! Sources: H. E. Rauch, F. Tung and C. T. Striebel, Maximum likelihood estimates of linear dynamic systems, AIAA
//! Journal 3, 1965; S. Sarkka, Unscented Rauch-Tung-Striebel smoother, IEEE Transactions on Automatic Control 53, 2008.

use nalgebra::{DMatrix, DVector};

/// One step of the prediction of a filter: estimate and covariance (by columns) before and after it.
#[derive(Clone, Debug)]
pub(super) struct Passage {
    pub(super) before: (Vec<f64>, Vec<f64>),
    pub(super) after: (Vec<f64>, Vec<f64>),
    /// `E e e-'`, by columns.
    pub(super) cross: Vec<f64>,
}

/// Smoothed estimates with their covariances.
#[derive(Clone, Debug, PartialEq)]
pub struct Smoothed {
    /// The estimates from the whole log, one row for each time.
    pub estimate: DMatrix<f64>,
    covariances: Vec<DMatrix<f64>>,
}

impl Smoothed {
    /// The covariance of the error of the estimate at the time of this index, n x n; none beyond the last.
    pub fn covariance(&self, index: usize) -> Option<&DMatrix<f64>> {
        self.covariances.get(index)
    }

    /// The standard deviations, one row for each time.
    pub fn deviation(&self) -> DMatrix<f64> {
        let at = |k: usize, i: usize| self.covariances[k][(i, i)].max(0.0).sqrt();
        DMatrix::from_fn(self.covariances.len(), self.estimate.ncols(), at)
    }
}

/// The record of a filter on its way: its times, and the steps between them.
#[derive(Clone, Debug, Default)]
pub(super) struct Record {
    pub(super) passages: Vec<Passage>,
    /// Before which passage each time lies.
    pub(super) places: Vec<usize>,
    /// Estimate and covariance at the last time.
    pub(super) last: (Vec<f64>, Vec<f64>),
}

impl Record {
    /// Smooths.
    pub(super) fn smooth(self) -> Smoothed {
        let n = self.last.0.len();
        let column = |x: &[f64]| DVector::from_column_slice(x);
        let matrix = |p: &[f64]| DMatrix::from_column_slice(n, n, p);
        let mut estimate = DMatrix::zeros(self.places.len(), n);
        let mut covariances = vec![DMatrix::zeros(0, 0); self.places.len()];
        let (mut x, mut p) = (column(&self.last.0), matrix(&self.last.1));
        let mut place = self.passages.len();
        for k in (0..self.places.len()).rev() {
            while place > self.places[k] {
                place -= 1;
                let Passage { before, after, cross } = &self.passages[place];
                let predicted = matrix(&after.1);
                // G' = (P-)^-1 (E e e-')'.
                let gain = solve(&predicted, &matrix(cross).transpose()).transpose();
                x = column(&before.0) + &gain * (x - column(&after.0));
                let next = matrix(&before.1) + &gain * (p - predicted) * gain.transpose();
                p = (&next + next.transpose()) * 0.5;
            }
            estimate.set_row(k, &x.transpose());
            covariances[k].clone_from(&p);
        }
        Smoothed { estimate, covariances }
    }
}

/// `P^-1 B`, or with the pseudo-inverse of a singular P.
fn solve(p: &DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    // In units of the standard deviations, so that states of any magnitude count alike.
    let scale = DVector::from_fn(p.nrows(), |i, _| if p[(i, i)] > 0.0 { 1.0 / p[(i, i)].sqrt() } else { 0.0 });
    let scaled = DMatrix::from_fn(p.nrows(), p.ncols(), |i, j| scale[i] * p[(i, j)] * scale[j]);
    let right = DMatrix::from_fn(b.nrows(), b.ncols(), |i, j| scale[i] * b[(i, j)]);
    let eigen = scaled.symmetric_eigen();
    let least = eigen.eigenvalues.amax() * p.nrows() as f64 * f64::EPSILON;
    let inverse = eigen.eigenvalues.map(|value| if value > least { 1.0 / value } else { 0.0 });
    let solved = &eigen.eigenvectors * DMatrix::from_diagonal(&inverse) * eigen.eigenvectors.transpose() * right;
    DMatrix::from_fn(b.nrows(), b.ncols(), |i, j| scale[i] * solved[(i, j)])
}
