//! An observer in continuous time as straight-line code: KKL observers with given maps, [KKL+PEB] observers.
//!
//! Its state z has an equation `z' = g(t, z, u, y)` and the estimate `xhat = k(t, z, u, y)`, of all states of the
//! plant; it starts at `z(0) = j(xhat, y)`. Where the state jumps at samples, it is `z+ = q(t, z, u, y)` after one. The
//! four are recorded from the observer that runs.

use std::sync::Arc;

use luenberger_expression::{ExpressionPlant, Recorded, Recording, RecordingError, Routine};
use luenberger_observers::{InterSampleObserver, Observer, ObserverDimensions};
use luenberger_plants::Column;
use nalgebra::{DMatrix, DVector, Dyn, RealField};

/// The sampled form that is exported.
pub type SampledExtension<T> = InterSampleObserver<ExpressionPlant, RecordedObserver, T, Dyn, Dyn, Dyn, Dyn, Dyn>;

/// A recorded observer; see the [module](self). A copy shares its program.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordedObserver {
    maps: Arc<ExtensionMaps>,
    size: ObserverDimensions,
}

impl RecordedObserver {
    /// The program of `observer`.
    ///
    /// # Errors
    /// [`RecordingError`].
    pub fn new<O>(recording: &mut Recording, observer: &O) -> Result<Self, RecordingError>
    where
        O: Observer<Recorded, Input = DVector<Recorded>, Output = DVector<Recorded>, Estimate = DVector<Recorded>>,
    {
        let size = observer.dimensions();
        let ObserverDimensions { state, inputs, outputs, estimate } = size;
        let z = O::State::from_slice;
        let column = DVector::from_column_slice;
        let known = (state, inputs + outputs);
        let rate = recording.program(known, |t, x, known| {
            let (u, y) = known.split_at(inputs);
            observer.derivative(t, &z(x), &column(u), &column(y)).as_slice().to_vec()
        })?;
        let of_state = recording.program(known, |t, x, known| {
            let (u, y) = known.split_at(inputs);
            observer.estimate(t, &z(x), &column(u), &column(y)).as_slice().to_vec()
        })?;
        // A start is at u = 0.
        let start = recording.program((estimate, outputs), |t, xhat, y| {
            let none = DVector::from_element(inputs, nalgebra::convert(0.0));
            observer.initial(t, &column(xhat), &none, &column(y)).as_slice().to_vec()
        })?;
        let jump = recording.program(known, |t, x, known| {
            let (u, y) = known.split_at(inputs);
            observer.jump(t, &z(x), &column(u), &column(y)).as_slice().to_vec()
        })?;
        let jump = (!jump.is_identity()).then_some(jump);
        Ok(Self { maps: Arc::new(ExtensionMaps { rate, estimate: of_state, start, jump }), size })
    }

    /// `dg/dz` at a point.
    pub fn jacobian(&self, t: f64, z: &DVector<f64>, u: &DVector<f64>, y: &DVector<f64>) -> DMatrix<f64> {
        let order = self.size.state;
        let mut jacobian = DMatrix::zeros(order, order);
        let slopes = self.maps.rate.jacobian(order);
        slopes.evaluate(t, z.as_slice(), &joined(u, y), |k, entry| jacobian[(k / order, k % order)] = entry);
        jacobian
    }

    /// g, k, j and q as straight-line code.
    pub(crate) fn routines(&self) -> &ExtensionMaps {
        &self.maps
    }
}

/// g, k, j and q as straight-line code.
#[derive(Debug, Clone, PartialEq)]
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

/// (u, y).
fn joined<T: Copy>(u: &DVector<T>, y: &DVector<T>) -> Vec<T> {
    u.iter().chain(y.iter()).copied().collect()
}

/// The results of a routine.
pub(crate) fn results<T: RealField + Copy>(routine: &Routine, t: T, x: &[T], known: &[T]) -> DVector<T> {
    let mut out = DVector::zeros(routine.len());
    routine.evaluate(t, x, known, |k, value| out[k] = value);
    out
}

impl<T: RealField + Copy> Observer<T> for RecordedObserver {
    type State = DVector<T>;
    type Input = DVector<T>;
    type Output = DVector<T>;
    type Estimate = DVector<T>;

    fn dimensions(&self) -> ObserverDimensions {
        self.size
    }

    fn derivative(&self, t: T, z: &DVector<T>, u: &DVector<T>, y: &DVector<T>) -> DVector<T> {
        results(&self.maps.rate, t, z.as_slice(), &joined(u, y))
    }

    fn estimate(&self, t: T, z: &DVector<T>, u: &DVector<T>, y: &DVector<T>) -> DVector<T> {
        results(&self.maps.estimate, t, z.as_slice(), &joined(u, y))
    }

    fn jump(&self, t: T, z: &DVector<T>, u: &DVector<T>, y: &DVector<T>) -> DVector<T> {
        self.maps.jump.as_ref().map_or_else(|| z.clone(), |jump| results(jump, t, z.as_slice(), &joined(u, y)))
    }

    fn initial(&self, t: T, estimate: &DVector<T>, _u: &DVector<T>, y: &DVector<T>) -> DVector<T> {
        results(&self.maps.start, t, estimate.as_slice(), y.as_slice())
    }
}
