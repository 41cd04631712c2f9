//! The linear observer of a plant in discrete time: `xhat+ = A xhat + B u + L (y - C xhat - D u)`.
//!
//! Its error obeys `e+ = (A - L C) e`. It is a predictor: the estimate at a sample is that before its measurement.

use luenberger_plants::error::check_matrix;
use luenberger_plants::{LinearPlant, Size};
use nalgebra::{Const, DefaultAllocator, Dim, OMatrix, OVector, RealField};

use crate::dense::{copy, entry, with_column};
use crate::error::ObserverError;
use crate::feedthrough;
use crate::observer::{ObserverDimensions, SampledObserver, state_is_estimate};

/// `xhat+ = A xhat + B u + L (y - C xhat - D u)` for `x+ = A x + B u`, `y = C x + D u`, with N states, M inputs and P
/// outputs.
///
/// Fields are read through methods, because the constructor has checked them.
#[derive(Clone, Debug, PartialEq)]
pub struct DiscreteLinearObserver<T: RealField + Copy, N: Dim, M: Dim, P: Dim>
where
    DefaultAllocator: Size<N, M, P>,
{
    plant: LinearPlant<T, N, M, P>,
    l: OMatrix<T, N, P>,
    period: T,
}

/// A linear observer in discrete time whose sizes are known at compile time.
pub type StaticDiscreteLinearObserver<T, const N: usize, const M: usize, const P: usize> =
    DiscreteLinearObserver<T, Const<N>, Const<M>, Const<P>>;

impl<T: RealField + Copy, N: Dim, M: Dim, P: Dim> DiscreteLinearObserver<T, N, M, P>
where
    DefaultAllocator: Size<N, M, P>,
{
    /// The observer with gain L (n x p) of the plant `x+ = A x + B u`, `y = C x + D u` of this period.
    ///
    /// ```
    /// use luenberger_observers::{DiscreteLinearObserver, SampledObserver};
    /// use luenberger_plants::StaticPlant;
    /// use nalgebra::{Matrix2, RowVector2, Vector1, Vector2};
    /// let plant = StaticPlant::new(Matrix2::new(1.0, 0.5, 0.0, 1.0), Vector2::new(0.0, 0.5), RowVector2::new(1.0, 0.0))?;
    /// let observer = DiscreteLinearObserver::new(plant, Vector2::new(1.0, 0.5), 0.5)?;
    /// let mut xhat = Vector2::new(0.0, 2.0);
    /// observer.step(0.0, &mut xhat, &Vector1::new(2.0), &Vector1::new(1.0));
    /// assert_eq!(xhat, Vector2::new(1.0 + 1.0, 2.0 + 1.0 + 0.5));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    /// # Errors
    /// [`ObserverError::Matrix`]: shapes that do not fit, entries that are not finite; [`ObserverError::Period`].
    pub fn new(plant: LinearPlant<T, N, M, P>, l: OMatrix<T, N, P>, period: T) -> Result<Self, ObserverError> {
        let plant = plant.checked()?;
        check_matrix("L", &l, (plant.a.nrows(), plant.c.nrows()))?;
        if !(period.is_finite() && period > T::zero()) {
            return Err(ObserverError::Period { period: period.to_subset_unchecked() });
        }
        Ok(Self { plant, l, period })
    }

    /// The plant, `x+ = A x + B u`, `y = C x + D u`.
    pub fn plant(&self) -> &LinearPlant<T, N, M, P> {
        &self.plant
    }

    /// The gain L, n x p.
    pub fn l(&self) -> &OMatrix<T, N, P> {
        &self.l
    }

    /// The innovation `y - C xhat - D u`.
    pub fn innovation(&self, xhat: &OVector<T, N>, u: &OVector<T, M>, y: &OVector<T, P>) -> OVector<T, P> {
        feedthrough::innovation_of(&self.plant.c, self.plant.d.as_ref(), (xhat, u, y))
    }
}

impl<T: RealField + Copy, N: Dim, M: Dim, P: Dim> SampledObserver<T> for DiscreteLinearObserver<T, N, M, P>
where
    DefaultAllocator: Size<N, M, P>,
{
    state_is_estimate! { SampledObserver }

    fn dimensions(&self) -> ObserverDimensions {
        let LinearPlant { a, b, c, .. } = &self.plant;
        ObserverDimensions { state: a.nrows(), inputs: b.ncols(), outputs: c.nrows(), estimate: a.nrows() }
    }

    fn period(&self) -> T {
        self.period
    }

    crate::partial::step_of_measured! {}

    fn step(&self, _t: T, xhat: &mut Self::State, u: &Self::Input, y: &Self::Output) {
        let LinearPlant { a, b, c, d } = &self.plant;
        let (u, y, xhat) = (u.as_slice(), y.as_slice(), xhat.as_mut_slice());
        let (order, outputs) = self.l.shape_generic();
        with_column(outputs, |innovation| {
            feedthrough::sampled_innovation(c, d.as_ref(), (xhat, u, y), innovation);
            with_column(order, |next| {
                predict((a, b, &self.l), (xhat, u, innovation), next);
                copy(next, xhat);
            });
        });
    }
}

/// `A xhat + B u + L z` into `next`. Without a closure of its own: one that two observers share is not inlined.
#[inline(always)]
#[allow(clippy::inline_always, clippy::type_complexity, reason = "as in dense.rs; three matrices, not a type")]
pub(crate) fn predict<T: RealField + Copy, N: Dim, M: Dim, P: Dim>(
    (a, b, l): (&OMatrix<T, N, N>, &OMatrix<T, N, M>, &OMatrix<T, N, P>),
    (xhat, u, z): (&[T], &[T], &[T]),
    next: &mut [T],
) where
    DefaultAllocator: Size<N, M, P>,
{
    for (i, next) in next.iter_mut().enumerate() {
        let moved = entry(a, i, xhat);
        let moved = if u.is_empty() { moved } else { moved + entry(b, i, u) };
        *next = moved + entry(l, i, z);
    }
}
