//! Interval observers: a linear observer with bounds that enclose the state.
//!
//! The error `e = x - xhat` of a linear observer under bounded disturbances and noise is bounded block by block in
//! coordinates `z = T e`, `|z_k| <= rho_k`, by a comparison system that needs no measurement:
//! ```text
//! continuous   rho' = K rho + g                          |x_i - xhat_i| <= (H rho)_i
//! sampled      rho+ = N rho + g + Q|xhat| + U|u|         |x_i - xhat_i| <= (H rho)_i + outward |xhat_i|
//! ```
//! K is Metzler; Q, U and outward cover the rounding of the sampled step. Where these entries come from, and the proof
//! of the enclosure, are in the design and the proof crates (`IntervalDesign`, `statement::BlockCoordinates`). The
//! lower and the upper bound are `xhat - r` and `xhat + r` with the half-widths r.

use core::marker::PhantomData;

use luenberger_plants::error::check_matrix;
use luenberger_plants::{Column, Size};
use nalgebra::allocator::Allocator;
use nalgebra::{Const, DefaultAllocator, Dim, OMatrix, OVector, RealField, convert};

use crate::dense::{entry, with_column};
use crate::error::ObserverError;
use crate::observer::{Observer, ObserverDimensions, SampledObserver};

/// Checks the signs of the entries that `of` selects: with a negative one the bounds do not enclose the state.
fn not_negative<T: RealField + Copy, R: Dim, C: Dim>(
    what: &'static str,
    matrix: &OMatrix<T, R, C>,
    of: impl Fn(usize, usize) -> bool,
) -> Result<(), ObserverError>
where
    DefaultAllocator: Allocator<R, C>,
{
    for row in 0..matrix.nrows() {
        for column in 0..matrix.ncols() {
            let entry = matrix[(row, column)];
            if of(row, column) && entry < T::zero() {
                let value = entry.to_subset_unchecked();
                return Err(ObserverError::Negative { what, row, column, value });
            }
        }
    }
    Ok(())
}

/// The comparison system of an [`IntervalObserver`] with Q blocks.
#[derive(Clone, Debug, PartialEq)]
pub struct ComparisonSystem<T: RealField + Copy, N: Dim, Q: Dim>
where
    DefaultAllocator: Allocator<Q, Q> + Allocator<Q> + Allocator<N, Q>,
{
    /// K, q x q, Metzler.
    pub k: OMatrix<T, Q, Q>,
    /// g, q x 1.
    pub g: OVector<T, Q>,
    /// H, n x q.
    pub h: OMatrix<T, N, Q>,
    /// rho at the start, q x 1.
    pub start: OVector<T, Q>,
}

/// The observer `O` of N states with the comparison system of its error; the state is (xhat, rho), of length `S = N +
/// Q`.
///
/// ```
/// use luenberger_observers::{ComparisonSystem, LinearObserver, Observer, StaticIntervalObserver};
/// use nalgebra::{Matrix1, Vector1, Vector2};
/// // x' = -x + w, |w| <= 3, y = x, L = 1: e' = -2e + w, and the width is 3/2 in the end.
/// let one = Matrix1::new(1.0);
/// let inner = LinearObserver::new(-one, one, one, one)?;
/// let comparison = ComparisonSystem { k: Matrix1::new(-2.0), g: Vector1::new(3.0), h: one, start: Vector1::new(0.5) };
/// let observer = StaticIntervalObserver::<_, f64, 1, 1, 2>::new(inner, comparison)?;
/// let state = observer.initial(0.0, &Vector1::new(7.0), &one, &one);
/// assert_eq!(state, Vector2::new(7.0, 0.5));
/// assert_eq!(observer.derivative(0.0, &state, &Vector1::new(1.0), &Vector1::new(7.0)), Vector2::new(-6.0, 2.0));
/// assert_eq!(observer.half_widths(state.as_slice()), Vector1::new(0.5));
/// # Ok::<(), luenberger_observers::ObserverError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct IntervalObserver<O, T: RealField + Copy, N: Dim, Q: Dim, S>
where
    DefaultAllocator: Allocator<Q, Q> + Allocator<Q> + Allocator<N, Q>,
{
    inner: O,
    comparison: ComparisonSystem<T, N, Q>,
    joined: PhantomData<S>,
}

/// An interval observer whose sizes are known at compile time; S is N + Q.
pub type StaticIntervalObserver<O, T, const N: usize, const Q: usize, const S: usize> =
    IntervalObserver<O, T, Const<N>, Const<Q>, Const<S>>;

