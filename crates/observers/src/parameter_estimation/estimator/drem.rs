//! Dynamic regressor extension and mixing: q scalar regressions instead of one of q parameters.
//!
//! Extension makes of `Y = M theta` a square regression `Z = Phi theta` (q equations), mixing multiplies it by the
//! adjugate, `adj(Phi) Z = Delta theta` with `Delta = det Phi`, and every parameter has an equation of its own:
//!
//! ```text
//! theta_hat_i' = gamma_i Delta (v_i - Delta theta_hat_i),  v = adj(Phi) Z
//! ```
//!
//! For an exact regression `theta~_i' = -gamma_i Delta^2 theta~_i`: **each entry of the error decreases monotonically
//! in magnitude**, and tends to 0 if and only if Delta is not square integrable, which can be so without persistent
//! excitation of M.
//!
//! Two extensions:
//! - [`Kreisselmeier`]: `Phi' = -a Phi + M'M`, `Z' = -a Z + M'Y`, from zero. Any number of rows, q (q + 1) states, Phi
//!   is positive semidefinite.
//! - [`LtiFilters`]: k stable filters `beta_i/(p + beta_i)` of Y and M, beside Y and M themselves: r (k + 1) equations.
//!   If these are q, they are the square regression; if they are more, their normal equations are (`Phi = Me'Me`, whose
//!   determinant is the square of that of a square Me).
//!
//! The scale of Delta is that of M to the power q (2q for normal equations), and gamma has to make up for it: look at
//! the excitation, which is `|Delta|`.
//!
//! Sources: S. Aranovskiy, A. Bobtsov, R. Ortega and A. Pyrkin, IEEE Transactions on Automatic Control 62, 2017; G.
//! Kreisselmeier, IEEE Transactions on Automatic Control 22, 1977.

use nalgebra::allocator::Allocator;
use nalgebra::{DefaultAllocator, Dim, DimAdd, DimMul, DimProd, DimSum, OMatrix, OVector, RealField, U1};

use super::adjugate::adjugate;
use super::{ParameterEstimator, RegressionSize, finite_or_zero};
use crate::error::ObserverError;
use crate::filters::{all_positive, positive};

/// A dynamic extension of a regression to a square one.
pub trait Extension<T: RealField + Copy, R: Dim, Q: Dim>
where
    DefaultAllocator: RegressionSize<R, Q>,
{
    /// The length of its state, as a dimension.
    type Length: Dim;

    /// The length of its state, for `rows` rows and `parameters` parameters. It starts at zero.
    fn state_len(&self, rows: usize, parameters: usize) -> usize;

    /// Writes the rate of its state.
    fn rate(&self, state: &[T], y: &OVector<T, R>, m: &OMatrix<T, R, Q>, rate: &mut [T]);

    /// Phi (q x q) and Z (q) with `Z = Phi theta`.
    fn square(&self, state: &[T], y: &OVector<T, R>, m: &OMatrix<T, R, Q>) -> (OMatrix<T, Q, Q>, OVector<T, Q>);

    /// Moves the state to the coordinates `theta - delta`: `Y - M delta` in the place of Y.
    fn shift(&self, state: &mut [T], delta: &OVector<T, Q>);

    /// Phi alone, for the excitation.
    fn regressor(&self, state: &[T], m: &OMatrix<T, R, Q>) -> OMatrix<T, Q, Q> {
        let zero = OVector::zeros_generic(m.shape_generic().0, U1);
        self.square(state, &zero, m).0
    }
}

/// `Phi' = -a Phi + M'M`, `Z' = -a Z + M'Y`; the state is (Z, Phi by columns).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kreisselmeier<T> {
    a: T,
}

impl<T: RealField + Copy> Kreisselmeier<T> {
    /// The extension that forgets at the rate a, in 1/s.
    ///
    /// # Errors
    /// [`ObserverError::NotPositive`] unless a is positive and finite.
    pub fn new(a: T) -> Result<Self, ObserverError> {
        positive("the rate of forgetting a", a).map(|a| Self { a })
    }

    /// The rate a, in 1/s.
    pub fn forgetting_rate(&self) -> T {
        self.a
    }
}

