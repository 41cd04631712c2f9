//! Products and the Cholesky factorisation of small matrices, with one order of operations for every size.
//!
//! nalgebra multiplies large matrices by blocks, with fused operations where the processor has them, and unrolls sums
//! of fixed length, so that its last bits depend on the machine and on whether sizes are known at compile time. A
//! filter that is simulated on a workstation, runs in Rust on a target and is exported as C needs the same bits in all
//! three. Here a sum starts with its first term and adds the others in order.

#![allow(clippy::inline_always, reason = "loops over columns of fixed sizes unroll only where the sizes are seen")]

use nalgebra::allocator::Allocator;
use nalgebra::{Const, DefaultAllocator, Dim, OMatrix, OVector, RealField};

/// `terms[0] + terms[1] + ..`, from left to right; 0 without terms.
#[inline(always)]
pub(crate) fn sum<T: RealField + Copy>(count: usize, term: impl Fn(usize) -> T) -> T {
    (0..count).map(term).reduce(|sum, term| sum + term).unwrap_or_else(T::zero)
}

/// A number whose computation has branches. Apart from the rest, so that a body that is recorded for its export joins
/// them here: branches that are side by side would multiply.
#[inline(always)]
pub(crate) fn branches<T: RealField + Copy>(value: impl Fn() -> T) -> T {
    T::zero().map_lanes(|_| value())
}

/// x where the condition holds, else y.
#[inline(always)]
pub(crate) fn choose<T: RealField + Copy>(condition: impl Fn() -> bool, x: T, y: T) -> T {
    branches(|| if condition() { x } else { y })
}

/// The larger of two numbers, the second where they are equal or the first is none: that of zeros with different signs
/// is not the same on all processors with `max`.
pub(crate) fn larger<T: RealField + Copy>(x: T, y: T) -> T {
    choose(|| x > y, x, y)
}

/// Columns up to this length live on the stack where their size is not known at compile time.
const SMALL: usize = 16;

/// Runs with a column of zeros, for which nothing is allocated up to [`SMALL`] entries.
#[inline(always)]
pub(crate) fn with_column<T: RealField + Copy, D: Dim, R>(dim: D, run: impl FnOnce(&mut [T]) -> R) -> R
where
    DefaultAllocator: Allocator<D>,
{
    if D::try_to_usize().is_none() && dim.value() <= SMALL {
        run(&mut [T::zero(); SMALL][..dim.value()])
    } else {
        run(OVector::<T, D>::zeros_generic(dim, Const).as_mut_slice())
    }
}

/// Copies what both have: no length can be wrong, so that nothing panics on a target.
pub(crate) fn copy<T: Copy>(from: &[T], to: &mut [T]) {
    for (to, from) in to.iter_mut().zip(from) {
        *to = *from;
    }
}

/// Entry `i` of `A v`. In a release build an index beyond A adds nothing: where the sizes are out of the compiler's
/// sight it would keep a panic for it.
#[inline(always)]
pub(crate) fn entry<T: RealField + Copy, R: Dim, C: Dim>(a: &OMatrix<T, R, C>, i: usize, v: &[T]) -> T
where
    DefaultAllocator: Allocator<R, C>,
{
    debug_assert_eq!(a.ncols(), v.len(), "columns of a matrix and length of the vector");
    let mut products = v.iter().enumerate().map(|(k, v)| a.get((i, k)).map_or_else(T::zero, |a| *a * *v));
    let first = products.next().unwrap_or_else(T::zero);
    products.fold(first, |sum, product| sum + product)
}

/// The matrix of entries `f(i, j)`. As nalgebra's `from_fn_generic`, in line: called, that keeps a panic for an index
/// that no caller has.
#[inline(always)]
fn filled<T: RealField + Copy, R: Dim, C: Dim>(rows: R, columns: C, f: impl Fn(usize, usize) -> T) -> OMatrix<T, R, C>
where
    DefaultAllocator: Allocator<R, C>,
{
    let mut matrix = OMatrix::zeros_generic(rows, columns);
    for j in 0..columns.value() {
        for i in 0..rows.value() {
            matrix[(i, j)] = f(i, j);
        }
    }
    matrix
}

