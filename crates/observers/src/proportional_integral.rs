//! Proportional-integral observer: a constant or slowly varying disturbance is estimated with the state.
//!
//! The plant `x' = A x + B u + E d`, `y = C x + D u` with `d' = 0` is the plant with the state `(x, d)` and the
//! matrices `[A E; 0 0]`, `[B; 0]`, `[C 0]`. A linear or a cubic observer of it has the estimates xhat and dhat: dhat
//! is the integral of the output error, hence the name. Which observer it is, the type O says; this one hands out xhat
//! as the estimate, and keeps dhat in its state. In discrete time, `x+ = A x + B u + E d` with `d+ = d`, O is an
//! observer for samples, and dhat the sum of the output errors.

use nalgebra::allocator::Allocator;
use nalgebra::{Const, DefaultAllocator, Dim, OVector, RealField};

use crate::dense::copy;
use crate::error::ObserverError;
use crate::observer::{Observer, ObserverDimensions, SampledObserver, put_slice};

/// The observer `O` of the state and the disturbance, of which the first N entries are the estimate.
///
/// ```
/// use luenberger_observers::{LinearObserver, Observer, ProportionalIntegralObserver};
/// use nalgebra::{Const, Matrix3, RowVector3, Vector1, Vector2, Vector3};
/// // A double integrator with a constant force: x1' = x2, x2' = u + d, d' = 0.
/// let a = Matrix3::new(0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0);
/// let inner = LinearObserver::new(a, Vector3::new(0.0, 1.0, 0.0), RowVector3::new(1.0, 0.0, 0.0), Vector3::new(6.0, 11.0, 6.0))?;
/// let observer = ProportionalIntegralObserver::new(inner, Const::<2>)?;
/// let state = observer.initial(0.0, &Vector2::new(1.0, 2.0), &Vector1::zeros(), &Vector1::new(1.0));
/// assert_eq!(state, Vector3::new(1.0, 2.0, 0.0));
/// assert_eq!(observer.estimate(0.0, &state, &Vector1::zeros(), &Vector1::zeros()), Vector2::new(1.0, 2.0));
/// assert_eq!(observer.disturbance(&[1.0, 2.0, 3.0]), [3.0]);
/// # Ok::<(), luenberger_observers::ObserverError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct ProportionalIntegralObserver<O, N: Dim> {
    inner: O,
    states: N,
}

/// A proportional-integral observer whose number of states is known at compile time; the other sizes are those of `O`.
pub type StaticProportionalIntegralObserver<O, const N: usize> = ProportionalIntegralObserver<O, Const<N>>;

impl<O, N: Dim> ProportionalIntegralObserver<O, N> {
    /// `inner` of the state and the disturbance, the first `states` entries being the state.
    ///
    /// # Errors
    /// [`ObserverError::Matrix`] if `inner` has fewer states.
    pub fn new<T>(inner: O, states: N) -> Result<Self, ObserverError>
    where
        O: Observer<T>,
    {
        let found = inner.dimensions().estimate;
        Self::of_order(inner, found, states)
    }

    /// The same in discrete time.
    ///
    /// ```
    /// use luenberger_observers::{DiscreteLinearObserver, ProportionalIntegralObserver, SampledObserver};
    /// use luenberger_plants::StaticPlant;
    /// use nalgebra::{Const, Matrix2, RowVector2, Vector1, Vector2};
    /// // x+ = x/2 + d, d+ = d; both poles at zero.
    /// let plant = StaticPlant::new(Matrix2::new(0.5, 1.0, 0.0, 1.0), Vector2::new(1.0, 0.0), RowVector2::new(1.0, 0.0))?;
    /// let inner = DiscreteLinearObserver::new(plant, Vector2::new(1.5, 1.0), 0.1)?;
    /// let observer = ProportionalIntegralObserver::of_samples(inner, Const::<1>)?;
    /// let mut state = observer.initial(0.0, &Vector1::new(4.0), &Vector1::zeros(), &Vector1::new(4.0));
    /// observer.step(0.0, &mut state, &Vector1::new(1.0), &Vector1::new(4.0));
    /// assert_eq!((observer.estimate(&state), observer.disturbance(state.as_slice())), (Vector1::new(3.0), &[0.0][..]));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    /// # Errors
    /// As [`new`](Self::new).
    pub fn of_samples<T>(inner: O, states: N) -> Result<Self, ObserverError>
    where
        O: SampledObserver<T>,
    {
        let found = inner.dimensions().estimate;
        Self::of_order(inner, found, states)
    }

    fn of_order(inner: O, found: usize, states: N) -> Result<Self, ObserverError> {
        let expected = states.value();
        if found < expected {
            let (expected, found) = ((expected, 1), (found, 1));
            let what = "the state and the disturbance";
            return Err(luenberger_plants::PlantError::DimensionMismatch { what, expected, found }.into());
        }
        Ok(Self { inner, states })
    }

    /// The observer of the state and the disturbance.
    pub fn inner(&self) -> &O {
        &self.inner
    }

