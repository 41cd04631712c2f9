//! An observer whose state jumps after a number of samples: the samples are counted in its state.
//!
//! A sampled form takes a jump at every sample. Here it is that of the observer at the samples at which the count has
//! come to its number, and counts otherwise: z is followed by the number of samples since the last jump, which stands
//! still between them.

use core::marker::PhantomData;

use luenberger_plants::Column;
use nalgebra::allocator::Allocator;
use nalgebra::{Const, DefaultAllocator, Dim, OVector, RealField};

use crate::cubic::count;
use crate::observer::{Observer, ObserverDimensions};

/// The observer `O` whose jump is due after so many samples; its state is that of `O` with the count behind it, of
/// length D.
#[derive(Clone, Debug, PartialEq)]
pub struct SampledJumps<O, D> {
    observer: O,
    samples: usize,
    length: PhantomData<D>,
}

impl<O, D> SampledJumps<O, D> {
    /// `observer`, whose jump is due after so many samples.
    pub fn new(observer: O, samples: usize) -> Self {
        Self { observer, samples, length: PhantomData }
    }

    /// The observer.
    pub fn observer(&self) -> &O {
        &self.observer
    }
}

/// z with the count behind it.
fn joined<T: RealField + Copy, D: Dim>(z: &[T], samples: T) -> OVector<T, D>
where
    DefaultAllocator: Allocator<D>,
{
    let entries = z.iter().copied().chain(core::iter::once(samples));
    OVector::from_iterator_generic(D::from_usize(z.len() + 1), Const, entries)
}

/// z without the count.
fn own<T, C: Column<T>>(state: &[T]) -> C {
    C::from_slice(&state[..state.len().saturating_sub(1)])
}

impl<T: RealField + Copy, O: Observer<T>, D: Dim> Observer<T> for SampledJumps<O, D>
where
    DefaultAllocator: Allocator<D>,
{
    type State = OVector<T, D>;
    type Input = O::Input;
    type Output = O::Output;
    type Estimate = O::Estimate;

    fn dimensions(&self) -> ObserverDimensions {
        let own = self.observer.dimensions();
        ObserverDimensions { state: own.state + 1, ..own }
    }

    fn derivative(&self, t: T, state: &Self::State, u: &Self::Input, y: &Self::Output) -> Self::State {
        joined(self.observer.derivative(t, &own(state.as_slice()), u, y).as_slice(), T::zero())
    }

    fn estimate(&self, t: T, state: &Self::State, u: &Self::Input, y: &Self::Output) -> Self::Estimate {
        self.observer.estimate(t, &own(state.as_slice()), u, y)
    }

    fn initial(&self, t: T, estimate: &Self::Estimate, u: &Self::Input, y: &Self::Output) -> Self::State {
        joined(self.observer.initial(t, estimate, u, y).as_slice(), T::zero())
    }

    fn jump(&self, t: T, state: &Self::State, u: &Self::Input, y: &Self::Output) -> Self::State {
        let z: O::State = own(state.as_slice());
        let samples = state.as_slice().last().copied().unwrap_or_else(T::zero);
        if samples >= count(self.samples) {
            joined(self.observer.jump(t, &z, u, y).as_slice(), T::one())
        } else {
            joined(z.as_slice(), samples + T::one())
        }
    }
}
