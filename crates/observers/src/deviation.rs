//! A linear observer of a nonlinear plant, in deviations from an operating point.
//!
//! At an operating point `f(x_0, u_0) = 0`, `y_0 = h(x_0, u_0)` the deviations `x - x_0`, `u - u_0`, `y - y_0` obey the
//! linear plant of the Jacobians, up to terms of second order. An observer of that linear plant is given `u - u_0` and
//! `y - y_0`, and its estimate is shifted by x_0. What is proved of it is proved of the linear plant.

use luenberger_plants::Column;
use luenberger_plants::error::check_matrix;
use nalgebra::allocator::Allocator;
use nalgebra::{Const, DefaultAllocator, Dim, OVector, RealField};

use crate::error::ObserverError;
use crate::observer::{ContinuousDiscreteObserver, Observer, ObserverDimensions, SampledObserver};

/// The observer `O` of the deviations from the point (x_0, u_0, y_0).
///
/// ```
/// use luenberger_observers::{DeviationObserver, LinearObserver, Observer};
/// use nalgebra::{Matrix2, RowVector2, Vector1, Vector2};
/// // A pendulum, x2' = u - sin x1, held at x1 = pi/6 by u = 1/2: its linearisation has -cos(pi/6) in A.
/// let (x0, u0, y0) = (Vector2::new(std::f64::consts::FRAC_PI_6, 0.0), Vector1::new(0.5), Vector1::new(std::f64::consts::FRAC_PI_6));
/// let a = Matrix2::new(0.0, 1.0, -x0[0].cos(), 0.0);
/// let linear = LinearObserver::new(a, Vector2::new(0.0, 1.0), RowVector2::new(1.0, 0.0), Vector2::new(4.0, 3.0))?;
/// let observer = DeviationObserver::new(linear, x0, u0, y0)?;
/// // At the operating point it rests, and the estimate is that of the plant.
/// let state = observer.initial(0.0, &x0, &u0, &y0);
/// assert_eq!(observer.derivative(0.0, &state, &u0, &y0), Vector2::zeros());
/// assert_eq!(observer.estimate(0.0, &state, &u0, &y0), x0);
/// # Ok::<(), luenberger_observers::ObserverError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct DeviationObserver<O, T: RealField + Copy, N: Dim, M: Dim, P: Dim>
where
    DefaultAllocator: Allocator<N> + Allocator<M> + Allocator<P>,
{
    observer: O,
    x0: OVector<T, N>,
    u0: OVector<T, M>,
    y0: OVector<T, P>,
}

/// An observer of deviations whose sizes are known at compile time.
pub type StaticDeviationObserver<O, T, const N: usize, const M: usize, const P: usize> =
    DeviationObserver<O, T, Const<N>, Const<M>, Const<P>>;

impl<O, T: RealField + Copy, N: Dim, M: Dim, P: Dim> DeviationObserver<O, T, N, M, P>
where
    DefaultAllocator: Allocator<N> + Allocator<M> + Allocator<P>,
{
    /// `observer`, of the deviations from the state `x0`, the input `u0` and the output `y0`.
    ///
    /// Lengths are checked with each other by the simulation, as those of every observer.
    /// # Errors
    /// [`ObserverError::Matrix`] for an entry that is not finite.
    pub fn new(observer: O, x0: OVector<T, N>, u0: OVector<T, M>, y0: OVector<T, P>) -> Result<Self, ObserverError> {
        check_matrix("x0", &x0, x0.shape())?;
        check_matrix("u0", &u0, u0.shape())?;
        check_matrix("y0", &y0, y0.shape())?;
        Ok(Self { observer, x0, u0, y0 })
    }

    /// The observer of the deviations.
    pub fn inner(&self) -> &O {
        &self.observer
    }

    /// The state of the operating point.
    pub fn x0(&self) -> &OVector<T, N> {
        &self.x0
    }

    /// The input of the operating point.
    pub fn u0(&self) -> &OVector<T, M> {
        &self.u0
    }

    /// The output of the operating point.
    pub fn y0(&self) -> &OVector<T, P> {
        &self.y0
    }
}

