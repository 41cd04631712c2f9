//! Observers over the scalar of the target, stepped.

use core::fmt::Debug;
use std::sync::Arc;

use luenberger_expression::Routine;
use luenberger_observers::{
    CovarianceFilter, ExtendedKalmanFilter, Innovation, SampledObserver, UnscentedKalmanFilter,
};
use luenberger_plants::{Column, Differentiable};
use nalgebra::{DMatrix, DVector, Dyn, RealField};

use crate::extension::results;

/// An observer that is stepped on its state as one column.
pub(crate) trait Stepper<T>: Debug + Send + Sync {
    /// The sampling period.
    fn period(&self) -> T;

    /// The state with this estimate.
    fn start(&self, estimate: &DVector<T>) -> DVector<T>;

    /// One step from the sample at time `t`.
    fn step(&self, t: T, state: &mut DVector<T>, u: &DVector<T>, y: &DVector<T>);

    /// The estimate that the state holds.
    fn estimate(&self, state: &DVector<T>) -> DVector<T>;
}

/// One with a state of its own type.
#[derive(Debug)]
pub(crate) struct Sampled<O>(pub(crate) O);

impl<T: RealField + Copy, O> Stepper<T> for Sampled<O>
where
    O: SampledObserver<T, Input = DVector<T>, Output = DVector<T>, Estimate = DVector<T>> + Debug + Send + Sync,
{
    fn period(&self) -> T {
        self.0.period()
    }

    fn start(&self, estimate: &DVector<T>) -> DVector<T> {
        let size = self.0.dimensions();
        let (u, y) = (DVector::zeros(size.inputs), DVector::zeros(size.outputs));
        DVector::from_column_slice(self.0.initial(T::zero(), estimate, &u, &y).as_slice())
    }

    fn step(&self, t: T, state: &mut DVector<T>, u: &DVector<T>, y: &DVector<T>) {
        let mut next = O::State::from_slice(state.as_slice());
        self.0.step(t, &mut next, u, y);
        state.copy_from_slice(next.as_slice());
    }

    fn estimate(&self, state: &DVector<T>) -> DVector<T> {
        self.0.estimate(&O::State::from_slice(state.as_slice()))
    }
}

/// A filter with its two halves of a step apart, on its state as one column.
pub(crate) trait Halves<T: RealField + Copy>: Debug + Send + Sync {
    /// The covariance of the error of the estimate.
    fn covariance(&self, state: &DVector<T>) -> DMatrix<T>;

    /// The update by the finite outputs of y at time `t`; none, and the state as it was, if it is passed over.
    fn update(&self, t: T, state: &mut DVector<T>, u: &DVector<T>, y: &DVector<T>) -> Option<Innovation<T, Dyn>>;

    /// How many outputs of y an update uses: those that are finite and that no gate rejects.
    fn used(&self, t: T, state: &DVector<T>, u: &DVector<T>, y: &DVector<T>) -> usize;

    /// The prediction over a period; false, and the state as it was, if it has no result.
    fn predict(&self, t: T, state: &mut DVector<T>, u: &DVector<T>) -> bool;
}

/// A filter whose update says what its innovation was.
pub(crate) trait Innovates<T: RealField + Copy>:
    CovarianceFilter<T, Input = DVector<T>, Output = DVector<T>, Estimate = DVector<T>>
{
    fn innovate(&self, t: T, state: &mut Self::State, u: &DVector<T>, y: &DVector<T>) -> Option<Innovation<T, Dyn>>;
}

macro_rules! innovates {
    ($($filter:ident)*) => {$(
        impl<T: RealField + Copy, S: Differentiable<T, Dyn, Dyn, Dyn>> Innovates<T> for $filter<S, T, Dyn, Dyn, Dyn> {
            fn innovate(
                &self,
                t: T,
                state: &mut Self::State,
                u: &DVector<T>,
                y: &DVector<T>,
            ) -> Option<Innovation<T, Dyn>> {
                self.update(t, state, u, y)
            }
        }
    )*};
}

innovates!(ExtendedKalmanFilter UnscentedKalmanFilter);

impl<T: RealField + Copy, O: Innovates<T> + Debug + Send + Sync> Halves<T> for Sampled<O> {
    fn covariance(&self, state: &DVector<T>) -> DMatrix<T> {
        let n = self.0.dimensions().estimate;
        let mut p = DMatrix::zeros(n, n);
        self.0.covariance_into(&O::State::from_slice(state.as_slice()), p.as_mut_slice());
        p
    }

    fn update(&self, t: T, state: &mut DVector<T>, u: &DVector<T>, y: &DVector<T>) -> Option<Innovation<T, Dyn>> {
        let mut next = O::State::from_slice(state.as_slice());
        let innovation = self.0.innovate(t, &mut next, u, y)?;
        state.copy_from_slice(next.as_slice());
        Some(innovation)
    }

    fn used(&self, t: T, state: &DVector<T>, u: &DVector<T>, y: &DVector<T>) -> usize {
        let state = O::State::from_slice(state.as_slice());
        let is_used = |i: &usize| y[*i].is_finite() && !self.0.rejects_output(t, &state, u, y, *i);
        (0..y.len()).filter(is_used).count()
    }

    fn predict(&self, t: T, state: &mut DVector<T>, u: &DVector<T>) -> bool {
        let mut next = O::State::from_slice(state.as_slice());
        let is_right = self.0.advance(t, &mut next, u, self.0.period());
        state.copy_from_slice(next.as_slice());
        is_right
    }
}

/// An observer over the scalar of the target.
#[derive(Debug, Clone)]
pub(crate) struct Cast<T> {
    observer: Arc<dyn Stepper<T>>,
    /// The same, if it is a filter with a covariance.
    halves: Option<Arc<dyn Halves<T>>>,
    /// h, if it is nonlinear.
    output: Option<Routine>,
}

impl<T: RealField + Copy> Cast<T> {
    /// An observer, with the outputs of its plant if that is nonlinear.
    pub(crate) fn new(observer: impl Stepper<T> + 'static, output: Option<Routine>) -> Self {
        Self { observer: Arc::new(observer), halves: None, output }
    }

    /// A filter of a nonlinear plant.
    pub(crate) fn filter<O: Innovates<T> + Debug + Send + Sync + 'static>(filter: O, output: Routine) -> Self {
        let filter = Arc::new(Sampled(filter));
        Self { observer: Arc::clone(&filter) as Arc<dyn Stepper<T>>, halves: Some(filter), output: Some(output) }
    }

    /// Update and prediction, of a filter.
    pub(crate) fn halves(&self) -> Option<&dyn Halves<T>> {
        self.halves.as_deref()
    }

    /// The time of the sample number `sample`, from 0.
    pub(crate) fn time(&self, sample: usize) -> T {
        nalgebra::convert::<f64, T>(sample as f64) * self.observer.period()
    }

    pub(crate) fn start(&self, estimate: &DVector<T>) -> DVector<T> {
        self.observer.start(estimate)
    }

    pub(crate) fn step(&self, sample: usize, state: &mut DVector<T>, u: &DVector<T>, y: &DVector<T>) {
        self.observer.step(self.time(sample), state, u, y);
    }

    pub(crate) fn estimate(&self, state: &DVector<T>) -> DVector<T> {
        self.observer.estimate(state)
    }

    /// h at the estimate, of a nonlinear plant.
    pub(crate) fn output(&self, sample: usize, state: &DVector<T>, u: &DVector<T>) -> Option<DVector<T>> {
        let output = self.output.as_ref()?;
        Some(results(output, self.time(sample), self.estimate(state).as_slice(), u.as_slice()))
    }
}
