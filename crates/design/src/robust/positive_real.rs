//! The fixed-N margin for one output, without a solver: a strict-positive-real condition.
//!
//! For p = 1, `P N = -C's` with `s > 0` and `(F + eps I)'P + P(F + eps I) < 0` have a solution `P > 0` iff
//! `G(s) = -C (s I - F - eps I)^-1 N` is strictly positive real (Kalman-Yakubovich-Popov lemma, strict form: A.
//! Rantzer, Systems & Control Letters 28, 1996). On the imaginary axis `Re G(i w) = q(w^2) / |d(i w)|^2` with d the
//! characteristic polynomial and q a polynomial of degree at most n - 1, so that the condition is: F + eps I Hurwitz, q
//! > 0 on `w^2 >= 0`, and a positive leading coefficient `C (F + eps I) N` of q.

use luenberger_linalg::{RealMatrixView, eigenvalues, spectral_abscissa};
use luenberger_proof::UndecidedReason;
use nalgebra::DMatrix;

use crate::check;
use crate::error::{DesignError, InfeasibilityReason};

/// The supremum of eps for which some `P > 0` proves the observer with gains L and N (p = 1) at `A + eps I`.
///
/// `f = A - L C` is n x n, `c` 1 x n, `n_gain` n x 1. Bisection to the last bits between minus infinity and minus the
/// spectral abscissa of F; feasibility is monotone in eps because P serves every smaller eps too. A floating-point
/// result: what is *proved* comes from [`fixed_gain_margin`](super::fixed_gain_margin). Cost: `O(n^4)` once, `O(n^3)`
/// per step.
///
/// # Errors
/// [`DesignError::SeveralOutputs`] for p > 1; [`DesignError::Infeasible`] when `C N > 0`, which no P allows;
/// [`DesignError::DegenerateGain`] when `C N = 0`; [`DesignError::Undecided`] when rounding hides every shift at which
/// the function is positive real.
pub fn positive_real_margin<'a>(
    f: impl Into<RealMatrixView<'a>>,
    c: impl Into<RealMatrixView<'a>>,
    n_gain: impl Into<RealMatrixView<'a>>,
) -> Result<f64, DesignError> {
    margin(&check::owned(f), &check::owned(c), &check::owned(n_gain))
}

fn margin(f: &DMatrix<f64>, c: &DMatrix<f64>, n_gain: &DMatrix<f64>) -> Result<f64, DesignError> {
    let order = f.nrows();
    check::matrix("A - L C", f, (order, order))?;
    if c.nrows() != 1 {
        return Err(DesignError::SeveralOutputs { what: "the positive-real margin", outputs: c.nrows() });
    }
    check::matrix("C", c, (1, order))?;
    check::matrix("N", n_gain, (order, 1))?;
    let cn = (c * n_gain)[(0, 0)];
    // Its sign without rounding.
    match check::exactly(c)?.product(&check::exactly(n_gain)?)?[(0, 0)].signum() {
        0 => return Err(DesignError::DegenerateGain { real_part: 0.0 }),
        1 => {
            return Err(DesignError::Infeasible { what: "(13') for any P", reason: InfeasibilityReason::SignOfCn(cn) });
        }
        _ => {}
    }
    let mut high = -spectral_abscissa(f)?;
    // G of relative degree one is positive real after a large enough shift; double it until it is.
    let scale = f.norm().max(f64::MIN_POSITIVE);
    let mut low = high - scale;
    let mut found = is_strictly_positive_real(f, c, n_gain, low)?;
    for doubling in 1..64 {
        if found {
            break;
        }
        low = high - scale * f64::powi(2.0, doubling);
        found = is_strictly_positive_real(f, c, n_gain, low)?;
    }
    if !found {
        let why = UndecidedReason::NoProposal {
            status: "no shift makes the transfer function positive real in floating point",
        };
        return Err(DesignError::Undecided {
            what: "strict positive realness",
            why,
            best: f64::NEG_INFINITY,
            seen: None,
        });
    }
    // 200 halvings exhaust the 53 bits of any interval that fits between two doublings.
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        if is_strictly_positive_real(f, c, n_gain, middle)? {
            low = middle;
        } else {
            high = middle;
        }
    }
    Ok(low)
}

