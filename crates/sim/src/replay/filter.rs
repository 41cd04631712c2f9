//! Kalman filters without their sizes: measurement update and prediction apart, and the covariance in between.

use luenberger_observers::kalman::{ExtendedKalmanFilter, GaussianEstimate, Innovation};
use luenberger_observers::{KalmanFilter, ObserverDimensions, SampledObserver};
use luenberger_plants::{Column, Differentiable, Size};
use nalgebra::allocator::Allocator;
use nalgebra::{DefaultAllocator, Dim, DimAdd, DimSum, OVector, U1};

use super::innovation::NormalisedSquare;
use crate::erased::{AnyObserver, Sampled};
use crate::error::SimError;

/// A filter of any size. Its state is a slice as that of any observer: estimate, then covariance by columns.
pub(super) trait AnyFilter {
    fn dimensions(&self) -> ObserverDimensions;
    fn check(&self) -> Result<(), SimError>;
    /// The period at which it has to be predicted, of a filter in discrete time.
    fn grid(&self) -> Option<f64>;
    fn initial(&self, t: f64, estimate: &[f64], state: &mut [f64]);
    /// Whether the gate of the filter rejects an output that was measured.
    fn rejects(&self, _t: f64, _state: &[f64], _u: &[f64], _y: &[f64], _output: usize) -> bool {
        false
    }
    /// The update by the outputs that were measured under the input u; none if the innovation covariance is not
    /// positive definite.
    fn update(&self, t: f64, state: &mut [f64], u: &[f64], y: &[f64], measured: &[bool]) -> Option<NormalisedSquare>;
    /// How many calls of [`predict`](Self::predict) take it over a duration.
    fn pieces(&self, duration: f64) -> f64;
    fn predict(&self, t: f64, state: &mut [f64], u: &[f64], duration: f64);
}

/// The extended Kalman filter: predicted over any time, or from sample to sample of a plant in discrete time.
pub(super) struct Extended<S, N: Dim, M: Dim, P: Dim>(pub(super) ExtendedKalmanFilter<S, f64, N, M, P>)
where
    DefaultAllocator: Size<N, M, P>;

/// The Kalman filter in discrete time: predicted from sample to sample.
pub(super) struct Discrete<N: Dim, M: Dim, P: Dim>(pub(super) KalmanFilter<f64, N, M, P>)
where
    DefaultAllocator: Size<N, M, P>;

/// Applies `change` to the belief that a slice holds.
fn with_belief<N, R>(state: &mut [f64], change: impl FnOnce(&mut GaussianEstimate<f64, N>) -> R) -> Option<R>
where
    N: DimAdd<U1>,
    DefaultAllocator: Allocator<N, DimSum<N, U1>>,
{
    let mut belief = GaussianEstimate::try_from_slice(state)?;
    let result = change(&mut belief);
    state.copy_from_slice(belief.as_slice());
    Some(result)
}

fn square<P: Dim>(innovation: &Innovation<f64, P>, measured: &[bool]) -> NormalisedSquare
where
    DefaultAllocator: Allocator<P> + Allocator<P, P>,
{
    let degrees = measured.iter().filter(|measured| **measured).count();
    NormalisedSquare { square: innovation.normalized_square, degrees }
}

impl<S, N, M, P> AnyFilter for Extended<S, N, M, P>
where
    S: Differentiable<f64, N, M, P>,
    N: DimAdd<U1>,
    M: Dim,
    P: Dim,
    DefaultAllocator: Size<N, M, P> + Allocator<N, DimSum<N, U1>>,
{
    fn dimensions(&self) -> ObserverDimensions {
        SampledObserver::<f64>::dimensions(&self.0)
    }

    fn check(&self) -> Result<(), SimError> {
        Sampled(&self.0).check()
    }

    fn grid(&self) -> Option<f64> {
        self.0.substeps().is_none().then(|| self.0.period())
    }

    fn initial(&self, _t: f64, estimate: &[f64], state: &mut [f64]) {
        if let Some(estimate) = OVector::<f64, N>::try_from_slice(estimate) {
            state.copy_from_slice(GaussianEstimate::new(&estimate, &self.0.noise_model().p0).as_slice());
        }
    }

    fn rejects(&self, t: f64, state: &[f64], u: &[f64], y: &[f64], output: usize) -> bool {
        let belief = GaussianEstimate::try_from_slice(state);
        let columns = (belief, OVector::<f64, M>::try_from_slice(u), OVector::<f64, P>::try_from_slice(y));
        let (Some(belief), Some(u), Some(y)) = columns else { return false };
        self.0.rejects(t, &belief, &u, &y, output)
    }

    fn update(&self, t: f64, state: &mut [f64], u: &[f64], y: &[f64], measured: &[bool]) -> Option<NormalisedSquare> {
        let (u, y) = (OVector::<f64, M>::try_from_slice(u)?, OVector::<f64, P>::try_from_slice(y)?);
        let innovation = with_belief(state, |belief| self.0.update_partial(t, belief, &u, &y, |j| measured[j]))??;
        Some(square(&innovation, measured))
    }

    fn pieces(&self, duration: f64) -> f64 {
        (duration / self.0.period() - 1e-9).ceil().max(1.0)
    }

    fn predict(&self, t: f64, state: &mut [f64], u: &[f64], duration: f64) {
        let (pieces, Some(u)) = (self.pieces(duration), OVector::<f64, M>::try_from_slice(u)) else { return };
        let tau = duration / pieces;
        with_belief(state, |belief| {
            (0..pieces as u64).for_each(|k| self.0.predict(t + tau * k as f64, belief, &u, tau));
        });
    }
}

impl<N, M, P> AnyFilter for Discrete<N, M, P>
where
    N: DimAdd<U1>,
    M: Dim,
    P: Dim,
    DefaultAllocator: Size<N, M, P> + Allocator<N, DimSum<N, U1>>,
{
    fn dimensions(&self) -> ObserverDimensions {
        SampledObserver::<f64>::dimensions(&self.0)
    }

    fn check(&self) -> Result<(), SimError> {
        Sampled(&self.0).check()
    }

    fn grid(&self) -> Option<f64> {
        Some(SampledObserver::<f64>::period(&self.0))
    }

    fn initial(&self, _t: f64, estimate: &[f64], state: &mut [f64]) {
        if let Some(estimate) = OVector::<f64, N>::try_from_slice(estimate) {
            state.copy_from_slice(GaussianEstimate::new(&estimate, &self.0.model().p0).as_slice());
        }
    }

    fn update(&self, _t: f64, state: &mut [f64], u: &[f64], y: &[f64], measured: &[bool]) -> Option<NormalisedSquare> {
        let (u, y) = (OVector::<f64, M>::try_from_slice(u)?, OVector::<f64, P>::try_from_slice(y)?);
        let innovation = with_belief(state, |belief| self.0.update_partial(belief, &u, &y, |j| measured[j]))??;
        Some(square(&innovation, measured))
    }

    fn pieces(&self, _duration: f64) -> f64 {
        1.0
    }

    fn predict(&self, _t: f64, state: &mut [f64], u: &[f64], _duration: f64) {
        let Some(u) = OVector::<f64, M>::try_from_slice(u) else { return };
        with_belief(state, |belief| self.0.predict(belief, &u));
    }
}
