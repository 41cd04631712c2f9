//! Bounds of eigenvalues by a matrix P > 0: Schur stability, spectral abscissa and spectral radius.
//!
//! With the norm `|v|_P^2 = v'Pv`: `A'P + PA <= 2 s P` gives `Re lambda <= s`, and `A'PA <= r^2 P` gives
//! `|Av|_P <= r |v|_P`, hence `|lambda| <= r`. The tightness depends on P: the bounds attain the spectral abscissa and
//! radius for the P of an eigenvector basis, and are less tight for the solution of a Lyapunov equation with Q = I. A
//! lower bound of the largest real part is the mean of all, `trace(A)/n`.

use super::lyapunov::{Stein, largest_eigenvalue_bound, stable_by};
use super::{Expression, embed, embed_symmetric, positive};
use crate::definite::{Direction, Sense, proved_eigenvalue_bound};
use crate::error::ProofError;
use crate::interval::Interval;
use crate::matrix::Matrix;
use crate::ring::Ring;
use crate::verdict::Verdict;

/// Bisection steps for a bound, to 1e-12 of the bracket.
const BISECTIONS: usize = 42;

/// `A` is Schur stable (all eigenvalues inside the unit circle), by the Lyapunov matrix `P`.
///
/// - Proved if `A'PA - P < 0` and `P > 0` are proved. The margin is a lower bound of 1 minus the spectral radius:
///   `1 - sqrt(1 - lambda_min(P - A'PA) / lambda_max(P))`.
/// - Refuted if `A'PA - P < 0` is proved and `P > 0` refuted: the solution of `x+ = A x` that starts at the witness v
///   has `V = v'Pv <= 0`, decreasing, and cannot tend to 0.
/// - Undecided otherwise, since another `P` may prove it.
///
/// ```
/// use luenberger_proof::{Matrix, statement::schur_stable};
/// # fn main() -> Result<(), luenberger_proof::ProofError> {
/// let p = |x: f64| Matrix::from_rows([[x]]);
/// assert!((schur_stable(&p(-0.5), &p(3.0))?.margin().expect("proved") - 0.5).abs() < 1e-12);
/// assert!(schur_stable(&p(1.5), &p(-1.0))?.is_refuted());
/// # Ok(())
/// # }
/// ```
/// # Errors
/// [`ProofError`] for inconsistent shapes, entries that are not finite, or a `P` that is not symmetric.
pub fn schur_stable(a: &Matrix<f64>, p: &Matrix<f64>) -> Result<Verdict<Direction>, ProofError> {
    let n = a.rows();
    let (l, c) = (Matrix::from_fn(n, 0, |_, _| 0.0), Matrix::from_fn(0, n, |_, _| 0.0));
    let decrease = (Stein { a, l: &l, c: &c, p, factor: None }).decide(Sense::NegativeDefinite)?;
    stable_by(decrease, p, |margin| {
        // 1 - sqrt(1 - x) = x / (1 + sqrt(1 - x)), without cancellation. For order 0 both bounds are infinite, and the
        // margin is 1.
        let x = (margin / largest_eigenvalue_bound(p)).next_down().clamp(0.0, 1.0);
        let root = ((1.0 - x).next_up().min(1.0).sqrt().next_up()).min(1.0);
        (x / (1.0 + root).next_up()).next_down().max(0.0)
    })
}

/// Enclosure of the spectral abscissa, the largest real part of an eigenvalue of A: from below `trace(A)/n`, from above
/// the smallest s for which `A'P + PA < 2 s P` is proved (by bisection). `None` if `P > 0` is not proved or no s is
/// found, and for order 0.
///
/// ```
/// use luenberger_proof::{Matrix, statement::spectral_abscissa};
/// # fn main() -> Result<(), luenberger_proof::ProofError> {
/// // Eigenvalues -1 and -3, and the P of the eigenvectors (1, 0) and (-1, 1).
/// let a = Matrix::from_rows([[-1.0, 2.0], [0.0, -3.0]]);
/// let p = Matrix::from_rows([[1.0, 1.0], [1.0, 2.0]]);
/// let abscissa = spectral_abscissa(&a, &p)?.expect("P > 0");
/// assert!(abscissa.contains(-1.0) && abscissa.hi() < -1.0 + 1e-9);
/// # Ok(())
/// # }
/// ```
/// # Errors
/// As [`schur_stable`].
pub fn spectral_abscissa(a: &Matrix<f64>, p: &Matrix<f64>) -> Result<Option<Interval>, ProofError> {
    let n = a.rows();
    let enclosed = embed::<Interval>(a, "A", (n, n))?;
    let metric = embed_symmetric::<Interval>(p, "P", n)?;
    if n == 0 || !positive(p)?.is_proved() {
        return Ok(None);
    }
    let mean = mean_eigenvalue(&enclosed);
    let twice = metric.product(&enclosed)?.plus_transpose()?;
    let holds = |s: f64| {
        let Some(s) = Interval::from_f64(2.0 * s) else { return Ok(false) };
        Ok::<_, ProofError>(proved_eigenvalue_bound(&metric.scaled(&s).difference(&twice)?).is_some())
    };
    let scale = row_sum(a).max(f64::MIN_POSITIVE);
    let upper = smallest(mean.lo(), scale, holds)?;
    Ok(upper.and_then(|upper| Interval::new(mean.lo(), upper.max(mean.lo()))))
}

