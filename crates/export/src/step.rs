//! An observer whose step is given by expressions, `z+ = g(t, z, u, y)`, and whose estimate is its whole state.
//!
//! The interval observer, whose state is the estimate with its bounds, and sliding-mode observers with an implicit step
//! are exported in this form.

use luenberger_expression::{ExpressionPlant, Routine};
use luenberger_observers::{ObserverDimensions, ObserverError, SampledObserver};
use luenberger_plants::{Plant, PlantError, Shape};
use nalgebra::{DVector, RealField};

/// The step, with its sampling period.
#[derive(Debug, Clone, PartialEq)]
pub struct ExpressionStep<T> {
    flow: ExpressionPlant,
    inputs: usize,
    period: T,
}

impl<T: RealField + Copy> ExpressionStep<T> {
    /// The step g as the rows f of `flow`, whose states are z and whose inputs are (u, y), u of this length. The rows h
    /// are the outputs that z predicts; they depend on no input.
    ///
    /// # Errors
    /// [`ObserverError::Matrix`] for sizes that do not fit, [`ObserverError::Period`].
    pub fn new(flow: ExpressionPlant, inputs: usize, period: T) -> Result<Self, ObserverError> {
        let size = flow.dimensions();
        let expected = (inputs + size.outputs, 1);
        if size.inputs != expected.0 {
            return Err(PlantError::DimensionMismatch { what: "(u, y)", expected, found: (size.inputs, 1) }.into());
        }
        if flow.routines().h.uses_inputs() {
            let (expected, found) = ((0, 1), (size.inputs, 1));
            return Err(PlantError::DimensionMismatch { what: "inputs of h", expected, found }.into());
        }
        if !(period.is_finite() && period > T::zero()) {
            return Err(ObserverError::Period { period: period.to_subset_unchecked() });
        }
        Ok(Self { flow, inputs, period })
    }

    /// The same with another scalar.
    pub(crate) fn cast<U: RealField + Copy>(&self, period: U) -> Result<ExpressionStep<U>, ObserverError> {
        ExpressionStep::new(self.flow.clone(), self.inputs, period)
    }

    /// g and h as straight-line code.
    pub(crate) fn routines(&self) -> (Routine, Routine) {
        let all = self.flow.routines();
        (all.f, all.h)
    }

    /// The rows as a plant.
    pub(crate) fn flow(&self) -> &ExpressionPlant {
        &self.flow
    }
}

impl<T: RealField + Copy> SampledObserver<T> for ExpressionStep<T> {
    type State = DVector<T>;
    type Input = DVector<T>;
    type Output = DVector<T>;
    type Estimate = DVector<T>;

    fn dimensions(&self) -> ObserverDimensions {
        let size = self.flow.dimensions();
        ObserverDimensions { state: size.states, inputs: self.inputs, outputs: size.outputs, estimate: size.states }
    }

    fn period(&self) -> T {
        self.period
    }

    fn step(&self, t: T, state: &mut DVector<T>, u: &DVector<T>, y: &DVector<T>) {
        let known = DVector::from_iterator(u.len() + y.len(), u.iter().chain(y.iter()).copied());
        *state = self.flow.derivative(t, state, &known);
    }

    fn estimate(&self, state: &DVector<T>) -> DVector<T> {
        state.clone()
    }

    fn initial(&self, _t: T, estimate: &DVector<T>, _u: &DVector<T>, _y: &DVector<T>) -> DVector<T> {
        estimate.clone()
    }
}
