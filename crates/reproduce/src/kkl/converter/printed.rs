//! Table I exactly as printed: the observers with its misprints, hence separate from the corrected observers.
//!
//! The states start at 0 and the filters W at the output, as in the corrected ones. `F[g]` is a state f with `f' =
//! alpha (g - f)`, and `W[s] = alpha (s - w)` with `w' = alpha (s - w)`. The printed KKLO is correct, and is that of
//! [`cuk`](crate::kkl::cuk).

use crate::kkl::cuk::Tuning;
use luenberger_observers::{Observer, ObserverDimensions};
use luenberger_plants::CukConverter;
use nalgebra::{SVector, Vector1, Vector2, Vector4};

/// The lengths of an observer of (i1, v4) from (v2, i3) and u with a state of this length.
fn dimensions(state: usize) -> ObserverDimensions {
    ObserverDimensions { state, inputs: 1, outputs: 2, estimate: 2 }
}

/// PEBO: in M, `-1/L3` without its filter; in Y, `F[... + G L3 y2/C4]` where `G y2/C4` has to stand.
///
/// The state is `(xi1, xi2, w1, w2, F[w], F[w xi1 + u y2], F[(u y1 + xi2)/L3 + G L3 y2/C4], theta1, theta2)`.
#[derive(Clone, Copy, Debug)]
pub struct Pebo {
    plant: CukConverter,
    tuning: Tuning<f64>,
}

impl Pebo {
    /// For this converter with these numbers.
    pub fn new(plant: CukConverter, tuning: Tuning<f64>) -> Self {
        Self { plant, tuning }
    }
}

impl Observer<f64> for Pebo {
    type State = SVector<f64, 9>;
    type Input = Vector1<f64>;
    type Output = Vector2<f64>;
    type Estimate = Vector2<f64>;

    fn dimensions(&self) -> ObserverDimensions {
        dimensions(9)
    }

    fn derivative(&self, _t: f64, state: &Self::State, u: &Vector1<f64>, y: &Vector2<f64>) -> Self::State {
        let CukConverter { l1, c2, l3, c4, g, e } = self.plant;
        let Tuning { alpha, gains, .. } = self.tuning;
        let (u, w) = (u[0], 1.0 - u[0]);
        let [xi1, xi2, w1, w2, fw, f1, f2, theta1, theta2] = state.data.0[0];
        let (m1, m2) = (fw / c2, -1.0 / l3);
        let (y1, y2) = (alpha * (y[0] - w1) - f1 / c2, alpha * (y[1] - w2) + f2);
        let filtered = |input: f64, state: f64| alpha * (input - state);
        SVector::from([
            (e - w * y[0]) / l1,
            (y[1] + g * u * y[0]) / c4,
            filtered(y[0], w1),
            filtered(y[1], w2),
            filtered(w, fw),
            filtered(w * xi1 + u * y[1], f1),
            filtered((u * y[0] + xi2) / l3 + g * l3 * y[1] / c4, f2),
            gains[0] * m1 * (y1 - m1 * theta1),
            gains[1] * m2 * (y2 - m2 * theta2),
        ])
    }

    fn estimate(&self, _t: f64, state: &Self::State, _u: &Vector1<f64>, y: &Vector2<f64>) -> Vector2<f64> {
        let CukConverter { l3, c4, g, .. } = self.plant;
        Vector2::new(state[0] + state[7], state[1] + state[8] + g * l3 * y[1] / c4)
    }

    fn initial(&self, _t: f64, _estimate: &Vector2<f64>, _u: &Vector1<f64>, y: &Vector2<f64>) -> Self::State {
        SVector::from([0.0, 0.0, y[0], y[1], 0.0, 0.0, 0.0, 0.0, 0.0])
    }
}

/// [KKL+PEB]O: xi2 in Y where xi1 has to stand.
///
/// The state is `(xi1, xi2, w, F[w], F[w xi2 + u y2], theta)`.
#[derive(Clone, Copy, Debug)]
pub struct KklPeb {
    plant: CukConverter,
    tuning: Tuning<f64>,
}

impl KklPeb {
    /// For this converter with these numbers.
    pub fn new(plant: CukConverter, tuning: Tuning<f64>) -> Self {
        Self { plant, tuning }
    }
}

impl Observer<f64> for KklPeb {
    type State = SVector<f64, 6>;
    type Input = Vector1<f64>;
    type Output = Vector2<f64>;
    type Estimate = Vector2<f64>;

    fn dimensions(&self) -> ObserverDimensions {
        dimensions(6)
    }

    fn derivative(&self, _t: f64, state: &Self::State, u: &Vector1<f64>, y: &Vector2<f64>) -> Self::State {
        let CukConverter { l1, c2, c4, g, e, .. } = self.plant;
        let Tuning { alpha, gamma, .. } = self.tuning;
        let (u, w) = (u[0], 1.0 - u[0]);
        let [_, xi2, w1, fw, f1, theta] = state.data.0[0];
        let m = fw / c2;
        let regressed = alpha * (y[0] - w1) - f1 / c2;
        SVector::from([
            (e - w * y[0]) / l1,
            (y[1] - g * xi2) / c4,
            alpha * (y[0] - w1),
            alpha * (w - fw),
            alpha * (w * xi2 + u * y[1] - f1),
            gamma * m * (regressed - m * theta),
        ])
    }

