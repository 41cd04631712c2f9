//! The [KKL+PEB]O of Proposition 6: x2 by the KKL part, x3 by estimating `Theta = exp(x3(0) - xi2(0))`.
//!
//! ```text
//! xi1' = -xi1 + y^2 + sin y,  xi2' = u y + 1/(y^2 + 1)                                    (32), (33)
//! Theta_hat' = gamma psi (Y - psi Theta_hat)                                              (34)
//! Y = W[y] + F[y^3],  psi = F[exp(xi2)]                                                   (37)
//! x2hat = xi1,  x3hat = xi2 + ln Theta_hat                                                (35), (36)
//! ```
//!
//! Theta is positive, and its estimate must be positive too: it starts at 1, for an exact regression it approaches
//! Theta monotonically, and under noise it is bounded below by [`LOWEST`]; [`Diagnose`](luenberger_observers::Diagnose)
//! reports when this bound is active or nearly reached. psi(0) = 0, not positive as in the paper: the regression is
//! then exact from the start (psi(0) > 0 adds a transient to it that decays with the filter).
//!
//! F3, that the plant admits no KKLO, is true: that of Proposition 1 has a constant Lambda. It is true too for one that
//! depends on y. With a Lambda that depends on y and u, as in the paper's own KKLO of the converter, there is one:
//! [`kklo`].

use nalgebra::{Matrix1, Matrix2, RealField, U1, U2, Vector1, Vector2, convert};

use luenberger_observers::ObserverError;
use luenberger_observers::estimator::finite_or_zero;
use luenberger_observers::estimator::gradient::Gradient;
use luenberger_observers::filters::positive;
use luenberger_observers::kkl::{KklMap, KklObserver};
use luenberger_observers::kkl_peb::KklPebObserver;
use luenberger_observers::pebo::Regression;

/// The least Theta_hat: x3hat is not taken more than 27.6 below xi2.
pub const LOWEST: f64 = 1e-12;

/// `phi = (x2, x3)`, `Lambda = diag(-1, 0)`, `B = (y^2 + sin y, u y + 1/(y^2 + 1))`, and the regression
/// `y' = -y^3 + exp(xi2) Theta`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ExponentialCascadeMap;

/// The observer of Proposition 6, with a state of length 6: xi of length 2, w, `F[-y^3]`, psi, Theta_hat.
pub type ExponentialCascadeObserver<T> = KklPebObserver<ExponentialCascadeMap, Gradient<T, U1>, T>;

/// The observer with filter pole `-alpha` and gain `gamma`; Theta_hat(0) = 1.
///
/// ```
/// use luenberger_observers::Observer;
/// use luenberger_reproduce::kkl::exponential_cascade;
/// use nalgebra::{Vector1, Vector2};
/// let observer = exponential_cascade::observer(1.0, 5.0)?;
/// let (u, y) = (Vector1::new(-0.5), Vector1::new(0.5));
/// let state = observer.initial(0.0, &Vector2::zeros(), &u, &y);
/// assert_eq!(state.as_slice(), [0.0, 0.0, 0.5, 0.0, 0.0, 1.0]);
/// assert_eq!(observer.estimate(0.0, &state, &u, &y), Vector2::zeros());
/// # Ok::<(), luenberger_observers::ObserverError>(())
/// ```
/// # Errors
/// [`ObserverError::NotPositive`], [`ObserverError::NotDefinite`] for gains that are not positive.
pub fn observer<T: RealField + Copy>(alpha: T, gamma: T) -> Result<ExponentialCascadeObserver<T>, ObserverError> {
    KklPebObserver::new(ExponentialCascadeMap, Gradient::new(Matrix1::new(gamma))?, alpha)?.starting_at(T::one())
}

impl<T: RealField + Copy> KklMap<T> for ExponentialCascadeMap {
    type Xi = U2;
    type Inputs = U1;
    type Outputs = U1;
    type Estimate = U2;

    fn lambda(&self, _t: T, _u: &Vector1<T>, _y: &Vector1<T>) -> Matrix2<T> {
        Matrix2::from_diagonal(&Vector2::new(-T::one(), T::zero()))
    }

    fn injection(&self, _t: T, _xi: &Vector2<T>, u: &Vector1<T>, y: &Vector1<T>) -> Vector2<T> {
        let square = y[0] * y[0];
        Vector2::new(square + y[0].sin(), u[0] * y[0] + T::one() / (square + T::one()))
    }

    fn left_inverse(&self, _t: T, xi: &Vector2<T>, _y: &Vector1<T>) -> Vector2<T> {
        *xi
    }

    fn image(&self, _t: T, xhat: &Vector2<T>, _y: &Vector1<T>) -> Vector2<T> {
        *xhat
    }
}

impl<T: RealField + Copy> Regression<T> for ExponentialCascadeMap {
    type Rows = U1;
    type Parameters = U1;

    fn signal(&self, _t: T, y: &Vector1<T>) -> Vector1<T> {
        *y
    }

