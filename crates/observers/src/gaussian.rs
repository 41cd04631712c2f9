//! Estimates with a covariance: their noises, what moves the covariance, and the measurement update that the Kalman
//! filters share.

#![allow(clippy::inline_always, reason = "as in dense.rs")]

use luenberger_plants::error::check_matrix;
use luenberger_plants::{Column, Size};
use nalgebra::allocator::Allocator;
use nalgebra::{DefaultAllocator, Dim, DimAdd, DimSum, OMatrix, OVector, RealField, U1, convert};

use crate::dense::{Factor, are_finite, times, times_transpose};
use crate::error::ObserverError;
use crate::semidefinite::failing_pivot;

/// The state of a Kalman filter: estimate and covariance, one beside the other.
#[derive(Clone, Debug, PartialEq)]
pub struct GaussianEstimate<T: RealField + Copy, N: DimAdd<U1>>(OMatrix<T, N, DimSum<N, U1>>)
where
    DefaultAllocator: Allocator<N, DimSum<N, U1>>;

impl<T: RealField + Copy, N: DimAdd<U1>> GaussianEstimate<T, N>
where
    DefaultAllocator: Allocator<N, DimSum<N, U1>> + Allocator<N> + Allocator<N, N>,
{
    /// The state with estimate xhat (length n) and covariance P (n x n).
    pub fn new(xhat: &OVector<T, N>, p: &OMatrix<T, N, N>) -> Self {
        let rows = xhat.shape_generic().0;
        Self(OMatrix::from_fn_generic(rows, rows.add(U1), |i, j| if j == 0 { xhat[i] } else { p[(i, j - 1)] }))
    }

    /// The estimate xhat.
    pub fn estimate(&self) -> OVector<T, N> {
        self.0.column(0).into_owned()
    }

    /// The estimate and the columns of the covariance, one after the other.
    #[cfg(feature = "alloc")]
    pub(crate) fn as_mut_slice(&mut self) -> &mut [T] {
        self.0.as_mut_slice()
    }

    /// Number of states, n.
    pub(crate) fn order(&self) -> usize {
        self.0.nrows()
    }

    /// The same covariance, with an estimate that is NaN.
    pub(crate) fn lost(&self) -> Self {
        let (rows, columns) = self.0.shape_generic();
        let nan: T = convert(f64::NAN);
        Self(OMatrix::from_fn_generic(rows, columns, |i, j| if j == 0 { nan } else { self.0[(i, j)] }))
    }

    /// The covariance P of the error, as computed by the filter.
    pub fn covariance(&self) -> OMatrix<T, N, N> {
        let rows = self.0.shape_generic().0;
        OMatrix::from_fn_generic(rows, rows, |i, j| self.0[(i, j + 1)])
    }
}

impl<T: RealField + Copy, N: DimAdd<U1>> Column<T> for GaussianEstimate<T, N>
where
    DefaultAllocator: Allocator<N, DimSum<N, U1>>,
{
    fn try_from_slice(entries: &[T]) -> Option<Self> {
        // n (n + 1) entries: n is the integer part of the root.
        let n = N::try_to_usize().unwrap_or_else(|| entries.len().isqrt());
        let rows = N::from_usize(n);
        (n * (n + 1) == entries.len()).then(|| Self(OMatrix::from_column_slice_generic(rows, rows.add(U1), entries)))
    }

    fn as_slice(&self) -> &[T] {
        self.0.as_slice()
    }

    fn fixed_len() -> Option<usize> {
        N::try_to_usize().map(|n| n * (n + 1))
    }
}

/// The noise a filter is designed for, and the covariance of its initial error.
#[derive(Clone, Debug, PartialEq)]
pub struct NoiseModel<T: RealField + Copy, N: Dim, P: Dim>
where
    DefaultAllocator: Allocator<N, N> + Allocator<P, P>,
{
    /// Intensity W of the process noise, n x n, symmetric positive semidefinite, per unit of time.
    pub w: OMatrix<T, N, N>,
    /// Covariance V of one measurement, p x p, symmetric positive definite.
    pub v: OMatrix<T, P, P>,
    /// Covariance of the error of the initial estimate, n x n, symmetric positive semidefinite.
    pub p0: OMatrix<T, N, N>,
}

