//! The traits of run-time observers.
//!
//! The state of an observer need not be the estimate: a Kalman filter carries a covariance, a
//! parameter-estimation-based observer carries filters and parameters. The estimate is read from the state, and may use
//! the present input and output as well. It need not be the whole plant state either: an observer of the unmeasured
//! states has a shorter estimate.

use luenberger_plants::Column;
use nalgebra::Dim;

/// Lengths of the columns an observer works with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ObserverDimensions {
    /// Length of the observer's own state.
    pub state: usize,
    /// Number of inputs, m.
    pub inputs: usize,
    /// Number of measured outputs, p.
    pub outputs: usize,
    /// Length of the estimate: n, or less when only some states are estimated.
    pub estimate: usize,
}

impl ObserverDimensions {
    /// The lengths of columns of these types.
    pub(crate) fn of<Z: Dim, M: Dim, P: Dim, N: Dim>() -> Self {
        Self { state: length::<Z>(), inputs: length::<M>(), outputs: length::<P>(), estimate: length::<N>() }
    }
}

/// The length of columns of a type.
pub(crate) fn length<D: Dim>() -> usize {
    let length = D::try_to_usize();
    debug_assert!(length.is_some(), "a map of dynamic lengths has to say them");
    length.unwrap_or(0)
}

/// An observer in continuous time: `z' = g(t, z, u, y)`, `xhat = k(t, z, u, y)`.
///
/// Nothing here returns an error, allocates (with static sizes) or panics: what can be wrong is found by the
/// constructors. Columns of dynamic length must have the lengths that [`dimensions`](Self::dimensions) says.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not an observer in continuous time over the scalar `{T}`",
    note = "implement `Observer<T>` for every `T: RealField + Copy`, or for the scalar that is used",
    note = "`SampledObserver<T>` is the trait of observers stepped once per sample: in a simulation or a replay of a log use `sampled_observer` in place of `observer`"
)]
pub trait Observer<T> {
    /// Column of the observer's own state, z.
    type State: Column<T>;
    /// Column of the inputs, u.
    type Input: Column<T>;
    /// Column of the measured outputs, y.
    type Output: Column<T>;
    /// Column of the estimate, xhat.
    type Estimate: Column<T>;

    /// Lengths of the columns.
    fn dimensions(&self) -> ObserverDimensions;

    /// `g(t, z, u, y)`, the right-hand side.
    fn derivative(&self, t: T, state: &Self::State, u: &Self::Input, y: &Self::Output) -> Self::State;

    /// `k(t, z, u, y)`, the estimate.
    fn estimate(&self, t: T, state: &Self::State, u: &Self::Input, y: &Self::Output) -> Self::Estimate;

    /// The initial state for which the estimate at time `t` is `estimate`; filters of the output start at `y`,
    /// covariances at their initial value.
    fn initial(&self, t: T, estimate: &Self::Estimate, u: &Self::Input, y: &Self::Output) -> Self::State;

    /// The time from one jump of the state to the next, the first after the start of a run; none for an observer whose
    /// state does not jump (default).
    fn jump_period(&self) -> Option<T> {
        None
    }

    /// The state after a jump at time `t`. A sampled form takes it at every sample.
    fn jump(&self, t: T, state: &Self::State, u: &Self::Input, y: &Self::Output) -> Self::State {
        let _ = (t, u, y);
        state.clone()
    }

    /// Whether g is affine in z, u and y and does not depend on t; simulation then uses the exact solution. Return
    /// false (default) if this is not known.
    fn is_affine(&self) -> bool {
        false
    }

    /// [`derivative`](Self::derivative) on slices, with the same result to the last bit: what simulation calls. Returns
    /// whether the lengths fit; otherwise `slope` is not written.
    ///
    /// The default makes columns and copies; override it for columns of dynamic length to avoid their allocation.
    fn derivative_into(&self, t: T, state: &[T], u: &[T], y: &[T], slope: &mut [T]) -> bool
    where
        T: Copy,
    {
        let columns = (Column::try_from_slice(state), Column::try_from_slice(u), Column::try_from_slice(y));
        let (Some(state), Some(u), Some(y)) = columns else { return false };
        put(&self.derivative(t, &state, &u, &y), slope)
    }

