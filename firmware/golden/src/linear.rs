//! Observers of linear plants, with matrices without pattern and small enough for stable observers.

pub use luenberger_observers::{
    StaticDiscreteLinearObserver as Linear, StaticKalmanFilter as Kalman, StaticSampledCubicObserver as Cubic,
};

use luenberger_observers::{KalmanModel, ObserverError, SampledCubicGains};
use luenberger_plants::StaticPlant;
use nalgebra::SMatrix;

use crate::{Noise, Number};

const PERIOD: f64 = 0.05;

/// Entries of magnitude below `size`.
fn matrix<T: Number, const R: usize, const C: usize>(noise: &mut Noise, size: f64) -> SMatrix<T, R, C> {
    SMatrix::from_fn(|_, _| T::of(0.5 * size * noise.number()))
}

/// A times the identity, and zeros where the matrix is not square.
fn diagonal<T: Number, const R: usize, const C: usize>(x: f64) -> SMatrix<T, R, C> {
    SMatrix::from_fn(|i, j| if i == j { T::of(x) } else { T::zero() })
}

/// `xhat+ = A xhat + B u + L (y - C xhat)`.
///
/// # Errors
/// None, for these numbers.
pub fn linear<T: Number, const N: usize, const M: usize, const P: usize>() -> Result<Linear<T, N, M, P>, ObserverError>
{
    let noise = &mut Noise(17 + N as u64);
    let (n, p) = (N as f64, P as f64);
    let plant = StaticPlant::new(matrix(noise, 0.4 / n), matrix(noise, 1.0), matrix(noise, 1.0))?;
    Linear::new(plant, matrix(noise, 0.4 / (n * p)), T::of(PERIOD))
}

/// The sampled cubic observer; C begins with the identity, so that `N = -w C'` is radial.
///
/// # Errors
/// None, for these numbers.
pub fn cubic<T: Number, const N: usize, const M: usize, const P: usize>() -> Result<Cubic<T, N, M, P>, ObserverError> {
    let noise = &mut Noise(19 + N as u64);
    let (n, p) = (N as f64, P as f64);
    let w = 0.7;
    let mut gain: SMatrix<T, N, P> = matrix(noise, 1.0);
    for i in 0..P {
        for j in 0..P {
            gain[(i, j)] = if i == j { T::of(-w) } else { T::zero() };
        }
    }
    let mut theta = diagonal::<T, P, P>(3.0);
    for i in 0..P {
        for j in 0..i {
            let x = T::of(0.3 * noise.number());
            (theta[(i, j)], theta[(j, i)]) = (x, x);
        }
    }
    Cubic::new(SampledCubicGains {
        ad: matrix(noise, 0.4 / n),
        bd: matrix(noise, 1.0),
        c: diagonal(1.0),
        ld: matrix(noise, 0.4 / (n * p)),
        n: gain,
        theta,
        w: T::of(w),
        period: T::of(PERIOD),
    })
}

/// The Kalman filter with its covariance.
///
/// # Errors
/// None, for these numbers.
pub fn kalman<T: Number, const N: usize, const M: usize, const P: usize>() -> Result<Kalman<T, N, M, P>, ObserverError>
{
    let noise = &mut Noise(23 + N as u64);
    Kalman::new(KalmanModel {
        ad: matrix(noise, 1.2 / N as f64),
        bd: matrix(noise, 1.0),
        c: matrix(noise, 1.0),
        w: diagonal(0.01),
        v: diagonal(0.04),
        p0: diagonal(1.0),
        period: T::of(PERIOD),
    })
}
