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
    if a.iter().any(|entry| !entry.is_finite()) {
        let determinant = nalgebra::convert::<f64, T>(f64::NAN);
        return Adjugate { adjugate: OMatrix::repeat_generic(order, order, determinant), determinant };
    }
    // Elimination of U, with L^-1 P' gathered in `left` and the order of the columns in `columns`.
    let mut u = a.clone();
    let mut left = OMatrix::<T, Q, Q>::identity_generic(order, order);
    let mut columns = OVector::<usize, Q>::from_fn_generic(order, U1, |i, _| i);
    let mut sign = one;
    for k in 0..n {
        let (mut row, mut column) = (k, k);
        for j in k..n {
            for i in k..n {
                if u[(i, j)].abs() > u[(row, column)].abs() {
                    (row, column) = (i, j);
                }
            }
        }
        if row != k {
            u.swap_rows(k, row);
            left.swap_rows(k, row);
            sign = -sign;
        }
        if column != k {
            u.swap_columns(k, column);
            columns.swap_rows(k, column);
            sign = -sign;
        }
        let pivot = u[(k, k)];
        if pivot == zero {
            if k + 1 < n {
                // Two zero pivots: rank n - 2 or less.
                return Adjugate { adjugate: OMatrix::zeros_generic(order, order), determinant: zero };
            }
            break;
        }
        for i in k + 1..n {
            let factor = u[(i, k)] / pivot;
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
    let determinant = (0..n).fold(sign, |product, k| product * u[(k, k)]);
    // adj U: upper triangular, its diagonal the products of the other pivots; rows above the diagonal by U adj(U) =
    // det(U) I.
    let mut middle = OMatrix::<T, Q, Q>::zeros_generic(order, order);
    for j in 0..n {
        middle[(j, j)] = (0..n).filter(|&k| k != j).fold(sign, |product, k| product * u[(k, k)]);
        for i in (0..j).rev() {
            let sum = (i + 1..=j).fold(zero, |sum, k| sum + u[(i, k)] * middle[(k, j)]);
            middle[(i, j)] = -sum / u[(i, i)];
        }
    }
    let product = middle * left;
    let mut adjugate = OMatrix::zeros_generic(order, order);
    for (k, &column) in columns.iter().enumerate() {
        adjugate.set_row(column, &product.row(k));
    }
    Adjugate { adjugate, determinant }
}
