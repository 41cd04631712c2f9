//! One Gauss-Newton step: the window's problem, linearised along a trajectory, solved by a Kalman filter forward and
//! the adjoint equations backward.
//!
//! The stationarity of the linearised problem gives, with the filtered mean m and covariance P of a stage, the gains
//! K = P c/s, rows c' and innovations nu with the variance s of its measurements, and A from it to the next,
//!
//! ```text
//! x = m - P lambda,    lambda <- A' mu,    mu <- mu - c (K' mu + nu/s)    over the measurements of the next stage
//! ```
//!
//! where mu begins with the lambda of the next stage and takes its measurements in reversed order; lambda = 0 at the
//! last stage. No covariance is inverted but s: W and the prior may be singular. A measurement takes `9 n^2` flops, one
//! of a single state `5 n^2`, the way back `4 n^2` a stage.
//!
//! Source: G. J. Bierman, Fixed interval smoothing with discrete measurements, International Journal of Control 18,
//! 1973 (the modified Bryson-Frazier smoother).

use nalgebra::allocator::Allocator;
use nalgebra::{ComplexField, DefaultAllocator, Dim, OMatrix, OVector, RealField, U1};

/// The size of what is not read: 0, if it is known at run time.
pub(super) fn unused<N: Dim>() -> N {
    N::from_usize(N::try_to_usize().unwrap_or(0))
}

/// The row of a measurement: its entries, or that of one state.
#[derive(Clone, Copy)]
pub(super) enum Row<'r, T: RealField + Copy> {
    Entries(&'r [T]),
    State(usize),
}

impl<T: RealField + Copy> Row<'_, T> {
    /// `M' c`.
    fn transposed_times<N: Dim>(self, matrix: &OMatrix<T, N, N>) -> OVector<T, N>
    where
        DefaultAllocator: Allocator<N> + Allocator<N, N>,
    {
        match self {
            Row::Entries(c) => transposed_times(matrix, c),
            Row::State(j) => OVector::from_fn_generic(matrix.shape_generic().0, U1, |i, _| matrix[(j, i)]),
        }
    }

    /// The product with a vector.
    fn times(self, v: &[T]) -> T {
        match self {
            Row::Entries(c) => product(c, v),
            Row::State(j) => v[j],
        }
    }
}

fn product<T: RealField + Copy>(v: &[T], w: &[T]) -> T {
    v.iter().zip(w).fold(T::zero(), |sum, (v, w)| sum + *v * *w)
}

fn transposed_times<T: RealField + Copy, N: Dim>(matrix: &OMatrix<T, N, N>, v: &[T]) -> OVector<T, N>
where
    DefaultAllocator: Allocator<N> + Allocator<N, N>,
{
    OVector::from_fn_generic(matrix.shape_generic().0, U1, |i, _| {
        v.iter().enumerate().fold(T::zero(), |sum, (k, v)| sum + matrix[(k, i)] * *v)
    })
}

/// What the way back needs of K measurements of a stage: their gains, in columns, and `nu/s`.
#[derive(Clone, Debug)]
pub(super) struct Used<T: RealField + Copy, N: Dim, K: Dim>
where
    DefaultAllocator: Allocator<N, K> + Allocator<K>,
{
    gains: OMatrix<T, N, K>,
    innovations: OVector<T, K>,
}

impl<T: RealField + Copy, N: Dim, K: Dim> Used<T, N, K>
where
    DefaultAllocator: Allocator<N, K> + Allocator<K>,
{
    /// None of them.
    pub(super) fn none(order: N, count: K) -> Self {
        Self { gains: OMatrix::zeros_generic(order, count), innovations: OVector::zeros_generic(count, U1) }
    }

    fn gain(&self, k: usize) -> &[T] {
        let n = self.gains.nrows();
        &self.gains.as_slice()[k * n..(k + 1) * n]
    }

    /// `adjoint - c (K' adjoint + nu/s)` of the measurement k.
    pub(super) fn before(&self, k: usize, c: Row<'_, T>, adjoint: &mut [T]) {
        let weight = product(self.gain(k), adjoint) + self.innovations[k];
        match c {
            Row::Entries(c) => adjoint.iter_mut().zip(c).for_each(|(entry, c)| *entry -= *c * weight),
            Row::State(j) => adjoint[j] -= weight,
        }
    }
}

/// A sample of the window in the filter, and what the way back needs of it.
#[derive(Clone, Debug)]
pub(super) struct Stage<T: RealField + Copy, N: Dim, P: Dim>
where
    DefaultAllocator: Allocator<N> + Allocator<N, N> + Allocator<N, P> + Allocator<P>,
{
    /// Mean and covariance after the measurements of the stage.
    pub(super) mean: OVector<T, N>,
    pub(super) covariance: OMatrix<T, N, N>,
    /// The rows of the outputs, in columns; zero where none was measured.
    pub(super) rows: OMatrix<T, N, P>,
    pub(super) outputs: Used<T, N, P>,
    /// A to the next stage.
    pub(super) forward: OMatrix<T, N, N>,
}