impl<O, T: RealField + Copy, N: Dim, Q: Dim, S: Dim> IntervalObserver<O, T, N, Q, S>
where
    DefaultAllocator: Allocator<Q, Q> + Allocator<Q> + Allocator<N, Q> + Allocator<N> + Allocator<S>,
{
    /// The observer `inner` with the comparison system of its error.
    ///
    /// # Errors
    /// [`ObserverError::Matrix`]: shapes that do not fit, entries that are not finite; [`ObserverError::Negative`] for
    /// a negative entry of g, H, rho or of K outside of the diagonal.
    pub fn new(inner: O, comparison: ComparisonSystem<T, N, Q>) -> Result<Self, ObserverError>
    where
        O: Observer<T>,
    {
        let (n, q) = (inner.dimensions().estimate, comparison.k.nrows());
        check_matrix("K", &comparison.k, (q, q))?;
        check_matrix("g", &comparison.g, (q, 1))?;
        check_matrix("H", &comparison.h, (n, q))?;
        check_matrix("rho", &comparison.start, (q, 1))?;
        let found = S::try_to_usize().unwrap_or(n + q);
        if inner.dimensions().state != n || found != n + q {
            let (expected, found) = ((n + q, 1), (found, 1));
            return Err(
                luenberger_plants::PlantError::DimensionMismatch { what: "(xhat, rho)", expected, found }.into()
            );
        }
        not_negative("K", &comparison.k, |i, j| i != j)?;
        not_negative("g", &comparison.g, |_, _| true)?;
        not_negative("H", &comparison.h, |_, _| true)?;
        not_negative("rho", &comparison.start, |_, _| true)?;
        Ok(Self { inner, comparison, joined: PhantomData })
    }

    /// The observer without its bounds.
    pub fn inner(&self) -> &O {
        &self.inner
    }

    /// The comparison system.
    pub fn comparison(&self) -> &ComparisonSystem<T, N, Q> {
        &self.comparison
    }

    /// The half-widths of the bounds in a state of this observer.
    pub fn half_widths(&self, state: &[T]) -> OVector<T, N> {
        let h = &self.comparison.h;
        let rho = state.get(h.nrows()..).unwrap_or_default();
        OVector::from_fn_generic(h.shape_generic().0, Const, |i, _| entry(h, i, rho))
    }
}

impl<T, O, N, M, P, Q, S> Observer<T> for IntervalObserver<O, T, N, Q, S>
where
    T: RealField + Copy,
    O: Observer<T, State = OVector<T, N>, Input = OVector<T, M>, Output = OVector<T, P>, Estimate = OVector<T, N>>,
    N: Dim,
    M: Dim,
    P: Dim,
    Q: Dim,
    S: Dim,
    DefaultAllocator:
        Allocator<Q, Q> + Allocator<Q> + Allocator<N, Q> + Allocator<N> + Allocator<M> + Allocator<P> + Allocator<S>,
{
    type State = OVector<T, S>;
    type Input = OVector<T, M>;
    type Output = OVector<T, P>;
    type Estimate = OVector<T, N>;

    fn dimensions(&self) -> ObserverDimensions {
        let inner = self.inner.dimensions();
        ObserverDimensions { state: inner.state + self.comparison.k.nrows(), ..inner }
    }

    fn derivative(&self, t: T, state: &Self::State, u: &Self::Input, y: &Self::Output) -> Self::State {
        let ComparisonSystem { k, g, .. } = &self.comparison;
        let n = self.comparison.h.nrows();
        let (xhat, rho) = state.as_slice().split_at(n);
        let slope = self.inner.derivative(t, &<OVector<T, N> as Column<T>>::from_slice(xhat), u, y);
        let bounds = (0..k.nrows()).map(|i| entry(k, i, rho) + g[i]);
        OVector::from_iterator_generic(S::from_usize(state.len()), Const, slope.iter().copied().chain(bounds))
    }

    fn estimate(&self, _t: T, state: &Self::State, _u: &Self::Input, _y: &Self::Output) -> Self::Estimate {
        <OVector<T, N> as Column<T>>::from_slice(&state.as_slice()[..self.comparison.h.nrows()])
    }

    fn initial(&self, _t: T, estimate: &Self::Estimate, _u: &Self::Input, _y: &Self::Output) -> Self::State {
        let length = estimate.len() + self.comparison.start.len();
        let both = estimate.iter().chain(self.comparison.start.iter()).copied();
        OVector::from_iterator_generic(S::from_usize(length), Const, both)
    }

    fn is_affine(&self) -> bool {
        self.inner.is_affine()
    }
}

