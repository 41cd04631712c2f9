//! Plants and observers without their sizes: slices in, slices out.
//!
//! A run mixes a static plant with dynamic observers and the other way round. These traits convert at the border and
//! call the very objects that run on the target; there is no second definition of any right-hand side.

use std::fmt;

use luenberger_observers::{ContinuousDiscreteObserver, Observer, ObserverDimensions, SampledObserver};
use luenberger_plants::{Column, Dimensions, Plant};

use crate::error::SimError;
use crate::sample_times::SampleTimes;

/// An owner of a plant or observer, erased behind the traits of this file.
pub(crate) struct Erased<O>(pub(crate) O);

/// A plant of any size.
pub(crate) trait AnyPlant: Send + Sync {
    fn dimensions(&self) -> Dimensions;
    /// Checks that columns of fixed length have the lengths that the dimensions say.
    fn check(&self) -> Result<(), SimError>;
    fn is_affine(&self) -> bool;
    fn derivative(&self, t: f64, x: &[f64], u: &[f64], slope: &mut [f64]);
    fn output(&self, t: f64, x: &[f64], u: &[f64], y: &mut [f64]);
    /// Derivative and output.
    fn motion(&self, t: f64, x: &[f64], u: &[f64], slope: &mut [f64], y: &mut [f64]);
}

impl fmt::Debug for dyn AnyPlant + '_ {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?}", self.dimensions())
    }
}

/// An observer of any kind and size, on slices: what a run simulates. [`Continuous`] and [`Sampled`] make one of every
/// observer of `luenberger-observers`.
///
/// Slices have the lengths of [`dimensions`](Self::dimensions); a result is NaN where they do not fit.
///
/// ```
/// use luenberger_observers::{LinearObserver, SampledNonlinearObserver};
/// use luenberger_plants::double_integrator;
/// use luenberger_sim::{AnyObserver, Continuous, Sampled, Scenario};
/// use nalgebra::Vector2;
/// use std::sync::Arc;
/// let l = Vector2::new(7.0, 10.0);
/// let observers: [(&str, Arc<dyn AnyObserver>); 2] = [
///     ("continuous", Arc::new(Continuous::new(LinearObserver::of(double_integrator(), l)?))),
///     ("sampled", Arc::new(Sampled(SampledNonlinearObserver::new(double_integrator(), l, 0.1, 4)?))),
/// ];
/// let mut scenario = Scenario::new(double_integrator()).initial_state(&[1.0, 0.0]).until(10.0, 2);
/// for (name, observer) in observers {
///     scenario = scenario.any_observer(name, observer, &[0.0, 0.0]);
/// }
/// assert!(scenario.run()?.observers.iter().all(|observer| observer.error.row(1).norm() < 1e-3));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait AnyObserver: Send + Sync {
    /// Lengths of state, input, output and estimate.
    fn dimensions(&self) -> ObserverDimensions;

    /// Checks that columns of fixed length have the lengths that the dimensions say.
    ///
    /// # Errors
    /// [`SimError::Length`].
    fn check(&self) -> Result<(), SimError>;

    /// The sampling period; none in continuous time.
    fn period(&self) -> Option<f64>;

    /// Whether the derivative of an observer in continuous time is affine in state, input and output.
    fn is_affine(&self) -> bool;

    /// The derivative of the state in continuous time; 0 for a sampled observer.
    fn derivative(&self, t: f64, state: &[f64], u: &[f64], y: &[f64], slope: &mut [f64]);

    /// The step of a sampled observer over its period; nothing in continuous time. `measured` has the outputs that were
    /// measured, none for all; the other entries of `y` are predicted ones.
    fn step(&self, t: f64, state: &mut [f64], u: &[f64], y: &[f64], measured: &[bool]);

    /// The update of a sampled filter by its sample, without the prediction; false, and nothing done, for an observer
    /// without one. `measured` and `y` as in [`step`](Self::step).
    fn update(&self, _t: f64, _state: &mut [f64], _u: &[f64], _y: &[f64], _measured: &[bool]) -> bool {
        false
    }

    /// The prediction after [`update`](Self::update) over the period; false, and nothing done, if only
    /// [`step`](Self::step) has it.
    fn predict(&self, _t: f64, _state: &mut [f64], _u: &[f64]) -> bool {
        false
    }

    /// The estimate that the state holds.
    fn estimate(&self, t: f64, state: &[f64], u: &[f64], y: &[f64], estimate: &mut [f64]);

    /// The state that holds an estimate.
    fn initial(&self, t: f64, estimate: &[f64], u: &[f64], y: &[f64], state: &mut [f64]);

    /// Whether a sampled observer has an estimate with the measurement of its sample.
    fn is_filter(&self) -> bool {
        false
    }

    /// The estimate at a sample with its measurement, in place of the one before it. `measured` and `y` as in
    /// [`step`](Self::step).
    fn correct(&self, _state: &[f64], _u: &[f64], _y: &[f64], _measured: &[bool], _estimate: &mut [f64]) {}

    /// The time between two jumps of the state of an observer in continuous time.
    fn jump_period(&self) -> Option<f64> {
        None
    }

    /// The jump.
    fn jump(&self, _t: f64, _state: &mut [f64], _u: &[f64], _y: &[f64]) {}

    /// The samples that correct an observer in continuous time.
    fn sample_times(&self) -> Option<SampleTimes> {
        None
    }

    /// Whether samples correct an observer in continuous time.
    fn is_corrected(&self) -> bool {
        false
    }

    /// The correction by a sample, so long after the last one.
    fn correct_at(&self, _state: &mut [f64], _u: &[f64], _y: &[f64], _elapsed: f64) {}
}

