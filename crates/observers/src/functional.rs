//! Functional observer: an estimate of `z = K x` alone, by fewer states than the plant has.
//!
//! ```text
//! w' = F w + G y + H u,    zhat = w + N y                  y = C x
//! ```
//! With T such that `T A - F T = G C`, `H = T B` and `T + N C = K` the error `z - zhat = T x - w` has the derivative
//! `F (T x - w)`. The matrices are those of `luenberger_linalg::functional_observer`. Where the rows of K in question
//! need others beside them, z has further entries, which are no part of the estimate.

use luenberger_plants::PlantError;
use luenberger_plants::error::check_matrix;
use nalgebra::allocator::Allocator;
use nalgebra::{Const, DefaultAllocator, Dim, OMatrix, OVector, RealField};

use crate::dense::copy;
use crate::error::ObserverError;
use crate::observer::{Observer, ObserverDimensions};

/// An observer of order r for the first Z of r functions of the state (default: all of them).
///
/// ```
/// use luenberger_observers::{FunctionalObserver, Observer};
/// use nalgebra::{Vector1, matrix, vector};
/// // The double integrator, z = x2: w' = -4 w - 16 y + u, zhat = w + 4 y.
/// let observer = FunctionalObserver::new(matrix![-4.0], matrix![-16.0], matrix![1.0], matrix![4.0])?;
/// let (u, y) = (Vector1::new(0.5), vector![2.0]);
/// let w = observer.initial(0.0, &vector![1.0], &u, &y);
/// assert_eq!(w, vector![-7.0]);
/// assert_eq!(observer.derivative(0.0, &w, &u, &y), vector![-3.5]);
/// assert_eq!(observer.estimate(0.0, &w, &u, &y), vector![1.0]);
/// # Ok::<(), luenberger_observers::ObserverError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct FunctionalObserver<T: RealField + Copy, R: Dim, M: Dim, P: Dim, Z: Dim = R>
where
    DefaultAllocator: Allocator<R, R> + Allocator<R, M> + Allocator<R, P> + Allocator<R>,
{
    f: OMatrix<T, R, R>,
    g: OMatrix<T, R, P>,
    h: OMatrix<T, R, M>,
    n: OMatrix<T, R, P>,
    first: OVector<T, R>,
    functions: Z,
}

/// A functional observer whose sizes are known at compile time: R functions, M inputs, P outputs.
pub type StaticFunctionalObserver<T, const R: usize, const M: usize, const P: usize> =
    FunctionalObserver<T, Const<R>, Const<M>, Const<P>>;

impl<T: RealField + Copy, R: Dim, M: Dim, P: Dim> FunctionalObserver<T, R, M, P>
where
    DefaultAllocator: Allocator<R, R> + Allocator<R, M> + Allocator<R, P> + Allocator<R>,
{
    /// From F (r x r), G (r x p), H (r x m) and N (r x p).
    ///
    /// # Errors
    /// [`ObserverError::Matrix`]: shapes that do not fit, entries that are not finite.
    pub fn new(
        f: OMatrix<T, R, R>,
        g: OMatrix<T, R, P>,
        h: OMatrix<T, R, M>,
        n: OMatrix<T, R, P>,
    ) -> Result<Self, ObserverError> {
        let order = f.shape_generic().0;
        Self::leading(f, g, h, n, (order, OVector::zeros_generic(order, Const)))
    }
}

impl<T: RealField + Copy, R: Dim, M: Dim, P: Dim, Z: Dim> FunctionalObserver<T, R, M, P, Z>
where
    DefaultAllocator: Allocator<R, R> + Allocator<R, M> + Allocator<R, P> + Allocator<R>,
{
    /// The observer of the first `functions` of r functions, and the first estimate of all r, of which the entries
    /// behind these count.
    ///
    /// # Errors
    /// As [`new`](Self::new); [`ObserverError::Matrix`] for more functions than r.
    pub fn leading(
        f: OMatrix<T, R, R>,
        g: OMatrix<T, R, P>,
        h: OMatrix<T, R, M>,
        n: OMatrix<T, R, P>,
        (functions, first): (Z, OVector<T, R>),
    ) -> Result<Self, ObserverError> {
        let (order, outputs) = (f.nrows(), g.ncols());
        check_matrix("F", &f, (order, order))?;
        check_matrix("G", &g, (order, outputs))?;
        check_matrix("H", &h, (order, h.ncols()))?;
        check_matrix("N", &n, (order, outputs))?;
        check_matrix("the first estimate", &first, (order, 1))?;
        if functions.value() > order {
            let (expected, found) = ((order, 1), (functions.value(), 1));
            return Err(PlantError::DimensionMismatch { what: "the functions", expected, found }.into());
        }
        Ok(Self { f, g, h, n, first, functions })
    }

    /// F, r x r.
    pub fn f(&self) -> &OMatrix<T, R, R> {
        &self.f
    }

    /// G, r x p.
    pub fn g(&self) -> &OMatrix<T, R, P> {
        &self.g
    }

    /// H, r x m.
    pub fn h(&self) -> &OMatrix<T, R, M> {
        &self.h
    }

    /// N, r x p.
    pub fn n(&self) -> &OMatrix<T, R, P> {
        &self.n
    }

    /// How many functions are estimated, and the first estimate of all r.
    pub fn first(&self) -> (Z, &OVector<T, R>) {
        (self.functions, &self.first)
    }
}

impl<T: RealField + Copy, R: Dim, M: Dim, P: Dim, Z: Dim> Observer<T> for FunctionalObserver<T, R, M, P, Z>
where
    DefaultAllocator:
        Allocator<R, R> + Allocator<R, M> + Allocator<R, P> + Allocator<R> + Allocator<M> + Allocator<P> + Allocator<Z>,
{
    type State = OVector<T, R>;
    type Input = OVector<T, M>;
    type Output = OVector<T, P>;
    type Estimate = OVector<T, Z>;

    fn dimensions(&self) -> ObserverDimensions {
        let (order, inputs, outputs) = (self.f.nrows(), self.h.ncols(), self.g.ncols());
        ObserverDimensions { state: order, inputs, outputs, estimate: self.functions.value() }
    }

    fn derivative(&self, _t: T, state: &Self::State, u: &Self::Input, y: &Self::Output) -> Self::State {
        &self.f * state + &self.g * y + &self.h * u
    }

    fn estimate(&self, _t: T, state: &Self::State, _u: &Self::Input, y: &Self::Output) -> Self::Estimate {
        let all = state + &self.n * y;
        let count = self.functions.value();
        OVector::from_iterator_generic(self.functions, Const, all.iter().copied().take(count))
    }

    fn initial(&self, _t: T, estimate: &Self::Estimate, _u: &Self::Input, y: &Self::Output) -> Self::State {
        let mut all = self.first.clone();
        copy(estimate.as_slice(), all.as_mut_slice());
        all - &self.n * y
    }

    fn is_affine(&self) -> bool {
        true
    }
}