/// `A B`.
#[inline(always)]
pub fn times<T: RealField + Copy, R: Dim, K: Dim, C: Dim>(
    a: &OMatrix<T, R, K>,
    b: &OMatrix<T, K, C>,
) -> OMatrix<T, R, C>
where
    DefaultAllocator: Allocator<R, K> + Allocator<K, C> + Allocator<R, C>,
{
    let (rows, columns, inner) = (a.shape_generic().0, b.shape_generic().1, a.ncols());
    filled(rows, columns, |i, j| sum(inner, |k| a[(i, k)] * b[(k, j)]))
}

/// `A B'`.
#[inline(always)]
pub fn times_transpose<T: RealField + Copy, R: Dim, K: Dim, C: Dim>(
    a: &OMatrix<T, R, K>,
    b: &OMatrix<T, C, K>,
) -> OMatrix<T, R, C>
where
    DefaultAllocator: Allocator<R, K> + Allocator<C, K> + Allocator<R, C>,
{
    let (rows, columns, inner) = (a.shape_generic().0, b.shape_generic().0, a.ncols());
    filled(rows, columns, |i, j| sum(inner, |k| a[(i, k)] * b[(j, k)]))
}

/// The Cholesky factor of a symmetric positive definite matrix, `S = G G'`, of which the lower triangle is read.
#[derive(Clone, Debug, PartialEq)]
pub struct Factor<T: RealField + Copy, D: Dim>(OMatrix<T, D, D>)
where
    DefaultAllocator: Allocator<D, D>;

impl<T: RealField + Copy, D: Dim> Factor<T, D>
where
    DefaultAllocator: Allocator<D, D>,
{
    /// `None` unless all pivots are positive numbers.
    pub fn new(s: &OMatrix<T, D, D>) -> Option<Self> {
        let mut g = s.clone();
        for j in 0..g.nrows() {
            for i in j..g.nrows() {
                let entry = (0..j).fold(g[(i, j)], |entry, k| entry - g[(i, k)] * g[(j, k)]);
                if i > j {
                    g[(i, j)] = entry / g[(j, j)];
                } else if entry > T::zero() {
                    g[(j, j)] = entry.sqrt();
                } else {
                    return None;
                }
            }
        }
        Some(Self(g))
    }

    /// `ln det S`.
    #[cfg(feature = "alloc")]
    pub(crate) fn log_determinant(&self) -> T {
        (0..self.0.nrows()).fold(T::zero(), |sum, i| sum + self.0[(i, i)].ln() * (T::one() + T::one()))
    }

    /// G, whose entries above the diagonal are those of S.
    pub(crate) fn lower(&self) -> &OMatrix<T, D, D> {
        &self.0
    }

    /// `G^-1 B` in the place of B.
    pub(crate) fn half_solve<C: Dim>(&self, x: &mut OMatrix<T, D, C>)
    where
        DefaultAllocator: Allocator<D, C>,
    {
        let g = &self.0;
        for j in 0..x.ncols() {
            for i in 0..g.nrows() {
                let entry = (0..i).fold(x[(i, j)], |entry, k| entry - g[(i, k)] * x[(k, j)]);
                x[(i, j)] = entry / g[(i, i)];
            }
        }
    }

    /// `S^-1 B`.
    pub fn solve<C: Dim>(&self, b: &OMatrix<T, D, C>) -> OMatrix<T, D, C>
    where
        DefaultAllocator: Allocator<D, C>,
    {
        let (g, mut x) = (&self.0, b.clone());
        let order = g.nrows();
        for j in 0..x.ncols() {
            for i in 0..order {
                let entry = (0..i).fold(x[(i, j)], |entry, k| entry - g[(i, k)] * x[(k, j)]);
                x[(i, j)] = entry / g[(i, i)];
            }
            for i in (0..order).rev() {
                let entry = (i + 1..order).fold(x[(i, j)], |entry, k| entry - g[(k, i)] * x[(k, j)]);
                x[(i, j)] = entry / g[(i, i)];
            }
        }
        x
    }
}

/// Whether all entries are finite. Without a branch for each, and on slices, which loops pass in fewer instructions
/// than the iterators of matrices.
pub(crate) fn are_finite<T: RealField + Copy>(entries: &[T]) -> bool {
    entries.iter().fold(true, |are, entry| are & entry.is_finite())
}