    /// The number of states without the disturbance.
    pub fn states(&self) -> usize {
        self.states.value()
    }

    /// The estimate of the disturbance in a state of this observer.
    pub fn disturbance<'a, T>(&self, state: &'a [T]) -> &'a [T] {
        state.get(self.states.value()..).unwrap_or_default()
    }
}

impl<T, O, N, K, M, P> Observer<T> for ProportionalIntegralObserver<O, N>
where
    T: RealField + Copy,
    O: Observer<T, State = OVector<T, K>, Input = OVector<T, M>, Output = OVector<T, P>, Estimate = OVector<T, K>>,
    N: Dim,
    K: Dim,
    M: Dim,
    P: Dim,
    DefaultAllocator: Allocator<N> + Allocator<K> + Allocator<M> + Allocator<P>,
    OVector<T, N>: luenberger_plants::Column<T>,
{
    type State = OVector<T, K>;
    type Input = OVector<T, M>;
    type Output = OVector<T, P>;
    type Estimate = OVector<T, N>;

    fn dimensions(&self) -> ObserverDimensions {
        ObserverDimensions { estimate: self.states.value(), ..self.inner.dimensions() }
    }

    fn derivative(&self, t: T, state: &Self::State, u: &Self::Input, y: &Self::Output) -> Self::State {
        self.inner.derivative(t, state, u, y)
    }

    fn derivative_into(&self, t: T, state: &[T], u: &[T], y: &[T], slope: &mut [T]) -> bool {
        self.inner.derivative_into(t, state, u, y, slope)
    }

    fn estimate(&self, _t: T, state: &Self::State, _u: &Self::Input, _y: &Self::Output) -> Self::Estimate {
        let mut estimate = OVector::<T, N>::zeros_generic(self.states, Const);
        copy(state.as_slice(), estimate.as_mut_slice());
        estimate
    }

    fn estimate_into(&self, _t: T, state: &[T], _u: &[T], _y: &[T], estimate: &mut [T]) -> bool {
        state.get(..self.states.value()).is_some_and(|state| put_slice(state, estimate))
    }

    /// The disturbance is estimated to be 0 at the start.
    fn initial(&self, t: T, estimate: &Self::Estimate, u: &Self::Input, y: &Self::Output) -> Self::State {
        let order = K::from_usize(self.inner.dimensions().estimate);
        let mut both = OVector::<T, K>::zeros_generic(order, Const);
        copy(estimate.as_slice(), both.as_mut_slice());
        self.inner.initial(t, &both, u, y)
    }

    fn is_affine(&self) -> bool {
        self.inner.is_affine()
    }
}

impl<T, O, N, K, M, P> SampledObserver<T> for ProportionalIntegralObserver<O, N>
where
    T: RealField + Copy,
    O: SampledObserver<
            T,
            State = OVector<T, K>,
            Input = OVector<T, M>,
            Output = OVector<T, P>,
            Estimate = OVector<T, K>,
        >,
    N: Dim,
    K: Dim,
    M: Dim,
    P: Dim,
    DefaultAllocator: Allocator<N> + Allocator<K> + Allocator<M> + Allocator<P>,
    OVector<T, N>: luenberger_plants::Column<T>,
{
    type State = OVector<T, K>;
    type Input = OVector<T, M>;
    type Output = OVector<T, P>;
    type Estimate = OVector<T, N>;

    fn dimensions(&self) -> ObserverDimensions {
        ObserverDimensions { estimate: self.states.value(), ..self.inner.dimensions() }
    }

    fn period(&self) -> T {
        self.inner.period()
    }

    fn step(&self, t: T, state: &mut Self::State, u: &Self::Input, y: &Self::Output) {
        self.inner.step(t, state, u, y);
    }

    fn step_partial(&self, t: T, state: &mut Self::State, u: &Self::Input, y: &Self::Output, measured: &[bool]) {
        self.inner.step_partial(t, state, u, y, measured);
    }

    fn step_into(&self, t: T, state: &mut [T], u: &[T], y: &[T], measured: &[bool]) -> bool {
        self.inner.step_into(t, state, u, y, measured)
    }

    fn estimate(&self, state: &Self::State) -> Self::Estimate {
        let mut estimate = OVector::<T, N>::zeros_generic(self.states, Const);
        copy(state.as_slice(), estimate.as_mut_slice());
        estimate
    }

    fn estimate_into(&self, state: &[T], estimate: &mut [T]) -> bool {
        state.get(..self.states.value()).is_some_and(|state| put_slice(state, estimate))
    }

    /// The disturbance is estimated to be 0 at the start.
    fn initial(&self, t: T, estimate: &Self::Estimate, u: &Self::Input, y: &Self::Output) -> Self::State {
        let order = K::from_usize(self.inner.dimensions().estimate);
        let mut both = OVector::<T, K>::zeros_generic(order, Const);
        copy(estimate.as_slice(), both.as_mut_slice());
        self.inner.initial(t, &both, u, y)
    }
}
