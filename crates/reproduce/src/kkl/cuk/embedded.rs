//! The maps that make the [KKL+PEB]O an I&IO: Proposition 5, as printed and corrected.
//!
//! chi is the whole state (xi1, xi2, w, F[g], F[m], theta_hat) of the [KKL+PEB]O, `beta = (xi1 + theta_hat, xi2)` its
//! estimate, (21), and `phi = (i1, v4)`. beta depends on two directions of chi; in the other four chi evolves according
//! to Q, for which the right-hand side of the [KKL+PEB]O is the natural choice. In the two, (18) makes beta follow
//! phi(xhat), so that the estimate of i1 evolves as i1 does and its error stays constant. That of the [KKL+PEB]O has
//! the additional term `d theta_hat/dt`, and `rho = (d theta_hat/dt, 0)` is the missing term.

use luenberger_plants::CukConverter;
use nalgebra::{RealField, U1, U2, U4, U6, Vector1, Vector2, Vector4, Vector6, convert};

use super::{CukKklPebo, Tuning, complete, kkl_pebo, unmeasured};
use luenberger_observers::Observer;
use luenberger_observers::ObserverError;
use luenberger_observers::immersion_invariance::Immersion;

/// What (18) is given beside beta and phi.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Embedding {
    /// Q = 0 and rho = 0: (21) to (23) as printed.
    Printed,
    /// Q is the right-hand side of the [KKL+PEB]O.
    Free,
    /// The same Q, and `rho = (d theta_hat/dt, 0)`: the I&IO is the [KKL+PEB]O.
    Equivalent,
}

/// The maps of Proposition 5 for the converter's [KKL+PEB]O.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CukKklPebImmersion {
    pub(super) converter: CukConverter,
    pub(super) alpha: f64,
    pub(super) gamma: f64,
    pub(super) embedding: Embedding,
}

impl CukKklPebImmersion {
    fn original<T: RealField + Copy>(&self) -> Result<CukKklPebo<T>, ObserverError> {
        let tuning = Tuning { alpha: convert(self.alpha), gamma: convert(self.gamma), ..Tuning::default() };
        kkl_pebo(self.converter, &tuning)
    }

    /// The right-hand side of the [KKL+PEB]O, whose numbers the constructor has seen accepted.
    fn slope<T: RealField + Copy>(&self, chi: &Vector6<T>, u: &Vector1<T>, y: &Vector2<T>) -> Vector6<T> {
        self.original().map_or_else(|_| Vector6::zeros(), |original| original.derivative(T::zero(), chi, u, y))
    }
}

impl luenberger_plants::ByDual for CukKklPebImmersion {}

impl<T: RealField + Copy> Immersion<T> for CukKklPebImmersion {
    type States = U4;
    type Inputs = U1;
    type Outputs = U2;
    type Manifold = U2;
    type Extension = U6;
    type Estimate = U2;

    fn beta(&self, _y: &Vector2<T>, chi: &Vector6<T>) -> Vector2<T> {
        Vector2::new(chi[0] + chi[5], chi[1])
    }

    fn phi(&self, x: &Vector4<T>) -> Vector2<T> {
        unmeasured(x)
    }

    fn left_inverse(&self, z: &Vector2<T>, y: &Vector2<T>) -> Vector4<T> {
        complete(z, y)
    }

    fn estimate(&self, xhat: &Vector4<T>) -> Vector2<T> {
        unmeasured(xhat)
    }

    fn start(&self, estimate: &Vector2<T>, y: &Vector2<T>) -> Vector6<T> {
        let start = |original: CukKklPebo<T>| original.initial(T::zero(), estimate, &Vector1::zeros(), y);
        self.original().map_or_else(|_| Vector6::zeros(), start)
    }

    fn freedom(&self, y: &Vector2<T>, chi: &Vector6<T>, u: &Vector1<T>) -> Vector6<T> {
        if self.embedding == Embedding::Printed { Vector6::zeros() } else { self.slope(chi, u, y) }
    }

    fn rho(&self, y: &Vector2<T>, chi: &Vector6<T>, u: &Vector1<T>) -> Option<Vector2<T>> {
        (self.embedding == Embedding::Equivalent).then(|| Vector2::new(self.slope(chi, u, y)[5], T::zero()))
    }
}
