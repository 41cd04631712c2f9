//! The pseudo-inverse of a small matrix, with its rank.
//!
//! `A+` is the matrix with `A A+ A = A`, `A+ A A+ = A+` and both products symmetric. Directions in which A has a
//! singular value below the rounding of the largest one are left out rather than divided by, so that the answer is
//! finite whatever A is, and the singular values say how near that is.
//!
//! Method: one-sided Jacobi on the rows, 4 + r sweeps, at most 40: rotations make the rows of `W = V'A` orthogonal,
//! their lengths are the singular values, to high *relative* accuracy, and `A+ = W' diag(1/sigma^2) V'`. No allocation.
//! Source: M. R. Hestenes, Journal of SIAM 6, 1958; J. Demmel and K. Veselic, SIAM Journal on Matrix Analysis and
//! Applications 13, 1992, for the accuracy.

use nalgebra::allocator::Allocator;
use nalgebra::{ComplexField, DefaultAllocator, Dim, OMatrix, OVector, RealField, U1, convert, try_convert};

use crate::dense::{choose, larger};

/// A matrix of r rows gets r more sweeps than this, at most [`MOST_SWEEPS`]: more than random and graded matrices with
/// up to 40 rows need (2 with two rows, 5 with four, 14 with sixteen, 19 with forty).
const SWEEPS_OF_NONE: usize = 4;

/// See [`SWEEPS_OF_NONE`].
const MOST_SWEEPS: usize = 40;

/// The pseudo-inverse `A+` with the singular values.
#[derive(Clone, Debug, PartialEq)]
pub struct PseudoInverse<T: RealField + Copy, R: Dim, C: Dim>
where
    DefaultAllocator: Allocator<C, R> + Allocator<R>,
{
    /// `A+`, c x r for A r x c.
    pub inverse: OMatrix<T, C, R>,
    /// The r singular values in no order (those of the rows beyond c are 0).
    pub singular_values: OVector<T, R>,
    /// Singular values up to this are left out.
    pub negligible: T,
}

impl<T: RealField + Copy, R: Dim, C: Dim> PseudoInverse<T, R, C>
where
    DefaultAllocator: Allocator<C, R> + Allocator<R>,
{
    /// Rank: the number of singular values above the tolerance.
    pub fn rank(&self) -> usize {
        self.singular_values.iter().filter(|s| **s > self.negligible).count()
    }

    /// The smallest of the singular values.
    pub fn smallest(&self) -> T {
        self.singular_values.iter().fold(self.largest(), |smallest: T, &s| smallest.min(s))
    }

    /// The largest singular value.
    pub fn largest(&self) -> T {
        self.singular_values.iter().fold(T::zero(), |largest: T, &s| largest.max(s))
    }
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
/// assert_eq!(answer.rank(), 2);
/// assert!((a * answer.inverse - Matrix2::identity()).amax() <= 4.0 * f64::EPSILON);
/// // Of rank 1: no division by what is 0.
/// let answer = pseudo_inverse(&Matrix2::new(1.0, 1.0, 1.0, 1.0));
/// assert!(answer.rank() == 1 && (answer.inverse - Matrix2::repeat(0.25)).amax() <= f64::EPSILON);
/// ```
pub fn pseudo_inverse<T: RealField + Copy, R: Dim, C: Dim>(a: &OMatrix<T, R, C>) -> PseudoInverse<T, R, C>
where
    DefaultAllocator: Allocator<R, C> + Allocator<C, R> + Allocator<R, R> + Allocator<R>,
{
    let (rows, columns) = a.shape_generic();
    let (zero, one) = (T::zero(), T::one());
    let (r, c) = a.shape();
    let size = a.iter().fold(zero, |largest: T, entry| larger(entry.abs(), largest));
    let is_usable = || a.iter().all(ComplexField::is_finite) && (one / size).is_finite();
    let usable = choose(is_usable, one, zero);
    let scale = choose(|| usable == one, size, one);
    let mut w = a.map(|entry| choose(|| usable == one, entry / scale, zero));
    // Row i of `v` is what the row i of W is made of.
    let mut v = OMatrix::<T, R, R>::identity_generic(rows, rows);
    let epsilon = T::default_epsilon();
    for _ in 0..(SWEEPS_OF_NONE + r).min(MOST_SWEEPS) {
        let mut rotations = zero;
        for p in 0..r {
            for q in p + 1..r {
                let product = |i: usize, j: usize| (0..c).fold(zero, |sum, k| sum + w[(i, k)] * w[(j, k)]);
                let (alpha, beta, gamma) = (product(p, p), product(q, q), product(p, q));
                let negligible = epsilon * (alpha * beta).sqrt();
                let rotates = || gamma.abs() > negligible;
                rotations = choose(rotates, one, rotations);
                let zeta = (beta - alpha) / (gamma + gamma);
                let sign = choose(|| zeta < zero, -one, one);
                let far = || zeta.abs() > one / epsilon;
                let near = sign / (zeta.abs() + (one + zeta * zeta).sqrt());
                let tangent = choose(far, one / (zeta + zeta), near);
                let cosine = one / (one + tangent * tangent).sqrt();
                let sine = cosine * tangent;
                rotate(rotates, &mut w, (p, q), (cosine, sine));
                rotate(rotates, &mut v, (p, q), (cosine, sine));
            }
        }
        // Of a number only: a body that is recorded takes all sweeps, the last of which change nothing.
        if try_convert::<T, f64>(rotations) == Some(0.0) {
            break;
        }
    }
    let sigma = OVector::<T, R>::from_fn_generic(rows, U1, |i, _| w.row(i).norm());
    let largest = sigma.iter().fold(zero, |largest: T, &s| larger(s, largest));
    let negligible = largest * epsilon * convert::<f64, T>(r.max(c) as f64);
    let mut inverse = OMatrix::<T, C, R>::zeros_generic(columns, rows);
    for (i, &s) in sigma.iter().enumerate() {
        for j in 0..r {
            for k in 0..c {
                let (sum, more) = (inverse[(k, j)], w[(i, k)] / s * (v[(i, j)] / s));
                inverse[(k, j)] = choose(|| s > negligible, sum + more, sum);
            }
        }
    }
    let singular_values = sigma * scale;
    PseudoInverse { inverse: inverse / scale, singular_values, negligible: negligible * scale }
}

/// Rows p and q become `cosine p - sine q` and `sine p + cosine q` where the condition holds.
fn rotate<T: RealField + Copy, R: Dim, C: Dim>(
    condition: impl Fn() -> bool,
    m: &mut OMatrix<T, R, C>,
    (p, q): (usize, usize),
    (cosine, sine): (T, T),
) where
    DefaultAllocator: Allocator<R, C>,
{
    for k in 0..m.ncols() {
        let (a, b) = (m[(p, k)], m[(q, k)]);
        m[(p, k)] = choose(&condition, cosine * a - sine * b, a);
        m[(q, k)] = choose(&condition, sine * a + cosine * b, b);
    }
}
