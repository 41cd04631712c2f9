//! Corrections by a constant gain of samples of which some outputs are missing.
//!
//! An output that is not finite, such as NaN, was not measured. Its innovation is 0, so that the others correct as they
//! always do and its column of the gain is left out; without any output the sample is a prediction:
//!
//! ```text
//! xhat+ = A xhat + B u + sum_i l_i (y_i - c_i xhat - d_i u),   i over the outputs that were measured
//! ```
//!
//! The error of such a sample obeys `e+ = (A - sum_i l_i c_i) e`, which no Lyapunov function of `A - L C` covers: it
//! may grow. After the last incomplete sample a theorem about convergence holds anew, from the error that there is
//! then.

use nalgebra::allocator::Allocator;
use nalgebra::{DefaultAllocator, Dim, OVector, RealField, convert};

use crate::dense::choose;

/// The innovation of an output y, and 0 if y is not finite.
#[inline(always)]
#[allow(clippy::inline_always, reason = "as in dense.rs")]
pub(crate) fn of_measured<T: RealField + Copy>(y: T, innovation: T) -> T {
    of_measured_or(y, innovation, T::zero())
}

/// The innovation of an output y, and that of `before` if y is not finite.
#[inline(always)]
#[allow(clippy::inline_always, reason = "as in dense.rs")]
pub(crate) fn of_measured_or<T: RealField + Copy>(y: T, innovation: T, before: T) -> T {
    choose(|| y.is_finite(), innovation, before)
}

/// The outputs with NaN in the place of those that are false in `measured`.
pub(crate) fn only<T: RealField + Copy, P: Dim>(y: &OVector<T, P>, measured: &[bool]) -> OVector<T, P>
where
    DefaultAllocator: Allocator<P>,
{
    let mut seen = y.clone();
    for (y, _) in seen.iter_mut().zip(measured).filter(|(_, measured)| !**measured) {
        *y = convert(f64::NAN);
    }
    seen
}

/// [`SampledObserver::step_partial`](crate::SampledObserver::step_partial) of an observer whose step leaves out outputs
/// that are not finite.
macro_rules! step_of_measured {
    () => {
        fn step_partial(&self, t: T, state: &mut Self::State, u: &Self::Input, y: &Self::Output, measured: &[bool]) {
            self.step(t, state, u, &crate::partial::only(y, measured));
        }
    };
}

pub(crate) use step_of_measured;
