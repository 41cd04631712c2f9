//! An observer of a plant in discrete time whose equations are those of an observer in continuous time, with the next
//! state in the place of the derivative:
//!
//! ```text
//! z+ = g(z, u, y),    xhat(k) = k(z(k), u(k), y(k))
//! ```
//!
//! Observers of lower order and unknown-input observers have the same equations in both times: of `w = T x` the right
//! side `F w + G y + H u` is the derivative, or the next value. The estimate at a sample uses the measurement of that
//! sample. Before it, the estimate is the prediction `A xhat + B u` of the plant from the last one, or the last one
//! itself. g and k must not depend on the time.
//!
//! The state is z with this estimate behind it.

use core::marker::PhantomData;

use luenberger_plants::error::check_matrix;
use luenberger_plants::{Column, LinearPlant, Plant, PlantError, Size};
use nalgebra::allocator::Allocator;
use nalgebra::{Const, DefaultAllocator, Dim, OVector, RealField};

use crate::error::ObserverError;
use crate::observer::{Observer, ObserverDimensions, SampledObserver};

/// The observer with the equations of `O` in discrete time, an estimate of length N, M inputs and P outputs. The state
/// of `O` has the length Z, that of this one D = Z + N; see the [module](self).
#[derive(Clone, Debug, PartialEq)]
pub struct DiscreteForm<O, T: RealField + Copy, Z: Dim, N: Dim, M: Dim, P: Dim, D>
where
    DefaultAllocator: Size<N, M, P> + Allocator<Z>,
{
    observer: O,
    period: T,
    between: Between<T, Z, N, M, P>,
    length: PhantomData<D>,
}

/// What gives the estimate before its measurement.
#[derive(Clone, Debug, PartialEq)]
enum Between<T: RealField + Copy, Z: Dim, N: Dim, M: Dim, P: Dim>
where
    DefaultAllocator: Size<N, M, P> + Allocator<Z>,
{
    /// The plant, from the last estimate.
    Predicted(LinearPlant<T, N, M, P>),
    /// The last estimate; z at the start.
    Held(OVector<T, Z>),
}

/// An observer in discrete time whose sizes are known at compile time; D is Z + N.
pub type StaticDiscreteForm<O, T, const Z: usize, const N: usize, const M: usize, const P: usize, const D: usize> =
    DiscreteForm<O, T, Const<Z>, Const<N>, Const<M>, Const<P>, Const<D>>;

impl<O, T: RealField + Copy, Z: Dim, N: Dim, M: Dim, P: Dim, D: Dim> DiscreteForm<O, T, Z, N, M, P, D>
where
    O: Observer<T, Input = OVector<T, M>, Output = OVector<T, P>, Estimate = OVector<T, N>>,
    DefaultAllocator: Size<N, M, P> + Allocator<Z> + Allocator<D>,
{
    /// An observer of the state of `plant`, `x+ = A x + B u`, `y = C x + D u`, which predicts. It starts with the
    /// output that the first estimate predicts.
    ///
    /// ```
    /// use luenberger_observers::{LinearObserver, SampledObserver, StaticDiscreteForm, UnknownInputObserver};
    /// use luenberger_plants::StaticPlant;
    /// use nalgebra::{Matrix2, RowVector2, SMatrix, Vector1, Vector2, vector};
    /// // x1+ = x2/2 + d, x2+ = x2/4, y = x1: H = (1, 0), T = diag(0, 1), TA = [0 0; 0 1/4], L = 0.
    /// let (a, c) = (Matrix2::new(0.0, 0.5, 0.0, 0.25), RowVector2::new(1.0, 0.0));
    /// let none = SMatrix::<f64, 2, 0>::zeros();
    /// let inner = LinearObserver::new(Matrix2::new(0.0, 0.0, 0.0, 0.25), none, c, Vector2::zeros())?;
    /// let of_x2 = UnknownInputObserver::new(inner, Vector2::new(1.0, 0.0), None)?;
    /// let plant = StaticPlant::new(a, none, c)?;
    /// let observer = StaticDiscreteForm::<_, f64, 2, 2, 0, 1, 4>::predicting(of_x2, plant, 0.1)?;
    /// let (u, y) = (SMatrix::zeros(), Vector1::new(7.0));
    /// let mut state = observer.initial(0.0, &vector![1.0, 8.0], &u, &y);
    /// assert_eq!(observer.estimate_at(&state, &u, &y), vector![7.0, 8.0]);
    /// observer.step(0.0, &mut state, &u, &y);
    /// // The prediction A xhat, to which the next d adds.
    /// assert_eq!(observer.estimate(&state), vector![4.0, 2.0]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    /// # Errors
    /// [`ObserverError::Matrix`]: sizes that do not fit, entries that are not finite; [`ObserverError::Period`].
    pub fn predicting(observer: O, plant: LinearPlant<T, N, M, P>, period: T) -> Result<Self, ObserverError> {
        let (plant, size) = (plant.checked()?, observer.dimensions());
        let of_plant =
            [("the estimate", plant.a.nrows(), size.estimate), ("u of the observer", plant.b.ncols(), size.inputs)];
        fit(of_plant.into_iter().chain([("y of the observer", plant.c.nrows(), size.outputs)]))?;
        Self::new(observer, period, Between::Predicted(plant))
    }

    /// An observer whose estimate stands still between two samples, as that of functions of the state, which starts at
    /// `first`.
    ///
    /// # Errors
    /// [`ObserverError::Matrix`]: sizes that do not fit, entries that are not finite; [`ObserverError::Period`].
    pub fn holding(observer: O, first: OVector<T, Z>, period: T) -> Result<Self, ObserverError> {
        check_matrix("z(0)", &first, (observer.dimensions().state, 1))?;
        Self::new(observer, period, Between::Held(first))
    }

    fn new(observer: O, period: T, between: Between<T, Z, N, M, P>) -> Result<Self, ObserverError> {
        let ObserverDimensions { state, estimate, .. } = observer.dimensions();
        let all = state + estimate;
        fit([
            ("z", state, Z::try_to_usize().unwrap_or(state)),
            ("z of the observer", state, O::State::fixed_len().unwrap_or(state)),
            ("z with the estimate", all, D::try_to_usize().unwrap_or(all)),
        ])?;
        if !(period.is_finite() && period > T::zero()) {
            return Err(ObserverError::Period { period: period.to_subset_unchecked() });
        }
        Ok(Self { observer, period, between, length: PhantomData })
    }

    /// The observer in continuous time with these equations.
    pub fn observer(&self) -> &O {
        &self.observer
    }

    /// z at the start, of one whose estimate stands still between two samples.
    pub fn first(&self) -> Option<&OVector<T, Z>> {
        if let Between::Held(first) = &self.between { Some(first) } else { None }
    }

    /// z of a state.
    fn own(&self, state: &OVector<T, D>) -> O::State {
        O::State::from_slice(&state.as_slice()[..self.observer.dimensions().state])
    }

    /// z with the estimate behind it.
    fn joined(z: &[T], xhat: &OVector<T, N>) -> OVector<T, D> {
        let entries = z.iter().chain(xhat.iter()).copied();
        OVector::from_iterator_generic(D::from_usize(z.len() + xhat.len()), Const, entries)
    }
}

