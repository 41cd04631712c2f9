//! Filters with a covariance and separate measurement update and prediction, for logs, consistency tests and smoothers.

use luenberger_plants::Column;
use nalgebra::RealField;

use crate::observer::{SampledObserver, put_slice};

/// A filter that computes a covariance of its error, with separate update and prediction.
///
/// [`step`](SampledObserver::step) is [`measure`](Self::measure) and then [`advance`](Self::advance) over one period.
pub trait CovarianceFilter<T: RealField + Copy>: SampledObserver<T> {
    /// Whether the filter is in discrete time: predictions then go from one sample to the next, whatever the duration.
    fn is_discrete(&self) -> bool;

    /// The covariance of the error that a state holds, n x n by columns. Returns whether the length fits.
    fn covariance_into(&self, state: &Self::State, p: &mut [T]) -> bool;

    /// The measurement update at time t by the outputs that are true in `measured`, one entry for each output; the
    /// other entries of y are not read. `y~' S^-1 y~`, or `None`, and the state as it was, if S is not positive
    /// definite in floating point.
    fn measure(&self, t: T, state: &mut Self::State, u: &Self::Input, y: &Self::Output, measured: &[bool])
    -> Option<T>;

    /// [`measure`](Self::measure), and beside its square `ln det S` of the outputs that the update used; none where
    /// the update has no S (default).
    ///
    /// The log-likelihood of the measurement, given those before it, is `-(p ln(2 pi) + ln det S + y~' S^-1 y~)/2`,
    /// with p outputs.
    fn measure_with_determinant(
        &self,
        t: T,
        state: &mut Self::State,
        u: &Self::Input,
        y: &Self::Output,
        measured: &[bool],
    ) -> Option<(T, Option<T>)> {
        self.measure(t, state, u, y, measured).map(|square| (square, None))
    }

    /// The innovation of the measurement y at time t: y less the output that the update expects, for every output,
    /// whether it was measured or not. NaN where h is not defined, or columns have other lengths.
    ///
    /// The extended filter expects h(xhat), the unscented one the mean of h over its sigma points.
    fn innovation(&self, t: T, state: &Self::State, u: &Self::Input, y: &Self::Output) -> Self::Output;

    /// The prediction from t to `t + duration`, the input held; in discrete time to the next sample. False if it has no
    /// result in floating point.
    fn advance(&self, t: T, state: &mut Self::State, u: &Self::Input, duration: T) -> bool;

    /// [`advance`](Self::advance), and the covariance of the errors before and after it, `E e(t) e(t + duration)'`, n x
    /// n by columns: the gain of a smoother is that times the inverse of the covariance after it. False (default) of a
    /// filter that has no such covariance.
    fn advance_across(&self, t: T, state: &mut Self::State, u: &Self::Input, duration: T, cross: &mut [T]) -> bool {
        let _ = (t, state, u, duration, cross);
        false
    }

    /// The number of the unit vector that a state belongs to, from 1 on; 0 (default) for one that belongs to none. The
    /// covariance says nothing of the length of a unit vector, so that an error is measured across it
    /// ([`tangential`](crate::tangential)).
    fn unit_vector_of(&self, state: usize) -> usize {
        let _ = state;
        0
    }

    /// Whether a gate rejects an output of the measurement y; default false.
    fn rejects_output(&self, t: T, state: &Self::State, u: &Self::Input, y: &Self::Output, output: usize) -> bool {
        let _ = (t, state, u, y, output);
        false
    }
}

/// [`SampledObserver::update_into`] of a filter. A measurement without a result is passed over, as if it were missed.
pub(crate) fn update_columns<T: RealField + Copy, F: CovarianceFilter<T>>(
    filter: &F,
    t: T,
    state: &mut [T],
    (u, y): (&[T], &[T]),
    measured: &[bool],
) -> bool {
    let columns = (F::State::try_from_slice(state), Column::try_from_slice(u), Column::try_from_slice(y));
    let (Some(mut next), Some(u), Some(y)) = columns else { return false };
    if measured.is_empty() || measured.contains(&true) {
        filter.measure(t, &mut next, &u, &y, measured);
    }
    put_slice(next.as_slice(), state)
}

/// [`SampledObserver::predict_into`] of a filter, by what moves its state.
pub(crate) fn predict_columns<T: RealField + Copy, F: CovarianceFilter<T>>(
    filter: &F,
    state: &mut [T],
    u: &[T],
    predict: impl FnOnce(&mut F::State, &F::Input),
) -> bool {
    let size = filter.dimensions();
    if (state.len(), u.len()) != (size.state, size.inputs) {
        return false;
    }
    let (Some(mut next), Some(u)) = (F::State::try_from_slice(state), Column::try_from_slice(u)) else { return false };
    predict(&mut next, &u);
    put_slice(next.as_slice(), state)
}

/// The step of a [`SampledObserver`] over `$t` that is a [`CovarianceFilter`] with a function `finish`, the prediction
/// of a step: update and prediction, on columns and on slices. Columns of other lengths change nothing.
#[cfg(feature = "alloc")]
macro_rules! update_and_finish {
    ($t:ty) => {
        fn step(&self, t: $t, state: &mut Self::State, u: &Self::Input, y: &Self::Output) {
            self.step_partial(t, state, u, y, &[]);
        }

        fn step_partial(&self, t: $t, state: &mut Self::State, u: &Self::Input, y: &Self::Output, measured: &[bool]) {
            let (size, lengths) = (self.dimensions(), [state.as_slice().len(), u.as_slice().len(), y.as_slice().len()]);
            if lengths == [size.state, size.inputs, size.outputs] {
                if measured.is_empty() || measured.contains(&true) {
                    self.measure(t, state, u, y, measured);
                }
                self.finish(t, state, u);
            }
        }

        fn update_into(&self, t: $t, state: &mut [$t], u: &[$t], y: &[$t], measured: &[bool]) -> bool {
            crate::covariance_filter::update_columns(self, t, state, (u, y), measured)
        }

        fn predict_into(&self, t: $t, state: &mut [$t], u: &[$t]) -> bool {
            crate::covariance_filter::predict_columns(self, state, u, |state, u| self.finish(t, state, u))
        }
    };
}

#[cfg(feature = "alloc")]
pub(crate) use update_and_finish;
