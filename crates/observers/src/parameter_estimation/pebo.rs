//! Parameter-estimation-based observers: the state as an integral and a constant; eq. (8) to (12) of the [KKL+PEB]
//! paper.
//!
//! phi takes the plant to pure integrators, `d phi(x)/dt = B(h(x), u)`, so that with `xi' = B(y, u)` what is missing is
//! a constant, `phi(x(t)) = xi(t) + theta`. The constant is estimated, and `xhat = phi^L(xi + theta_hat, y)`.
//!
//! The paper's regression (11) uses y', which is not measured. Where some function s of the outputs changes affinely in
//! theta,
//!
//! ```text
//! d s(y)/dt = g(t, xi, u, y) + m(t, xi, u, y) theta
//! ```
//!
//! filtering both sides gives a regression in known signals only:
//!
//! ```text
//! Y = M theta,  Y = W[s] - F[g],  M = F[m]          F = alpha/(p + alpha), W = alpha p/(p + alpha)
//! ```
//!
//! exactly, from the start, if the filter of W starts at s(y(0)) and those of F at 0: the transients of
//! `F[g + m theta]` and of `W[s]` are then the same, because theta is constant. [`Regression`] is s, g and m, and what
//! theta means.
//!
//! A PEBO is the case Lambda = 0 of the [KKL+PEB]O (R4), and that is how it is made: a [`KklMap`](crate::KklMap) that
//! does not define [`lambda`](crate::KklMap::lambda), with a [`Regression`]. Its drawback stays (R2): integrators
//! integrate every offset there is.
//!
//! Source: R. Ortega, A. Bobtsov, A. Pyrkin and S. Aranovskiy, Systems and Control Letters 85, 2015.

use super::kkl_peb::KklPebObserver;

pub use super::regression::{PebSize, Regression};

/// A parameter-estimation-based observer: a [KKL+PEB]O whose Lambda is zero.
///
/// For `x1' = x2 + u`, `x2' = x1^2`, `y = x1`: `phi = x2`, `xi' = y^2`, and `y' = xi + u + theta`:
/// ```
/// use luenberger_observers::estimator::gradient::Gradient;
/// use luenberger_observers::{KklMap, Observer, PeboObserver, Regression};
/// use nalgebra::{Matrix1, U1, Vector1};
///
/// struct Squared;
///
/// impl KklMap<f64> for Squared {
///     type Xi = U1;
///     type Inputs = U1;
///     type Outputs = U1;
///     type Estimate = U1;
///     fn injection(&self, _t: f64, _xi: &Vector1<f64>, _u: &Vector1<f64>, y: &Vector1<f64>) -> Vector1<f64> {
///         Vector1::new(y[0] * y[0])
///     }
///     fn left_inverse(&self, _t: f64, xi: &Vector1<f64>, _y: &Vector1<f64>) -> Vector1<f64> {
///         *xi
///     }
///     fn image(&self, _t: f64, xhat: &Vector1<f64>, _y: &Vector1<f64>) -> Vector1<f64> {
///         *xhat
///     }
/// }
///
/// impl Regression<f64> for Squared {
///     type Rows = U1;
///     type Parameters = U1;
///     fn signal(&self, _t: f64, y: &Vector1<f64>) -> Vector1<f64> {
///         *y
///     }
///     fn known(&self, _t: f64, xi: &Vector1<f64>, u: &Vector1<f64>, _y: &Vector1<f64>) -> Vector1<f64> {
///         xi + u
///     }
///     fn regressor(&self, _t: f64, _xi: &Vector1<f64>, _u: &Vector1<f64>, _y: &Vector1<f64>) -> Matrix1<f64> {
///         Matrix1::new(1.0)
///     }
///     fn missing(&self, theta: &Vector1<f64>) -> Vector1<f64> {
///         *theta
///     }
/// }
///
/// let observer = PeboObserver::new(Squared, Gradient::new(Matrix1::new(3.0))?, 10.0)?;
/// let (u, mut x) = (Vector1::new(-0.2), [0.1, 0.3]);
/// let mut state = observer.initial(0.0, &Vector1::new(-1.0), &u, &Vector1::new(x[0]));
/// // Euler with 1 ms over 4 s, plant and observer.
/// for k in 0..4000 {
///     let y = Vector1::new(x[0]);
///     state += observer.derivative(f64::from(k) * 1e-3, &state, &u, &y) * 1e-3;
///     x = [x[0] + 1e-3 * (x[1] + u[0]), x[1] + 1e-3 * x[0] * x[0]];
/// }
/// let xhat = observer.estimate(4.0, &state, &u, &Vector1::new(x[0]));
/// // It started 1.3 off; gamma int F[1]^2 is 11.5, and exp(-11.5) = 1e-5.
/// assert!((xhat[0] - x[1]).abs() < 1e-4);
/// # Ok::<(), luenberger_observers::ObserverError>(())
/// ```
pub type PeboObserver<K, E, T> = KklPebObserver<K, E, T>;
