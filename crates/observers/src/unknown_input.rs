//! Unknown-input observer: the estimate does not depend on a disturbance of which nothing is known.
//!
//! Plant `x' = A x + B u + E d`, `y = C x + D u`. With H such that `H C E = E` and `T = I - HC`,
//! ```text
//! z' = T A xhat + T B u + L r - (r'theta r) N r,    r = y - C xhat - D u,    xhat = z + H (y - D u),
//! ```
//! has the error `e' = (T A - L C) e + (r'theta r) N r`, whatever d is: `T E = 0`. The right-hand side is that of a
//! linear or a cubic observer of the plant (TA, TB, C) at the estimate; which one, the type O says.

use luenberger_plants::error::check_matrix;
use nalgebra::allocator::Allocator;
use nalgebra::{Const, DefaultAllocator, Dim, OMatrix, OVector, RealField};

use crate::dense::{entry, with_column};
use crate::error::ObserverError;
use crate::observer::{Observer, ObserverDimensions};

/// The observer `O` of the plant (TA, TB, C), with the part `H y` of the estimate.
///
/// ```
/// use luenberger_observers::{LinearObserver, Observer, UnknownInputObserver};
/// use nalgebra::{Matrix2, Vector1, Vector2};
/// // x1' = x2 + d, x2' = -x2, y = x1: H = (1, 0), T = diag(0, 1), TA = [0 0; 0 -1].
/// let inner = LinearObserver::new(
///     Matrix2::new(0.0, 0.0, 0.0, -1.0), Vector2::zeros(), nalgebra::RowVector2::new(1.0, 0.0), Vector2::new(3.0, 0.0),
/// )?;
/// let observer = UnknownInputObserver::new(inner, Vector2::new(1.0, 0.0), None)?;
/// let (u, y) = (Vector1::zeros(), Vector1::new(5.0));
/// let state = observer.initial(0.0, &Vector2::new(4.0, 2.0), &u, &y);
/// assert_eq!(state, Vector2::new(-1.0, 2.0));
/// assert_eq!(observer.derivative(0.0, &state, &u, &y), Vector2::new(3.0, -2.0));
/// assert_eq!(observer.estimate(0.0, &state, &u, &y), Vector2::new(4.0, 2.0));
/// # Ok::<(), luenberger_observers::ObserverError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct UnknownInputObserver<O, T: RealField + Copy, N: Dim, M: Dim, P: Dim>
where
    DefaultAllocator: Allocator<N, P> + Allocator<P, M> + Allocator<P>,
{
    inner: O,
    h: OMatrix<T, N, P>,
    d: Option<OMatrix<T, P, M>>,
}

/// An unknown-input observer whose sizes are known at compile time.
pub type StaticUnknownInputObserver<O, T, const N: usize, const M: usize, const P: usize> =
    UnknownInputObserver<O, T, Const<N>, Const<M>, Const<P>>;

impl<O, T: RealField + Copy, N: Dim, M: Dim, P: Dim> UnknownInputObserver<O, T, N, M, P>
where
    DefaultAllocator: Allocator<N, P> + Allocator<P, M> + Allocator<P>,
{
    /// `inner` of the plant (TA, TB, C, D), with H (n x p) and the feedthrough D (p x m) of the plant.
    ///
    /// # Errors
    /// [`ObserverError::Matrix`]: shapes that do not fit, entries that are not finite.
    pub fn new(inner: O, h: OMatrix<T, N, P>, d: Option<OMatrix<T, P, M>>) -> Result<Self, ObserverError>
    where
        O: Observer<T>,
    {
        let size = inner.dimensions();
        check_matrix("H", &h, (size.state, size.outputs))?;
        if let Some(d) = &d {
            check_matrix("D", d, (size.outputs, size.inputs))?;
        }
        Ok(Self { inner, h, d })
    }

    /// The observer of the plant (TA, TB, C).
    pub fn inner(&self) -> &O {
        &self.inner
    }

    /// H, n x p.
    pub fn h(&self) -> &OMatrix<T, N, P> {
        &self.h
    }

    /// D, p x m, if there is one.
    pub fn d(&self) -> Option<&OMatrix<T, P, M>> {
        self.d.as_ref()
    }

    /// Adds `factor H (y - D u)` to `state`.
    fn add_measured(&self, u: &[T], y: &[T], factor: T, state: &mut [T]) {
        with_column(self.h.shape_generic().1, |measured| {
            for (i, (measured, y)) in measured.iter_mut().zip(y).enumerate() {
                *measured = *y;
                if let Some(d) = &self.d {
                    *measured -= entry(d, i, u);
                }
            }
            for (i, state) in state.iter_mut().enumerate() {
                *state += factor * entry(&self.h, i, measured);
            }
        });
    }
}

impl<T, O, N, M, P> Observer<T> for UnknownInputObserver<O, T, N, M, P>
where
    T: RealField + Copy,
    O: Observer<T, State = OVector<T, N>, Input = OVector<T, M>, Output = OVector<T, P>, Estimate = OVector<T, N>>,
    N: Dim,
    M: Dim,
    P: Dim,
    DefaultAllocator: Allocator<N, P> + Allocator<P, M> + Allocator<N> + Allocator<M> + Allocator<P>,
{
    type State = OVector<T, N>;
    type Input = OVector<T, M>;
    type Output = OVector<T, P>;
    type Estimate = OVector<T, N>;

    fn dimensions(&self) -> ObserverDimensions {
        self.inner.dimensions()
    }

    fn derivative(&self, t: T, state: &Self::State, u: &Self::Input, y: &Self::Output) -> Self::State {
        let estimate = self.estimate(t, state, u, y);
        self.inner.derivative(t, &estimate, u, y)
    }

    fn estimate(&self, _t: T, state: &Self::State, u: &Self::Input, y: &Self::Output) -> Self::Estimate {
        let mut estimate = state.clone();
        self.add_measured(u.as_slice(), y.as_slice(), T::one(), estimate.as_mut_slice());
        estimate
    }

    fn initial(&self, _t: T, estimate: &Self::Estimate, u: &Self::Input, y: &Self::Output) -> Self::State {
        let mut state = estimate.clone();
        self.add_measured(u.as_slice(), y.as_slice(), -T::one(), state.as_mut_slice());
        state
    }

    fn is_affine(&self) -> bool {
        self.inner.is_affine()
    }
}
