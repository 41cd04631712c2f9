//! The cubic term of the cubic observer: condition (13') of Share Pasand, `P N C + C'N'P <= 0`.
//!
//! If rank C < n the inequality is never strict, and it is equivalent to a structural condition: it holds if and only
//! if `P N = -C'S` with `S + S' >= 0` (C of full row rank). A gain `N` rounded to binary64 violates `P N = -C'S` in the
//! last digit; then the inequality for the given data is false, by about 1e-17. There are three statements for this
//! case:
//! - [`cubic_dissipation`] decides the inequality exactly for `N` as given;
//! - [`cubic_dissipation_structured`] decides it for the real gain `N = -P^-1 C'S`, which is defined by `S`;
//! - [`deployed_cubic`](super::deployed_cubic) proves convergence with `N` as given, in other ways.

use super::embed;
use crate::definite::Direction;
use crate::error::ProofError;
use crate::interval::Interval;
use crate::label::Names;
use crate::matrix::Matrix;
use crate::verdict::Verdict;

/// `P N C + C'N'P <= 0` (13'), for the numbers exactly as given.
///
/// `P` is n x n symmetric, `N` n x p, `C` p x n. If rank C < n the inequality is never strict: `Proved` with margin 0
/// if `P N = -C'S` holds exactly (for integers, say), otherwise `Refuted` with a value of the size of the rounding
/// error of `N`. This refutation is correct but seldom useful: see the head of this module.
/// # Errors
/// [`ProofError`] for inconsistent shapes, entries that are not finite, or a `P` that is not symmetric.
pub fn cubic_dissipation(p: &Matrix<f64>, n: &Matrix<f64>, c: &Matrix<f64>) -> Result<Verdict<Direction>, ProofError> {
    Names::new().symmetric("P", p).matrix("C", c).matrix("N", n).decide("P N C + C'N'P <= 0")
}

/// `P N C + C'N'P <= 0` (13') for the exact real matrix `N = -P^-1 C'S`; a stored gain is a rounding of it.
///
/// `P` is n x n symmetric, `S` p x p, `C` p x n. Then `P N C + C'N'P = -C'(S + S')C` for every `P > 0`, so `P > 0` and
/// `S + S' >= 0` prove the inequality. The margin is that of `S + S' >= 0`, in the units of `S`: the cubic term
/// contributes at most `-margin (y'theta y) |y|^2` to `V'`.
///
/// Refuted if `P > 0` is refuted (the gain is then not defined), or if `C'(S + S')C >= 0` is, with the direction as
/// witness. If `S + S' >= 0` is false, `C'(S + S')C >= 0` decides; it may still hold if C lacks rank, and the margin is
/// then 0.
/// # Errors
/// [`ProofError`] for inconsistent shapes, entries that are not finite, or a `P` that is not symmetric.
pub fn cubic_dissipation_structured(
    p: &Matrix<f64>,
    s: &Matrix<f64>,
    c: &Matrix<f64>,
) -> Result<Verdict<Direction>, ProofError> {
    let names = Names::new().symmetric("P", p).matrix("C", c).matrix("S", s);
    embed::<Interval>(c, "C", (c.rows(), p.rows()))?;
    embed::<Interval>(s, "S", (c.rows(), c.rows()))?;
    let defined = names.decide("P > 0")?;
    if !defined.is_proved() {
        return Ok(defined);
    }
    let sufficient = accretive(s)?;
    if sufficient.is_proved() {
        return Ok(sufficient);
    }
    Ok(match names.decide("He(C'SC) >= 0")? {
        Verdict::Proved { .. } => Verdict::Proved { margin: 0.0 },
        other => other,
    })
}

/// `S + S' >= 0`: `w'Sw >= 0` for every `w`. The margin is a lower bound of the smallest eigenvalue of `S + S'`.
/// # Errors
/// [`ProofError`] for an `S` that is not square or has entries that are not finite.
pub fn accretive(s: &Matrix<f64>) -> Result<Verdict<Direction>, ProofError> {
    Names::new().matrix("S", s).decide("S + S' >= 0")
}
