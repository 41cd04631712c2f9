//! An observer with the feedback `u = r - K xhat` as one block: measured outputs in, inputs of the plant out.
//!
//! At a sample the estimate is what is known before its measurement, so that u follows from the state of the observer
//! alone and can be applied at once; the step that takes the measurement has a whole period. By the separation
//! principle the estimation error of a linear plant does not depend on K and r, and the poles of the loop are those of
//! `A - L C` and of `A - B K`.

use luenberger_plants::error::check_matrix;
use nalgebra::allocator::Allocator;
use nalgebra::{DefaultAllocator, Dim, OMatrix, OVector, RealField};

use crate::error::ObserverError;
use crate::observer::SampledObserver;

/// `u = r - K xhat` with the estimate of a sampled observer.
///
/// Fields are read through methods, because the constructor has checked them.
#[derive(Clone, Debug, PartialEq)]
pub struct OutputFeedback<T: RealField + Copy, O, M: Dim, N: Dim>
where
    DefaultAllocator: Allocator<M, N>,
{
    observer: O,
    k: OMatrix<T, M, N>,
}

impl<T: RealField + Copy, O, M: Dim, N: Dim> OutputFeedback<T, O, M, N>
where
    O: SampledObserver<T, Input = OVector<T, M>, Estimate = OVector<T, N>>,
    DefaultAllocator: Allocator<M, N> + Allocator<M> + Allocator<N>,
{
    /// The observer with the feedback gain K, m x n.
    ///
    /// ```
    /// use luenberger_observers::{DiscreteLinearObserver, OutputFeedback};
    /// use luenberger_plants::StaticPlant;
    /// use nalgebra::{Matrix1, Vector1};
    /// // x+ = x + u, y = x, with L = 1 and K = 0.5.
    /// let plant = StaticPlant::new(Matrix1::new(1.0), Matrix1::new(1.0), Matrix1::new(1.0))?;
    /// let observer = DiscreteLinearObserver::new(plant, Matrix1::new(1.0), 0.1)?;
    /// let block = OutputFeedback::new(observer, Matrix1::new(0.5))?;
    /// let mut xhat = Vector1::new(2.0);
    /// let u = block.step(0.0, &mut xhat, &Vector1::new(3.0), &Vector1::new(2.5));
    /// assert_eq!((u, xhat), (Vector1::new(3.0 - 1.0), Vector1::new(2.0 + 2.0 + 0.5)));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    /// # Errors
    /// [`ObserverError::Matrix`]: a shape that does not fit, entries that are not finite.
    pub fn new(observer: O, k: OMatrix<T, M, N>) -> Result<Self, ObserverError> {
        let size = observer.dimensions();
        check_matrix("K", &k, (size.inputs, size.estimate))?;
        Ok(Self { observer, k })
    }

    /// The observer.
    pub fn observer(&self) -> &O {
        &self.observer
    }

    /// The feedback gain K, m x n.
    pub fn k(&self) -> &OMatrix<T, M, N> {
        &self.k
    }

    /// The input to apply from this sample to the next, `r - K xhat`.
    pub fn input(&self, state: &O::State, r: &OVector<T, M>) -> OVector<T, M> {
        r - &self.k * self.observer.estimate(state)
    }

    /// From the sample at `t` to the estimate at `t + h`, in place; returns the input that is applied in between.
    pub fn step(&self, t: T, state: &mut O::State, r: &OVector<T, M>, y: &O::Output) -> OVector<T, M> {
        let u = self.input(state, r);
        self.observer.step(t, state, &u, y);
        u
    }
}
