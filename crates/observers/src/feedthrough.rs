//! Direct feedthrough: a plant with `y = C x + D u` is observed through `y - D u`.
//!
//! The input is known, so that neither gain nor error equation changes. An observer without D does not pay for it: its
//! right-hand side is to the last bit what it is for `y = C x`.

use luenberger_plants::PlantError;
use luenberger_plants::error::check_matrix;
use nalgebra::allocator::Allocator;
use nalgebra::{DefaultAllocator, Dim, OMatrix, OVector, RealField};

use crate::dense::entry;
use crate::error::ObserverError;
use crate::observer::{Observer, ObserverDimensions};
use crate::partial::of_measured;

/// The observer `O` of the plant without its feedthrough, which reads `y - D u` for y: of observers without an
/// innovation of their own, such as those of lower order.
///
/// ```
/// use luenberger_observers::{FeedthroughObserver, FunctionalObserver, Observer};
/// use nalgebra::{Vector1, matrix, vector};
/// // The double integrator, y = x1 + u/2, z = x2: w' = -4 w - 16 (y - u/2) + u, zhat = w + 4 (y - u/2).
/// let of_state = FunctionalObserver::new(matrix![-4.0], matrix![-16.0], matrix![1.0], matrix![4.0])?;
/// let observer = FeedthroughObserver::new(of_state, Some(matrix![0.5]))?;
/// let (u, y) = (Vector1::new(1.0), vector![2.5]);
/// let w = observer.initial(0.0, &vector![1.0], &u, &y);
/// assert_eq!(w, vector![-7.0]);
/// assert_eq!(observer.derivative(0.0, &w, &u, &y), vector![28.0 - 32.0 + 1.0]);
/// assert_eq!(observer.estimate(0.0, &w, &u, &y), vector![1.0]);
/// # Ok::<(), luenberger_observers::ObserverError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct FeedthroughObserver<O, T: RealField + Copy, M: Dim, P: Dim>
where
    DefaultAllocator: Allocator<P, M>,
{
    inner: O,
    d: Option<OMatrix<T, P, M>>,
}

impl<O, T: RealField + Copy, M: Dim, P: Dim> FeedthroughObserver<O, T, M, P>
where
    O: Observer<T, Input = OVector<T, M>, Output = OVector<T, P>>,
    DefaultAllocator: Allocator<P, M> + Allocator<M> + Allocator<P>,
{
    /// `inner`, of the plant with y = C x, for y = C x + D u; D is p x m, none for 0.
    ///
    /// # Errors
    /// [`ObserverError::Matrix`]: a shape that does not fit, entries that are not finite.
    pub fn new(inner: O, d: Option<OMatrix<T, P, M>>) -> Result<Self, ObserverError> {
        let size = inner.dimensions();
        let d = d.map(|d| checked(d, (size.outputs, size.inputs))).transpose()?;
        Ok(Self { inner, d })
    }

    /// The observer that reads `y - D u`.
    pub fn inner(&self) -> &O {
        &self.inner
    }

    /// D, p x m, if there is one.
    pub fn d(&self) -> Option<&OMatrix<T, P, M>> {
        self.d.as_ref()
    }

    /// `y - D u`.
    fn of_state(&self, u: &OVector<T, M>, y: &OVector<T, P>) -> OVector<T, P> {
        without(self.d.as_ref(), u, y.clone())
    }
}