/// Whether `-C (s I - F - eps I)^-1 N` is strictly positive real, up to rounding.
fn is_strictly_positive_real(
    f: &DMatrix<f64>,
    c: &DMatrix<f64>,
    n_gain: &DMatrix<f64>,
    eps: f64,
) -> Result<bool, DesignError> {
    let order = f.nrows();
    let shifted = f + DMatrix::identity(order, order) * eps;
    if spectral_abscissa(&shifted)? >= 0.0 {
        return Ok(false);
    }
    let (numerator, denominator) = transfer_function(&shifted, c, n_gain);
    let q = real_part(&numerator, &denominator);
    if q.last().is_none_or(|&leading| leading <= 0.0) {
        return Ok(false);
    }
    // The minimum of q over x >= 0 is at 0 or at a root of q'; extra points do no harm.
    let derivative: Vec<f64> = q.iter().enumerate().skip(1).map(|(k, a)| k as f64 * a).collect();
    let mut points = vec![0.0];
    points.extend(roots(&derivative)?.into_iter().filter(|&x| x > 0.0));
    Ok(points.into_iter().all(|x| q.iter().rev().fold(0.0, |sum, a| sum * x + a) > 0.0))
}

/// Numerator and denominator, lowest power first, of `-C (s I - A)^-1 B` by the Faddeev-LeVerrier recursion.
fn transfer_function(a: &DMatrix<f64>, c: &DMatrix<f64>, b: &DMatrix<f64>) -> (Vec<f64>, Vec<f64>) {
    let n = a.nrows();
    let mut denominator = vec![0.0; n + 1];
    let mut numerator = vec![0.0; n];
    denominator[n] = 1.0;
    let mut adjugate = DMatrix::identity(n, n);
    for k in 1..=n {
        numerator[n - k] = -(c * &adjugate * b)[(0, 0)];
        let product = a * &adjugate;
        let coefficient = -product.trace() / k as f64;
        denominator[n - k] = coefficient;
        adjugate = product + DMatrix::identity(n, n) * coefficient;
    }
    (numerator, denominator)
}

/// Coefficients of `Re(num(i w) conj(den(i w)))` as a polynomial in `w^2`, lowest power first.
fn real_part(numerator: &[f64], denominator: &[f64]) -> Vec<f64> {
    // num(i w) conj(den(i w)) = sum n_j d_k i^j (-i)^k w^(j+k); only even j + k is real, with sign (-1)^((j - k)/2).
    let n = denominator.len() - 1;
    let mut q = vec![0.0; n];
    for (j, a) in numerator.iter().enumerate() {
        for (k, d) in denominator.iter().enumerate() {
            let power = j + k;
            if power % 2 == 0 && power < 2 * n {
                let sign = if j.abs_diff(k) % 4 == 0 { 1.0 } else { -1.0 };
                q[power / 2] += sign * a * d;
            }
        }
    }
    q
}

/// Real parts of the roots of a polynomial, lowest power first, by its companion matrix.
fn roots(polynomial: &[f64]) -> Result<Vec<f64>, DesignError> {
    let Some(degree) = polynomial.iter().rposition(|&a| a != 0.0) else { return Ok(vec![]) };
    if degree == 0 {
        return Ok(vec![]);
    }
    let companion = DMatrix::from_fn(degree, degree, |i, j| {
        let subdiagonal = if i == j + 1 { 1.0 } else { 0.0 };
        if j == degree - 1 { subdiagonal - polynomial[i] / polynomial[degree] } else { subdiagonal }
    });
    Ok(eigenvalues(&companion)?.into_iter().map(|root| root.re).collect())
}