/// The matrices of a [`SampledIntervalObserver`] with N states, M inputs, P outputs and Q blocks.
#[derive(Clone, Debug, PartialEq)]
pub struct SampledIntervalGains<T: RealField + Copy, N: Dim, M: Dim, P: Dim, Q: Dim>
where
    DefaultAllocator:
        Size<N, M, P> + Allocator<Q, Q> + Allocator<Q> + Allocator<N, Q> + Allocator<Q, N> + Allocator<Q, M>,
{
    /// F, n x n.
    pub f: OMatrix<T, N, N>,
    /// G, n x m.
    pub g: OMatrix<T, N, M>,
    /// C, p x n.
    pub c: OMatrix<T, P, N>,
    /// L, n x p.
    pub l: OMatrix<T, N, P>,
    /// N, q x q.
    pub blocks: OMatrix<T, Q, Q>,
    /// The constant g of rho, q x 1.
    pub constant: OVector<T, Q>,
    /// Q, q x n.
    pub of_estimate: OMatrix<T, Q, N>,
    /// U, q x m.
    pub of_input: OMatrix<T, Q, M>,
    /// H, n x q.
    pub h: OMatrix<T, N, Q>,
    /// The factor of |xhat| in a half-width.
    pub outward: T,
    /// rho at the start, q x 1.
    pub start: OVector<T, Q>,
    /// The sampling period.
    pub period: T,
}

/// The sampled interval observer; its state is (xhat, rho), of length `S = N + Q`. See the [module](self).
#[derive(Clone, Debug, PartialEq)]
pub struct SampledIntervalObserver<T: RealField + Copy, N: Dim, M: Dim, P: Dim, Q: Dim, S>
where
    DefaultAllocator:
        Size<N, M, P> + Allocator<Q, Q> + Allocator<Q> + Allocator<N, Q> + Allocator<Q, N> + Allocator<Q, M>,
{
    gains: SampledIntervalGains<T, N, M, P, Q>,
    joined: PhantomData<S>,
}

/// A sampled interval observer whose sizes are known at compile time; S is N + Q.
pub type StaticSampledIntervalObserver<
    T,
    const N: usize,
    const M: usize,
    const P: usize,
    const Q: usize,
    const S: usize,
> = SampledIntervalObserver<T, Const<N>, Const<M>, Const<P>, Const<Q>, Const<S>>;

impl<T: RealField + Copy, N: Dim, M: Dim, P: Dim, Q: Dim, S: Dim> SampledIntervalObserver<T, N, M, P, Q, S>
where
    DefaultAllocator: Size<N, M, P>
        + Allocator<Q, Q>
        + Allocator<Q>
        + Allocator<N, Q>
        + Allocator<Q, N>
        + Allocator<Q, M>
        + Allocator<S>,
{
    /// The observer with these matrices.
    ///
    /// # Errors
    /// [`ObserverError::Matrix`]: shapes that do not fit, entries that are not finite; [`ObserverError::Period`];
    /// [`ObserverError::Negative`] for a negative entry of N, g, Q, U, H or rho; [`ObserverError::NotPositive`] for a
    /// factor `outward` that is negative or not finite.
    pub fn new(gains: SampledIntervalGains<T, N, M, P, Q>) -> Result<Self, ObserverError> {
        let (n, m, p, q) = (gains.f.nrows(), gains.g.ncols(), gains.c.nrows(), gains.blocks.nrows());
        check_matrix("F", &gains.f, (n, n))?;
        check_matrix("G", &gains.g, (n, m))?;
        check_matrix("C", &gains.c, (p, n))?;
        check_matrix("L", &gains.l, (n, p))?;
        check_matrix("N", &gains.blocks, (q, q))?;
        check_matrix("g", &gains.constant, (q, 1))?;
        check_matrix("Q", &gains.of_estimate, (q, n))?;
        check_matrix("U", &gains.of_input, (q, m))?;
        check_matrix("H", &gains.h, (n, q))?;
        check_matrix("rho", &gains.start, (q, 1))?;
        let found = S::try_to_usize().unwrap_or(n + q);
        if found != n + q {
            let (expected, found) = ((n + q, 1), (found, 1));
            return Err(
                luenberger_plants::PlantError::DimensionMismatch { what: "(xhat, rho)", expected, found }.into()
            );
        }
        if !(gains.period.is_finite() && gains.period > T::zero()) {
            return Err(ObserverError::Period { period: gains.period.to_subset_unchecked() });
        }
        not_negative("N", &gains.blocks, |_, _| true)?;
        not_negative("g", &gains.constant, |_, _| true)?;
        not_negative("Q", &gains.of_estimate, |_, _| true)?;
        not_negative("U", &gains.of_input, |_, _| true)?;
        not_negative("H", &gains.h, |_, _| true)?;
        not_negative("rho", &gains.start, |_, _| true)?;
        if !(gains.outward.is_finite() && gains.outward >= T::zero()) {
            let value = convert::<f64, f64>(gains.outward.to_subset_unchecked());
            return Err(ObserverError::NotPositive { what: "outward", value });
        }
        Ok(Self { gains, joined: PhantomData })
    }

    /// The observer gain L, n x p.
    pub fn l(&self) -> &OMatrix<T, N, P> {
        &self.gains.l
    }

    /// The matrices.
    pub fn gains(&self) -> &SampledIntervalGains<T, N, M, P, Q> {
        &self.gains
    }

    /// The half-widths of the bounds in a state of this observer.
    pub fn half_widths(&self, state: &[T]) -> OVector<T, N> {
        let SampledIntervalGains { h, outward, .. } = &self.gains;
        let rho = state.get(h.nrows()..).unwrap_or_default();
        let width = |i: usize| entry(h, i, rho) + *outward * state.get(i).copied().unwrap_or_else(T::zero).abs();
        OVector::from_fn_generic(h.shape_generic().0, Const, |i, _| width(i))
    }
}