impl<O, T: RealField + Copy, M: Dim, P: Dim> Observer<T> for FeedthroughObserver<O, T, M, P>
where
    O: Observer<T, Input = OVector<T, M>, Output = OVector<T, P>>,
    DefaultAllocator: Allocator<P, M> + Allocator<M> + Allocator<P>,
{
    type State = O::State;
    type Input = OVector<T, M>;
    type Output = OVector<T, P>;
    type Estimate = O::Estimate;

    fn dimensions(&self) -> ObserverDimensions {
        self.inner.dimensions()
    }

    fn derivative(&self, t: T, state: &Self::State, u: &Self::Input, y: &Self::Output) -> Self::State {
        self.inner.derivative(t, state, u, &self.of_state(u, y))
    }

    fn estimate(&self, t: T, state: &Self::State, u: &Self::Input, y: &Self::Output) -> Self::Estimate {
        self.inner.estimate(t, state, u, &self.of_state(u, y))
    }

    fn initial(&self, t: T, estimate: &Self::Estimate, u: &Self::Input, y: &Self::Output) -> Self::State {
        self.inner.initial(t, estimate, u, &self.of_state(u, y))
    }

    fn is_affine(&self) -> bool {
        self.inner.is_affine()
    }
}

/// `value - D u`, for a value that is y or `y - C xhat`; the value itself where there is no D.
pub(crate) fn without<T: RealField + Copy, M: Dim, P: Dim>(
    d: Option<&OMatrix<T, P, M>>,
    u: &OVector<T, M>,
    value: OVector<T, P>,
) -> OVector<T, P>
where
    DefaultAllocator: Allocator<P, M> + Allocator<M> + Allocator<P>,
{
    match d {
        Some(d) => value - d * u,
        None => value,
    }
}

/// `y - C xhat - D u` into `innovation`.
#[inline(always)]
#[allow(clippy::inline_always, reason = "as in dense.rs")]
pub(crate) fn innovation<T: RealField + Copy, N: Dim, M: Dim, P: Dim>(
    c: &OMatrix<T, P, N>,
    d: Option<&OMatrix<T, P, M>>,
    (xhat, u, y): (&[T], &[T], &[T]),
    innovation: &mut [T],
) where
    DefaultAllocator: Allocator<P, N> + Allocator<P, M>,
{
    debug_assert_eq!(y.len(), innovation.len(), "outputs");
    for (i, (value, y)) in innovation.iter_mut().zip(y).enumerate() {
        *value = *y - entry(c, i, xhat);
        if let Some(d) = d {
            *value -= entry(d, i, u);
        }
    }
}

/// The same of a sample: 0 for an output that is not finite, which counts as not measured.
#[inline(always)]
#[allow(clippy::inline_always, reason = "as in dense.rs")]
pub(crate) fn sampled_innovation<T: RealField + Copy, N: Dim, M: Dim, P: Dim>(
    c: &OMatrix<T, P, N>,
    d: Option<&OMatrix<T, P, M>>,
    (xhat, u, y): (&[T], &[T], &[T]),
    of_sample: &mut [T],
) where
    DefaultAllocator: Allocator<P, N> + Allocator<P, M>,
{
    innovation(c, d, (xhat, u, y), of_sample);
    for (value, y) in of_sample.iter_mut().zip(y) {
        *value = of_measured(*y, *value);
    }
}

/// `y - C xhat - D u`.
#[allow(clippy::type_complexity, reason = "three columns, not a type")]
pub(crate) fn innovation_of<T: RealField + Copy, N: Dim, M: Dim, P: Dim>(
    c: &OMatrix<T, P, N>,
    d: Option<&OMatrix<T, P, M>>,
    (xhat, u, y): (&OVector<T, N>, &OVector<T, M>, &OVector<T, P>),
) -> OVector<T, P>
where
    DefaultAllocator: Allocator<P, N> + Allocator<P, M> + Allocator<N> + Allocator<M> + Allocator<P>,
{
    let mut column = y.clone();
    innovation(c, d, (xhat.as_slice(), u.as_slice(), y.as_slice()), column.as_mut_slice());
    column
}

/// D of a plant with these sizes.
pub(crate) fn checked<T: RealField + Copy, M: Dim, P: Dim>(
    d: OMatrix<T, P, M>,
    (outputs, inputs): (usize, usize),
) -> Result<OMatrix<T, P, M>, PlantError>
where
    DefaultAllocator: Allocator<P, M>,
{
    check_matrix("D", &d, (outputs, inputs))?;
    Ok(d)
}