/// The innovation of a measurement update, with its covariance and normalised square.
#[derive(Clone, Debug, PartialEq)]
pub struct Innovation<T: RealField + Copy, P: Dim>
where
    DefaultAllocator: Allocator<P> + Allocator<P, P>,
{
    /// The innovation `y~ = y - h(xhat, u)` before the update, length p; zero for an output that was not measured.
    pub value: OVector<T, P>,
    /// Its covariance `S = H P H' + V`, p x p; the row and column of an output that was not measured are those of I.
    pub covariance: OMatrix<T, P, P>,
    /// `y~' S^-1 y~`: for the right noise and a linear plant chi-squared distributed, with as many degrees of freedom
    /// as outputs were measured.
    pub normalized_square: T,
}

impl<T: RealField + Copy, P: Dim> Innovation<T, P>
where
    DefaultAllocator: Allocator<P> + Allocator<P, P>,
{
    /// `ln det S` of the outputs that were measured; NaN if S is not positive definite.
    ///
    /// ```
    /// use luenberger_observers::{KalmanFilter, KalmanModel, SampledObserver};
    /// use nalgebra::{Matrix1, SMatrix, Vector1};
    /// // A constant of variance 3, measured with variance 1: S = 4.
    /// let one = Matrix1::new(1.0);
    /// let bd = SMatrix::<f64, 1, 0>::zeros();
    /// let model = KalmanModel { ad: one, bd, c: one, w: Matrix1::zeros(), v: one, p0: one * 3.0, period: 1.0 };
    /// let filter = KalmanFilter::new(model)?;
    /// let (u, y) = (SMatrix::<f64, 0, 1>::zeros(), Vector1::new(2.0));
    /// let mut state = filter.initial(0.0, &Vector1::zeros(), &u, &y);
    /// let innovation = filter.update(&mut state, &u, &y).ok_or("an update")?;
    /// assert!((innovation.log_determinant() - 4f64.ln()).abs() < 1e-15);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn log_determinant(&self) -> T {
        // The factor of a symmetric matrix, column by column: no more is needed than its diagonal.
        let order = self.covariance.nrows();
        let mut factor = self.covariance.clone();
        let mut sum = T::zero();
        for j in 0..order {
            let pivot = (0..j).fold(factor[(j, j)], |pivot, k| pivot - factor[(j, k)] * factor[(j, k)]);
            sum += pivot.ln();
            let root = pivot.sqrt();
            for i in j + 1..order {
                let entry = (0..j).fold(factor[(i, j)], |entry, k| entry - factor[(i, k)] * factor[(j, k)]);
                factor[(i, j)] = entry / root;
            }
        }
        sum
    }
}

/// Which entries of y an update uses: those that are `measured`, and finite numbers. None if some are measured, and all
/// of them are not finite.
pub(crate) fn usable<T: RealField + Copy, P: Dim>(
    y: &OVector<T, P>,
    measured: impl Fn(usize) -> bool,
) -> Option<OVector<bool, P>>
where
    DefaultAllocator: Allocator<P>,
{
    let usable = y.map_with_location(|i, _, y| measured(i) && y.is_finite());
    let is_any = usable.iter().any(|usable| *usable);
    (is_any || !(0..y.nrows()).any(measured)).then_some(usable)
}

/// A measurement as it is linearised at an estimate x: H (p x n), and `y - h(x)`.
pub(crate) type Linearised<T, N, P> = (OMatrix<T, P, N>, OVector<T, P>);

/// How often an update linearises, and H and `y - h(x)` where it does so after the first time.
pub(crate) type Again<F> = (usize, F);

