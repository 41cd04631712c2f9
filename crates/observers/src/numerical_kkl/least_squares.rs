//! The interpolated form of a left inverse: `min |W (T(x) - z)|` over the box.
//!
//! T is a [`TensorSpline`] or a [`TensorTrain`] in [`Coordinates`](crate::numerical_kkl::Coordinates); the minimum is
//! sought by Gauss-Newton steps with Levenberg's damping where a step does not reduce the residual, projected on the
//! box, and bounded in number. The start is the embedded form's estimate, a function of z alone, so that the estimate
//! is one too; who steps it in a loop can start from the last estimate instead ([`InterpolatedInverse::solve`]). Where
//! the iteration ends with a residual that the accuracy of the spline does not explain, it begins again at the best
//! points of a coarse grid, one after the other, and the best end is taken: the result is never farther from z, in T,
//! than the start was.

#[cfg(feature = "alloc")]
extern crate alloc;

use nalgebra::{Const, RealField, SMatrix, SVector, convert};

use crate::dense::{Factor, larger, sum};
use crate::error::ObserverError;
use crate::kkl::LeftInverse;
#[cfg(feature = "alloc")]
use crate::numerical_kkl::TensorTrain;
use crate::numerical_kkl::polynomial_tree::{PolynomialInverse, clamped, finite};
use crate::numerical_kkl::{Node, TensorSpline};

/// Where the iteration ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LeastSquares<T, const N: usize> {
    /// The state.
    pub x: SVector<T, N>,
    /// `|W (T(x) - z)|`: how far z is from T(box), as far as the iteration can see.
    pub residual: T,
    /// Evaluations of T.
    pub evaluations: usize,
    /// Whether the last step was below the resolution of the scalar; else the cap on evaluations ended it.
    pub converged: bool,
}

/// A differentiable map on a box: T as it is tabulated.
pub trait BoxMap<T: RealField + Copy, const N: usize, const Z: usize> {
    /// The box.
    fn bounds(&self) -> (&SVector<T, N>, &SVector<T, N>);

    /// The value at x and the Jacobian there (Z x N); outside the box, at its nearest point.
    fn with_gradient(&self, x: &SVector<T, N>) -> (SVector<T, Z>, SMatrix<T, Z, N>);
}

impl<T: RealField + Copy, V: AsRef<[T]>, const N: usize, const Z: usize> BoxMap<T, N, Z> for TensorSpline<T, V, N, Z> {
    fn bounds(&self) -> (&SVector<T, N>, &SVector<T, N>) {
        self.bounds()
    }

    fn with_gradient(&self, x: &SVector<T, N>) -> (SVector<T, Z>, SMatrix<T, Z, N>) {
        self.with_gradient(x)
    }
}

/// The interpolated form: T by splines, the state by least squares. `S` is the table, a [`TensorSpline`] or a
/// [`TensorTrain`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InterpolatedInverse<T, K, V, const N: usize, const Z: usize, S = TensorSpline<T, V, N, Z>> {
    spline: S,
    start: PolynomialInverse<T, K, V, N, Z>,
    search: Search<T>,
}

/// Starts on the coarse grid, at most.
pub const RESTARTS: usize = 4;

/// Largest number of points on the coarse grid.
const MOST_SEEDS: usize = 1 << 20;

/// Starts, nearest first, each with the square of its distance from z in T.
type Seeds<T, const N: usize> = [Option<(T, SVector<T, N>)>; RESTARTS];

/// How the interpolated form searches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Search<T> {
    /// Cap on the evaluations of the map per iteration, at least 1.
    pub max_evaluations: usize,
    /// The residual `|W (T(x) - z)|` that the accuracy of the spline explains.
    pub tolerance: T,
    /// Points per axis of the grid on which other starts are sought when the residual is larger; 0 for none.
    pub fallback: usize,
}

impl<T: RealField + Copy> Search<T> {
    /// # Errors
    /// [`ObserverError::Table`] for a cap of zero evaluations and for a coarse grid of more than a million points in N
    /// dimensions, [`ObserverError::TableNotFinite`] for the tolerance.
    pub(super) fn check<const N: usize>(&self) -> Result<(), ObserverError> {
        if self.max_evaluations == 0 {
            return Err(ObserverError::Table { what: "the cap on evaluations", expected: 1, found: 0 });
        }
        let grid = (0..N).try_fold(1, |count: usize, _| count.checked_mul(self.fallback));
        if grid.is_none_or(|count| count > MOST_SEEDS) {
            let (expected, found) = (MOST_SEEDS, self.fallback);
            return Err(ObserverError::Table { what: "the points per axis of the coarse grid", expected, found });
        }
        finite("the tolerance of the search", &[self.tolerance])
    }

    /// The same over another scalar, with a tolerance that it can resolve.
    #[cfg(feature = "alloc")]
    pub(super) fn cast<U: RealField + Copy>(&self) -> Search<U> {
        // Single precision cannot resolve what the spline can.
        let rounding = convert::<f64, U>(256.0) * U::default_epsilon();
        let tolerance = convert::<f64, U>(self.tolerance.to_subset_unchecked()).max(rounding);
        Search { max_evaluations: self.max_evaluations, tolerance, fallback: self.fallback }
    }

