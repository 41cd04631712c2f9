//! The gradient estimator `theta_hat' = Gamma M'(Y - M theta_hat)`, eq. (47) of the [KKL+PEB] paper.
//!
//! For an exact regression the error obeys `theta~' = -Gamma M'M theta~`, `theta~ = theta_hat - theta` (the paper's
//! proof prints it without the minus sign), and `theta~' Gamma^-1 theta~` never grows. It tends to 0, exponentially, if
//! and only if M is persistently exciting. The entries of theta~ one by one may overshoot;
//! [`drem`](crate::estimator::drem) is the cure.
//!
//! Source: K. S. Narendra and A. M. Annaswamy, Stable Adaptive Systems, Prentice Hall 1989, section 2.

use nalgebra::allocator::Allocator;
use nalgebra::{DefaultAllocator, Dim, OMatrix, OVector, RealField};

use super::{ParameterEstimator, RegressionSize, finite_or_zero, leading};
use crate::error::ObserverError;
use crate::gaussian::covariance;

/// `theta_hat' = Gamma M'(Y - M theta_hat)` for Q parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Gradient<T: RealField + Copy, Q: Dim>
where
    DefaultAllocator: Allocator<Q, Q>,
{
    gain: OMatrix<T, Q, Q>,
}

impl<T: RealField + Copy, Q: Dim> Gradient<T, Q>
where
    DefaultAllocator: Allocator<Q, Q> + Allocator<Q>,
{
    /// The estimator with gain Gamma, q x q, symmetric positive definite.
    ///
    /// ```
    /// use luenberger_observers::estimator::ParameterEstimator;
    /// use luenberger_observers::estimator::gradient::Gradient;
    /// use nalgebra::{Matrix2, RowVector2, Vector1};
    /// let estimator = Gradient::new(Matrix2::new(2.0, 0.0, 0.0, 1.0))?;
    /// // One row sees one direction of theta: Y - M theta_hat = 3 - 1.
    /// let mut rate = [0.0; 2];
    /// estimator.rate(&[1.0, 0.0], &Vector1::new(3.0), &RowVector2::new(1.0, 1.0), &mut rate);
    /// assert_eq!(rate, [4.0, 2.0]);
    /// # Ok::<(), luenberger_observers::ObserverError>(())
    /// ```
    /// # Errors
    /// [`ObserverError::Matrix`] unless Gamma is square and finite, [`ObserverError::NotSymmetric`],
    /// [`ObserverError::NotDefinite`].
    pub fn new(gain: OMatrix<T, Q, Q>) -> Result<Self, ObserverError> {
        let order = gain.nrows();
        Ok(Self { gain: covariance("Gamma", gain, order, true)? })
    }

    /// The gain Gamma, q x q.
    pub fn gain(&self) -> &OMatrix<T, Q, Q> {
        &self.gain
    }
}

impl<T: RealField + Copy, R: Dim, Q: Dim> ParameterEstimator<T, R, Q> for Gradient<T, Q>
where
    DefaultAllocator: RegressionSize<R, Q>,
{
    type Length = Q;

    fn state_len(&self, _rows: usize) -> usize {
        self.gain.nrows()
    }

    fn parameters(&self) -> usize {
        self.gain.nrows()
    }

    fn rate(&self, state: &[T], y: &OVector<T, R>, m: &OMatrix<T, R, Q>, rate: &mut [T]) {
        let residual = y - m * leading(state, m);
        let step = &self.gain * m.tr_mul(&residual);
        rate.iter_mut().zip(step.iter()).for_each(|(rate, &step)| *rate = finite_or_zero(step));
    }

    /// Unknown: what M has been is forgotten. [`Monitored`](super::excitation::Monitored) remembers it.
    fn shift(&self, state: &mut [T], delta: &OVector<T, Q>) {
        state.iter_mut().zip(delta.iter()).for_each(|(theta, &delta)| *theta -= delta);
    }

    fn excitation(&self, _state: &[T], _m: &OMatrix<T, R, Q>) -> Option<T> {
        None
    }
}
