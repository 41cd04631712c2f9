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

/// Smoothed estimates with their covariances.
#[derive(Clone, Debug, PartialEq)]
pub struct Smoothed {
    /// The estimates from the whole log, one row for each time.
    pub estimate: DMatrix<f64>,
    /// By columns, one time after the other.
    covariances: Vec<f64>,
}

impl Smoothed {
    /// The covariance of the error of the estimate at the time of this index, n x n; none beyond the last.
    pub fn covariance(&self, index: usize) -> Option<DMatrix<f64>> {
        let n = self.estimate.ncols();
        let entries = self.covariances.get(index * n * n..(index + 1) * n * n)?;
        Some(DMatrix::from_column_slice(n, n, entries))
    }

    /// The standard deviations, one row for each time.
    pub fn deviation(&self) -> DMatrix<f64> {
        let n = self.estimate.ncols();
        let at = |k: usize, i: usize| self.covariances[k * n * n + i * n + i].max(0.0).sqrt();
        DMatrix::from_fn(self.estimate.nrows(), n, at)
    }
}

/// The record of a filter on its way: its times, and the steps between them.
#[derive(Clone, Debug, Default)]
pub(super) struct Record {
    /// Of each step of the prediction one after the other: estimate and covariance before it, those after it, and
    /// `E e e-'`; matrices by columns.
    numbers: Vec<f64>,
    /// Before which step each time lies.
    pub(super) places: Vec<usize>,
    /// Estimate and covariance at the last time.
    pub(super) last: (Vec<f64>, Vec<f64>),
}

impl Record {
    /// Adds numbers of a step.
    pub(super) fn add(&mut self, numbers: &[f64]) {
        self.numbers.extend_from_slice(numbers);
    }

    /// Numbers of a step of a filter of order n.
    fn size(n: usize) -> usize {
        2 * n + 3 * n * n
    }

    /// How many steps there are.
    pub(super) fn steps(&self) -> usize {
        // Before the first step the order is not known, nor needed.
        self.numbers.len() / Self::size(self.last.0.len()).max(1)
    }

    /// Smooths.
    pub(super) fn smooth(self) -> Smoothed {
        let n = self.last.0.len();
        let column = |x: &[f64]| DVector::from_column_slice(x);
        let matrix = |p: &[f64]| DMatrix::from_column_slice(n, n, p);
        let mut estimate = DMatrix::zeros(self.places.len(), n);
        let mut covariances = vec![0.0; self.places.len() * n * n];
        let (mut x, mut p) = (column(&self.last.0), matrix(&self.last.1));
        let mut place = self.steps();
        for k in (0..self.places.len()).rev() {
            while place > self.places[k] {
                place -= 1;
                let step = &self.numbers[place * Self::size(n)..(place + 1) * Self::size(n)];
                let (before, rest) = step.split_at(n + n * n);
                let (after, cross) = rest.split_at(n + n * n);
                let predicted = matrix(&after[n..]);
                // G' = (P-)^-1 (E e e-')'.
                let gain = solve(&predicted, &matrix(cross).transpose()).transpose();
                x = column(&before[..n]) + &gain * (x - column(&after[..n]));
                let next = matrix(&before[n..]) + &gain * (p - predicted) * gain.transpose();
                p = (&next + next.transpose()) * 0.5;
            }
            estimate.set_row(k, &x.transpose());
            covariances[k * n * n..(k + 1) * n * n].copy_from_slice(p.as_slice());
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
