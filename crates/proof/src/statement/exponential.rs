//! Enclosure of the exponential of an interval matrix.
//!
//! Scaling and squaring: for `X = M/2^k`, `|X| <= 1/2` in the largest row sum, the Taylor polynomial of degree 20 is
//! evaluated in intervals by Horner's scheme, the remainder, at most `|X|^21/21! 22/(22 - |X|)`, is added to every
//! entry, and the result is squared k times.

use crate::error::ProofError;
use crate::interval::Interval;
use crate::matrix::Matrix;
use crate::ring::Ring;

/// Degree of the Taylor polynomial.
const DEGREE: u32 = 20;

/// The remainder for `|X| <= 1/2`: `2^-21/21! 44/43 < 1e-26`.
const REMAINDER: f64 = 1e-26;

/// Beyond this row sum every entry may overflow.
const LARGEST: f64 = 1024.0;

/// A matrix that contains `exp(M)` for every matrix M within the bounds; `None` if M is too large.
/// # Errors
/// [`ProofError::DimensionMismatch`] unless M is square.
pub fn exponential(m: &Matrix<Interval>) -> Result<Option<Matrix<Interval>>, ProofError> {
    let n = m.rows();
    m.expect_shape("the exponent", (n, n))?;
    let norm = (0..n)
        .fold(0.0_f64, |norm, i| norm.max(m.row(i).iter().fold(0.0, |sum: f64, x| (sum + x.magnitude()).next_up())));
    if norm.is_nan() || norm > LARGEST {
        return Ok(None);
    }
    let (mut squarings, mut scale) = (0, 1.0);
    while norm * scale > 0.5 {
        (squarings, scale) = (squarings + 1, scale * 0.5);
    }
    let one = Interval::point(1.0);
    let (x, identity) = (m.scaled(&Interval::point(scale)), Matrix::scalar(n, &one));
    let mut sum = identity.clone();
    for degree in (1..=DEGREE).rev() {
        let inverse = 1.0 / f64::from(degree);
        let Some(inverse) = Interval::new(inverse.next_down(), inverse.next_up()) else { return Ok(None) };
        sum = identity.sum(&x.product(&sum)?.scaled(&inverse))?;
    }
    let Some(remainder) = Interval::new(-REMAINDER, REMAINDER) else { return Ok(None) };
    let mut power = sum.map(|entry| entry.add(&remainder));
    for _ in 0..squarings {
        power = power.product(&power)?;
    }
    Ok(power.as_slice().iter().all(Interval::is_bounded).then_some(power))
}