impl<T: RealField + Copy, R: Dim, Q: Dim> Extension<T, R, Q> for Kreisselmeier<T>
where
    Q: DimAdd<U1> + DimMul<DimSum<Q, U1>>,
    DefaultAllocator: RegressionSize<R, Q>,
{
    type Length = DimProd<Q, DimSum<Q, U1>>;

    fn state_len(&self, _rows: usize, parameters: usize) -> usize {
        parameters * (parameters + 1)
    }

    fn rate(&self, state: &[T], y: &OVector<T, R>, m: &OMatrix<T, R, Q>, rate: &mut [T]) {
        let (right, gram) = (m.tr_mul(y), m.tr_mul(m));
        for ((rate, &state), &source) in rate.iter_mut().zip(state).zip(right.iter().chain(gram.iter())) {
            *rate = finite_or_zero(source - state * self.a);
        }
    }

    /// `Z - Phi delta`.
    fn shift(&self, state: &mut [T], delta: &OVector<T, Q>) {
        let q = delta.nrows();
        for i in 0..q {
            for j in 0..q {
                let moved = state[q + i + q * j] * delta[j];
                state[i] -= moved;
            }
        }
    }

    fn square(&self, state: &[T], _y: &OVector<T, R>, m: &OMatrix<T, R, Q>) -> (OMatrix<T, Q, Q>, OVector<T, Q>) {
        let (order, q) = (m.shape_generic().1, m.ncols());
        (
            OMatrix::from_fn_generic(order, order, |i, j| state[q + i + q * j]),
            OVector::from_fn_generic(order, U1, |i, _| state[i]),
        )
    }
}

/// `K` filters `beta_i/(p + beta_i)` of Y and M, from zero; the state is (Y_1, M_1 by columns, Y_2, ...).
#[derive(Clone, Debug, PartialEq)]
pub struct LtiFilters<T: RealField + Copy, K: Dim>
where
    DefaultAllocator: Allocator<K>,
{
    beta: OVector<T, K>,
}

impl<T: RealField + Copy, K: Dim> LtiFilters<T, K>
where
    DefaultAllocator: Allocator<K>,
{
    /// Filters with poles `-beta_i`, in 1/s, which should differ from each other; q/r - 1 of them for a square
    /// regression.
    ///
    /// # Errors
    /// [`ObserverError::NotPositive`] unless every beta is positive and finite, [`ObserverError::Matrix`] for none.
    pub fn new(beta: OVector<T, K>) -> Result<Self, ObserverError> {
        all_positive("a filter's beta", &beta)?;
        Ok(Self { beta })
    }

    /// The numbers beta, in 1/s.
    pub fn poles(&self) -> &OVector<T, K> {
        &self.beta
    }

    /// Row i of `[Y M]` of filter k, k = 0 being Y and M themselves; column 0 is Y.
    fn entry<R: Dim, Q: Dim>(state: &[T], y: &OVector<T, R>, m: &OMatrix<T, R, Q>, k: usize, i: usize, j: usize) -> T
    where
        DefaultAllocator: RegressionSize<R, Q>,
    {
        match (k, j) {
            (0, 0) => y[i],
            (0, _) => m[(i, j - 1)],
            _ => state[(k - 1) * m.nrows() * (m.ncols() + 1) + j * m.nrows() + i],
        }
    }
}

impl<T: RealField + Copy, R: Dim, Q: Dim, K: Dim> Extension<T, R, Q> for LtiFilters<T, K>
where
    Q: DimAdd<U1>,
    R: DimMul<DimSum<Q, U1>>,
    K: DimMul<DimProd<R, DimSum<Q, U1>>>,
    DefaultAllocator: RegressionSize<R, Q> + Allocator<K>,
{
    type Length = DimProd<K, DimProd<R, DimSum<Q, U1>>>;

    fn state_len(&self, rows: usize, parameters: usize) -> usize {
        self.beta.nrows() * rows * (parameters + 1)
    }

    fn rate(&self, state: &[T], y: &OVector<T, R>, m: &OMatrix<T, R, Q>, rate: &mut [T]) {
        let block = m.nrows() * (m.ncols() + 1);
        for (k, &beta) in self.beta.iter().enumerate() {
            for (position, source) in y.iter().chain(m.iter()).enumerate() {
                let at = k * block + position;
                rate[at] = finite_or_zero((*source - state[at]) * beta);
            }
        }
    }

    /// `Y_k - M_k delta` in each block.
    fn shift(&self, state: &mut [T], delta: &OVector<T, Q>) {
        let (filters, columns) = (self.beta.nrows(), delta.nrows() + 1);
        let rows = state.len() / (filters * columns);
        for k in 0..filters {
            let block = k * rows * columns;
            for i in 0..rows {
                for j in 1..columns {
                    let moved = state[block + j * rows + i] * delta[j - 1];
                    state[block + i] -= moved;
                }
            }
        }
    }

    fn square(&self, state: &[T], y: &OVector<T, R>, m: &OMatrix<T, R, Q>) -> (OMatrix<T, Q, Q>, OVector<T, Q>) {
        let (order, q, r) = (m.shape_generic().1, m.ncols(), m.nrows());
        let rows = r * (self.beta.nrows() + 1);
        let entry = |row: usize, j: usize| Self::entry(state, y, m, row / r, row % r, j);
        if rows == q {
            return (
                OMatrix::from_fn_generic(order, order, |i, j| entry(i, j + 1)),
                OVector::from_fn_generic(order, U1, |i, _| entry(i, 0)),
            );
        }
        let product = |i: usize, j: usize| (0..rows).fold(T::zero(), |sum, row| sum + entry(row, i) * entry(row, j));
        (
            OMatrix::from_fn_generic(order, order, |i, j| product(i + 1, j + 1)),
            OVector::from_fn_generic(order, U1, |i, _| product(i + 1, 0)),
        )
    }
}

