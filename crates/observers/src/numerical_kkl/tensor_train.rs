//! A map on a box of many dimensions, of low rank: a tensor train of cubic splines.
//!
//! ```text
//! s(x) = G_1(x_1) G_2(x_2) ... G_N(x_N)         G_i(x_i): r_i x r_(i+1), r_1 = Z, r_(N+1) = 1
//! G_i(x_i) = sum_k C_ik B_k(x_i)                B_k: the cubic B-splines of the grid of axis i
//! ```
//!
//! A [`TensorSpline`](crate::numerical_kkl::TensorSpline) has `prod (points_i + 2)` coefficients per output, this one
//! `sum (points_i + 2) r_i r_(i+1)`: it grows linearly with N for maps whose ranks are bounded. An evaluation with its
//! Jacobian takes about `sum r_i r_(i+1) (9 + N - i)` multiply-adds.
//!
//! Sources: I. V. Oseledets, Tensor-train decomposition, SIAM Journal on Scientific Computing 33, 2011; A. Gorodetsky,
//! S. Karaman and Y. Marzouk, A continuous analogue of the tensor-train decomposition, Computer Methods in Applied
//! Mechanics and Engineering 347, 2019, for cores that are functions.

#[cfg(feature = "alloc")]
extern crate alloc;

use core::marker::PhantomData;

use nalgebra::{RealField, SMatrix, SVector};

use crate::error::ObserverError;
use crate::numerical_kkl::least_squares::BoxMap;
use crate::numerical_kkl::polynomial_tree::finite;
use crate::numerical_kkl::spline::{Local, check_grid, local};

/// Largest rank: vectors of this length are on the stack.
pub const MOST_RANK: usize = 32;

/// A map from a box in N dimensions to Z numbers; `V` lends the coefficients.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TensorTrain<T, V, const N: usize, const Z: usize> {
    lower: SVector<T, N>,
    upper: SVector<T, N>,
    points: [usize; N],
    ranks: [usize; N],
    coefficients: V,
    scalar: PhantomData<T>,
}

impl<T, V, const N: usize, const Z: usize> TensorTrain<T, V, N, Z>
where
    T: RealField + Copy,
    V: AsRef<[T]>,
{
    /// The map with `points[i]` uniformly spaced points on axis i, ends included, and matrices of `ranks[i]` rows for
    /// it; the first is Z, and the matrices of the last axis have one column.
    ///
    /// Coefficients: axis by axis; for each of its `points[i] + 2` B-splines a matrix, row by row.
    ///
    /// `x_1 (1 + x_2)`, of rank 1, from the coefficients of x and of 1 + x on the unit interval:
    /// ```
    /// use luenberger_observers::numerical_kkl::{BoxMap, TensorTrain};
    /// use nalgebra::Vector2;
    /// let coefficients = [-1.0, 0.0, 1.0, 2.0, 0.0, 1.0, 2.0, 3.0];
    /// let (lower, upper) = (Vector2::zeros(), Vector2::repeat(1.0));
    /// let map = TensorTrain::<f64, _, 2, 1>::new(lower, upper, [2; 2], [1; 2], coefficients)?;
    /// let (value, slope) = map.with_gradient(&Vector2::new(0.5, 0.25));
    /// assert!((value[0] - 0.625).abs() < 1e-15);
    /// assert!((slope[0] - 1.25).abs() < 1e-15 && (slope[1] - 0.5).abs() < 1e-15);
    /// # Ok::<(), luenberger_observers::ObserverError>(())
    /// ```
    /// # Errors
    /// [`ObserverError::Box`]; [`ObserverError::Table`] for fewer than two points on an axis, a rank of 0 or above
    /// [`MOST_RANK`], a first rank other than Z, or another number of coefficients; [`ObserverError::TableNotFinite`].
    pub fn new(
        lower: SVector<T, N>,
        upper: SVector<T, N>,
        points: [usize; N],
        ranks: [usize; N],
        coefficients: V,
    ) -> Result<Self, ObserverError> {
        check_grid((&lower, &upper), &points)?;
        if let Some(&found) = ranks.iter().find(|&&rank| rank > MOST_RANK) {
            return Err(ObserverError::Table { what: "the largest rank", expected: MOST_RANK, found });
        }
        if let Some(&found) = ranks.iter().find(|&&rank| rank == 0) {
            return Err(ObserverError::Table { what: "the smallest rank", expected: 1, found });
        }
        if let Some(&found) = ranks.first().filter(|&&rank| rank != Z) {
            return Err(ObserverError::Table { what: "the first rank", expected: Z, found });
        }
        let numbers = |i: usize| ranks[i] * columns(&ranks, i);
        let expected =
            (0..N).fold(0usize, |sum, i| sum.saturating_add(points[i].saturating_add(2).saturating_mul(numbers(i))));
        let found = coefficients.as_ref().len();
        if found != expected {
            return Err(ObserverError::Table { what: "the coefficients of the tensor train", expected, found });
        }
        finite("the coefficients of the tensor train", coefficients.as_ref())?;
        Ok(Self { lower, upper, points, ranks, coefficients, scalar: PhantomData })
    }

    /// Points per axis.
    pub fn points(&self) -> [usize; N] {
        self.points
    }

    /// Rows of the matrices of each axis.
    pub fn ranks(&self) -> [usize; N] {
        self.ranks
    }

    /// The coefficients.
    pub fn coefficients(&self) -> &[T] {
        self.coefficients.as_ref()
    }

    /// The same over another scalar, on the heap.
    #[cfg(feature = "alloc")]
    pub fn cast<U: RealField + Copy>(&self) -> TensorTrain<U, alloc::vec::Vec<U>, N, Z> {
        let cast = |x: T| nalgebra::convert::<f64, U>(x.to_subset_unchecked());
        TensorTrain {
            lower: self.lower.map(cast),
            upper: self.upper.map(cast),
            points: self.points,
            ranks: self.ranks,
            coefficients: self.coefficients.as_ref().iter().map(|&x| cast(x)).collect(),
            scalar: PhantomData,
        }
    }
}