/// [`corrected`], of the state of a filter.
pub(crate) fn correct<T: RealField + Copy, N: DimAdd<U1>, M: Dim, P: Dim>(
    estimate: &mut GaussianEstimate<T, N>,
    first: Linearised<T, N, P>,
    v: OMatrix<T, P, P>,
    measured: impl Fn(usize) -> bool,
    again: Again<impl Fn(&OVector<T, N>) -> Linearised<T, N, P>>,
) -> Option<Innovation<T, P>>
where
    DefaultAllocator: Size<N, M, P> + Allocator<N, DimSum<N, U1>>,
{
    let (xhat, p) = (estimate.estimate(), estimate.covariance());
    let (xhat, p, innovation) = corrected(&xhat, &p, first, v, measured, again)?;
    *estimate = GaussianEstimate::new(&xhat, &p);
    Some(innovation)
}

/// Stores what a prediction gives; false, and the estimate as it was, if that is not finite.
#[inline(always)]
pub(crate) fn moved<T: RealField + Copy, N: DimAdd<U1>>(
    estimate: &mut GaussianEstimate<T, N>,
    xhat: &OVector<T, N>,
    p: &OMatrix<T, N, N>,
) -> bool
where
    DefaultAllocator: Allocator<N, DimSum<N, U1>> + Allocator<N> + Allocator<N, N>,
{
    let is_finite = are_finite(xhat.as_slice()) && are_finite(p.as_slice());
    if is_finite {
        *estimate = GaussianEstimate::new(xhat, p);
    }
    is_finite
}

/// The gain `K = P H' S^-1` of a measurement with H and V, and `S = H P H' + V` with its factor.
struct Gain<T: RealField + Copy, N: Dim, P: Dim>
where
    DefaultAllocator: Allocator<N, P> + Allocator<P, P>,
{
    k: OMatrix<T, N, P>,
    s: OMatrix<T, P, P>,
    factor: Factor<T, P>,
}

impl<T: RealField + Copy, N: Dim, P: Dim> Gain<T, N, P>
where
    DefaultAllocator: Allocator<N, N> + Allocator<N, P> + Allocator<P, N> + Allocator<P, P>,
{
    /// None unless S is positive definite in floating point.
    #[inline(always)]
    fn new(h: &OMatrix<T, P, N>, p: &OMatrix<T, N, N>, v: &OMatrix<T, P, P>) -> Option<Self> {
        let hp = times(h, p);
        let s = times_transpose(&hp, h) + v;
        if !are_finite(s.as_slice()) {
            return None;
        }
        let factor = Factor::new(&s)?;
        // K' = S^-1 (H P).
        let k = factor.solve(&hp).transpose();
        Some(Self { k, s, factor })
    }
}

