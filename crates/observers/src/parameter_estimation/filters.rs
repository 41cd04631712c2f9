//! The two filters of parameter estimation: `F = alpha/(p + alpha)` and `W = alpha p/(p + alpha)`, p = d/dt.
//!
//! W is a derivative seen through F: `W[s] = F[s']` for a signal s whose derivative is not measured. Realised as
//!
//! ```text
//! F[g]:  f' = alpha (g - f)
//! W[s]:  w' = alpha (s - w),  W[s] = alpha (s - w)          so that w = F[s]
//! ```
//!
//! `W[s] = F[s']` holds up to a transient `exp(-alpha t) alpha (s(0) - w(0))`, which is nothing when **w(0) = s(0)**.
//! With w(0) = 0, as "all states start at zero" would have it, the transient is of the size of s itself. F starts at 0.

use luenberger_plants::PlantError;
use nalgebra::allocator::Allocator;
use nalgebra::{DefaultAllocator, Dim, OMatrix, RealField};

use crate::error::ObserverError;

/// A pole `-alpha` with its two filters, for signals that are matrices.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Filter<T> {
    alpha: T,
}

impl<T: RealField + Copy> Filter<T> {
    /// The filters with this `alpha`, in 1/s.
    ///
    /// ```
    /// use luenberger_observers::filters::Filter;
    /// use nalgebra::Vector1;
    /// let filter = Filter::new(2.0)?;
    /// // s = 5 + 3 t at t = 0, started where it must be: s' is seen to be 0 at first, W[s] = 3 (1 - exp(-2 t)).
    /// let (w, s) = (Vector1::new(5.0), Vector1::new(5.0));
    /// assert_eq!(filter.washout(&w, &s)[0], 0.0);
    /// assert!(Filter::new(0.0).is_err());
    /// # Ok::<(), luenberger_observers::ObserverError>(())
    /// ```
    /// # Errors
    /// [`ObserverError::NotPositive`] unless `alpha` is positive and finite.
    pub fn new(alpha: T) -> Result<Self, ObserverError> {
        positive("the filter's alpha", alpha).map(|alpha| Self { alpha })
    }

    /// alpha, in 1/s; the pole is `-alpha`.
    pub fn alpha(&self) -> T {
        self.alpha
    }

    /// `alpha (signal - state)`: the rate of the state of either filter.
    pub fn rate<R: Dim, C: Dim>(&self, state: &OMatrix<T, R, C>, signal: &OMatrix<T, R, C>) -> OMatrix<T, R, C>
    where
        DefaultAllocator: Allocator<R, C>,
    {
        (signal - state) * self.alpha
    }

    /// `W[signal] = alpha (signal - state)`, equal to the rate of the state of W.
    pub fn washout<R: Dim, C: Dim>(&self, state: &OMatrix<T, R, C>, signal: &OMatrix<T, R, C>) -> OMatrix<T, R, C>
    where
        DefaultAllocator: Allocator<R, C>,
    {
        self.rate(state, signal)
    }
}

/// Checks that `value` is positive and finite.
///
/// # Errors
/// [`ObserverError::NotPositive`] with the value.
pub fn positive<T: RealField + Copy>(what: &'static str, value: T) -> Result<T, ObserverError> {
    if value.is_finite() && value > T::zero() {
        Ok(value)
    } else {
        Err(ObserverError::NotPositive { what, value: value.to_subset_unchecked() })
    }
}

/// Checks that every entry is positive and finite.
pub(crate) fn all_positive<T: RealField + Copy, D: Dim>(
    what: &'static str,
    values: &nalgebra::OVector<T, D>,
) -> Result<(), ObserverError>
where
    DefaultAllocator: Allocator<D>,
{
    if values.is_empty() {
        return Err(PlantError::DimensionMismatch { what, expected: (1, 1), found: values.shape() }.into());
    }
    values.iter().try_for_each(|&value| positive(what, value).map(|_| ()))
}
