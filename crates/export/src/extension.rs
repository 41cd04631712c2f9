//! An observer in continuous time whose right-hand side, estimate and start are expressions: KKL observers with given
//! maps, [KKL+PEB] observers.
//!
//! Its state z has an equation `z' = g(t, z, u, y)` and the estimate `xhat = k(t, z, y)`, of all states of the plant.
//! Both are the rows of one plant with the states z and the inputs (u, y). The start `z(0) = j(xhat, y)` is the output
//! of another one, with the states xhat and the inputs y. Where the state jumps at samples, `z+ = q(t, z, u, y)` is the
//! output of a third, with the states z and the inputs (u, y).

use luenberger_expression::{ExpressionPlant, Routine};
use luenberger_observers::{InterSampleObserver, Observer, ObserverDimensions};
use luenberger_plants::{Differentiable, Plant, PlantError, Shape};
use nalgebra::{DMatrix, DVector, Dyn, RealField};

/// The sampled form that is exported.
pub type SampledExtension<T> = InterSampleObserver<ExpressionPlant, ExpressionObserver, T, Dyn, Dyn, Dyn, Dyn, Dyn>;

/// An observer of expressions; see the [module](self).
#[derive(Debug, Clone, PartialEq)]
pub struct ExpressionObserver {
    flow: ExpressionPlant,
    start: ExpressionPlant,
    jump: Option<ExpressionPlant>,
    inputs: usize,
    outputs: usize,
}

impl ExpressionObserver {
    /// The observer with g and k as the rows f and h of `flow`, and j as the rows h of `start`, for a plant with these
    /// numbers of inputs and outputs.
    ///
    /// # Errors
    /// [`PlantError::DimensionMismatch`] for sizes that do not fit.
    pub fn new(
        flow: ExpressionPlant,
        start: ExpressionPlant,
        (inputs, outputs): (usize, usize),
    ) -> Result<Self, PlantError> {
        let (size, first) = (flow.dimensions(), start.dimensions());
        for (what, expected, found) in [
            ("(u, y)", inputs + outputs, size.inputs),
            ("y of the start", outputs, first.inputs),
            ("xhat of the start", size.outputs, first.states),
            ("z of the start", size.states, first.outputs),
        ] {
            if expected != found {
                return Err(PlantError::DimensionMismatch { what, expected: (expected, 1), found: (found, 1) });
            }
        }
        Ok(Self { flow, start, jump: None, inputs, outputs })
    }

    /// The same whose state jumps at every sample, to the rows h of `jump`.
    ///
    /// # Errors
    /// [`PlantError::DimensionMismatch`] for sizes that are not those of the observer.
    pub fn with_jump(self, jump: ExpressionPlant) -> Result<Self, PlantError> {
        let (size, own) = (jump.dimensions(), self.flow.dimensions());
        for (what, expected, found) in [
            ("z of the jump", own.states, size.states),
            ("(u, y) of the jump", own.inputs, size.inputs),
            ("z after the jump", own.states, size.outputs),
        ] {
            if expected != found {
                return Err(PlantError::DimensionMismatch { what, expected: (expected, 1), found: (found, 1) });
            }
        }
        Ok(Self { jump: Some(jump), ..self })
    }

    /// `dg/dz` at a point.
    pub fn jacobian(&self, t: f64, z: &DVector<f64>, u: &DVector<f64>, y: &DVector<f64>) -> DMatrix<f64> {
        self.flow.state_jacobian(t, z, &joined(u, y))
    }

    /// g, k and j as straight-line code.
    pub(crate) fn routines(&self) -> ExtensionMaps {
        let flow = self.flow.routines();
        let jump = self.jump.as_ref().map(|jump| jump.routines().h);
        ExtensionMaps { rate: flow.f, estimate: flow.h, start: self.start.routines().h, jump }
    }
}

/// g, k and j as straight-line code.
#[derive(Debug, Clone)]
pub(crate) struct ExtensionMaps {
    pub(crate) rate: Routine,
    pub(crate) estimate: Routine,
    pub(crate) start: Routine,
    /// The jump at a sample.
    pub(crate) jump: Option<Routine>,
}

impl ExtensionMaps {
    /// All of them.
    pub(crate) fn all(&self) -> impl Iterator<Item = &Routine> + Clone {
        [&self.rate, &self.estimate, &self.start].into_iter().chain(&self.jump)
    }
}

fn joined<T: RealField + Copy>(u: &DVector<T>, y: &DVector<T>) -> DVector<T> {
    DVector::from_iterator(u.len() + y.len(), u.iter().chain(y.iter()).copied())
}

impl<T: RealField + Copy> Observer<T> for ExpressionObserver {
    type State = DVector<T>;
    type Input = DVector<T>;
    type Output = DVector<T>;
    type Estimate = DVector<T>;

    fn dimensions(&self) -> ObserverDimensions {
        let size = self.flow.dimensions();
        let (inputs, outputs) = (self.inputs, self.outputs);
        ObserverDimensions { state: size.states, inputs, outputs, estimate: size.outputs }
    }

    fn derivative(&self, t: T, z: &DVector<T>, u: &DVector<T>, y: &DVector<T>) -> DVector<T> {
        self.flow.derivative(t, z, &joined(u, y))
    }

    fn estimate(&self, t: T, z: &DVector<T>, u: &DVector<T>, y: &DVector<T>) -> DVector<T> {
        self.flow.output(t, z, &joined(u, y))
    }

    fn jump(&self, t: T, z: &DVector<T>, u: &DVector<T>, y: &DVector<T>) -> DVector<T> {
        self.jump.as_ref().map_or_else(|| z.clone(), |jump| jump.output(t, z, &joined(u, y)))
    }

    fn initial(&self, t: T, estimate: &DVector<T>, _u: &DVector<T>, y: &DVector<T>) -> DVector<T> {
        self.start.output(t, estimate, y)
    }
}