/// Columns of the matrices of an axis: the rows of the next one's.
fn columns<const N: usize>(ranks: &[usize; N], axis: usize) -> usize {
    ranks.get(axis + 1).copied().unwrap_or(1)
}

impl<T, V, const N: usize, const Z: usize> BoxMap<T, N, Z> for TensorTrain<T, V, N, Z>
where
    T: RealField + Copy,
    V: AsRef<[T]>,
{
    fn bounds(&self) -> (&SVector<T, N>, &SVector<T, N>) {
        (&self.lower, &self.upper)
    }

    /// The product from the last axis to the first, a vector; beside it its derivatives by the axes that it has passed.
    fn with_gradient(&self, x: &SVector<T, N>) -> (SVector<T, Z>, SMatrix<T, Z, N>) {
        let Local { first, weights, slopes } = local(x, (&self.lower, &self.upper), &self.points);
        let mut rest = self.coefficients.as_ref();
        let mut value = [T::zero(); MOST_RANK];
        let mut gradient = [[T::zero(); MOST_RANK]; N];
        value[0] = T::one();
        for axis in (0..N).rev() {
            let (rows, columns) = (self.ranks[axis], columns(&self.ranks, axis));
            let size = rows * columns;
            let (before, core) = rest.split_at(rest.len() - (self.points[axis] + 2) * size);
            rest = before;
            let near = &core[first[axis] * size..][..4 * size];
            let (w, s) = (&weights[axis], &slopes[axis]);
            let mut next = [T::zero(); MOST_RANK];
            let mut turned = [[T::zero(); MOST_RANK]; N];
            for i in 0..rows {
                for j in 0..columns {
                    let c = |k: usize| near[k * size + i * columns + j];
                    let entry = w[0] * c(0) + w[1] * c(1) + w[2] * c(2) + w[3] * c(3);
                    let slope = s[0] * c(0) + s[1] * c(1) + s[2] * c(2) + s[3] * c(3);
                    next[i] += entry * value[j];
                    turned[axis][i] += slope * value[j];
                    for passed in axis + 1..N {
                        turned[passed][i] += entry * gradient[passed][j];
                    }
                }
            }
            (value, gradient) = (next, turned);
        }
        (SVector::from_fn(|z, _| value[z]), SMatrix::from_fn(|z, axis| gradient[axis][z]))
    }
}
