//! Observers of a pendulum with friction, measured in its angle: `x1' = x2`, `x2' = -9.81 sin x1 - x2/10 + u`.

use luenberger_observers::high_gain::{ChainPosition, HighGainMap};
use luenberger_observers::{
    NoiseModel, ObserverError, StaticExtendedKalmanFilter, StaticHighGainObserver, StaticNonlinearLuenbergerObserver,
};
use luenberger_plants::Differentiable;
use luenberger_plants::plant::{Dimensions, Plant, Shape};
use nalgebra::{Matrix1, Matrix2, U1, U2, Vector1, Vector2};

use crate::Number;
use crate::stepped::Stepped;

/// The extended Kalman filter of the pendulum.
pub type ExtendedKalman<T> = StaticExtendedKalmanFilter<Pendulum, T, 2, 1, 1>;

/// The copy of the pendulum with a constant gain.
pub type Luenberger<T> = Stepped<T, StaticNonlinearLuenbergerObserver<Pendulum, T, 2, 1, 1>>;

/// The high-gain observer of the pendulum.
pub type HighGain<T> = Stepped<T, StaticHighGainObserver<Pendulum, T, 2>>;

/// The plant.
#[derive(Clone, Copy, Debug)]
pub struct Pendulum;

impl Shape for Pendulum {
    fn dimensions(&self) -> Dimensions {
        Dimensions { states: 2, inputs: 1, outputs: 1 }
    }
}

impl<T: Number> Plant<T> for Pendulum {
    type State = Vector2<T>;
    type Input = Vector1<T>;
    type Output = Vector1<T>;

    fn derivative(&self, _t: T, x: &Vector2<T>, u: &Vector1<T>) -> Vector2<T> {
        Vector2::new(x[1], u[0] - T::of(9.81) * x[0].sin() - T::of(0.1) * x[1])
    }

    fn output(&self, _t: T, x: &Vector2<T>, _u: &Vector1<T>) -> Vector1<T> {
        Vector1::new(x[0])
    }
}

impl<T: Number> Differentiable<T, U2, U1, U1> for Pendulum {
    fn directional(&self, t: T, x: &Vector2<T>, u: &Vector1<T>, v: &Vector2<T>) -> (Vector2<T>, Vector2<T>) {
        let along = Vector2::new(v[1], -(T::of(9.81) * x[0].cos() * v[0]) - T::of(0.1) * v[1]);
        (self.derivative(t, x, u), along)
    }

    fn output_directional(&self, t: T, x: &Vector2<T>, u: &Vector1<T>, v: &Vector2<T>) -> (Vector1<T>, Vector1<T>) {
        (self.output(t, x, u), Vector1::new(v[0]))
    }
}

/// The extended Kalman filter every 20 ms, in two steps of Runge-Kutta.
///
/// # Errors
/// None, for these numbers.
pub fn extended_kalman<T: Number>() -> Result<ExtendedKalman<T>, ObserverError> {
    let noises = NoiseModel {
        w: Matrix2::from_diagonal_element(T::of(0.1)),
        v: Matrix1::new(T::of(0.01)),
        p0: Matrix2::identity(),
    };
    StaticExtendedKalmanFilter::new(Pendulum, noises, T::of(0.02), 2)
}

/// The same filter, with three linearisations of each measurement.
///
/// # Errors
/// None, for these numbers.
pub fn iterated_kalman<T: Number>() -> Result<ExtendedKalman<T>, ObserverError> {
    extended_kalman()?.with_iterations(3)
}

/// The copy of the plant with a constant gain, every 20 ms.
///
/// # Errors
/// None, for these numbers.
pub fn luenberger<T: Number>() -> Result<Luenberger<T>, ObserverError> {
    let l = Vector2::new(T::of(6.0), T::of(12.0));
    Ok(Stepped::new(StaticNonlinearLuenbergerObserver::new(Pendulum, l)?, T::of(0.02)))
}

impl<T: Number> HighGainMap<T> for Pendulum {
    type Xi = U2;
    type Inputs = U1;
    type Outputs = U1;
    type Estimate = U2;

    fn place(&self, i: usize) -> ChainPosition {
        ChainPosition { output: 0, position: i + 1 }
    }

    fn drift(&self, t: T, xi: &Vector2<T>, u: &Vector1<T>, _y: &Vector1<T>) -> Vector2<T> {
        Plant::derivative(self, t, xi, u)
    }

    fn estimate(&self, _t: T, xi: &Vector2<T>, _u: &Vector1<T>, _y: &Vector1<T>) -> Vector2<T> {
        *xi
    }

    fn start(&self, _t: T, estimate: &Vector2<T>, _u: &Vector1<T>, _y: &Vector1<T>) -> Vector2<T> {
        *estimate
    }
}

/// The high-gain observer, every 20 ms.
///
/// # Errors
/// None, for these numbers.
pub fn high_gain<T: Number>() -> Result<HighGain<T>, ObserverError> {
    let alpha = Vector2::new(T::of(2.0), T::of(1.0));
    Ok(Stepped::new(StaticHighGainObserver::new(Pendulum, alpha, T::of(0.1))?, T::of(0.02)))
}
