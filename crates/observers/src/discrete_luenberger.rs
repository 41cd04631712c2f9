//! The copy of a nonlinear plant in discrete time, corrected by a constant gain:
//! `xhat+ = f(t, xhat, u) + L (y - h(t, xhat, u))` for `x+ = f(t, x, u)`.
//!
//! Its error obeys `e+ = (Fbar - L Hbar) e` with the mean Jacobians of f and h over the segment from xhat to x. It is a
//! predictor: the estimate at a sample is that before its measurement.

use core::marker::PhantomData;

use luenberger_plants::error::check_matrix;
use luenberger_plants::{Plant, Size};
use nalgebra::{Const, DefaultAllocator, Dim, OMatrix, OVector, RealField};

use crate::error::ObserverError;
use crate::observer::{ObserverDimensions, SampledObserver, state_is_estimate};
use crate::partial::of_measured;

/// `xhat+ = f(t, xhat, u) + L (y - h(t, xhat, u))` for a plant `S` in discrete time, whose `derivative` is the next
/// state, with N states, M inputs and P outputs.
///
/// Fields are read through methods, because the constructor has checked them.
#[derive(Clone, Debug, PartialEq)]
pub struct DiscreteNonlinearObserver<S, T: RealField + Copy, N: Dim, M: Dim, P: Dim>
where
    DefaultAllocator: Size<N, M, P>,
{
    plant: S,
    l: OMatrix<T, N, P>,
    period: T,
    inputs: PhantomData<M>,
}

/// The copy of a nonlinear plant in discrete time with sizes known at compile time.
pub type StaticDiscreteNonlinearObserver<S, T, const N: usize, const M: usize, const P: usize> =
    DiscreteNonlinearObserver<S, T, Const<N>, Const<M>, Const<P>>;

impl<S, T: RealField + Copy, N: Dim, M: Dim, P: Dim> DiscreteNonlinearObserver<S, T, N, M, P>
where
    DefaultAllocator: Size<N, M, P>,
{
    /// The plant.
    pub fn plant(&self) -> &S {
        &self.plant
    }

    /// The gain L, n x p.
    pub fn l(&self) -> &OMatrix<T, N, P> {
        &self.l
    }
}

impl<S, T: RealField + Copy, N: Dim, M: Dim, P: Dim> DiscreteNonlinearObserver<S, T, N, M, P>
where
    S: Plant<T, State = OVector<T, N>, Input = OVector<T, M>, Output = OVector<T, P>>,
    DefaultAllocator: Size<N, M, P>,
{
    /// The observer of `plant` with the gain L (n x p) and the sampling period of the plant.
    ///
    /// ```
    /// use luenberger_observers::{DiscreteNonlinearObserver, SampledObserver};
    /// use luenberger_plants::{Plant, ReverseDuffing};
    /// use nalgebra::{SVector, Vector1, Vector2};
    /// // The right-hand side of any plant, read as its next state.
    /// let observer = DiscreteNonlinearObserver::new(ReverseDuffing, Vector2::new(0.5, 0.25), 0.1)?;
    /// let (mut xhat, u) = (Vector2::new(1.0, 2.0), SVector::zeros());
    /// observer.step(0.0, &mut xhat, &u, &Vector1::new(3.0));
    /// assert_eq!(xhat, Vector2::new(8.0 + 0.5 * 2.0, -1.0 + 0.25 * 2.0));
    /// # Ok::<(), luenberger_observers::ObserverError>(())
    /// ```
    /// # Errors
    /// [`ObserverError::Matrix`] for the shape and the entries of L; [`ObserverError::Period`].
    pub fn new(plant: S, l: OMatrix<T, N, P>, period: T) -> Result<Self, ObserverError> {
        let size = plant.dimensions();
        check_matrix("L", &l, (size.states, size.outputs))?;
        if !(period.is_finite() && period > T::zero()) {
            return Err(ObserverError::Period { period: period.to_subset_unchecked() });
        }
        Ok(Self { plant, l, period, inputs: PhantomData })
    }
}

impl<S, T: RealField + Copy, N: Dim, M: Dim, P: Dim> SampledObserver<T> for DiscreteNonlinearObserver<S, T, N, M, P>
where
    S: Plant<T, State = OVector<T, N>, Input = OVector<T, M>, Output = OVector<T, P>>,
    DefaultAllocator: Size<N, M, P>,
{
    state_is_estimate! { SampledObserver }

    fn dimensions(&self) -> ObserverDimensions {
        let size = self.plant.dimensions();
        ObserverDimensions { state: size.states, inputs: size.inputs, outputs: size.outputs, estimate: size.states }
    }

    fn period(&self) -> T {
        self.period
    }

    crate::partial::step_of_measured! {}

    fn step(&self, t: T, xhat: &mut Self::State, u: &Self::Input, y: &Self::Output) {
        let mut innovation = y - self.plant.output(t, xhat, u);
        innovation.zip_apply(y, |innovation, y| *innovation = of_measured(y, *innovation));
        *xhat = self.plant.derivative(t, xhat, u) + &self.l * innovation;
    }
}
