//! The estimator as a sampled observer and as a filter with a covariance.

use luenberger_plants::{Column, Differentiable, Size};
use nalgebra::allocator::Allocator;
use nalgebra::{DefaultAllocator, Dim, OVector, RealField, U1, convert};

use super::MovingHorizonEstimator;
use super::window::{Layout, Part};
use crate::angles;
use crate::covariance_filter::{CovarianceFilter, update_columns};
use crate::observer::{ObserverDimensions, SampledObserver, put_slice};
use crate::transition::Prediction;

impl<S, T: RealField + Copy, N: Dim, M: Dim, P: Dim, D: Dim, const L: usize> SampledObserver<T>
    for MovingHorizonEstimator<S, T, N, M, P, D, L>
where
    S: Differentiable<T, N, M, P>,
    DefaultAllocator: Size<N, M, P> + Allocator<D>,
{
    type State = OVector<T, D>;
    type Input = OVector<T, M>;
    type Output = OVector<T, P>;
    type Estimate = OVector<T, N>;

    fn dimensions(&self) -> ObserverDimensions {
        let Layout { n, m, p, .. } = self.layout;
        ObserverDimensions { state: self.layout.len(), inputs: m, outputs: p, estimate: n }
    }

    fn period(&self) -> T {
        self.h
    }

    /// Update by the outputs that are finite, and prediction. A sample without any, or whose problem has no solution,
    /// is passed over as if it were missed; a prediction without a result makes the estimate NaN. Columns of other
    /// lengths change nothing.
    fn step(&self, t: T, state: &mut Self::State, u: &Self::Input, y: &Self::Output) {
        if self.is_measurement(y) {
            self.update(t, state, u, y, |_| true);
            self.finish(t, state, u);
        }
    }

    fn step_partial(&self, t: T, state: &mut Self::State, u: &Self::Input, y: &Self::Output, measured: &[bool]) {
        if self.is_measurement(y) {
            if measured.contains(&true) {
                self.update(t, state, u, y, |output| measured.get(output).copied().unwrap_or(true));
            }
            self.finish(t, state, u);
        }
    }

    fn update_into(&self, t: T, state: &mut [T], u: &[T], y: &[T], measured: &[bool]) -> bool {
        update_columns(self, t, state, (u, y), measured)
    }

    fn predict_into(&self, t: T, state: &mut [T], u: &[T]) -> bool {
        let columns = (OVector::<T, D>::try_from_slice(state), OVector::<T, M>::try_from_slice(u));
        let (Some(mut next), Some(u)) = columns else { return false };
        self.finish(t, &mut next, &u);
        put_slice(next.as_slice(), state)
    }

    fn estimate(&self, state: &Self::State) -> Self::Estimate {
        let entries = &state.as_slice()[self.layout.estimate()];
        OVector::from_fn_generic(self.noises.w.shape_generic().0, U1, |i, _| entries[i])
    }

    fn estimate_into(&self, state: &[T], estimate: &mut [T]) -> bool {
        state.get(..estimate.len()).is_some_and(|xhat| put_slice(xhat, estimate))
    }

    fn initial(&self, t: T, estimate: &Self::Estimate, _u: &Self::Input, _y: &Self::Output) -> Self::State {
        let layout = self.layout;
        let mut state = OVector::<T, D>::zeros_generic(D::from_usize(layout.len()), U1);
        let entries = state.as_mut_slice();
        for range in [layout.estimate(), layout.prior_mean(), layout.part(0, Part::State)] {
            entries[range].copy_from_slice(estimate.as_slice());
        }
        for range in [layout.covariance(), layout.prior_covariance()] {
            entries[range].copy_from_slice(self.noises.p0.as_slice());
        }
        entries[layout.part(0, Part::Time)].fill(t);
        layout.set_count(entries, 1);
        state
    }
}

impl<S, T: RealField + Copy, N: Dim, M: Dim, P: Dim, D: Dim, const L: usize> CovarianceFilter<T>
    for MovingHorizonEstimator<S, T, N, M, P, D, L>
where
    S: Differentiable<T, N, M, P>,
    DefaultAllocator: Size<N, M, P> + Allocator<D>,
{
    fn is_discrete(&self) -> bool {
        self.prediction == Prediction::Discrete
    }

    fn covariance_into(&self, state: &Self::State, p: &mut [T]) -> bool {
        put_slice(&state.as_slice()[self.layout.covariance()], p)
    }

    fn measure(
        &self,
        t: T,
        state: &mut Self::State,
        u: &Self::Input,
        y: &Self::Output,
        measured: &[bool],
    ) -> Option<T> {
        self.update(t, state, u, y, |output| measured.get(output).copied().unwrap_or(true))
    }

    fn innovation(&self, t: T, state: &Self::State, u: &Self::Input, y: &Self::Output) -> Self::Output {
        if !self.fits(state, u) || !self.is_measurement(y) {
            return y.map(|_| convert(f64::NAN));
        }
        angles::difference(&self.turns, y, &self.plant.output(t, &self.estimate(state), u))
    }

    fn advance(&self, t: T, state: &mut Self::State, u: &Self::Input, duration: T) -> bool {
        self.predict(t, state, u, duration)
    }
}
