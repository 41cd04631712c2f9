//! An observer whose step is straight-line code, `z+ = g(t, z, u, y)`, and whose estimate is its whole state.
//!
//! The interval observer, whose state is the estimate with its bounds, sliding-mode observers, and observers in
//! discrete time whose estimate has the measurement of its sample are exported in this form. The step is recorded from
//! the observer that runs.

use luenberger_expression::{Recorded, Recording, RecordingError, Routine};
use luenberger_observers::{ObserverDimensions, ObserverError, SampledObserver};
use nalgebra::{DVector, RealField};

use crate::extension::results;

/// The step, with its sampling period.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordedStep<T> {
    step: Routine,
    output: Routine,
    size: ObserverDimensions,
    period: T,
    is_of_sample: bool,
}

impl<T: RealField + Copy> RecordedStep<T> {
    /// The program of the step `g(t, z, u, y)` of an observer with these sizes, and of the outputs `h(t, z)` that z
    /// predicts.
    ///
    /// # Errors
    /// [`RecordingError`].
    pub fn new(
        recording: &mut Recording,
        size: ObserverDimensions,
        period: T,
        step: impl Fn(Recorded, &[Recorded], &[Recorded], &[Recorded]) -> Vec<Recorded>,
        output: impl Fn(Recorded, &[Recorded]) -> Vec<Recorded>,
    ) -> Result<Self, RecordingError> {
        let known = (size.state, size.inputs + size.outputs);
        let step = recording.program(known, |t, z, known| {
            let (u, y) = known.split_at(size.inputs);
            step(t, z, u, y)
        })?;
        let output = recording.program((size.state, 0), |t, z, _| output(t, z))?;
        Ok(Self { step, output, size, period, is_of_sample: false })
    }

    /// The same, whose state begins with the estimate at the sample of the step, with its measurement, and not for the
    /// next one.
    #[must_use]
    pub fn of_sample(self) -> Self {
        Self { is_of_sample: true, ..self }
    }

    /// Whether it is such a step.
    pub fn is_of_sample(&self) -> bool {
        self.is_of_sample
    }

    /// The same with another scalar.
    pub(crate) fn cast<U: RealField + Copy>(&self, period: U) -> Result<RecordedStep<U>, ObserverError> {
        let (step, output) = (self.step.clone(), self.output.clone());
        if !(period.is_finite() && period > U::zero()) {
            return Err(ObserverError::Period { period: period.to_subset_unchecked() });
        }
        Ok(RecordedStep { step, output, size: self.size, period, is_of_sample: self.is_of_sample })
    }

    /// g and h as straight-line code.
    pub(crate) fn routines(&self) -> (Routine, Routine) {
        (self.step.clone(), self.output.clone())
    }
}

impl<T: RealField + Copy> SampledObserver<T> for RecordedStep<T> {
    type State = DVector<T>;
    type Input = DVector<T>;
    type Output = DVector<T>;
    type Estimate = DVector<T>;

    fn dimensions(&self) -> ObserverDimensions {
        self.size
    }

    fn period(&self) -> T {
        self.period
    }

    fn step(&self, t: T, state: &mut DVector<T>, u: &DVector<T>, y: &DVector<T>) {
        let known: Vec<T> = u.iter().chain(y.iter()).copied().collect();
        *state = results(&self.step, t, state.as_slice(), &known);
    }

    fn estimate(&self, state: &DVector<T>) -> DVector<T> {
        state.clone()
    }

    fn initial(&self, _t: T, estimate: &DVector<T>, _u: &DVector<T>, _y: &DVector<T>) -> DVector<T> {
        estimate.clone()
    }
}
