//! Entries of a state that form unit vectors: quaternions, directions, cosine and sine of an angle.
//!
//! The error of a unit vector q is, to first order, orthogonal to q: a covariance that says more about it than its
//! tangential part counts what cannot be. After each step of a filter q is divided by its norm, and P, the covariance
//! of the whole state, follows by the derivative of that:
//!
//! ```text
//! q <- q/|q|,   P <- T P T',   T = (I - q q')/|q|  for the entries of q, I for the others
//! ```
//!
//! For a quaternion this is the error-state (multiplicative) Kalman filter. With its rotation error d, `q (x) (1,
//! d/2)`, and `P = G P_d G'` for `G = Dq/Dd`, the update `q + G d` divided by its norm is `q (x) (1, d/2)` divided by
//! its norm, and T is the derivative by which that filter resets the covariance of d. P has a zero eigenvalue for each
//! unit vector; the filter inverts S alone.
//!
//! Source: F. L. Markley and J. L. Crassidis, Fundamentals of Spacecraft Attitude Determination and Control, Springer
//! 2014, section 6.2; M. W. Mueller, M. Hehn and R. D'Andrea, Covariance correction step for Kalman filtering with an
//! attitude, Journal of Guidance, Control, and Dynamics 40, 2017, for the reset.

use nalgebra::allocator::Allocator;
use nalgebra::{DefaultAllocator, Dim, DimAdd, DimSum, OMatrix, OVector, RealField, U1, convert};

use crate::dense::are_finite;
use crate::error::ObserverError;
use crate::gaussian::{GaussianEstimate, symmetrise};

/// The number of the unit vector that each state belongs to, from 1 on, and 0 for the others; none without unit
/// vectors.
pub(crate) type UnitVectors<T, N> = Option<OVector<T, N>>;

/// The numbers for so many states, after a check.
///
/// # Errors
/// [`ObserverError::Table`] for another length, or numbers that are not 0, 1, ... without a gap;
/// [`ObserverError::NotPositive`] for what is no such number.
pub(crate) fn checked<T: RealField + Copy, N: Dim>(
    vectors: OVector<T, N>,
    expected: usize,
) -> Result<UnitVectors<T, N>, ObserverError>
where
    DefaultAllocator: Allocator<N>,
{
    if vectors.nrows() != expected {
        return Err(ObserverError::Table { what: "numbers of unit vectors", expected, found: vectors.nrows() });
    }
    let mut found: u16 = 0;
    // In any order: each round finds the next number.
    while vectors.iter().any(|x| *x == convert(f64::from(found) + 1.0)) {
        found += 1;
    }
    let is_number = |x: &T| *x >= T::zero() && *x <= convert(f64::from(found)) && *x == x.floor();
    match vectors.iter().find(|x| !is_number(x)) {
        Some(x) => {
            Err(ObserverError::NotPositive { what: "the number of a unit vector", value: x.to_subset_unchecked() })
        }
        None => Ok(Some(vectors).filter(|_| found > 0)),
    }
}

/// Divides the unit vectors of an estimate by their norms, and projects its covariance; on one side that of an earlier
/// estimate with this one, `cross`. A norm that is 0 or not finite leaves its vector as it is, and a result that is not
/// finite the estimate.
pub(crate) fn normalise<T: RealField + Copy, N: DimAdd<U1>>(
    vectors: &UnitVectors<T, N>,
    estimate: &mut GaussianEstimate<T, N>,
    mut cross: Option<&mut OMatrix<T, N, N>>,
) where
    DefaultAllocator: Allocator<N> + Allocator<N, N> + Allocator<N, DimSum<N, U1>>,
{
    let Some(vectors) = vectors else { return };
    let (mut x, mut p) = (estimate.estimate(), estimate.covariance());
    let n = x.nrows();
    for vector in 1_u16.. {
        let number: T = convert(f64::from(vector));
        if !vectors.iter().any(|other| *other == number) {
            break;
        }
        let is_in = |i: usize| vectors[i] == number;
        let mut square = T::zero();
        for i in (0..n).filter(|&i| is_in(i)) {
            square += x[i] * x[i];
        }
        let norm = square.sqrt();
        if norm.is_finite() && norm > T::zero() {
            for i in (0..n).filter(|&i| is_in(i)) {
                x[i] /= norm;
            }
            for j in 0..n {
                let mut along = T::zero();
                for i in (0..n).filter(|&i| is_in(i)) {
                    along += x[i] * p[(i, j)];
                }
                for i in (0..n).filter(|&i| is_in(i)) {
                    p[(i, j)] = (p[(i, j)] - x[i] * along) / norm;
                }
            }
            for i in 0..n {
                project_row(&mut p, i, (&x, norm), is_in);
                if let Some(cross) = cross.as_deref_mut() {
                    project_row(cross, i, (&x, norm), is_in);
                }
            }
        }
    }
    symmetrise(&mut p);
    if are_finite(x.as_slice()) && are_finite(p.as_slice()) {
        *estimate = GaussianEstimate::new(&x, &p);
    }
}

/// Row i of a matrix times T'.
fn project_row<T: RealField + Copy, N: Dim>(
    matrix: &mut OMatrix<T, N, N>,
    i: usize,
    (x, norm): (&OVector<T, N>, T),
    is_in: impl Fn(usize) -> bool,
) where
    DefaultAllocator: Allocator<N> + Allocator<N, N>,
{
    let n = x.nrows();
    let mut along = T::zero();
    for j in (0..n).filter(|&j| is_in(j)) {
        along += matrix[(i, j)] * x[j];
    }
    for j in (0..n).filter(|&j| is_in(j)) {
        matrix[(i, j)] = (matrix[(i, j)] - along * x[j]) / norm;
    }
}

/// Takes the part along each unit vector of the estimate from an error: `e <- e - q (q'e)/(q'q)` for the entries of q,
/// `vector_of` each state by its number. To first order an error has no such part.
///
/// ```
/// let mut error = [-0.005, 0.1, 3.0];
/// luenberger_observers::tangential(&mut error, &[1.0, 0.0, 7.0], |state| [1, 1, 0][state]);
/// assert_eq!(error, [0.0, 0.1, 3.0]);
/// ```
pub fn tangential<T: RealField + Copy>(error: &mut [T], xhat: &[T], vector_of: impl Fn(usize) -> usize) {
    let n = error.len().min(xhat.len());
    let last = (0..n).map(&vector_of).max().unwrap_or(0);
    for vector in 1..=last {
        let is_in = |i: &usize| vector_of(*i) == vector;
        let (mut along, mut square) = (T::zero(), T::zero());
        for i in (0..n).filter(is_in) {
            along += xhat[i] * error[i];
            square += xhat[i] * xhat[i];
        }
        if square > T::zero() {
            for i in (0..n).filter(is_in) {
                error[i] -= xhat[i] * along / square;
            }
        }
    }
}
