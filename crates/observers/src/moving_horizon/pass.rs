//! One Gauss-Newton step: the window's problem, linearised along a trajectory, solved by a Kalman filter forward and
//! the adjoint equations backward.
//!
//! The stationarity of the linearised problem gives, with the filtered mean m and covariance P of a stage, its matrices
//! `T = product of (I - K C)` and `w = sum of C' S^-1 nu` over its measurements, and A from it to the next,
//!
//! ```text
//! x = m - P lambda,    lambda <- A' (T+' lambda+ - w+)                      from the last stage, lambda = 0, backward
//! ```
//!
//! No covariance is inverted but S: W and the prior may be singular. The cost is that of the filter and `6 n^2` flops a
//! stage.
//!
//! Source: G. J. Bierman, Fixed interval smoothing with discrete measurements, International Journal of Control 18,
//! 1973 (the modified Bryson-Frazier smoother).

use nalgebra::allocator::Allocator;
use nalgebra::{ComplexField, DefaultAllocator, Dim, OMatrix, OVector, RealField, U1};

use crate::dense::{times, times_transpose};
use crate::gaussian::symmetrise;

/// The size of what is not read: 0, if it is known at run time.
pub(super) fn unused<N: Dim>() -> N {
    N::from_usize(N::try_to_usize().unwrap_or(0))
}

/// What the way back needs of a stage.
#[derive(Clone, Debug)]
pub(super) struct Stage<T: RealField + Copy, N: Dim>
where
    DefaultAllocator: Allocator<N> + Allocator<N, N>,
{
    /// Mean and covariance after the measurements of the stage.
    pub(super) mean: OVector<T, N>,
    pub(super) covariance: OMatrix<T, N, N>,
    /// T and w, the sum of T' c nu/s over the updates.
    transition: OMatrix<T, N, N>,
    weighted_innovation: OVector<T, N>,
    /// A to the next stage.
    pub(super) forward: OMatrix<T, N, N>,
}

impl<T: RealField + Copy, N: Dim> Stage<T, N>
where
    DefaultAllocator: Allocator<N> + Allocator<N, N>,
{
    pub(super) fn new(mean: OVector<T, N>, covariance: OMatrix<T, N, N>) -> Self {
        let order = mean.shape_generic().0;
        Self {
            transition: OMatrix::identity_generic(order, order),
            weighted_innovation: OVector::zeros_generic(order, U1),
            forward: OMatrix::identity_generic(order, order),
            mean,
            covariance,
        }
    }

    /// What stands behind the last stage of a window, and is not read: nothing, if the size is known at run time.
    pub(super) fn unused() -> Self {
        let order = unused::<N>();
        Self::new(OVector::zeros_generic(order, U1), OMatrix::zeros_generic(order, order))
    }

    /// The update by one measurement `c x = value + v`, of an innovation with the variance `s = c P c' + v`; false if
    /// that is not a positive number.
    pub(super) fn update(&mut self, c: &OVector<T, N>, innovation: T, variance: T) -> bool {
        let n = c.nrows();
        let mut pc = OVector::<T, N>::zeros_generic(c.shape_generic().0, U1);
        let mut s = variance;
        for i in 0..n {
            for k in 0..n {
                pc[i] += self.covariance[(i, k)] * c[k];
            }
        }
        for i in 0..n {
            s += c[i] * pc[i];
        }
        if !(s > T::zero() && ComplexField::is_finite(&s)) {
            return false;
        }
        // T' c, before T changes: w + T' c nu/s.
        let mut row = OVector::<T, N>::zeros_generic(c.shape_generic().0, U1);
        let scale = innovation / s;
        for i in 0..n {
            for k in 0..n {
                row[i] += self.transition[(k, i)] * c[k];
            }
            self.weighted_innovation[i] += row[i] * scale;
        }
        // K = P c/s; T <- T - K (c' T), P in Joseph's form.
        let gain = pc.map(|entry| entry / s);
        let order = c.shape_generic().0;
        let mut once = OMatrix::<T, N, N>::identity_generic(order, order);
        for i in 0..n {
            self.mean[i] += gain[i] * innovation;
            for j in 0..n {
                self.transition[(i, j)] -= gain[i] * row[j];
                once[(i, j)] -= gain[i] * c[j];
            }
        }
        let mut p = times_transpose(&times(&once, &self.covariance), &once);
        for i in 0..n {
            for j in 0..n {
                p[(i, j)] += gain[i] * variance * gain[j];
            }
        }
        symmetrise(&mut p);
        self.covariance = p;
        true
    }

    /// `A' (T' lambda - w)` of the next stage, by the A of this one.
    pub(super) fn backward(&self, next: &Self, lambda: &OVector<T, N>) -> OVector<T, N> {
        let n = lambda.nrows();
        let before = |matrix: &OMatrix<T, N, N>, v: &OVector<T, N>| {
            let mut result = OVector::<T, N>::zeros_generic(v.shape_generic().0, U1);
            for i in 0..n {
                for k in 0..n {
                    result[i] += matrix[(k, i)] * v[k];
                }
            }
            result
        };
        let adjoint = before(&next.transition, lambda) - &next.weighted_innovation;
        before(&self.forward, &adjoint)
    }

    /// `m - P lambda`.
    pub(super) fn smoothed(&self, lambda: &OVector<T, N>) -> OVector<T, N> {
        let mut x = self.mean.clone();
        for i in 0..x.nrows() {
            for k in 0..x.nrows() {
                x[i] -= self.covariance[(i, k)] * lambda[k];
            }
        }
        x
    }
}
