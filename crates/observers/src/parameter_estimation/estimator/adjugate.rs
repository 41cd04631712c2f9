//! The adjugate and the determinant, `adj(A) A = A adj(A) = det(A) I`, without an inverse.
//!
//! Both exist for every square matrix, also a singular one, for which there is nothing to divide by: adj A has rank 1
//! when A has rank n - 1, and is 0 below that.
//!
//! Method: elimination with complete pivoting, `A = P L U Q`, and `adj A = det(PQ) Q' adj(U) L^-1 P'`. The recursion
//! for adj U divides by all pivots but the last, and complete pivoting leaves a zero before the last one only where adj
//! A = 0. n^3 operations, bounded. Source: G. W. Stewart, On the adjugate matrix, Linear Algebra and its Applications
//! 283, 1998.

use nalgebra::allocator::Allocator;
use nalgebra::{DefaultAllocator, Dim, OMatrix, OVector, RealField, U1};

use crate::cubic::count;
use crate::dense::{choose, times};

/// `adj A` and `det A`.
#[derive(Clone, Debug, PartialEq)]
pub struct Adjugate<T: RealField + Copy, Q: Dim>
where
    DefaultAllocator: Allocator<Q, Q>,
{
    /// `adj A`, q x q.
    pub adjugate: OMatrix<T, Q, Q>,
    /// `det A`.
    pub determinant: T,
}

/// `adj A` and `det A` of a square matrix. The matrix of no rows has determinant 1; an entry that is not finite gives a
/// determinant that is NaN.
///
/// ```
/// use luenberger_observers::estimator::adjugate::adjugate;
/// use nalgebra::Matrix2;
/// let answer = adjugate(&Matrix2::new(1.0, 2.0, 2.0, 4.0));
/// assert_eq!((answer.determinant, answer.adjugate), (0.0, Matrix2::new(4.0, -2.0, -2.0, 1.0)));
/// ```
pub fn adjugate<T: RealField + Copy, Q: Dim>(a: &OMatrix<T, Q, Q>) -> Adjugate<T, Q>
where
    DefaultAllocator: Allocator<Q, Q> + Allocator<Q>,
{
    let (order, n) = (a.shape_generic().0, a.nrows());
    let (zero, one) = (T::zero(), T::one());
    if n == 0 {
        return Adjugate { adjugate: a.clone(), determinant: one };
    }
    // 0, and NaN with an entry that is not finite.
    let spoiled = a.iter().fold(zero, |sum, entry| sum + *entry * zero);
    // Elimination of U, with L^-1 P' gathered in `left` and the order of the columns in `columns`.
    let mut u = a.clone();
    let mut left = OMatrix::<T, Q, Q>::identity_generic(order, order);
    let mut columns = OVector::<T, Q>::from_fn_generic(order, U1, |i, _| count(i));
    let mut sign = one;
    for k in 0..n {
        let (mut largest, mut row, mut column) = (u[(k, k)].abs(), count::<T>(k), count::<T>(k));
        for j in k..n {
            for i in k..n {
                let (size, before) = (u[(i, j)].abs(), largest);
                largest = choose(|| size > before, size, before);
                row = choose(|| size > before, count(i), row);
                column = choose(|| size > before, count(j), column);
            }
        }
        for i in k + 1..n {
            let is_row = || row == count(i);
            for j in 0..n {
                exchange(is_row, &mut u, (k, j), (i, j));
                exchange(is_row, &mut left, (k, j), (i, j));
            }
            sign = choose(is_row, -sign, sign);
        }
        for j in k + 1..n {
            let is_column = || column == count(j);
            for i in 0..n {
                exchange(is_column, &mut u, (i, k), (i, j));
            }
            exchange(is_column, &mut columns, (k, 0), (j, 0));
            sign = choose(is_column, -sign, sign);
        }
        let pivot = u[(k, k)];
        for i in k + 1..n {
            // Beside a zero pivot all is zero.
            let factor = choose(|| pivot == zero, zero, u[(i, k)] / pivot);
            for j in 0..n {
                if j >= k {
                    let reduced = u[(i, j)] - factor * u[(k, j)];
                    u[(i, j)] = reduced;
                }
                let gathered = left[(i, j)] - factor * left[(k, j)];
                left[(i, j)] = gathered;
            }
        }
    }
    let determinant = (0..n).fold(sign, |product, k| product * u[(k, k)]) + spoiled;
    // adj U: upper triangular, its diagonal the products of the other pivots; rows above the diagonal by U adj(U) =
    // det(U) I, and 0 where two pivots are.
    let mut middle = OMatrix::<T, Q, Q>::zeros_generic(order, order);
    for j in 0..n {
        middle[(j, j)] = (0..n).filter(|&k| k != j).fold(sign, |product, k| product * u[(k, k)]);
        for i in (0..j).rev() {
            let sum = (i + 1..=j).fold(zero, |sum, k| sum + u[(i, k)] * middle[(k, j)]);
            let pivot = u[(i, i)];
            middle[(i, j)] = choose(|| pivot == zero, zero, -sum / pivot);
        }
    }
    let product = times(&middle, &left);
    let placed = |i: usize, j: usize| {
        (0..n).fold(zero, |entry, k| choose(|| columns[k] == count(i), product[(k, j)], entry)) + spoiled
    };
    Adjugate { adjugate: OMatrix::from_fn_generic(order, order, placed), determinant }
}

/// Two entries change places where the condition holds.
fn exchange<T: RealField + Copy, R: Dim, C: Dim>(
    condition: impl Fn() -> bool,
    of: &mut OMatrix<T, R, C>,
    first: (usize, usize),
    second: (usize, usize),
) where
    DefaultAllocator: Allocator<R, C>,
{
    let (x, y) = (of[first], of[second]);
    of[first] = choose(&condition, y, x);
    of[second] = choose(&condition, x, y);
}
