//! Observers over the scalar of the target, stepped.

use core::fmt::Debug;
use std::sync::Arc;

use luenberger_expression::Routine;
use luenberger_observers::SampledObserver;
use luenberger_plants::Column;
use nalgebra::{DVector, RealField};

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

/// An observer over the scalar of the target.
#[derive(Debug, Clone)]
pub(crate) struct Cast<T> {
    observer: Arc<dyn Stepper<T>>,
    /// h, if it is nonlinear.
    output: Option<Routine>,
}

impl<T: RealField + Copy> Cast<T> {
    /// An observer, with the outputs of its plant if that is nonlinear.
    pub(crate) fn new(observer: impl Stepper<T> + 'static, output: Option<Routine>) -> Self {
        Self { observer: Arc::new(observer), output }
    }

    /// The time of the sample number `sample`, from 0.
    fn time(&self, sample: usize) -> T {
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