    /// [`estimate`](Self::estimate) on slices, as [`derivative_into`](Self::derivative_into).
    fn estimate_into(&self, t: T, state: &[T], u: &[T], y: &[T], estimate: &mut [T]) -> bool
    where
        T: Copy,
    {
        let columns = (Column::try_from_slice(state), Column::try_from_slice(u), Column::try_from_slice(y));
        let (Some(state), Some(u), Some(y)) = columns else { return false };
        put(&self.estimate(t, &state, &u, &y), estimate)
    }
}

/// Copies a column out; whether its length fits.
fn put<T: Copy>(column: &impl Column<T>, target: &mut [T]) -> bool {
    put_slice(column.as_slice(), target)
}

/// Copies entries out; whether their number fits.
pub(crate) fn put_slice<T: Copy>(entries: &[T], target: &mut [T]) -> bool {
    let fits = entries.len() == target.len();
    if fits {
        target.copy_from_slice(entries);
    }
    fits
}

/// The columns, the estimate and the initial state of an [`Observer`] or a [`SampledObserver`] over `T` whose state is
/// its estimate, with `N` states, `M` inputs and `P` outputs.
macro_rules! state_is_estimate {
    (Observer) => {
        crate::observer::state_is_estimate! { @ }

        fn estimate(&self, _t: T, xhat: &Self::State, _u: &Self::Input, _y: &Self::Output) -> Self::Estimate {
            xhat.clone()
        }

        fn estimate_into(&self, _t: T, xhat: &[T], _u: &[T], _y: &[T], estimate: &mut [T]) -> bool {
            crate::observer::put_slice(xhat, estimate)
        }
    };
    (SampledObserver) => {
        crate::observer::state_is_estimate! { @ }

        fn estimate(&self, xhat: &Self::State) -> Self::Estimate {
            xhat.clone()
        }
    };
    (@) => {
        type State = nalgebra::OVector<T, N>;
        type Input = nalgebra::OVector<T, M>;
        type Output = nalgebra::OVector<T, P>;
        type Estimate = nalgebra::OVector<T, N>;

        fn initial(&self, _t: T, estimate: &Self::Estimate, _u: &Self::Input, _y: &Self::Output) -> Self::State {
            estimate.clone()
        }
    };
}

pub(crate) use state_is_estimate;

/// Whether a column has as many rows as the observer says; nothing to check where the type has its length.
pub(crate) fn has_rows<D: Dim>(rows: usize, stated: impl FnOnce() -> usize) -> bool {
    D::try_to_usize().is_some() || rows == stated()
}

/// An observer that predicts in continuous time, and is corrected at samples that arrive at any times.
///
/// As an [`Observer`] it is the prediction: its derivative does not read y. The time between two samples may vary.
pub trait ContinuousDiscreteObserver<T>: Observer<T> {
    /// The correction by the sample `y`, in place; `elapsed` is the time since the last sample that arrived. An output
    /// that is NaN was not measured; at least one was.
    fn correct(&self, state: &mut Self::State, u: &Self::Input, y: &Self::Output, elapsed: T);
}

impl<T, O: ContinuousDiscreteObserver<T> + ?Sized> ContinuousDiscreteObserver<T> for &O {
    fn correct(&self, state: &mut Self::State, u: &Self::Input, y: &Self::Output, elapsed: T) {
        (**self).correct(state, u, y, elapsed);
    }
}

/// An observer stepped once per sample: `z+ = g(t, z, u, y)`.
///
/// At the time `t` of a sample the state holds what is known *before* that sample; [`step`](Self::step) takes the
/// sample `y = y(t)` and the input `u` held until `t + h`, and leaves what is known before the next one: a predictor,
/// whose result is needed at `t + h` only, so that the target has a whole period to compute it. An observer in filter
/// form also has an estimate that uses the measurement of the sample, [`estimate_at`](Self::estimate_at).
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a sampled observer over the scalar `{T}`",
    note = "implement `SampledObserver<T>` for every `T: RealField + Copy`, or for the scalar that is used",
    note = "`Observer<T>` is the trait of observers in continuous time"
)]
pub trait SampledObserver<T> {
    /// Column of the observer's own state, z.
    type State: Column<T>;
    /// Column of the inputs, u.
    type Input: Column<T>;
    /// Column of the measured outputs, y.
    type Output: Column<T>;
    /// Column of the estimate, xhat.
    type Estimate: Column<T>;