/// Estimate and covariance after the update by a measurement with V, in Joseph's form, shared by the filters.
///
/// It is linearised at xbar first, and then `iterations - 1` times `again`, where the linearisation before leads:
/// `x <- xbar + K (y - h(x) - H (xbar - x))`, with H and K of x, is a Gauss-Newton step of the weighted squares of
/// `x - xbar` and `y - h(x)`. The covariance is that of the last H, the innovation that at xbar.
///
/// An output that is not measured gets a zero row of H, a zero innovation and a noise of its own, so that its column of
/// K is zero: what is left is the update by the other rows.
///
/// None unless each S is positive definite and the result is finite. A measured entry of the innovation that is not
/// finite makes all of the estimate so, because `0 * NaN` and `0 * inf` are NaN.
#[allow(clippy::type_complexity, reason = "estimate, covariance, innovation")]
pub(crate) fn corrected<T: RealField + Copy, N: Dim, P: Dim>(
    xbar: &OVector<T, N>,
    p: &OMatrix<T, N, N>,
    first: Linearised<T, N, P>,
    mut v: OMatrix<T, P, P>,
    measured: impl Fn(usize) -> bool,
    (iterations, again): Again<impl Fn(&OVector<T, N>) -> Linearised<T, N, P>>,
) -> Option<(OVector<T, N>, OMatrix<T, N, N>, Innovation<T, P>)>
where
    DefaultAllocator:
        Allocator<N> + Allocator<P> + Allocator<N, N> + Allocator<N, P> + Allocator<P, N> + Allocator<P, P>,
{
    // Once: a gate has tested the innovations at xbar.
    let measured = first.1.map_with_location(|i, _, _| measured(i));
    let missing = || (0..measured.nrows()).filter(|&i| !measured[i]);
    let of_measured = |(mut h, mut error): Linearised<T, N, P>| {
        for i in missing() {
            h.row_mut(i).fill(T::zero());
            error[i] = T::zero();
        }
        (h, error)
    };
    for i in missing() {
        v.row_mut(i).fill(T::zero());
        v.column_mut(i).fill(T::zero());
        v[(i, i)] = T::one();
    }
    let (mut h, mut error) = of_measured(first);
    let mut gain = Gain::new(&h, p, &v)?;
    let normalized_square = error.dot(&gain.factor.solve(&error));
    let innovation = Innovation { value: error.clone(), covariance: gain.s.clone(), normalized_square };
    for _ in 1..iterations {
        let x = xbar + times(&gain.k, &error);
        (h, error) = of_measured(again(&x));
        error -= times(&h, &(xbar - x));
        gain = Gain::new(&h, p, &v)?;
    }
    let xhat = xbar + times(&gain.k, &error);
    let order = xhat.shape_generic().0;
    let keep = OMatrix::<T, N, N>::identity_generic(order, order) - times(&gain.k, &h);
    let mut p = times_transpose(&times(&keep, p), &keep) + times_transpose(&times(&gain.k, &v), &gain.k);
    symmetrise(&mut p);
    (are_finite(xhat.as_slice()) && are_finite(p.as_slice())).then_some((xhat, p, innovation))
}

/// Replaces a matrix by its symmetric part, exactly symmetric.
#[inline(always)]
pub(crate) fn symmetrise<T: RealField + Copy, N: Dim>(p: &mut OMatrix<T, N, N>)
where
    DefaultAllocator: Allocator<N, N>,
{
    let half: T = convert(0.5);
    for i in 0..p.nrows() {
        for j in 0..i {
            let mean = (p[(i, j)] + p[(j, i)]) * half;
            (p[(i, j)], p[(j, i)]) = (mean, mean);
        }
    }
}

/// The symmetric part of a covariance, after a check of shape, entries, symmetry and definiteness (or
/// semidefiniteness).
///
/// Mirrored entries may differ by 8 n epsilon of the largest entry, as for the designs that these matrices come from:
/// those of `C'WC` differ by `2 n epsilon` of `|C'| |W| |C|`.
pub(crate) fn covariance<T: RealField + Copy, D: Dim>(
    what: &'static str,
    mut matrix: OMatrix<T, D, D>,
    order: usize,
    definite: bool,
) -> Result<OMatrix<T, D, D>, ObserverError>
where
    DefaultAllocator: Allocator<D, D> + Allocator<D>,
{
    check_matrix(what, &matrix, (order, order))?;
    let largest = matrix.iter().fold(T::zero(), |largest: T, entry| largest.max(entry.abs()));
    let rounding = largest * T::default_epsilon() * convert::<f64, T>(8.0 * order as f64);
    for row in 0..order {
        for column in 0..row {
            let difference = matrix[(row, column)] - matrix[(column, row)];
            if difference.abs() > rounding {
                let difference = difference.to_subset_unchecked();
                return Err(ObserverError::NotSymmetric { what, row, column, difference });
            }
        }
    }
    symmetrise(&mut matrix);
    match failing_pivot(&matrix, (!definite).then_some(8)) {
        Some((row, pivot)) => Err(ObserverError::NotDefinite { what, row, pivot: pivot.to_subset_unchecked() }),
        None => Ok(matrix),
    }
}