impl<O, T: RealField + Copy, N: Dim, M: Dim, P: Dim> Observer<T> for DeviationObserver<O, T, N, M, P>
where
    O: Observer<T, Input = OVector<T, M>, Output = OVector<T, P>, Estimate = OVector<T, N>>,
    DefaultAllocator: Allocator<N> + Allocator<M> + Allocator<P>,
{
    type State = O::State;
    type Input = OVector<T, M>;
    type Output = OVector<T, P>;
    type Estimate = OVector<T, N>;

    fn dimensions(&self) -> ObserverDimensions {
        self.observer.dimensions()
    }

    fn derivative(&self, t: T, state: &Self::State, u: &Self::Input, y: &Self::Output) -> Self::State {
        self.observer.derivative(t, state, &(u - &self.u0), &(y - &self.y0))
    }

    fn is_affine(&self) -> bool {
        self.observer.is_affine()
    }

    fn estimate(&self, t: T, state: &Self::State, u: &Self::Input, y: &Self::Output) -> Self::Estimate {
        self.observer.estimate(t, state, &(u - &self.u0), &(y - &self.y0)) + &self.x0
    }

    fn initial(&self, t: T, estimate: &Self::Estimate, u: &Self::Input, y: &Self::Output) -> Self::State {
        self.observer.initial(t, &(estimate - &self.x0), &(u - &self.u0), &(y - &self.y0))
    }
}

impl<O, T: RealField + Copy, N: Dim, M: Dim, P: Dim> ContinuousDiscreteObserver<T> for DeviationObserver<O, T, N, M, P>
where
    O: ContinuousDiscreteObserver<T, Input = OVector<T, M>, Output = OVector<T, P>, Estimate = OVector<T, N>>,
    DefaultAllocator: Allocator<N> + Allocator<M> + Allocator<P>,
{
    fn correct(&self, state: &mut Self::State, u: &Self::Input, y: &Self::Output, elapsed: T) {
        self.observer.correct(state, &(u - &self.u0), &(y - &self.y0), elapsed);
    }
}

impl<O, T: RealField + Copy, N: Dim, M: Dim, P: Dim> SampledObserver<T> for DeviationObserver<O, T, N, M, P>
where
    O: SampledObserver<T, Input = OVector<T, M>, Output = OVector<T, P>, Estimate = OVector<T, N>>,
    DefaultAllocator: Allocator<N> + Allocator<M> + Allocator<P>,
{
    type State = O::State;
    type Input = OVector<T, M>;
    type Output = OVector<T, P>;
    type Estimate = OVector<T, N>;

    fn dimensions(&self) -> ObserverDimensions {
        self.observer.dimensions()
    }

    fn period(&self) -> T {
        self.observer.period()
    }

    fn step(&self, t: T, state: &mut Self::State, u: &Self::Input, y: &Self::Output) {
        self.observer.step(t, state, &(u - &self.u0), &(y - &self.y0));
    }

    fn step_partial(&self, t: T, state: &mut Self::State, u: &Self::Input, y: &Self::Output, measured: &[bool]) {
        self.observer.step_partial(t, state, &(u - &self.u0), &(y - &self.y0), measured);
    }

    fn estimate(&self, state: &Self::State) -> Self::Estimate {
        self.observer.estimate(state) + &self.x0
    }

    fn update_into(&self, t: T, state: &mut [T], u: &[T], y: &[T], measured: &[bool]) -> bool {
        let columns = (OVector::<T, M>::try_from_slice(u), OVector::<T, P>::try_from_slice(y));
        let (Some(u), Some(y)) = columns else { return false };
        let (u, y) = (u - &self.u0, y - &self.y0);
        self.observer.update_into(t, state, u.as_slice(), y.as_slice(), measured)
    }

    fn initial(&self, t: T, estimate: &Self::Estimate, u: &Self::Input, y: &Self::Output) -> Self::State {
        self.observer.initial(t, &(estimate - &self.x0), &(u - &self.u0), &(y - &self.y0))
    }
}
