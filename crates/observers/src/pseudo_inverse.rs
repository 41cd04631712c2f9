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

#[cfg(all(test, feature = "alloc"))]
mod tests {
    use super::pseudo_inverse;
    use nalgebra::{DMatrix, SMatrix};
    use proptest::prelude::*;

    /// The four conditions of Penrose, each to rounding amplified by the condition number that was kept.
    fn check(a: &DMatrix<f64>, rank: usize) -> Result<(), TestCaseError> {
        let answer = pseudo_inverse(a);
        prop_assert_eq!(answer.rank, rank, "{} {}", answer.smallest, answer.largest);
        let x = &answer.inverse;
        let condition = a.norm() * x.norm();
        let rounding = 64.0 * a.nrows().max(a.ncols()) as f64 * f64::EPSILON * condition;
        let (ax, xa) = (a * x, x * a);
        prop_assert!((&ax * a - a).norm() <= rounding * a.norm());
        prop_assert!((&xa * x - x).norm() <= rounding * x.norm() * condition);
        prop_assert!((&ax - ax.transpose()).norm() <= rounding * condition);
        prop_assert!((&xa - xa.transpose()).norm() <= rounding * condition);
        Ok(())
    }

    proptest! {
        #[test]
        fn the_conditions_of_penrose_hold(
            entries in prop::array::uniform15(-1.0..1.0f64),
            v in prop::array::uniform3(-1.0..1.0f64),
            w in prop::array::uniform5(0.5..1.0f64),
        ) {
            let wide = DMatrix::from_column_slice(3, 5, &entries) + DMatrix::identity(3, 5) * 4.0;
            check(&wide, 3)?;
            check(&wide.transpose(), 3)?;
            // Rank 2 of 3 rows: the last is a combination of the others.
            let mut deficient = wide.clone();
            deficient.set_row(2, &(wide.row(0) * v[0] + wide.row(1) * v[1]));
            check(&deficient, 2)?;
            check(&DMatrix::from_row_slice(1, 5, &w), 1)?;
        }
    }

    #[test]
    fn nothing_is_divided_by_zero() {
        let zero = pseudo_inverse(&SMatrix::<f64, 2, 3>::zeros());
        assert_eq!((zero.rank, zero.inverse), (0, SMatrix::<f64, 3, 2>::zeros()));
        assert_eq!(pseudo_inverse(&SMatrix::<f64, 2, 2>::new(f64::NAN, 0.0, 0.0, 1.0)).rank, 0);
        assert!(
            (pseudo_inverse(&SMatrix::<f64, 1, 1>::new(1e-300)).inverse[0] / 1e300 - 1.0).abs() <= 4.0 * f64::EPSILON
        );
        // 1/5e-324 is infinite.
        assert_eq!(pseudo_inverse(&SMatrix::<f64, 2, 2>::new(5e-324, 0.0, 0.0, 0.0)).rank, 0);
        assert_eq!(pseudo_inverse(&SMatrix::<f64, 0, 2>::zeros()).rank, 0);
    }
}