impl fmt::Debug for dyn AnyObserver + '_ {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Observer").field("dimensions", &self.dimensions()).field("period", &self.period()).finish()
    }
}

/// An observer in continuous time as [`AnyObserver`].
pub struct Continuous<O> {
    observer: O,
    samples: Option<SampleTimes>,
    correction: Option<Correction<O>>,
}

/// The correction by a sample: observer, state, input, output, time since the last sample.
type Correction<O> = fn(&O, &mut [f64], &[f64], &[f64], f64);

impl<O> Continuous<O> {
    /// The observer, with the measurement at all times.
    pub fn new(observer: O) -> Self {
        Self { observer, samples: None, correction: None }
    }

    /// With corrections at samples that are drawn.
    pub fn sampled_at(observer: O, times: SampleTimes) -> Self
    where
        O: ContinuousDiscreteObserver<f64>,
    {
        Self { samples: Some(times), ..Self::corrected(observer) }
    }

    /// With corrections at given samples.
    pub fn corrected(observer: O) -> Self
    where
        O: ContinuousDiscreteObserver<f64>,
    {
        let correct: Correction<O> = |observer, state, u, y, elapsed| {
            let columns = triple::<O::State, O::Input, O::Output>(state, u, y);
            let corrected = columns.map(|(mut z, u, y)| {
                observer.correct(&mut z, &u, &y, elapsed);
                z
            });
            put(corrected, state);
        };
        Self { observer, samples: None, correction: Some(correct) }
    }
}

/// A sampled-data observer as [`AnyObserver`].
pub struct Sampled<O>(pub O);

impl<P: Plant<f64> + Send + Sync> AnyPlant for Erased<P> {
    fn dimensions(&self) -> Dimensions {
        self.0.dimensions()
    }

    fn check(&self) -> Result<(), SimError> {
        let size = self.0.dimensions();
        fixed::<P::State>("the state of the plant", size.states)?;
        fixed::<P::Input>("the input of the plant", size.inputs)?;
        fixed::<P::Output>("the output of the plant", size.outputs)
    }

    fn is_affine(&self) -> bool {
        self.0.is_affine()
    }

    fn derivative(&self, t: f64, x: &[f64], u: &[f64], slope: &mut [f64]) {
        let fits = self.0.derivative_into(t, x, u, slope);
        expect(fits, slope);
    }

    fn output(&self, t: f64, x: &[f64], u: &[f64], y: &mut [f64]) {
        let fits = self.0.output_into(t, x, u, y);
        expect(fits, y);
    }

    fn motion(&self, t: f64, x: &[f64], u: &[f64], slope: &mut [f64], y: &mut [f64]) {
        self.derivative(t, x, u, slope);
        self.output(t, x, u, y);
    }
}

impl<O: Observer<f64> + Send + Sync> AnyObserver for Continuous<O> {
    fn dimensions(&self) -> ObserverDimensions {
        self.observer.dimensions()
    }

    fn check(&self) -> Result<(), SimError> {
        sized::<O::State, O::Input, O::Output, O::Estimate>(self.observer.dimensions())
    }

    fn period(&self) -> Option<f64> {
        None
    }

    fn is_affine(&self) -> bool {
        self.observer.is_affine()
    }

    fn derivative(&self, t: f64, state: &[f64], u: &[f64], y: &[f64], slope: &mut [f64]) {
        let fits = self.observer.derivative_into(t, state, u, y, slope);
        expect(fits, slope);
    }

    fn step(&self, _t: f64, _state: &mut [f64], _u: &[f64], _y: &[f64], _measured: &[bool]) {}

    fn estimate(&self, t: f64, state: &[f64], u: &[f64], y: &[f64], estimate: &mut [f64]) {
        let fits = self.observer.estimate_into(t, state, u, y, estimate);
        expect(fits, estimate);
    }

    fn initial(&self, t: f64, estimate: &[f64], u: &[f64], y: &[f64], state: &mut [f64]) {
        let columns = triple::<O::Estimate, O::Input, O::Output>(estimate, u, y);
        put(columns.map(|(estimate, u, y)| self.observer.initial(t, &estimate, &u, &y)), state);
    }