    fn estimate(&self, _t: f64, state: &Self::State, _u: &Vector1<f64>, _y: &Vector2<f64>) -> Vector2<f64> {
        Vector2::new(state[0] + state[5], state[1])
    }

    fn initial(&self, _t: f64, _estimate: &Vector2<f64>, _u: &Vector1<f64>, y: &Vector2<f64>) -> Self::State {
        SVector::from([0.0, 0.0, y[0], 0.0, 0.0, 0.0])
    }
}

/// I&IO: `+ g1 u y2` in xi1', and `xhat = xi + (C2 g1 y1, L3 g2 y2)`, both with the wrong sign.
#[derive(Clone, Copy, Debug)]
pub struct ImmersionInvariance {
    plant: CukConverter,
    tuning: Tuning<f64>,
}

impl ImmersionInvariance {
    /// For this converter with these numbers.
    pub fn new(plant: CukConverter, tuning: Tuning<f64>) -> Self {
        Self { plant, tuning }
    }
}

impl Observer<f64> for ImmersionInvariance {
    type State = Vector2<f64>;
    type Input = Vector1<f64>;
    type Output = Vector2<f64>;
    type Estimate = Vector2<f64>;

    fn dimensions(&self) -> ObserverDimensions {
        dimensions(2)
    }

    fn derivative(&self, _t: f64, xi: &Vector2<f64>, u: &Vector1<f64>, y: &Vector2<f64>) -> Vector2<f64> {
        let CukConverter { l1, c2, l3, c4, g, e } = self.plant;
        let Tuning { g1, g2, .. } = self.tuning;
        let (u, w) = (u[0], 1.0 - u[0]);
        let v4 = xi[1] - l3 * g2 * y[1];
        Vector2::new(
            -g1 * w * (xi[0] + c2 * g1 * y[0]) + g1 * u * y[1] + (e - w * y[0]) / l1,
            (y[1] - g * v4) / c4 - g2 * (u * y[0] + v4),
        )
    }

    fn estimate(&self, _t: f64, xi: &Vector2<f64>, _u: &Vector1<f64>, y: &Vector2<f64>) -> Vector2<f64> {
        let (CukConverter { c2, l3, .. }, Tuning { g1, g2, .. }) = (self.plant, self.tuning);
        xi + Vector2::new(c2 * g1 * y[0], l3 * g2 * y[1])
    }

    fn initial(&self, _t: f64, _estimate: &Vector2<f64>, _u: &Vector1<f64>, _y: &Vector2<f64>) -> Vector2<f64> {
        Vector2::zeros()
    }
}

/// The high-gain observers. Time-varying: the correction of xi4 has the wrong sign. Linear: r1 for r2, and the plant's
/// right-hand sides of i1 and v4 in xi2' and xi4', which are the derivatives of y1' and y2'.
#[derive(Clone, Copy, Debug)]
pub struct HighGain {
    plant: CukConverter,
    tuning: Tuning<f64>,
    linear: bool,
}

impl HighGain {
    /// The one with time-varying error dynamics.
    pub fn time_varying(plant: CukConverter, tuning: Tuning<f64>) -> Self {
        Self { plant, tuning, linear: false }
    }

    /// The one with linear error dynamics.
    pub fn linear(plant: CukConverter, tuning: Tuning<f64>) -> Self {
        Self { plant, tuning, linear: true }
    }
}

impl Observer<f64> for HighGain {
    type State = Vector4<f64>;
    type Input = Vector1<f64>;
    type Output = Vector2<f64>;
    type Estimate = Vector2<f64>;

    fn dimensions(&self) -> ObserverDimensions {
        dimensions(4)
    }

    fn derivative(&self, _t: f64, xi: &Vector4<f64>, u: &Vector1<f64>, y: &Vector2<f64>) -> Vector4<f64> {
        let CukConverter { l1, c2, l3, c4, g, e } = self.plant;
        let Tuning { r1, coefficients: [a1, a2, a3, a4], .. } = self.tuning;
        let (u, w) = (u[0], 1.0 - u[0]);
        let (e1, e2) = (y[0] - xi[0], y[1] - xi[2]);
        let (first, third) =
            if self.linear { (xi[1], xi[3]) } else { ((w * xi[1] + u * y[1]) / c2, -(xi[3] + u * y[0]) / l3) };
        Vector4::new(
            first + a1 / r1 * e1,
            (e - w * y[0]) / l1 + a2 / (r1 * r1) * e1,
            third + a3 / r1 * e2,
            (y[1] - g * xi[3]) / c4 + a4 / (r1 * r1) * e2,
        )
    }

    fn estimate(&self, _t: f64, xi: &Vector4<f64>, u: &Vector1<f64>, y: &Vector2<f64>) -> Vector2<f64> {
        let CukConverter { c2, l3, .. } = self.plant;
        if self.linear {
            // 1 - u stays above 0.2 in the run.
            Vector2::new((c2 * xi[1] - u[0] * y[1]) / (1.0 - u[0]), -l3 * xi[3] - u[0] * y[0])
        } else {
            Vector2::new(xi[1], xi[3])
        }
    }

    fn initial(&self, _t: f64, _estimate: &Vector2<f64>, _u: &Vector1<f64>, _y: &Vector2<f64>) -> Vector4<f64> {
        Vector4::zeros()
    }
}