/// DREM for Q parameters with the extension X; the state is (theta_hat, state of the extension).
#[derive(Clone, Debug, PartialEq)]
pub struct Drem<T: RealField + Copy, Q: Dim, X>
where
    DefaultAllocator: Allocator<Q>,
{
    gain: OVector<T, Q>,
    extension: X,
}

impl<T: RealField + Copy, Q: Dim, X> Drem<T, Q, X>
where
    DefaultAllocator: Allocator<Q>,
{
    /// The estimator with gains gamma_i > 0 and this extension.
    ///
    /// ```
    /// use luenberger_observers::estimator::ParameterEstimator;
    /// use luenberger_observers::estimator::drem::{Drem, LtiFilters};
    /// use nalgebra::{RowVector2, Vector1, Vector2};
    /// let estimator = Drem::new(Vector2::new(1.0, 1.0), LtiFilters::new(Vector1::new(5.0))?)?;
    /// // theta = (1, 2); now M = (1, 0), and the filter remembers M = (1, 1): Delta = 1.
    /// let (y, m) = (Vector1::new(1.0), RowVector2::new(1.0, 0.0));
    /// let state = [0.0, 0.0, /* Y_1, M_1 */ 3.0, 1.0, 1.0];
    /// let mut rate = [0.0; 5];
    /// estimator.rate(&state, &y, &m, &mut rate);
    /// assert_eq!(rate[..2], [1.0, 2.0]);
    /// assert_eq!(estimator.excitation(&state, &m), Some(1.0));
    /// # Ok::<(), luenberger_observers::ObserverError>(())
    /// ```
    /// # Errors
    /// [`ObserverError::NotPositive`] unless every gain is positive and finite.
    pub fn new(gain: OVector<T, Q>, extension: X) -> Result<Self, ObserverError> {
        all_positive("a gain gamma", &gain)?;
        Ok(Self { gain, extension })
    }

    /// The gains gamma.
    pub fn gain(&self) -> &OVector<T, Q> {
        &self.gain
    }

    /// The extension.
    pub fn extension(&self) -> &X {
        &self.extension
    }
}

impl<T, R, Q, X> ParameterEstimator<T, R, Q> for Drem<T, Q, X>
where
    T: RealField + Copy,
    R: Dim,
    Q: DimAdd<X::Length>,
    X: Extension<T, R, Q>,
    DefaultAllocator: RegressionSize<R, Q>,
{
    type Length = DimSum<Q, X::Length>;

    fn state_len(&self, rows: usize) -> usize {
        let q = self.gain.nrows();
        q + self.extension.state_len(rows, q)
    }

    fn parameters(&self) -> usize {
        self.gain.nrows()
    }

    fn rate(&self, state: &[T], y: &OVector<T, R>, m: &OMatrix<T, R, Q>, rate: &mut [T]) {
        let (theta, extended) = state.split_at(self.gain.nrows());
        let (theta_rate, extended_rate) = rate.split_at_mut(self.gain.nrows());
        self.extension.rate(extended, y, m, extended_rate);
        let (phi, z) = self.extension.square(extended, y, m);
        let mixed = adjugate(&phi);
        let v = &mixed.adjugate * z;
        for (i, (rate, &theta)) in theta_rate.iter_mut().zip(theta).enumerate() {
            *rate = finite_or_zero(self.gain[i] * mixed.determinant * (v[i] - mixed.determinant * theta));
        }
    }

    fn shift(&self, state: &mut [T], delta: &OVector<T, Q>) {
        let (theta, extended) = state.split_at_mut(self.gain.nrows());
        theta.iter_mut().zip(delta.iter()).for_each(|(theta, &delta)| *theta -= delta);
        self.extension.shift(extended, delta);
    }

    /// `|Delta|`, at this instant.
    fn excitation(&self, state: &[T], m: &OMatrix<T, R, Q>) -> Option<T> {
        let phi = self.extension.regressor(&state[self.gain.nrows()..], m);
        Some(adjugate(&phi).determinant.abs())
    }
}
