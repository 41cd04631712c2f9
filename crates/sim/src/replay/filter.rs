//! A Kalman filter that shows the covariance of its innovation.

use luenberger_observers::ObserverDimensions;
use luenberger_observers::kalman::{ExtendedKalmanFilter, GaussianEstimate};
use luenberger_plants::{Column, Differentiable, Size};
use nalgebra::allocator::Allocator;
use nalgebra::{DMatrix, DefaultAllocator, Dim, DimAdd, DimSum, OVector, U1};

use crate::erased::{AnyObserver, Sampled};
use crate::error::SimError;

/// The filter as a sampled-data observer, and its covariance.
pub(super) struct Filter<S, N: Dim, M: Dim, P: Dim>(pub(super) ExtendedKalmanFilter<S, f64, N, M, P>)
where
    DefaultAllocator: Size<N, M, P>;

impl<S, N, M, P> AnyObserver for Filter<S, N, M, P>
where
    S: Differentiable<f64, N, M, P>,
    N: DimAdd<U1>,
    M: Dim,
    P: Dim,
    DefaultAllocator: Size<N, M, P> + Allocator<N, DimSum<N, U1>>,
{
    fn dimensions(&self) -> ObserverDimensions {
        Sampled(&self.0).dimensions()
    }

    fn check(&self) -> Result<(), SimError> {
        Sampled(&self.0).check()
    }

    fn period(&self) -> Option<f64> {
        Sampled(&self.0).period()
    }

    fn derivative(&self, t: f64, state: &[f64], u: &[f64], y: &[f64], slope: &mut [f64]) {
        Sampled(&self.0).derivative(t, state, u, y, slope);
    }

    fn step(&self, t: f64, state: &mut [f64], u: &[f64], y: &[f64]) {
        Sampled(&self.0).step(t, state, u, y);
    }

    fn estimate(&self, t: f64, state: &[f64], u: &[f64], y: &[f64], estimate: &mut [f64]) {
        Sampled(&self.0).estimate(t, state, u, y, estimate);
    }

    fn initial(&self, t: f64, estimate: &[f64], u: &[f64], y: &[f64], state: &mut [f64]) {
        Sampled(&self.0).initial(t, estimate, u, y, state);
    }

    fn innovation_covariance(&self, t: f64, state: &[f64], u: &[f64]) -> Option<DMatrix<f64>> {
        let (belief, u) = (GaussianEstimate::try_from_slice(state)?, OVector::try_from_slice(u)?);
        let s = self.0.innovation_covariance(t, &belief, &u);
        Some(DMatrix::from_fn(s.nrows(), s.ncols(), |i, j| s[(i, j)]))
    }
}