    /// The point of the box where `map` is nearest to w, from `guess` on.
    pub fn solve<const N: usize, const Z: usize>(
        &self,
        map: &impl BoxMap<T, N, Z>,
        w: &SVector<T, Z>,
        guess: &SVector<T, N>,
    ) -> LeastSquares<T, N> {
        let first = nearest(map, w, guess, self.max_evaluations);
        if first.residual <= self.tolerance || self.fallback == 0 {
            return first;
        }
        let (seeds, looked) = self.best_of_grid(map, w);
        let mut best = first;
        let mut evaluations = first.evaluations + looked;
        for (_, seed) in seeds.into_iter().flatten() {
            let other = nearest(map, w, &seed, self.max_evaluations);
            evaluations += other.evaluations;
            if other.residual < best.residual {
                best = other;
            }
            if best.residual <= self.tolerance {
                break;
            }
        }
        LeastSquares { evaluations, ..best }
    }

    /// The centres of the cells of a coarse grid whose images are nearest to w, nearest first, and how many were looked
    /// at.
    fn best_of_grid<const N: usize, const Z: usize>(
        &self,
        map: &impl BoxMap<T, N, Z>,
        w: &SVector<T, Z>,
    ) -> (Seeds<T, N>, usize) {
        let (lower, upper) = map.bounds();
        let count = self.fallback.pow(N as u32);
        let mut best = [None; RESTARTS];
        for index in 0..count {
            let mut rest = index;
            let x = SVector::from_fn(|i, _| {
                let share = convert::<f64, T>(((rest % self.fallback) as f64 + 0.5) / self.fallback as f64);
                rest /= self.fallback;
                lower[i] + (upper[i] - lower[i]) * share
            });
            let mut candidate = Some((squared(&(map.with_gradient(&x).0 - w)), x));
            for place in &mut best {
                let nearer = match (&candidate, &*place) {
                    (Some((cost, _)), Some((least, _))) => cost < least,
                    (found, _) => found.is_some(),
                };
                if nearer {
                    core::mem::swap(place, &mut candidate);
                }
            }
        }
        (best, count)
    }
}

impl<T, K, V, S, const N: usize, const Z: usize> InterpolatedInverse<T, K, V, N, Z, S>
where
    T: RealField + Copy,
    K: AsRef<[Node<T>]>,
    V: AsRef<[T]>,
    S: BoxMap<T, N, Z>,
{
    /// `spline` is `W (T(x) - m)` in the coordinates of `start`.
    ///
    /// # Errors
    /// [`ObserverError::Table`] for a cap of zero evaluations and for a coarse grid of more than a million points,
    /// [`ObserverError::TableNotFinite`] for the tolerance.
    pub fn new(spline: S, start: PolynomialInverse<T, K, V, N, Z>, search: Search<T>) -> Result<Self, ObserverError> {
        search.check::<N>()?;
        Ok(Self { spline, start, search })
    }

    /// T in the coordinates of the start.
    pub fn spline(&self) -> &S {
        &self.spline
    }

    /// The embedded form, from which the iteration starts.
    pub fn start(&self) -> &PolynomialInverse<T, K, V, N, Z> {
        &self.start
    }

    /// `T^-L(z)`: the state of the box whose image is nearest to z, from the embedded form's estimate on.
    pub fn state(&self, z: &SVector<T, Z>) -> SVector<T, N> {
        self.solve(z, &self.start.state(z)).x
    }

    /// How it searches.
    pub fn search(&self) -> &Search<T> {
        &self.search
    }

    /// `T(x)` for x in the box; outside, the value at the nearest point of the box.
    pub fn target(&self, x: &SVector<T, N>) -> SVector<T, Z> {
        self.start.coordinates().coloured(&self.spline.with_gradient(x).0)
    }

    /// The state whose image is nearest to z, from `guess` on: the last estimate, say.
    pub fn solve(&self, z: &SVector<T, Z>, guess: &SVector<T, N>) -> LeastSquares<T, N> {
        self.search.solve(&self.spline, &self.start.coordinates().white(z), guess)
    }
}

/// The interpolated form over another scalar.
#[cfg(feature = "alloc")]
macro_rules! cast {
    ($($table:ident),*) => {
        $(impl<T, K, V, const N: usize, const Z: usize> InterpolatedInverse<T, K, V, N, Z, $table<T, V, N, Z>>
        where
            T: RealField + Copy,
            K: AsRef<[Node<T>]>,
            V: AsRef<[T]>,
        {
            /// The same over another scalar, on the heap.
            pub fn cast<U: RealField + Copy>(&self) -> OnHeap<U, N, Z, $table<U, alloc::vec::Vec<U>, N, Z>> {
                InterpolatedInverse { spline: self.spline.cast(), start: self.start.cast(), search: self.search.cast() }
            }
        })*
    };
}