impl<T, N, M, P, Q, S> SampledObserver<T> for SampledIntervalObserver<T, N, M, P, Q, S>
where
    T: RealField + Copy,
    N: Dim,
    M: Dim,
    P: Dim,
    Q: Dim,
    S: Dim,
    DefaultAllocator: Size<N, M, P>
        + Allocator<Q, Q>
        + Allocator<Q>
        + Allocator<N, Q>
        + Allocator<Q, N>
        + Allocator<Q, M>
        + Allocator<S>,
{
    type State = OVector<T, S>;
    type Input = OVector<T, M>;
    type Output = OVector<T, P>;
    type Estimate = OVector<T, N>;

    fn dimensions(&self) -> ObserverDimensions {
        let SampledIntervalGains { f, g, c, blocks, .. } = &self.gains;
        let n = f.nrows();
        ObserverDimensions { state: n + blocks.nrows(), inputs: g.ncols(), outputs: c.nrows(), estimate: n }
    }

    fn period(&self) -> T {
        self.gains.period
    }

    fn step(&self, _t: T, state: &mut Self::State, u: &Self::Input, y: &Self::Output) {
        let g = &self.gains;
        let (u, y) = (u.as_slice(), y.as_slice());
        let n = g.f.nrows();
        let before = state.clone();
        let Some((xhat, rho)) = before.as_slice().split_at_checked(n) else { return };
        with_column(g.c.shape_generic().0, |innovation| {
            for (i, (innovation, y)) in innovation.iter_mut().zip(y).enumerate() {
                *innovation = *y - entry(&g.c, i, xhat);
            }
            for (i, next) in state.iter_mut().enumerate() {
                *next = if i < n {
                    let moved = entry(&g.f, i, xhat);
                    let moved = if u.is_empty() { moved } else { moved + entry(&g.g, i, u) };
                    moved + entry(&g.l, i, innovation)
                } else {
                    let k = i - n;
                    let grown = entry(&g.blocks, k, rho) + g.constant.get(k).copied().unwrap_or_else(T::zero);
                    let grown = grown + entry_of_magnitudes(&g.of_estimate, k, xhat);
                    if u.is_empty() { grown } else { grown + entry_of_magnitudes(&g.of_input, k, u) }
                };
            }
        });
    }

    fn estimate(&self, state: &Self::State) -> Self::Estimate {
        let entries = state.iter().take(self.gains.f.nrows()).copied();
        OVector::from_iterator_generic(self.gains.f.shape_generic().0, Const, entries)
    }

    fn initial(&self, _t: T, estimate: &Self::Estimate, _u: &Self::Input, _y: &Self::Output) -> Self::State {
        let length = estimate.len() + self.gains.start.len();
        let both = estimate.iter().chain(self.gains.start.iter()).copied();
        OVector::from_iterator_generic(S::from_usize(length), Const, both)
    }
}

/// Entry `i` of `A |v|`.
fn entry_of_magnitudes<T: RealField + Copy, R: Dim, C: Dim>(a: &OMatrix<T, R, C>, i: usize, v: &[T]) -> T
where
    DefaultAllocator: Allocator<R, C>,
{
    let mut products = v.iter().enumerate().map(|(k, v)| a.get((i, k)).map_or_else(T::zero, |a| *a * v.abs()));
    let first = products.next().unwrap_or_else(T::zero);
    products.fold(first, |sum, product| sum + product)
}