impl<T: RealField + Copy, N: Dim, P: Dim> Stage<T, N, P>
where
    DefaultAllocator: Allocator<N> + Allocator<N, N> + Allocator<N, P> + Allocator<P>,
{
    pub(super) fn new(mean: OVector<T, N>, covariance: OMatrix<T, N, N>, outputs: P) -> Self {
        let order = mean.shape_generic().0;
        Self {
            rows: OMatrix::zeros_generic(order, outputs),
            outputs: Used::none(order, outputs),
            forward: OMatrix::identity_generic(order, order),
            mean,
            covariance,
        }
    }

    /// What stands behind the last stage of a window, and is not read: nothing, if the size is known at run time.
    pub(super) fn unused() -> Self {
        let order = unused::<N>();
        Self::new(OVector::zeros_generic(order, U1), OMatrix::zeros_generic(order, order), unused())
    }

    /// The row of an output.
    pub(super) fn row(&self, output: usize) -> Row<'_, T> {
        let n = self.mean.nrows();
        Row::Entries(&self.rows.as_slice()[output * n..(output + 1) * n])
    }

    /// The update by an output, whose row is stored, with a noise of the variance 1.
    pub(super) fn measure(&mut self, output: usize, innovation: T) -> bool {
        let n = self.mean.nrows();
        let row = Row::Entries(&self.rows.as_slice()[output * n..(output + 1) * n]);
        update((&mut self.mean, &mut self.covariance), row, (innovation, T::one()), (&mut self.outputs, output))
    }

    /// The update by a bound of a state, number k of these.
    pub(super) fn bound(&mut self, state: usize, value: (T, T), used: &mut Used<T, N, N>) -> bool {
        update((&mut self.mean, &mut self.covariance), Row::State(state), value, (used, state))
    }

    /// The adjoint variables of the stage before its outputs, from those behind them.
    pub(super) fn before_outputs(&self, adjoint: &mut OVector<T, N>) {
        for output in (0..self.rows.ncols()).rev() {
            self.outputs.before(output, self.row(output), adjoint.as_mut_slice());
        }
    }

    /// `A' mu`.
    pub(super) fn backward(&self, adjoint: &OVector<T, N>) -> OVector<T, N> {
        transposed_times(&self.forward, adjoint.as_slice())
    }

    /// `m - P lambda`.
    pub(super) fn smoothed(&self, lambda: &OVector<T, N>) -> OVector<T, N> {
        let mut x = self.mean.clone();
        for i in 0..x.nrows() {
            for k in 0..x.nrows() {
                x[i] -= self.covariance[(i, k)] * lambda[k];
            }
        }
        x
    }
}

/// The update of mean and covariance by one measurement `c x = value + v` of an innovation with the variance
/// `s = c P c' + v`, number k of its kind; false if s is not a positive number.
///
/// P is that of Joseph's form, by two changes of rank one: with the gain `K = P c'/s`, `A = P - K (P c')'` is followed
/// by `A - (A c') K' + K v K'`, where `A c'` is computed from A, so that what the first difference left in the
/// direction c by rounding is taken away by the second.
fn update<T: RealField + Copy, N: Dim, K: Dim>(
    (mean, covariance): (&mut OVector<T, N>, &mut OMatrix<T, N, N>),
    c: Row<'_, T>,
    (innovation, variance): (T, T),
    (used, k): (&mut Used<T, N, K>, usize),
) -> bool
where
    DefaultAllocator: Allocator<N> + Allocator<N, N> + Allocator<N, K> + Allocator<K>,
{
    let pc = c.transposed_times(covariance);
    let s = c.times(pc.as_slice()) + variance;
    if !(s > T::zero() && ComplexField::is_finite(&s)) {
        return false;
    }
    used.innovations[k] = innovation / s;
    let gain = pc.map(|entry| entry / s);
    // A', in the place of P.
    for i in 0..gain.nrows() {
        used.gains[(i, k)] = gain[i];
        mean[i] += gain[i] * innovation;
        for j in 0..gain.nrows() {
            covariance[(i, j)] -= pc[i] * gain[j];
        }
    }
    let left = c.transposed_times(covariance);
    for i in 0..gain.nrows() {
        let noise = gain[i] * variance;
        for j in 0..=i {
            let entry = covariance[(j, i)] - left[i] * gain[j] + noise * gain[j];
            (covariance[(i, j)], covariance[(j, i)]) = (entry, entry);
        }
    }
    true
}
