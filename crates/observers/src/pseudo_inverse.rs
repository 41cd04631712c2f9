//! The pseudo-inverse of a small matrix, with its rank.
//!
//! `A+` is the matrix with `A A+ A = A`, `A+ A A+ = A+` and both products symmetric. Directions in which A has a
//! singular value below the rounding of the largest one are left out rather than divided by, so that the answer is
//! finite whatever A is, and the singular values say how near that is.
//!
//! Method: one-sided Jacobi on the rows, at most 40 sweeps: rotations make the rows of `W = V'A` orthogonal, their
//! lengths are the singular values, to high *relative* accuracy, and `A+ = W' diag(1/sigma^2) V'`. No allocation.
//! Source: M. R. Hestenes, Journal of SIAM 6, 1958; J. Demmel and K. Veselic, SIAM Journal on Matrix Analysis and
//! Applications 13, 1992, for the accuracy.

use nalgebra::allocator::Allocator;
use nalgebra::{DefaultAllocator, Dim, OMatrix, OVector, RealField, U1, convert};

/// More than twice what matrices of order 100 need.
const SWEEPS: usize = 40;

/// The pseudo-inverse `A+` with rank and extreme singular values.
#[derive(Clone, Debug, PartialEq)]
pub struct PseudoInverse<T: RealField + Copy, R: Dim, C: Dim>
where
    DefaultAllocator: Allocator<C, R>,
{
    /// `A+`, c x r for A r x c.
    pub inverse: OMatrix<T, C, R>,
    /// Rank: the number of singular values above the tolerance.
    pub rank: usize,
    /// The smallest of the r singular values (the rows beyond c count as 0).
    pub smallest: T,
    /// The largest singular value.
    pub largest: T,
}

/// The pseudo-inverse of an r x c matrix. One with an entry that is not finite, or with none above the smallest number
/// that has a reciprocal, has rank 0 and the pseudo-inverse 0.
///
/// Singular values up to `max(r, c) epsilon` times the largest are left out.
///
/// ```
/// use luenberger_observers::pseudo_inverse::pseudo_inverse;
/// use nalgebra::{Matrix2, Matrix2x3};
/// let a = Matrix2x3::new(1.0, 0.0, 2.0, 0.0, 3.0, 0.0);
/// let answer = pseudo_inverse(&a);
/// assert_eq!(answer.rank, 2);
/// assert!((a * answer.inverse - Matrix2::identity()).amax() <= 4.0 * f64::EPSILON);
/// // Of rank 1: no division by what is 0.
/// let answer = pseudo_inverse(&Matrix2::new(1.0, 1.0, 1.0, 1.0));
/// assert!(answer.rank == 1 && (answer.inverse - Matrix2::repeat(0.25)).amax() <= f64::EPSILON);
/// ```
pub fn pseudo_inverse<T: RealField + Copy, R: Dim, C: Dim>(a: &OMatrix<T, R, C>) -> PseudoInverse<T, R, C>
where
    DefaultAllocator: Allocator<R, C> + Allocator<C, R> + Allocator<R, R> + Allocator<R>,
{
    let (rows, columns) = a.shape_generic();
    let (zero, one) = (T::zero(), T::one());
    let (r, c) = a.shape();
    let none =
        |largest| PseudoInverse { inverse: OMatrix::zeros_generic(columns, rows), rank: 0, smallest: zero, largest };
    if a.iter().any(|entry| !entry.is_finite()) {
        return none(one / zero);
    }
    let scale = a.iter().fold(zero, |largest: T, entry| largest.max(entry.abs()));
    if !(one / scale).is_finite() {
        return none(scale);
    }
    let mut w = a / scale;
    // Row i of `v` is what the row i of W is made of.
    let mut v = OMatrix::<T, R, R>::identity_generic(rows, rows);
    let epsilon = T::default_epsilon();
    for _ in 0..SWEEPS {
        let mut rotated = false;
        for p in 0..r {
            for q in p + 1..r {
                let product = |i: usize, j: usize| (0..c).fold(zero, |sum, k| sum + w[(i, k)] * w[(j, k)]);
                let (alpha, beta, gamma) = (product(p, p), product(q, q), product(p, q));
                if gamma.abs() <= epsilon * (alpha * beta).sqrt() || gamma == zero {
                    continue;
                }
                rotated = true;
                let zeta = (beta - alpha) / (gamma + gamma);
                let sign = if zeta < zero { -one } else { one };
                let tangent = if zeta.abs() > one / epsilon {
                    one / (zeta + zeta)
                } else {
                    sign / (zeta.abs() + (one + zeta * zeta).sqrt())
                };
                let cosine = one / (one + tangent * tangent).sqrt();
                let sine = cosine * tangent;
                rotate(&mut w, p, q, cosine, sine);
                rotate(&mut v, p, q, cosine, sine);
            }
        }
        if !rotated {
            break;
        }
    }
    let sigma = OVector::<T, R>::from_fn_generic(rows, U1, |i, _| w.row(i).norm());
    let largest = sigma.iter().fold(zero, |largest: T, &s| largest.max(s));
    let smallest = sigma.iter().fold(largest, |smallest: T, &s| smallest.min(s));
    let negligible = largest * epsilon * convert::<f64, T>(r.max(c) as f64);
    let mut inverse = OMatrix::<T, C, R>::zeros_generic(columns, rows);
    let mut rank = 0;
    for (i, &s) in sigma.iter().enumerate() {
        if s > negligible {
            rank += 1;
            for j in 0..r {
                for k in 0..c {
                    inverse[(k, j)] += w[(i, k)] / s * (v[(i, j)] / s);
                }
            }
        }
    }
    PseudoInverse { inverse: inverse / scale, rank, smallest: smallest * scale, largest: largest * scale }
}

/// Rows p and q become `cosine p - sine q` and `sine p + cosine q`.
fn rotate<T: RealField + Copy, R: Dim, C: Dim>(m: &mut OMatrix<T, R, C>, p: usize, q: usize, cosine: T, sine: T)
where
    DefaultAllocator: Allocator<R, C>,
{
    for k in 0..m.ncols() {
        let (a, b) = (m[(p, k)], m[(q, k)]);
        m[(p, k)] = cosine * a - sine * b;
        m[(q, k)] = sine * a + cosine * b;
    }
}
