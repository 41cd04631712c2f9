//! Convergence of the reduced-order observer.
//!
//! Plant `x' = A x + B u`, `y = C x`, and a q x n matrix T for which `S = [C; T]` has full column rank. With
//! `S'S = C'C + T'T`, the matrices `N = (S'S)^-1 C'` and `M = (S'S)^-1 T'` satisfy `N C + M T = I`. For the observer
//! ```text
//! w' = F w + G y + TB u,    xhat = M w + N y,    F = TAM,    G = TAN
//! ```
//! the error `v = w - Tx` obeys `v' = F w + TAN Cx + TBu - TAx - TBu = F w - TAM Tx = F v`, since `TAN C = TA - TAM T`,
//! and `xhat - x = M w + N C x - x = M v`. This holds exactly for the real matrices M, N, F and G, which are rational
//! functions of A, C and T. F is enclosed, and `F'P + PF + 2 rate P < 0` with `P > 0` is decided.
//!
//! `[N M]` is the left inverse of S, so `[G F] = TA (S'S)^-1 S'` is enclosed as in `left_inverse.rs`.

use super::left_inverse::{Product, times_left_inverse};
use super::{Expression, embed, embed_symmetric, number};
use crate::definite::{self, Direction, Sense};
use crate::error::ProofError;
use crate::interval::Interval;
use crate::matrix::Matrix;
use crate::ring::Ring;
use crate::verdict::{UndecidedReason, Verdict};

/// Verdicts on a reduced-order observer.
#[derive(Debug, Clone, PartialEq)]
pub struct ReducedOrder {
    /// `C'C + T'T > 0`.
    pub rank: Verdict<Direction>,
    /// `P > 0`.
    pub positive: Verdict<Direction>,
    /// `F'P + PF + 2 rate P < 0`.
    pub decrease: Verdict<Direction>,
}

/// Convergence of the reduced-order observer with the stored T at the given rate; P is q x q.
///
/// ```
/// use luenberger_proof::{Matrix, statement::reduced_order};
/// # fn main() -> Result<(), luenberger_proof::ProofError> {
/// // The double integrator, T = [-4 1]: F = -4.
/// let (a, c) = (Matrix::from_rows([[0.0, 1.0], [0.0, 0.0]]), Matrix::from_rows([[1.0, 0.0]]));
/// let (t, p) = (Matrix::from_rows([[-4.0, 1.0]]), Matrix::from_rows([[1.0]]));
/// let found = reduced_order((&a, &c), &t, &p, 3.9)?;
/// assert!(found.rank.is_proved() && found.decrease.is_proved());
/// assert!(reduced_order((&a, &c), &t, &p, 4.1)?.decrease.is_refuted());
/// # Ok(())
/// # }
/// ```
/// # Errors
/// [`ProofError`] for inconsistent shapes, entries that are not finite, or a P that is not symmetric.
pub fn reduced_order(
    (a, c): (&Matrix<f64>, &Matrix<f64>),
    t: &Matrix<f64>,
    p: &Matrix<f64>,
    rate: f64,
) -> Result<ReducedOrder, ProofError> {
    let (n, outputs, order) = (a.rows(), c.rows(), t.rows());
    embed::<Interval>(a, "A", (n, n))?;
    embed::<Interval>(c, "C", (outputs, n))?;
    embed::<Interval>(t, "T", (order, n))?;
    let p_enclosed = embed_symmetric::<Interval>(p, "P", order)?;
    let rate = number::<Interval>(rate, "the rate")?;
    let rank = Rank { c, t }.decide(Sense::PositiveDefinite)?;
    let positive = definite::decide(p, Sense::PositiveDefinite)?;
    let decrease = match if rank.is_proved() { flow(a, c, t)? } else { None } {
        Some(flow) => {
            let shifted = flow.sum(&Matrix::scalar(order, &rate))?;
            definite::decide(&p_enclosed.product(&shifted)?.plus_transpose()?, Sense::NegativeDefinite)?
        }
        None => Verdict::Undecided { why: UndecidedReason::NotByThisMatrix { name: "P" }, best: f64::NAN },
    };
    Ok(ReducedOrder { rank, positive, decrease })
}

/// Enclosure of F, if S has full column rank; `None` if the rank cannot be proved.
fn flow(a: &Matrix<f64>, c: &Matrix<f64>, t: &Matrix<f64>) -> Result<Option<Matrix<Interval>>, ProofError> {
    let solution = times_left_inverse(&Product(t, a), &Stacked { c, t })?;
    let (outputs, order) = (c.rows(), t.rows());
    Ok(solution.map(|x| Matrix::from_fn(order, order, |i, j| x[(i, outputs + j)])))
}

/// `S = [C; T]`.
struct Stacked<'a> {
    c: &'a Matrix<f64>,
    t: &'a Matrix<f64>,
}

impl Expression for Stacked<'_> {
    fn evaluate<R: Ring>(&self) -> Result<Matrix<R>, ProofError> {
        let (c, t) = (Matrix::<R>::embed(self.c, "C")?, Matrix::<R>::embed(self.t, "T")?);
        Ok(Matrix::from_fn(c.rows() + t.rows(), c.cols(), |i, j| {
            if i < c.rows() { c[(i, j)].clone() } else { t[(i - c.rows(), j)].clone() }
        }))
    }
}

/// `C'C + T'T`.
struct Rank<'a> {
    c: &'a Matrix<f64>,
    t: &'a Matrix<f64>,
}

impl Expression for Rank<'_> {
    fn evaluate<R: Ring>(&self) -> Result<Matrix<R>, ProofError> {
        let square = |m: &Matrix<f64>, what| {
            let m = Matrix::<R>::embed(m, what)?;
            m.congruence(&Matrix::scalar(m.rows(), &super::number(1.0, "1")?))
        };
        square(self.c, "C")?.sum(&square(self.t, "T")?)
    }
}
