//! Decoupling and convergence of the unknown-input observer, linear or cubic.
//!
//! Plant `x' = A x + B u + E d`, `y = C x`, d arbitrary. If C E has full column rank, `H = E ((CE)'CE)^-1 (CE)'` has
//! `H C E = E`, so that `T = I - HC` has `T E = 0`. The observer
//! ```text
//! z' = T A xhat + T B u + L r - (r'theta r) N r,    r = y - C xhat,    xhat = z + H y
//! ```
//! has `e = x - xhat = T x - z`, and `e' = T(Ax + Bu + Ed) - z' = (TA - LC) e + (r'theta r) N r`, `r = C e`: the error
//! equation of the observer of (TA, C), for every d. H and T are rational functions of C and E; their entries are
//! enclosed, H as in `left_inverse.rs`, and `T E = 0` is an identity. For the stored L and N convergence is proved with
//! P, or with a cubic term with the P~ of [`deployed_cubic`](super::deployed_cubic), for which `P~ N = -C'S~` exactly,
//! `S~ = -X C N`:
//! ```text
//! P~ > 0,    (TA - LC)'P~ + P~(TA - LC) + 2 rate P~ < 0,    theta >= 0,    S~ + S~' >= 0.
//! ```

use super::deployed_cubic::{Dissipated, structured_for};
use super::left_inverse::{Product, times_left_inverse};
use super::{Expression, embed, embed_symmetric};
use crate::definite::{self, Direction, Sense};
use crate::error::ProofError;
use crate::interval::Interval;
use crate::matrix::Matrix;
use crate::ring::Ring;
use crate::verdict::{UndecidedReason, Verdict};

/// A plant with an unknown input and the gains of its observer.
#[derive(Debug, Clone, Copy)]
pub struct UnknownInput<'a> {
    /// A, n x n.
    pub a: &'a Matrix<f64>,
    /// C, p x n.
    pub c: &'a Matrix<f64>,
    /// E, n x q.
    pub e: &'a Matrix<f64>,
    /// L, n x p, as stored.
    pub l: &'a Matrix<f64>,
    /// N (n x p, as stored), theta and X (p x p, symmetric) of a cubic term.
    pub cubic: Option<(&'a Matrix<f64>, &'a Matrix<f64>, &'a Matrix<f64>)>,
}

/// Verdicts on an unknown-input observer.
#[derive(Debug, Clone, PartialEq)]
pub struct Decoupled {
    /// `(CE)'CE > 0`: C E has full column rank.
    pub rank: Verdict<Direction>,
    /// `P~ > 0`.
    pub positive: Verdict<Direction>,
    /// `(TA - LC)'P~ + P~(TA - LC) + 2 rate P~ < 0`.
    pub decrease: Verdict<Direction>,
    /// With a cubic term: `theta >= 0` and `S~ + S~' >= 0`.
    pub cubic: Option<[Verdict<Direction>; 2]>,
}

/// Convergence of the unknown-input observer at the given rate, for L, N and theta exactly as stored and the exact T.
///
/// ```
/// use luenberger_proof::{Matrix, statement::{UnknownInput, unknown_input}};
/// # fn main() -> Result<(), luenberger_proof::ProofError> {
/// // x1' = x2 + d, x2' = -x2, y = x1: TA = [0 0; 0 -1].
/// let (a, c) = (Matrix::from_rows([[0.0, 1.0], [0.0, -1.0]]), Matrix::from_rows([[1.0, 0.0]]));
/// let (l, p) = (Matrix::from_rows([[3.0], [0.0]]), Matrix::from_rows([[1.0, 0.0], [0.0, 1.0]]));
/// let with = |e: [f64; 2]| unknown_input(&UnknownInput {
///     a: &a, c: &c, e: &Matrix::from_rows([[e[0]], [e[1]]]), l: &l, cubic: None,
/// }, &p, 0.5);
/// let found = with([1.0, 0.0])?;
/// assert!(found.rank.is_proved() && found.decrease.is_proved());
/// // A disturbance of x2 is not in the first derivative of the output.
/// assert!(with([0.0, 1.0])?.rank.is_refuted());
/// # Ok(())
/// # }
/// ```
/// # Errors
/// [`ProofError`] for inconsistent shapes, entries that are not finite, or matrices that are not symmetric.
pub fn unknown_input(plant: &UnknownInput<'_>, p: &Matrix<f64>, rate: f64) -> Result<Decoupled, ProofError> {
    let UnknownInput { a, c, e, l, cubic } = *plant;
    let (n, outputs) = (a.rows(), c.rows());
    let a = embed::<Interval>(a, "A", (n, n))?;
    let c_enclosed = embed::<Interval>(c, "C", (outputs, n))?;
    embed::<Interval>(e, "E", (n, e.cols()))?;
    let l = embed::<Interval>(l, "L", (n, outputs))?;
    let p_enclosed = embed_symmetric::<Interval>(p, "P", n)?;
    let rate = super::number::<Interval>(rate, "the rate")?;
    let rank = Rank { c, e }.decide(Sense::PositiveDefinite)?;
    let mut terms = None;
    let mut metric = Some(p_enclosed);
    if let Some((gain, theta, x)) = cubic {
        embed::<Interval>(gain, "N", (n, outputs))?;
        embed_symmetric::<Interval>(theta, "theta", outputs)?;
        embed_symmetric::<Interval>(x, "X", outputs)?;
        metric = structured_for(p, c, x, gain)?;
        terms = Some([
            definite::decide(theta, Sense::PositiveSemidefinite)?,
            Dissipated { x, c, n: gain }.decide(Sense::PositiveSemidefinite)?,
        ]);
    }
    let unproved = || Verdict::Undecided { why: UndecidedReason::NotByThisMatrix { name: "P" }, best: f64::NAN };
    let decoupler = if rank.is_proved() { decoupler(c, e)? } else { None };
    let positive = metric.as_ref().map(|m| definite::decide(m, Sense::PositiveDefinite)).transpose()?;
    let decrease = match (&metric, &decoupler) {
        (Some(metric), Some(t)) => {
            let flow = t.product(&a)?.difference(&l.product(&c_enclosed)?)?;
            let shifted = flow.sum(&Matrix::scalar(n, &rate))?;
            definite::decide(&metric.product(&shifted)?.plus_transpose()?, Sense::NegativeDefinite)?
        }
        _ => unproved(),
    };
    Ok(Decoupled { rank, positive: positive.unwrap_or_else(unproved), decrease, cubic: terms })
}

/// `(CE)'CE`.
struct Rank<'a> {
    c: &'a Matrix<f64>,
    e: &'a Matrix<f64>,
}

impl Expression for Rank<'_> {
    fn evaluate<R: Ring>(&self) -> Result<Matrix<R>, ProofError> {
        let image = Matrix::<R>::embed(self.c, "C")?.product(&Matrix::embed(self.e, "E")?)?;
        image.congruence(&Matrix::scalar(image.rows(), &super::number(1.0, "1")?))
    }
}

/// Enclosure of `T = I - HC`; `None` if full column rank of C E cannot be proved.
fn decoupler(c: &Matrix<f64>, e: &Matrix<f64>) -> Result<Option<Matrix<Interval>>, ProofError> {
    let Some(h) = times_left_inverse(e, &Product(c, e))? else { return Ok(None) };
    let measured = h.product(&Matrix::embed(c, "C")?)?;
    Ok(Some(Matrix::scalar(c.cols(), &Interval::ONE).difference(&measured)?))
}
