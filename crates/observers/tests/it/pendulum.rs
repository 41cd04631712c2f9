//! A sampled pendulum with two nonlinear outputs, for the filters.

#![cfg(feature = "dual")]

use luenberger_observers::NoiseModel;
use luenberger_plants::plant;
use nalgebra::{Const, Matrix2};

/// x1+ = x1 + x2/10, x2+ = 0.98 x2 - sin(x1)/10, y = (sin x1, x1 x2).
#[derive(Clone, Debug)]
pub(crate) struct Pendulum;

plant!(
    Pendulum,
    (2, 0, 2),
    |plant, t, x, u| {
        let of = |x: f64| nalgebra::convert::<f64, T>(x);
        [x[0] + of(0.1) * x[1], x[1] - of(0.1) * x[0].sin() - of(0.02) * x[1]]
    },
    [x[0].sin(), x[0] * x[1]]
);

/// Covariances of its noise and first error.
pub(crate) fn noises() -> NoiseModel<f64, Const<2>, Const<2>> {
    NoiseModel {
        w: Matrix2::new(0.01, 0.002, 0.002, 0.02),
        v: Matrix2::new(0.04, 0.01, 0.01, 0.09),
        p0: Matrix2::new(0.5, 0.1, 0.1, 0.3),
    }
}