/// An interpolated form on the heap.
#[cfg(feature = "alloc")]
type OnHeap<T, const N: usize, const Z: usize, S> =
    InterpolatedInverse<T, alloc::vec::Vec<Node<T>>, alloc::vec::Vec<T>, N, Z, S>;

#[cfg(feature = "alloc")]
cast!(TensorSpline, TensorTrain);

impl<T, K, V, S, const N: usize, const P: usize, const Z: usize> LeftInverse<T, Const<Z>, Const<P>, Const<N>>
    for InterpolatedInverse<T, K, V, N, Z, S>
where
    T: RealField + Copy,
    K: AsRef<[Node<T>]>,
    V: AsRef<[T]>,
    S: BoxMap<T, N, Z>,
{
    fn estimate_len(&self) -> usize {
        N
    }

    fn left_inverse(&self, z: &SVector<T, Z>, _y: &SVector<T, P>) -> SVector<T, N> {
        self.state(z)
    }

    fn image(&self, xhat: &SVector<T, N>, _y: &SVector<T, P>) -> SVector<T, Z> {
        self.target(xhat)
    }
}

/// The point x of the map's box whose value is nearest to w, from `guess` on, by projected Levenberg-Marquardt
/// steps.
///
/// A local minimum; bounded by `max_evaluations` evaluations of the map, of a spline some `4^(N-1) Z (N + 9)`
/// multiply-adds each.
pub fn nearest<T: RealField + Copy, const N: usize, const Z: usize>(
    map: &impl BoxMap<T, N, Z>,
    w: &SVector<T, Z>,
    guess: &SVector<T, N>,
    max_evaluations: usize,
) -> LeastSquares<T, N> {
    let (&lower, &upper) = map.bounds();
    let width = upper - lower;
    let inside = |x: &SVector<T, N>| clamped(&x.map(|e| if e.is_finite() { e } else { T::zero() }), &lower, &upper);
    let mut x = inside(guess);
    let (value, mut jacobian) = map.with_gradient(&x);
    let mut residual = w - value;
    let mut cost = squared(&residual);
    let mut evaluations = 1;
    let mut damping = T::zero();
    // A step of this many parts of the width of the box is noise.
    let resolution = convert::<f64, T>(4.0) * T::default_epsilon();
    let mut converged = false;
    while evaluations < max_evaluations && !converged {
        let gradient = SVector::<T, N>::from_fn(|i, _| sum(Z, |k| jacobian[(k, i)] * residual[k]));
        let gram = SMatrix::<T, N, N>::from_fn(|i, j| sum(Z, |k| jacobian[(k, i)] * jacobian[(k, j)]));
        let trace = sum(N, |i| gram[(i, i)]);
        // At a face of the box, with the descent pointing out of it, a coordinate stands still.
        let held = SVector::<bool, N>::from_fn(|i, _| {
            (x[i] <= lower[i] && gradient[i] < T::zero()) || (x[i] >= upper[i] && gradient[i] > T::zero())
        });
        let step = damped_step(&gram, &gradient, damping + trace * T::default_epsilon(), &held);
        let next = inside(&(x + step));
        let moved = (0..N).map(|i| ((next[i] - x[i]) / width[i]).abs()).fold(T::zero(), larger);
        if moved <= resolution {
            converged = true;
            break;
        }
        let (candidate, slope) = map.with_gradient(&next);
        evaluations += 1;
        let trial = w - candidate;
        let trial_cost = squared(&trial);
        if trial_cost < cost {
            // So little gained that rounding may have gained it.
            converged = cost - trial_cost <= resolution * cost;
            (x, residual, cost, jacobian) = (next, trial, trial_cost, slope);
            damping *= convert(0.1);
            if damping < trace * convert(1e-6) {
                damping = T::zero();
            }
        } else {
            damping = larger(damping * convert(8.0), trace * convert(1e-4));
        }
    }
    LeastSquares { x, residual: cost.sqrt(), evaluations, converged }
}

/// `(J'J + damping I) step = J'r` in the coordinates that are not held; zero where that has no solution.
fn damped_step<T: RealField + Copy, const N: usize>(
    gram: &SMatrix<T, N, N>,
    gradient: &SVector<T, N>,
    damping: T,
    held: &SVector<bool, N>,
) -> SVector<T, N> {
    let mut matrix = *gram;
    let mut right = *gradient;
    for i in 0..N {
        if held[i] {
            matrix.row_mut(i).fill(T::zero());
            matrix.column_mut(i).fill(T::zero());
            matrix[(i, i)] = T::one();
            right[i] = T::zero();
        } else {
            matrix[(i, i)] += damping;
        }
    }
    Factor::new(&matrix).map_or_else(SVector::zeros, |factor| factor.solve(&right))
}

/// The sum of the squares, from the first to the last.
fn squared<T: RealField + Copy, const Z: usize>(v: &SVector<T, Z>) -> T {
    sum(Z, |k| v[k] * v[k])
}
