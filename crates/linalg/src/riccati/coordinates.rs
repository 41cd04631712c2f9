//! Coordinates of the state, `x = T z`, in which the solution of a Riccati equation is near the identity.
//!
//! `S = T^-1` is stored, and defines the coordinates exactly. T is its inverse up to `E = S T - I`, of size
//! `eps cond(T)`, which is corrected where it matters. Products that cancel down to the size of the closed loop are
//! formed in twice the working precision.

use super::scaled::Scaled;
use crate::argument::symmetric_part;
use crate::compensated::product;
use crate::product::view;
use crate::sequential::hermitian_eigen;
use nalgebra::{DMatrix, DVector};

/// Backward error of a Schur form, in units of n eps times the norm of the matrix.
const SCHUR_FORM: f64 = 10.0;

pub(super) struct Frame {
    pub(super) t: DMatrix<f64>,
    pub(super) inverse: DMatrix<f64>,
    /// `S T - I`.
    error: DMatrix<f64>,
    /// Smallest and largest absolute eigenvalue of the X that defined the last step.
    pub(super) extremes: (f64, f64),
}

impl Frame {
    pub(super) fn identity(n: usize) -> Self {
        Self {
            t: DMatrix::identity(n, n),
            inverse: DMatrix::identity(n, n),
            error: DMatrix::zeros(n, n),
            extremes: (0.0, f64::INFINITY),
        }
    }

    /// Coordinates in which `x`, given in the present ones, becomes the identity. Eigenvalues below `floor` times the
    /// largest are raised to that. `None` if x is zero or not finite.
    pub(super) fn then(&self, x: &DMatrix<f64>, floor: f64) -> Option<Self> {
        let n = x.nrows();
        let (values, vectors) = hermitian_eigen(view(x))?;
        let sizes = DVector::from_fn(n, |i, _| values[i].abs());
        let largest = sizes.amax();
        if largest == 0.0 || !largest.is_finite() {
            return None;
        }
        let root = sizes.map(|w| w.max(largest * floor).sqrt());
        let t = &self.t * DMatrix::from_fn(n, n, |i, j| vectors[(i, j)] / root[j]);
        let inverse = DMatrix::from_fn(n, n, |i, j| vectors[(j, i)] * root[i]) * &self.inverse;
        let finite = t.iter().chain(inverse.iter()).all(|e| e.is_finite());
        let error = inverse_error(&inverse, &t);
        finite.then_some(Self { t, inverse, error, extremes: (values[0], largest) })
    }

    /// `S'X S`, from these coordinates to those of the problem.
    pub(super) fn back(&self, x: &DMatrix<f64>) -> DMatrix<f64> {
        symmetric_part(&(self.inverse.tr_mul(x) * &self.inverse))
    }

    /// `T'W T`.
    pub(super) fn form(&self, w: &DMatrix<f64>) -> DMatrix<f64> {
        symmetric_part(&(self.t.tr_mul(w) * &self.t))
    }

    /// `S B`.
    pub(super) fn driven(&self, b: &DMatrix<f64>) -> DMatrix<f64> {
        let (high, low) = product(&self.inverse, b);
        high + low
    }

    /// `K S^-1`.
    pub(super) fn gain(&self, k: &DMatrix<f64>) -> DMatrix<f64> {
        let (high, low) = product(k, &self.t);
        let k = high + low;
        &k - &k * &self.error
    }

    /// `S (A - B K) S^-1` and a bound of its error, including that of its Schur form. Formed in the coordinates of the
    /// problem, `A - B K` may lose A beside B K.
    pub(super) fn closed_loop(&self, problem: &Scaled, k: &DMatrix<f64>) -> (DMatrix<f64>, f64) {
        let (n, m) = problem.b.shape();
        let (kt, kt_rest) = product(k, &self.t);
        let (mut plant, mut motion) = (DMatrix::zeros(n, n + m), DMatrix::zeros(n + m, n));
        plant.columns_mut(0, n).copy_from(&problem.a);
        plant.columns_mut(n, m).copy_from(&problem.b);
        motion.rows_mut(0, n).copy_from(&self.t);
        motion.rows_mut(n, m).copy_from(&-kt);
        let (high, low) = product(&plant, &motion);
        let low = low - &problem.b * kt_rest;
        let (f, f_rest) = product(&self.inverse, &high);
        let f = f + (f_rest + &self.inverse * low);
        // S A T = S A S^-1 (I + E).
        let f = &f - &f * &self.error;
        let size = f.norm();
        let bound = size * (SCHUR_FORM * n as f64 * f64::EPSILON + 2.0 * self.error.norm().powi(2));
        (f, bound)
    }
}

/// `S T - I`.
fn inverse_error(s: &DMatrix<f64>, t: &DMatrix<f64>) -> DMatrix<f64> {
    let (mut high, low) = product(s, t);
    for i in 0..high.nrows() {
        high[(i, i)] -= 1.0;
    }
    high + low
}
