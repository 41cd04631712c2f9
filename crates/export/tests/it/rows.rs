//! An observer whose maps are rows of expressions, to be recorded.

use luenberger_export::extension::RecordedObserver;
use luenberger_export::step::RecordedStep;
use luenberger_expression::{ExpressionPlant, Recorded};
use luenberger_observers::{Observer, ObserverDimensions};
use luenberger_plants::{Plant, Shape};
use nalgebra::{DVector, RealField};

/// `z' = f(t, z, (u, y))`, `xhat = h(t, z, (u, y))` of `flow`, the start h of `start` and the jump h of `jump`.
pub(crate) struct Rows {
    pub(crate) flow: ExpressionPlant,
    pub(crate) start: ExpressionPlant,
    pub(crate) jump: Option<ExpressionPlant>,
    pub(crate) outputs: usize,
}

fn joined<T: RealField + Copy>(u: &DVector<T>, y: &DVector<T>) -> DVector<T> {
    DVector::from_iterator(u.len() + y.len(), u.iter().chain(y.iter()).copied())
}

impl<T: RealField + Copy> Observer<T> for Rows {
    type State = DVector<T>;
    type Input = DVector<T>;
    type Output = DVector<T>;
    type Estimate = DVector<T>;

    fn dimensions(&self) -> ObserverDimensions {
        let size = self.flow.dimensions();
        let outputs = self.outputs;
        ObserverDimensions { state: size.states, inputs: size.inputs - outputs, outputs, estimate: size.outputs }
    }

    fn derivative(&self, t: T, z: &DVector<T>, u: &DVector<T>, y: &DVector<T>) -> DVector<T> {
        self.flow.derivative(t, z, &joined(u, y))
    }

    fn estimate(&self, t: T, z: &DVector<T>, u: &DVector<T>, y: &DVector<T>) -> DVector<T> {
        self.flow.output(t, z, &joined(u, y))
    }

    fn initial(&self, t: T, estimate: &DVector<T>, _u: &DVector<T>, y: &DVector<T>) -> DVector<T> {
        self.start.output(t, estimate, y)
    }

    fn jump(&self, t: T, z: &DVector<T>, u: &DVector<T>, y: &DVector<T>) -> DVector<T> {
        self.jump.as_ref().map_or_else(|| z.clone(), |jump| jump.output(t, z, &joined(u, y)))
    }
}

impl Rows {
    /// Its program, with this plant.
    pub(crate) fn recorded(&self, plant: &ExpressionPlant) -> RecordedObserver {
        plant.record(|recording| RecordedObserver::new(recording, self)).unwrap()
    }
}

/// The step to the rows f of `flow`, whose inputs are (u, y), with the outputs h.
pub(crate) fn step(flow: &ExpressionPlant, inputs: usize, period: f64) -> RecordedStep<f64> {
    let size = flow.dimensions();
    let (state, outputs) = (size.states, size.outputs);
    let sizes = ObserverDimensions { state, inputs, outputs, estimate: state };
    let column = |entries: &[Recorded]| DVector::from_column_slice(entries);
    let next = |t, z: &[Recorded], u: &[Recorded], y: &[Recorded]| {
        flow.derivative(t, &column(z), &joined(&column(u), &column(y))).as_slice().to_vec()
    };
    let output = |t, z: &[Recorded]| flow.output(t, &column(z), &DVector::zeros(0)).as_slice().to_vec();
    flow.record(|recording| RecordedStep::new(recording, sizes, period, next, output)).unwrap()
}
