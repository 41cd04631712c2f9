//! A plant at an input that is held, without its type: what filters whose sizes are known at run time are compiled for.
//!
//! Where sizes are small, [`sized`] makes them types, so that a filter of such a plant takes no memory. It is the same
//! body as for any size, and gives the same bits.

use luenberger_plants::{Differentiable, Dimensions, Plant, Shape, Size};
use nalgebra::allocator::Allocator;
use nalgebra::{DefaultAllocator, Dim, OMatrix, OVector, RealField, U0, U1, convert};

use crate::dense::times;

/// f or h and its Jacobian by columns at time and state, on slices; false if their lengths do not fit.
pub(crate) type WithJacobian<'f, T> = dyn Fn(T, &[T], &mut [T], &mut [T]) -> bool + 'f;

/// The plant at an input that is held, with as many states and outputs.
#[derive(Clone, Copy)]
pub(crate) struct Held<'f, T, N, P> {
    pub(crate) motion: &'f WithJacobian<'f, T>,
    pub(crate) measurement: &'f WithJacobian<'f, T>,
    /// Whether f is linear between samples.
    pub(crate) is_linear: bool,
    pub(crate) size: (N, P),
}

/// A map with its Jacobian; NaN where there is none.
fn evaluated<T: RealField + Copy, R: Dim, N: Dim>(
    map: &WithJacobian<'_, T>,
    (rows, columns): (R, N),
    t: T,
    x: &OVector<T, N>,
) -> (OVector<T, R>, OMatrix<T, R, N>)
where
    DefaultAllocator: Allocator<R> + Allocator<N> + Allocator<R, N>,
{
    let (mut value, mut jacobian) = (OVector::zeros_generic(rows, U1), OMatrix::zeros_generic(rows, columns));
    if !map(t, x.as_slice(), value.as_mut_slice(), jacobian.as_mut_slice()) {
        value.fill(convert(f64::NAN));
    }
    (value, jacobian)
}

impl<T, N: Dim, P: Dim> Shape for Held<'_, T, N, P> {
    fn dimensions(&self) -> Dimensions {
        Dimensions { states: self.size.0.value(), inputs: 0, outputs: self.size.1.value() }
    }
}

impl<T: RealField + Copy, N: Dim, P: Dim> Plant<T> for Held<'_, T, N, P>
where
    DefaultAllocator: Size<N, U0, P>,
{
    type State = OVector<T, N>;
    type Input = OVector<T, U0>;
    type Output = OVector<T, P>;

    fn derivative(&self, t: T, x: &Self::State, u: &Self::Input) -> Self::State {
        self.motion(t, x, u).0
    }

    fn output(&self, t: T, x: &Self::State, u: &Self::Input) -> Self::Output {
        self.measurement(t, x, u).0
    }
}

impl<T: RealField + Copy, N: Dim, P: Dim> Differentiable<T, N, U0, P> for Held<'_, T, N, P>
where
    DefaultAllocator: Size<N, U0, P>,
{
    fn directional(
        &self,
        t: T,
        x: &OVector<T, N>,
        u: &OVector<T, U0>,
        v: &OVector<T, N>,
    ) -> (OVector<T, N>, OVector<T, N>) {
        let (f, jacobian) = self.motion(t, x, u);
        (f, times(&jacobian, v))
    }

    fn output_directional(
        &self,
        t: T,
        x: &OVector<T, N>,
        u: &OVector<T, U0>,
        v: &OVector<T, N>,
    ) -> (OVector<T, P>, OVector<T, P>) {
        let (h, jacobian) = self.measurement(t, x, u);
        (h, times(&jacobian, v))
    }

    fn motion(&self, t: T, x: &OVector<T, N>, _u: &OVector<T, U0>) -> (OVector<T, N>, OMatrix<T, N, N>) {
        evaluated(self.motion, (self.size.0, self.size.0), t, x)
    }

    fn measurement(&self, t: T, x: &OVector<T, N>, _u: &OVector<T, U0>) -> (OVector<T, P>, OMatrix<T, P, N>) {
        evaluated(self.measurement, (self.size.1, self.size.0), t, x)
    }

    fn is_linear_between_samples(&self) -> bool {
        self.is_linear
    }
}

/// A call with a size as a type, if it is one of the list, or of the second one outside of web pages; else false.
macro_rules! sized {
    ($size:expr, [$($small:literal)*] [$($large:literal)*], $dim:ident => $call:expr) => {
        match $size {
            $($small => {
                let $dim = nalgebra::Const::<$small>;
                $call
            })*
            $(#[cfg(not(target_arch = "wasm32"))]
            $large => {
                let $dim = nalgebra::Const::<$large>;
                $call
            })*
            _ => false,
        }
    };
}

pub(crate) use sized;