/// Lengths that agree.
fn fit(lengths: impl IntoIterator<Item = (&'static str, usize, usize)>) -> Result<(), ObserverError> {
    match lengths.into_iter().find(|(_, expected, found)| expected != found) {
        Some((what, expected, found)) => {
            Err(PlantError::DimensionMismatch { what, expected: (expected, 1), found: (found, 1) }.into())
        }
        None => Ok(()),
    }
}

impl<O, T: RealField + Copy, Z: Dim, N: Dim, M: Dim, P: Dim, D: Dim> SampledObserver<T>
    for DiscreteForm<O, T, Z, N, M, P, D>
where
    O: Observer<T, Input = OVector<T, M>, Output = OVector<T, P>, Estimate = OVector<T, N>>,
    DefaultAllocator: Size<N, M, P> + Allocator<Z> + Allocator<D>,
{
    type State = OVector<T, D>;
    type Input = OVector<T, M>;
    type Output = OVector<T, P>;
    type Estimate = OVector<T, N>;

    fn dimensions(&self) -> ObserverDimensions {
        let own = self.observer.dimensions();
        ObserverDimensions { state: own.state + own.estimate, ..own }
    }

    fn period(&self) -> T {
        self.period
    }

    fn step(&self, t: T, state: &mut Self::State, u: &Self::Input, y: &Self::Output) {
        let z = self.own(state);
        let next = self.observer.derivative(t, &z, u, y);
        let xhat = self.observer.estimate(t, &z, u, y);
        let before = match &self.between {
            Between::Predicted(plant) => plant.derivative(t, &xhat, u),
            Between::Held(_) => xhat,
        };
        *state = Self::joined(next.as_slice(), &before);
    }

    fn estimate(&self, state: &Self::State) -> Self::Estimate {
        <OVector<T, N> as Column<T>>::from_slice(&state.as_slice()[self.observer.dimensions().state..])
    }

    fn estimate_at(&self, state: &Self::State, u: &Self::Input, y: &Self::Output) -> Self::Estimate {
        self.observer.estimate(T::zero(), &self.own(state), u, y)
    }

    fn is_filter(&self) -> bool {
        true
    }

    fn initial(&self, t: T, estimate: &Self::Estimate, u: &Self::Input, _y: &Self::Output) -> Self::State {
        match &self.between {
            Between::Predicted(plant) => {
                let y = plant.output(t, estimate, u);
                Self::joined(self.observer.initial(t, estimate, u, &y).as_slice(), estimate)
            }
            Between::Held(first) => Self::joined(first.as_slice(), estimate),
        }
    }
}