/// Enclosure of the spectral radius, the largest modulus of an eigenvalue of A: from below `|trace(A)|/n`, from above
/// the smallest r for which `A'PA < r^2 P` is proved (by bisection), the contraction factor of A in the norm of P.
/// `None` if `P > 0` is not proved or no r is found, and for order 0.
///
/// ```
/// use luenberger_proof::{Matrix, statement::spectral_radius};
/// # fn main() -> Result<(), luenberger_proof::ProofError> {
/// // A rotation by 45 degrees, shortened: both eigenvalues have the modulus sqrt(1/2).
/// let a = Matrix::from_rows([[0.5, -0.5], [0.5, 0.5]]);
/// let radius = spectral_radius(&a, &Matrix::from_rows([[1.0, 0.0], [0.0, 1.0]]))?.expect("P > 0");
/// assert!((radius.hi() - 0.5_f64.sqrt()).abs() < 1e-9 && radius.contains(0.5_f64.sqrt()));
/// # Ok(())
/// # }
/// ```
/// # Errors
/// As [`schur_stable`].
pub fn spectral_radius(a: &Matrix<f64>, p: &Matrix<f64>) -> Result<Option<Interval>, ProofError> {
    let n = a.rows();
    let enclosed = embed::<Interval>(a, "A", (n, n))?;
    let metric = embed_symmetric::<Interval>(p, "P", n)?;
    if n == 0 || !positive(p)?.is_proved() {
        return Ok(None);
    }
    let least = mean_eigenvalue(&enclosed).abs().lo();
    let upper = contraction(&metric, &[enclosed], row_sum(a).max(f64::MIN_POSITIVE))?;
    Ok(upper.and_then(|upper| Interval::new(least, upper.max(least))))
}

/// A rho, found by bisection, for which `M'PM < rho^2 P` is proved for every one of the maps; `scale` is about the
/// largest value to be expected.
pub(super) fn contraction(
    p: &Matrix<Interval>,
    maps: &[Matrix<Interval>],
    scale: f64,
) -> Result<Option<f64>, ProofError> {
    let images = maps.iter().map(|map| map.congruence(p)).collect::<Result<Vec<_>, _>>()?;
    let holds = |rho: f64| {
        let Some(rho) = Interval::from_f64(rho) else { return Ok(false) };
        let bound = p.scaled(&rho.mul(&rho));
        for image in &images {
            if proved_eigenvalue_bound(&bound.difference(image)?).is_none() {
                return Ok(false);
            }
        }
        Ok::<_, ProofError>(true)
    };
    smallest(0.0, scale, holds)
}

/// The smallest x above `floor` for which `holds`, up to `2^-42` of the bracket, for a property that is monotone in x;
/// the search starts at `scale`, `4 scale`, ....
fn smallest(
    floor: f64,
    scale: f64,
    holds: impl Fn(f64) -> Result<bool, ProofError>,
) -> Result<Option<f64>, ProofError> {
    let mut above = scale;
    let mut tries = 0;
    while !holds(above)? {
        tries += 1;
        above *= 4.0;
        if tries > 60 || !above.is_finite() {
            return Ok(None);
        }
    }
    let mut below = floor;
    for _ in 0..BISECTIONS {
        let middle = f64::midpoint(below, above);
        if !(below < middle && middle < above) {
            break;
        }
        if holds(middle)? { above = middle } else { below = middle }
    }
    Ok(Some(above))
}

fn mean_eigenvalue(a: &Matrix<Interval>) -> Interval {
    let n = a.rows();
    let trace = (0..n).fold(Interval::zero(), |sum, i| sum.add(&a[(i, i)]));
    Interval::from_f64(n as f64).and_then(|n| trace.quotient(&n)).unwrap_or(Interval::UNBOUNDED)
}

fn row_sum(a: &Matrix<f64>) -> f64 {
    (0..a.rows()).map(|i| a.row(i).iter().map(|x| x.abs()).sum::<f64>()).fold(0.0, f64::max)
}
