//! A plant and maps that bring their own derivatives, as on a bare target: the same with the feature `dual` and without
//! it.

use luenberger_observers::Observer;
use luenberger_observers::immersion_invariance::{DifferentiableImmersion, Immersion, ImmersionInvarianceObserver};
use luenberger_plants::{Differentiable, Dimensions, Plant, Shape};
use nalgebra::{RealField, U1, U2, Vector1, Vector2, convert};

/// `x1' = x2`, `x2' = -x2^3 + u`, `y = x1`.
#[derive(Clone, Copy, Debug)]
struct Drag;

impl Shape for Drag {
    fn dimensions(&self) -> Dimensions {
        Dimensions { states: 2, inputs: 1, outputs: 1 }
    }
}

impl<T: RealField + Copy> Plant<T> for Drag {
    type State = Vector2<T>;
    type Input = Vector1<T>;
    type Output = Vector1<T>;

    fn derivative(&self, _t: T, x: &Vector2<T>, u: &Vector1<T>) -> Vector2<T> {
        Vector2::new(x[1], u[0] - x[1] * x[1] * x[1])
    }

    fn output(&self, _t: T, x: &Vector2<T>, _u: &Self::Input) -> Vector1<T> {
        Vector1::new(x[0])
    }
}

impl<T: RealField + Copy> Differentiable<T, U2, U1, U1> for Drag {
    fn directional(&self, t: T, x: &Vector2<T>, u: &Vector1<T>, v: &Vector2<T>) -> (Vector2<T>, Vector2<T>) {
        let slope = -convert::<f64, T>(3.0) * x[1] * x[1];
        (self.derivative(t, x, u), Vector2::new(v[1], slope * v[1]))
    }

    fn output_directional(&self, t: T, x: &Vector2<T>, u: &Vector1<T>, v: &Vector2<T>) -> (Vector1<T>, Vector1<T>) {
        (self.output(t, x, u), Vector1::new(v[0]))
    }
}

const GAIN: f64 = 4.0;

/// `beta = chi + GAIN sinh y`, `phi = x2 cosh y`: neither is linear, so that each derivative is taken somewhere.
#[derive(Clone, Copy, Debug)]
struct Speed;

impl<T: RealField + Copy> Immersion<T> for Speed {
    type States = U2;
    type Inputs = U1;
    type Outputs = U1;
    type Manifold = U1;
    type Extension = U1;
    type Estimate = U1;

    fn beta(&self, y: &Vector1<T>, chi: &Vector1<T>) -> Vector1<T> {
        Vector1::new(chi[0] + convert::<f64, T>(GAIN) * y[0].sinh())
    }

    fn phi(&self, x: &Vector2<T>) -> Vector1<T> {
        Vector1::new(x[1] * x[0].cosh())
    }

    fn left_inverse(&self, z: &Vector1<T>, y: &Vector1<T>) -> Vector2<T> {
        Vector2::new(y[0], z[0] / y[0].cosh())
    }

    fn estimate(&self, xhat: &Vector2<T>) -> Vector1<T> {
        Vector1::new(xhat[1])
    }

    fn start(&self, estimate: &Vector1<T>, y: &Vector1<T>) -> Vector1<T> {
        Vector1::new(estimate[0] * y[0].cosh() - convert::<f64, T>(GAIN) * y[0].sinh())
    }
}

impl<T: RealField + Copy> DifferentiableImmersion<T> for Speed {
    fn beta_directional(&self, y: &Vector1<T>, _chi: &Vector1<T>, dy: &Vector1<T>, dchi: &Vector1<T>) -> Vector1<T> {
        Vector1::new(dchi[0] + convert::<f64, T>(GAIN) * y[0].cosh() * dy[0])
    }

    fn phi_directional(&self, x: &Vector2<T>, dx: &Vector2<T>) -> Vector1<T> {
        Vector1::new(x[1] * x[0].sinh() * dx[0] + x[0].cosh() * dx[1])
    }
}

/// (18) by hand, with s = sinh y, c = cosh y and v the estimate of x2: beta has to move as phi(xhat) does along
/// f(xhat),
/// `chi' = s v^2 + c (u - v^3) - GAIN c v`.
#[test]
fn an_immersion_with_its_own_derivatives_needs_no_dual_numbers() {
    let observer = ImmersionInvarianceObserver::new(Drag, Speed);
    for (y, v, u) in [(0.0f64, 1.0f64, 0.0f64), (0.5, -2.0, 0.25), (-1.25, 0.5, -3.0)] {
        let (measured, input) = (Vector1::new(y), Vector1::new(u));
        let chi = observer.initial(0.0, &Vector1::new(v), &input, &measured);
        let found: f64 = observer.estimate(0.0, &chi, &input, &measured)[0];
        // Sums of a few terms below 20.
        assert!((found - v).abs() <= 64.0 * f64::EPSILON, "{found} {v}");
        let slope = observer.derivative(0.0, &chi, &input, &measured)[0];
        let (s, c) = (y.sinh(), y.cosh());
        let claimed = s * v * v + c * (u - v * v * v) - GAIN * c * v;
        assert!((slope - claimed).abs() <= 256.0 * f64::EPSILON * (1.0 + claimed.abs()), "{slope} {claimed}");
    }
}