    fn jump_period(&self) -> Option<f64> {
        self.observer.jump_period()
    }

    fn jump(&self, t: f64, state: &mut [f64], u: &[f64], y: &[f64]) {
        let columns = triple::<O::State, O::Input, O::Output>(state, u, y);
        put(columns.map(|(z, u, y)| self.observer.jump(t, &z, &u, &y)), state);
    }

    fn sample_times(&self) -> Option<SampleTimes> {
        self.samples
    }

    fn is_corrected(&self) -> bool {
        self.correction.is_some()
    }

    fn correct_at(&self, state: &mut [f64], u: &[f64], y: &[f64], elapsed: f64) {
        if let Some(correct) = self.correction {
            correct(&self.observer, state, u, y, elapsed);
        }
    }
}

impl<O: SampledObserver<f64> + Send + Sync> AnyObserver for Sampled<O> {
    fn dimensions(&self) -> ObserverDimensions {
        self.0.dimensions()
    }

    fn check(&self) -> Result<(), SimError> {
        sized::<O::State, O::Input, O::Output, O::Estimate>(self.0.dimensions())
    }

    fn period(&self) -> Option<f64> {
        Some(self.0.period())
    }

    fn is_affine(&self) -> bool {
        false
    }

    fn derivative(&self, _t: f64, _state: &[f64], _u: &[f64], _y: &[f64], slope: &mut [f64]) {
        slope.fill(0.0);
    }

    fn step(&self, t: f64, state: &mut [f64], u: &[f64], y: &[f64], measured: &[bool]) {
        let fits = self.0.step_into(t, state, u, y, measured);
        expect(fits, state);
    }

    fn estimate(&self, _t: f64, state: &[f64], _u: &[f64], _y: &[f64], estimate: &mut [f64]) {
        let fits = self.0.estimate_into(state, estimate);
        expect(fits, estimate);
    }

    fn update(&self, t: f64, state: &mut [f64], u: &[f64], y: &[f64], measured: &[bool]) -> bool {
        self.0.update_into(t, state, u, y, measured)
    }

    fn predict(&self, t: f64, state: &mut [f64], u: &[f64]) -> bool {
        self.0.predict_into(t, state, u)
    }

    fn is_filter(&self) -> bool {
        self.0.is_filter()
    }

    fn correct(&self, state: &[f64], u: &[f64], y: &[f64], measured: &[bool], estimate: &mut [f64]) {
        if !self.0.is_filter() {
            return;
        }
        let columns = triple::<O::State, O::Input, O::Output>(state, u, y);
        put(columns.map(|(state, u, y)| self.0.estimate_at_partial(&state, &u, &y, measured)), estimate);
    }

    fn initial(&self, t: f64, estimate: &[f64], u: &[f64], y: &[f64], state: &mut [f64]) {
        let columns = triple::<O::Estimate, O::Input, O::Output>(estimate, u, y);
        put(columns.map(|(estimate, u, y)| self.0.initial(t, &estimate, &u, &y)), state);
    }
}

fn column<C: Column<f64>>(entries: &[f64]) -> Option<C> {
    C::try_from_slice(entries)
}

fn triple<A: Column<f64>, B: Column<f64>, C: Column<f64>>(a: &[f64], b: &[f64], c: &[f64]) -> Option<(A, B, C)> {
    Some((column(a)?, column(b)?, column(c)?))
}

/// Lengths have been checked before the run; a plant that changes them on the way gets NaN, which the integrator
/// reports.
#[inline]
fn expect(fits: bool, target: &mut [f64]) {
    if !fits {
        target.fill(f64::NAN);
    }
}

/// Copies a result out, likewise.
fn put<C: Column<f64>>(result: Option<C>, target: &mut [f64]) {
    match result {
        Some(result) if result.as_slice().len() == target.len() => target.copy_from_slice(result.as_slice()),
        _ => target.fill(f64::NAN),
    }
}

/// As [`fixed`], for the columns of an observer: state, input, output and estimate.
pub(crate) fn sized<X, U, Y, E>(size: ObserverDimensions) -> Result<(), SimError>
where
    X: Column<f64>,
    U: Column<f64>,
    Y: Column<f64>,
    E: Column<f64>,
{
    fixed::<X>("the state of an observer", size.state)?;
    fixed::<U>("the input of an observer", size.inputs)?;
    fixed::<Y>("the output an observer reads", size.outputs)?;
    fixed::<E>("the estimate of an observer", size.estimate)
}

/// A column type of fixed length must have the length that is announced.
fn fixed<C: Column<f64>>(what: &str, announced: usize) -> Result<(), SimError> {
    match C::fixed_len() {
        Some(length) if length != announced => {
            Err(SimError::Length { what: what.to_owned(), expected: length, found: announced })
        }
        _ => Ok(()),
    }
}
