//! An observer in continuous time as one that is stepped once per sample: a step of the classical Runge-Kutta method,
//! inputs and outputs held.

use luenberger_observers::{Observer, ObserverDimensions, SampledObserver};
use nalgebra::SVector;

use crate::{Filled, Number};

/// The observer and its period.
pub struct Stepped<T, O> {
    observer: O,
    period: T,
}

impl<T, O> Stepped<T, O> {
    /// One step per period.
    pub fn new(observer: O, period: T) -> Self {
        Self { observer, period }
    }
}

impl<T: Number, O: Observer<T, State = SVector<T, N>>, const N: usize> SampledObserver<T> for Stepped<T, O>
where
    O::Input: Filled<T>,
    O::Output: Filled<T>,
{
    type State = O::State;
    type Input = O::Input;
    type Output = O::Output;
    type Estimate = O::Estimate;

    fn dimensions(&self) -> ObserverDimensions {
        self.observer.dimensions()
    }

    fn period(&self) -> T {
        self.period
    }

    fn step(&self, t: T, z: &mut Self::State, u: &Self::Input, y: &Self::Output) {
        let (h, half, two) = (self.period, self.period * T::of(0.5), T::of(2.0));
        let slope = |t: T, z: &SVector<T, N>| self.observer.derivative(t, z, u, y);
        let k1 = slope(t, z);
        let k2 = slope(t + half, &(*z + k1 * half));
        let k3 = slope(t + half, &(*z + k2 * half));
        let k4 = slope(t + h, &(*z + k3 * h));
        *z += (k1 + (k2 + k3) * two + k4) * (h * T::of(1.0 / 6.0));
    }

    fn estimate(&self, state: &Self::State) -> Self::Estimate {
        let (u, y) = (O::Input::filled(T::zero), O::Output::filled(T::zero));
        self.observer.estimate(T::zero(), state, &u, &y)
    }

    fn initial(&self, t: T, estimate: &Self::Estimate, u: &Self::Input, y: &Self::Output) -> Self::State {
        self.observer.initial(t, estimate, u, y)
    }
}