    /// Lengths of the columns.
    fn dimensions(&self) -> ObserverDimensions;

    /// The sampling period h.
    fn period(&self) -> T;

    /// From the sample at `t` to the estimate at `t + h`, in place.
    fn step(&self, t: T, state: &mut Self::State, u: &Self::Input, y: &Self::Output);

    /// As [`step`](Self::step), of a sample of which only the outputs with true in `measured` were measured. The caller
    /// sets the others to their predictions from the estimate.
    ///
    /// A filter with a covariance takes the outputs that were measured, and does not read the others; a linear, a cubic
    /// observer and a copy of the plant with a constant gain leave them out of the correction, as those that are not
    /// finite in [`step`](Self::step). In the others the predicted output takes the place of a missing one.
    fn step_partial(&self, t: T, state: &mut Self::State, u: &Self::Input, y: &Self::Output, measured: &[bool]) {
        let _ = measured;
        self.step(t, state, u, y);
    }

    /// [`step`](Self::step), or [`step_partial`](Self::step_partial) if one of `measured` is false, on slices, with the
    /// same result to the last bit: what simulation calls. Returns whether the lengths fit; otherwise `state` is not
    /// written.
    fn step_into(&self, t: T, state: &mut [T], u: &[T], y: &[T], measured: &[bool]) -> bool
    where
        T: Copy,
    {
        step_columns(self, t, state, (u, y), measured)
    }

    /// [`estimate`](Self::estimate) on slices, as [`step_into`](Self::step_into).
    fn estimate_into(&self, state: &[T], estimate: &mut [T]) -> bool
    where
        T: Copy,
    {
        Column::try_from_slice(state).is_some_and(|state| put(&self.estimate(&state), estimate))
    }

    /// The estimate that the state holds.
    fn estimate(&self, state: &Self::State) -> Self::Estimate;

    /// The estimate at a sample with its measurement `y` and its input `u`, for the state before that sample: the same
    /// as [`estimate`](Self::estimate) but for observers in filter form.
    fn estimate_at(&self, state: &Self::State, u: &Self::Input, y: &Self::Output) -> Self::Estimate {
        let _ = (u, y);
        self.estimate(state)
    }

    /// As [`estimate_at`](Self::estimate_at), of a sample of which only the outputs with true in `measured` were
    /// measured; the others as in [`step_partial`](Self::step_partial).
    fn estimate_at_partial(
        &self,
        state: &Self::State,
        u: &Self::Input,
        y: &Self::Output,
        measured: &[bool],
    ) -> Self::Estimate {
        let _ = measured;
        self.estimate_at(state, u, y)
    }

    /// The update of a filter whose [`step`](Self::step) is an update and a prediction, on slices: what the state holds
    /// *after* the sample, with the outputs that are true in `measured`, none for all. Returns whether there is such a
    /// state; otherwise (default) `state` is not written.
    fn update_into(&self, t: T, state: &mut [T], u: &[T], y: &[T], measured: &[bool]) -> bool
    where
        T: Copy,
    {
        let _ = (t, state, u, y, measured);
        false
    }

    /// The rest of a step after [`update_into`](Self::update_into): the prediction over the period, on slices. For a
    /// filter whose update is most of its step, so that a simulation does not compute it twice. Returns whether it was
    /// done; otherwise (default) `state` is not written.
    fn predict_into(&self, t: T, state: &mut [T], u: &[T]) -> bool
    where
        T: Copy,
    {
        let _ = (t, state, u);
        false
    }

    /// Whether [`estimate_at`](Self::estimate_at) uses the measurement.
    fn is_filter(&self) -> bool {
        false
    }

    /// The initial state for which the estimate at time `t` is `estimate`.
    fn initial(&self, t: T, estimate: &Self::Estimate, u: &Self::Input, y: &Self::Output) -> Self::State;
}

/// [`SampledObserver::step_into`] by columns that are made and copied.
pub(crate) fn step_columns<T: Copy, O: SampledObserver<T> + ?Sized>(
    observer: &O,
    t: T,
    state: &mut [T],
    (u, y): (&[T], &[T]),
    measured: &[bool],
) -> bool {
    let size = observer.dimensions();
    if (state.len(), u.len(), y.len()) != (size.state, size.inputs, size.outputs) {
        return false;
    }
    let columns = (O::State::try_from_slice(state), Column::try_from_slice(u), Column::try_from_slice(y));
    let (Some(mut next), Some(u), Some(y)) = columns else { return false };
    if measured.contains(&false) {
        observer.step_partial(t, &mut next, &u, &y, measured);
    } else {
        observer.step(t, &mut next, &u, &y);
    }
    put(&next, state)
}