    fn known(&self, _t: T, _xi: &Vector2<T>, _u: &Vector1<T>, y: &Vector1<T>) -> Vector1<T> {
        Vector1::new(-y[0] * y[0] * y[0])
    }

    fn regressor(&self, _t: T, xi: &Vector2<T>, _u: &Vector1<T>, _y: &Vector1<T>) -> Matrix1<T> {
        Matrix1::new(xi[1].exp())
    }

    /// `(0, ln Theta)`. Called with parameters inside their domain.
    fn missing(&self, theta: &Vector1<T>) -> Vector2<T> {
        Vector2::new(T::zero(), theta[0].ln())
    }

    fn lower_bound(&self, _parameter: usize) -> Option<T> {
        Some(convert(LOWEST))
    }
}

/// A KKLO of the same plant: in z = exp(x3) it is linear, `y' = z - y^3`, `z' = a z` with `a = 1/(y^2 + 1) + y u`, so
/// that with any k
///
/// ```text
/// phi = (x2, exp(x3) - k(y)),  Lambda = diag(-1, a - k'(y)),  B = (y^2 + sin y, (a - k') k + k' y^3)
/// ```
///
/// solves (4), and `phi^L = (xi1, ln(xi2 + k))`. Here `k = c y + y^3`, and
/// `a - k' = 1/(y^2 + 1) + y u - 3 y^2 - c <= 1 - c + u^2/12`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VaryingExponentialCascadeMap<T> {
    c: T,
}

/// The observer of [`VaryingExponentialCascadeMap`], with a state of length 2.
pub type ExponentialCascadeKklo<T> = KklObserver<VaryingExponentialCascadeMap<T>>;

/// The KKLO of [`VaryingExponentialCascadeMap`] with the gain c, in 1/s: the error of `exp(x3)` decays at the rate
/// `c - 1 - u^2/12` or faster, and at `c - 1` or faster where `u = -y`.
///
/// Its xi2 + k is an estimate of exp(x3), and may be negative on the way: x3hat is not taken below `ln` of [`LOWEST`].
///
/// ```
/// use luenberger_observers::{KklMap, Observer};
/// use luenberger_reproduce::kkl::exponential_cascade;
/// use nalgebra::{Vector1, Vector2};
/// let observer = exponential_cascade::kklo(2.0)?;
/// let (u, y) = (Vector1::new(-0.5), Vector1::new(0.5));
/// let poles = observer.map().lambda(0.0, &u, &y).diagonal();
/// assert_eq!(poles, Vector2::new(-1.0, 1.0 / 1.25 - 0.25 - 0.75 - 2.0));
/// // x3hat = 0 is exp(x3hat) = 1.
/// let state = observer.initial(0.0, &Vector2::zeros(), &u, &y);
/// assert_eq!(state, Vector2::new(0.0, 1.0 - 1.0 - 0.125));
/// # Ok::<(), luenberger_observers::ObserverError>(())
/// ```
/// # Errors
/// [`ObserverError::NotPositive`] unless c is positive and finite.
pub fn kklo<T: RealField + Copy>(c: T) -> Result<ExponentialCascadeKklo<T>, ObserverError> {
    positive("the gain c", c).map(|c| KklObserver::new(VaryingExponentialCascadeMap { c }))
}

impl<T: RealField + Copy> VaryingExponentialCascadeMap<T> {
    /// `k(y)`, `k'(y)`, and `a - k'`.
    fn parts(&self, u: T, y: T) -> [T; 3] {
        let square = y * y;
        let slope = self.c + square * convert(3.0);
        [(self.c + square) * y, slope, finite_or_zero(T::one() / (square + T::one()) + y * u - slope)]
    }
}

impl<T: RealField + Copy> KklMap<T> for VaryingExponentialCascadeMap<T> {
    type Xi = U2;
    type Inputs = U1;
    type Outputs = U1;
    type Estimate = U2;

    fn lambda(&self, _t: T, u: &Vector1<T>, y: &Vector1<T>) -> Matrix2<T> {
        Matrix2::from_diagonal(&Vector2::new(-T::one(), self.parts(u[0], y[0])[2]))
    }

    /// An entry that overflows is 0.
    fn injection(&self, _t: T, _xi: &Vector2<T>, u: &Vector1<T>, y: &Vector1<T>) -> Vector2<T> {
        let ([k, slope, pole], square) = (self.parts(u[0], y[0]), y[0] * y[0]);
        Vector2::new(finite_or_zero(square + y[0].sin()), finite_or_zero(pole * k + slope * square * y[0]))
    }

    fn left_inverse(&self, _t: T, xi: &Vector2<T>, y: &Vector1<T>) -> Vector2<T> {
        let exponential = finite_or_zero(xi[1] + self.parts(T::zero(), y[0])[0]);
        Vector2::new(xi[0], exponential.max(convert(LOWEST)).ln())
    }

    fn image(&self, _t: T, xhat: &Vector2<T>, y: &Vector1<T>) -> Vector2<T> {
        Vector2::new(xhat[0], xhat[1].exp() - self.parts(T::zero(), y[0])[0])
    }
}
