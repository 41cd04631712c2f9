//! Immersion and invariance: Proposition 4, with an extension longer than the manifold.

#![cfg(feature = "dual")]

use luenberger_observers::Observer;
use luenberger_observers::immersion_invariance::{Immersion, ImmersionInvarianceObserver};
use luenberger_plants::{Chaotic, Plant};
use nalgebra::{RealField, SVector, U0, U1, U2, U3, Vector1, Vector2, Vector3};
use proptest::prelude::*;

/// `phi = x3 + x1^2` and `beta = chi1 + chi2 y1 + sin chi3 + y2^2` for the chaotic plant: an extension longer than the
/// manifold, nonlinear in everything, with a Q and a rho.
#[derive(Clone, Copy, Debug)]
struct Winding;

impl luenberger_plants::ByDual for Winding {}

impl<T: RealField + Copy> Immersion<T> for Winding {
    type States = U3;
    type Inputs = U0;
    type Outputs = U2;
    type Manifold = U1;
    type Extension = U3;
    type Estimate = U1;

    fn beta(&self, y: &Vector2<T>, chi: &Vector3<T>) -> Vector1<T> {
        Vector1::new(chi[0] + chi[1] * y[0] + chi[2].sin() + y[1] * y[1])
    }
    fn phi(&self, x: &Vector3<T>) -> Vector1<T> {
        Vector1::new(x[2] + x[0] * x[0])
    }
    fn left_inverse(&self, z: &Vector1<T>, y: &Vector2<T>) -> Vector3<T> {
        Vector3::new(y[0], y[1], z[0] - y[0] * y[0])
    }
    fn estimate(&self, xhat: &Vector3<T>) -> Vector1<T> {
        Vector1::new(xhat[2])
    }
    fn start(&self, estimate: &Vector1<T>, y: &Vector2<T>) -> Vector3<T> {
        Vector3::new(estimate[0] + y[0] * y[0] - y[1] * y[1], T::zero(), T::zero())
    }
    fn rho(&self, y: &Vector2<T>, chi: &Vector3<T>, _u: &SVector<T, 0>) -> Option<Vector1<T>> {
        Some(Vector1::new(chi[0] * y[1]))
    }
    fn freedom(&self, y: &Vector2<T>, chi: &Vector3<T>, _u: &SVector<T, 0>) -> Vector3<T> {
        Vector3::new(chi[1], y[0], -chi[2])
    }
}

proptest! {
    /// Proposition 4, eq. (16), with every derivative taken by hand: the distance from the manifold moves with what x
    /// and xhat differ in, with rho, and with nothing else, whatever Q. In the directions of chi that beta does not
    /// see, chi' is Q.
    #[test]
    fn the_distance_from_the_manifold_obeys_16(x in prop::array::uniform3(-2.0..2.0f64), chi in prop::array::uniform3(-2.0..2.0f64)) {
        let (x, chi, u) = (Vector3::from(x), Vector3::from(chi), SVector::<f64, 0>::zeros());
        let observer = ImmersionInvarianceObserver::new(Chaotic, Winding);
        let y = Chaotic.output(0.0, &x, &u);
        let slope: Vector3<f64> = observer.derivative(0.0, &chi, &u, &y);
        let xhat = Vector3::new(y[0], y[1], observer.estimate(0.0, &chi, &u, &y)[0]);
        let (f, fhat) = (Chaotic.derivative(0.0, &x, &u), Chaotic.derivative(0.0, &xhat, &u));
        let beta_rate = slope[0] + slope[1] * y[0] + chi[1] * f[0] + chi[2].cos() * slope[2] + 2.0 * y[1] * f[1];
        let phi_rate = |f: &Vector3<f64>| f[2] + 2.0 * x[0] * f[0];
        let moved = beta_rate - phi_rate(&f);
        let rho = chi[0] * y[1];
        let claimed = rho + chi[1] * (f[0] - fhat[0]) + 2.0 * y[1] * (f[1] - fhat[1]) - phi_rate(&f) + phi_rate(&fhat);
        // f up to 20 here, multiplied by 4.
        prop_assert!((moved - claimed).abs() <= 256.0 * f64::EPSILON * 80.0, "{moved} {claimed}");
        // The kernel of D_chi beta = (1, y1, cos chi3).
        for hidden in [Vector3::new(-y[0], 1.0, 0.0), Vector3::new(-chi[2].cos(), 0.0, 1.0)] {
            let deviation: f64 = hidden.dot(&(slope - Vector3::new(chi[1], y[0], -chi[2])));
            prop_assert!(deviation.abs() <= 256.0 * f64::EPSILON * 80.0, "{deviation}");
        }
        // On the manifold it stays.
        let on = observer.initial(0.0, &Vector1::new(x[2]), &u, &y);
        prop_assert!((observer.estimate(0.0, &on, &u, &y)[0] - x[2]).abs() <= 16.0 * f64::EPSILON * 8.0);
    }
}
