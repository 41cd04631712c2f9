//! Excitation of a regression: the Gramian of its regressor.
//!
//! `E(t) = int_0^t exp(-mu (t - s)) M(s)'M(s) ds` is the Gramian of the regressor with forgetting factor mu (mu = 0:
//! all of the past). theta is determined by Y and M if and only if E is definite; what is reported is a bound below its
//! smallest eigenvalue that is 0 exactly when that is: `det E ((q - 1)/trace E)^(q - 1) <= lambda_min(E)`, from the
//! inequality of arithmetic and geometric means for the other eigenvalues.

use nalgebra::allocator::Allocator;
use nalgebra::{DefaultAllocator, Dim, DimAdd, DimMul, DimProd, DimSum, OMatrix, OVector, RealField};

use super::adjugate::adjugate;
use super::{ParameterEstimator, RegressionSize, finite_or_zero};
use crate::error::ObserverError;

/// An estimator, and the Gramian of its regressor beside it: q^2 more states.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Monitored<T, E> {
    estimator: E,
    mu: T,
}

impl<T: RealField + Copy, E> Monitored<T, E> {
    /// `estimator` with a Gramian that forgets at the rate mu >= 0, in 1/s.
    ///
    /// # Errors
    /// [`ObserverError::NotPositive`] for a mu that is negative or not finite.
    pub fn new(estimator: E, mu: T) -> Result<Self, ObserverError> {
        if !(mu.is_finite() && mu >= T::zero()) {
            return Err(ObserverError::NotPositive {
                what: "the forgetting factor mu",
                value: mu.to_subset_unchecked(),
            });
        }
        Ok(Self { estimator, mu })
    }

    /// The estimator.
    pub fn estimator(&self) -> &E {
        &self.estimator
    }
}

impl<T, R, Q, E> ParameterEstimator<T, R, Q> for Monitored<T, E>
where
    T: RealField + Copy,
    R: Dim,
    Q: DimMul<Q>,
    E: ParameterEstimator<T, R, Q>,
    E::Length: DimAdd<DimProd<Q, Q>>,
    DefaultAllocator: RegressionSize<R, Q>,
{
    type Length = DimSum<E::Length, DimProd<Q, Q>>;

    fn state_len(&self, rows: usize) -> usize {
        self.estimator.state_len(rows) + self.parameters() * self.parameters()
    }

    fn parameters(&self) -> usize {
        self.estimator.parameters()
    }

    fn rate(&self, state: &[T], y: &OVector<T, R>, m: &OMatrix<T, R, Q>, rate: &mut [T]) {
        let own = self.estimator.state_len(m.nrows());
        self.estimator.rate(&state[..own], y, m, &mut rate[..own]);
        let seen = m.tr_mul(m);
        for ((rate, &seen), &gram) in rate[own..].iter_mut().zip(seen.iter()).zip(&state[own..]) {
            *rate = finite_or_zero(seen - gram * self.mu);
        }
    }

    fn shift(&self, state: &mut [T], delta: &OVector<T, Q>) {
        self.estimator.shift(state, delta);
    }

    fn excitation(&self, state: &[T], m: &OMatrix<T, R, Q>) -> Option<T> {
        let own = self.estimator.state_len(m.nrows());
        let order = m.shape_generic().1;
        Some(least_eigenvalue(&OMatrix::from_iterator_generic(order, order, state[own..].iter().copied())))
    }
}

/// A bound below the smallest eigenvalue of a positive semidefinite matrix: `det E ((q - 1)/trace E)^(q - 1)`, and not
/// below 0.
///
/// ```
/// use luenberger_observers::estimator::excitation::least_eigenvalue;
/// use nalgebra::Matrix2;
/// // The eigenvalues are 1 and 3.
/// assert_eq!(least_eigenvalue(&Matrix2::new(2.0, 1.0, 1.0, 2.0)), 0.75);
/// assert_eq!(least_eigenvalue(&Matrix2::new(1.0, 1.0, 1.0, 1.0)), 0.0);
/// ```
pub fn least_eigenvalue<T: RealField + Copy, Q: Dim>(gram: &OMatrix<T, Q, Q>) -> T
where
    DefaultAllocator: Allocator<Q, Q> + Allocator<Q>,
{
    let trace = gram.trace();
    if !(trace.is_finite() && trace > T::zero()) {
        return T::zero();
    }
    // The determinant of E/trace E, so that nothing overflows.
    let determinant = adjugate(&(gram / trace)).determinant.max(T::zero());
    let others = gram.nrows() - 1;
    let count: T = nalgebra::convert(others as f64);
    trace * (0..others).fold(determinant, |product, _| product * count)
}