impl<T, O: Observer<T> + ?Sized> Observer<T> for &O {
    type State = O::State;
    type Input = O::Input;
    type Output = O::Output;
    type Estimate = O::Estimate;

    fn jump_period(&self) -> Option<T> {
        (**self).jump_period()
    }

    fn jump(&self, t: T, state: &Self::State, u: &Self::Input, y: &Self::Output) -> Self::State {
        (**self).jump(t, state, u, y)
    }

    fn dimensions(&self) -> ObserverDimensions {
        (**self).dimensions()
    }

    fn derivative(&self, t: T, state: &Self::State, u: &Self::Input, y: &Self::Output) -> Self::State {
        (**self).derivative(t, state, u, y)
    }

    fn estimate(&self, t: T, state: &Self::State, u: &Self::Input, y: &Self::Output) -> Self::Estimate {
        (**self).estimate(t, state, u, y)
    }

    fn initial(&self, t: T, estimate: &Self::Estimate, u: &Self::Input, y: &Self::Output) -> Self::State {
        (**self).initial(t, estimate, u, y)
    }

    fn is_affine(&self) -> bool {
        (**self).is_affine()
    }

    fn derivative_into(&self, t: T, state: &[T], u: &[T], y: &[T], slope: &mut [T]) -> bool
    where
        T: Copy,
    {
        (**self).derivative_into(t, state, u, y, slope)
    }

    fn estimate_into(&self, t: T, state: &[T], u: &[T], y: &[T], estimate: &mut [T]) -> bool
    where
        T: Copy,
    {
        (**self).estimate_into(t, state, u, y, estimate)
    }
}

impl<T, O: SampledObserver<T> + ?Sized> SampledObserver<T> for &O {
    type State = O::State;
    type Input = O::Input;
    type Output = O::Output;
    type Estimate = O::Estimate;

    fn dimensions(&self) -> ObserverDimensions {
        (**self).dimensions()
    }

    fn period(&self) -> T {
        (**self).period()
    }

    fn step(&self, t: T, state: &mut Self::State, u: &Self::Input, y: &Self::Output) {
        (**self).step(t, state, u, y);
    }

    fn step_partial(&self, t: T, state: &mut Self::State, u: &Self::Input, y: &Self::Output, measured: &[bool]) {
        (**self).step_partial(t, state, u, y, measured);
    }

    fn step_into(&self, t: T, state: &mut [T], u: &[T], y: &[T], measured: &[bool]) -> bool
    where
        T: Copy,
    {
        (**self).step_into(t, state, u, y, measured)
    }

    fn estimate(&self, state: &Self::State) -> Self::Estimate {
        (**self).estimate(state)
    }

    fn estimate_at(&self, state: &Self::State, u: &Self::Input, y: &Self::Output) -> Self::Estimate {
        (**self).estimate_at(state, u, y)
    }

    fn estimate_at_partial(
        &self,
        state: &Self::State,
        u: &Self::Input,
        y: &Self::Output,
        measured: &[bool],
    ) -> Self::Estimate {
        (**self).estimate_at_partial(state, u, y, measured)
    }

    fn update_into(&self, t: T, state: &mut [T], u: &[T], y: &[T], measured: &[bool]) -> bool
    where
        T: Copy,
    {
        (**self).update_into(t, state, u, y, measured)
    }

    fn predict_into(&self, t: T, state: &mut [T], u: &[T]) -> bool
    where
        T: Copy,
    {
        (**self).predict_into(t, state, u)
    }

    fn is_filter(&self) -> bool {
        (**self).is_filter()
    }

    fn estimate_into(&self, state: &[T], estimate: &mut [T]) -> bool
    where
        T: Copy,
    {
        (**self).estimate_into(state, estimate)
    }

    fn initial(&self, t: T, estimate: &Self::Estimate, u: &Self::Input, y: &Self::Output) -> Self::State {
        (**self).initial(t, estimate, u, y)
    }
}
