//! Enclosure of the exact solution of a Lyapunov or Stein equation: `A'P + PA + Q = 0`, `A'PA - P + Q = 0`, Q
//! symmetric.
//!
//! Let `T(X) = A'X + XA` or `A'XA - X`. A solver gives an approximate solution P~ as a sum of floating-point matrices:
//! the error of a single matrix is about half a unit in the last place of each entry, that of a sum of two can be
//! smaller, and then the enclosure is as narrow as binary64 allows. With the residual `R = T(P~) + Q`, evaluated
//! exactly if A and Q are numbers and with outward rounding if they are intervals, the error `X = P - P~` solves
//! `T(X) = -R`. Two theorems enclose it. Interval matrices A and Q stand for all matrices within; the proof holds for
//! each pair.
//!
//! **By comparison**, from a matrix W that proves stability. Let `D = -T(W) > 0` and `W > 0`. Then T is nonsingular,
//! and
//! ```text
//! -r D <= R <= r D   implies   -r W <= P - P~ <= r W,   hence   |P - P~|_ij <= r sqrt(W_ii W_jj).
//! ```
//! *Proof.* By Lyapunov's (Stein's) theorem all eigenvalues of A lie in the open left half plane (unit disc). So
//! `T(Y) = -Z` has exactly one solution for each Z, `Y = int exp(A't) Z exp(At) dt` (`sum A'^k Z A^k`), which is
//! positive semidefinite if Z is. `T(rW - X) = -(rD - R)` and `T(rW + X) = -(rD + R)` have this form with semidefinite
//! right-hand sides. The entries: `|x_ij| <= sqrt((rW)_ii (rW)_jj)`, because with `B = rW`, `B - X >= 0` and
//! `B + X >= 0` give `2 |u'Xv| <= u'Bu + v'Bv` for all u and v, which may be scaled. *qed.* The first r tried is
//! `|R|_F / lambda_min(D)`, which is always valid; it is halved as long as both inequalities can be proved, so that the
//! final r does not depend on the units of the states. If `W < 0` and `T(W) < 0` in the Lyapunov equation, -A is
//! stable, and the same holds with -W in place of W.
//!
//! **By elimination**, for any A of order up to [`ELIMINATION_ORDER`] (stable or not). On the upper triangle of X, T is
//! a matrix M of order `n(n + 1)/2`, and the solution of `M x = -R` is enclosed with a verified inverse; theorem and
//! proof are in the head of `statement/linear_system.rs`. The eigenvalues of T on symmetric matrices are all the
//! `lambda_i + lambda_j` (`lambda_i lambda_j - 1`), the same as on all matrices: a solution that is unique among the
//! symmetric ones is unique.
//!
//! The comparison costs a few products and Cholesky factorisations of order n, the elimination about n^6/4 operations.

mod comparison;
mod elimination;

pub use elimination::ELIMINATION_ORDER;

use super::{embed, embed_symmetric};
use crate::error::ProofError;
use crate::exact::Exact;
use crate::interval::Interval;
use crate::matrix::Matrix;
use crate::ring::Ring;
use crate::verdict::UndecidedReason;

/// Result for the exact solution of a matrix equation.
#[derive(Debug, Clone, PartialEq)]
pub enum Enclosure {
    /// The equation has exactly one solution, which lies in the enclosure.
    Enclosed(Enclosed),
    /// Neither existence nor uniqueness was shown.
    Undecided {
        /// The reason.
        why: UndecidedReason,
    },
}

/// Enclosure of the exact solution.
#[derive(Debug, Clone, PartialEq)]
pub struct Enclosed {
    /// The exact solution is symmetric, and each of its entries lies in the interval of that entry.
    pub p: Matrix<Interval>,
    /// Upper bound of the difference between an entry of the exact solution and that of the approximation.
    pub distance: f64,
}

impl Enclosure {
    /// The enclosure, if there is one.
    pub fn enclosed(&self) -> Option<&Enclosed> {
        match self {
            Self::Enclosed(enclosed) => Some(enclosed),
            Self::Undecided { .. } => None,
        }
    }
}

/// Encloses the exact solution of `A'P + PA + Q = 0`, and proves that it exists and is unique, for all A and Q within
/// their intervals.
///
/// A is n x n, Q n x n (both bounds symmetric), `approximation` a list of symmetric n x n matrices whose *sum* is near
/// P; one is enough, a second that solves the equation for the residual makes the enclosure narrower. `stability` is a
/// symmetric W with `A'W + WA < 0` that is positive or negative definite (the solution for Q = I, say), for the proof
/// by comparison. Without it, or if it proves nothing, the equation is solved by elimination, up to order
/// [`ELIMINATION_ORDER`]. The head of this module has the theorems. Undecided if neither proves uniqueness, in
/// particular if two eigenvalues of A add to zero.
///
/// # Errors
/// [`ProofError`] for inconsistent shapes, entries that are not finite or bounded, or a Q, an approximation or a W that
/// is not symmetric.
/// ```
/// use luenberger_proof::{Interval, Matrix, Ring, statement::lyapunov_solution};
/// # fn main() -> Result<(), luenberger_proof::ProofError> {
/// // -2 p + 1/5 = 0 with the 1/5 of binary64: p is its half.
/// let number = |x: f64| Matrix::from_rows([[Interval::from_f64(x).expect("finite")]]);
/// let near = Matrix::from_rows([[0.1000001]]);
/// let found = lyapunov_solution(&number(-1.0), &number(0.2), &[near], None)?;
/// let p = found.enclosed().expect("unique").p[(0, 0)];
/// assert!(p.contains(0.1) && p.width() < 1e-15);
/// // An oscillator: its eigenvalues add to zero, and no solution is unique.
/// let none = lyapunov_solution(&number(0.0), &number(1.0), &[Matrix::from_rows([[1.0]])], None)?;
/// assert!(none.enclosed().is_none());
/// # Ok(())
/// # }
/// ```
pub fn lyapunov_solution(
    a: &Matrix<Interval>,
    q: &Matrix<Interval>,
    approximation: &[Matrix<f64>],
    stability: Option<&Matrix<f64>>,
) -> Result<Enclosure, ProofError> {
    enclose(Kind::Lyapunov, a, q, approximation, stability)
}

/// Encloses the exact solution of `A'PA - P + Q = 0`, and proves that it exists and is unique, for all A and Q within
/// their intervals.
///
/// As [`lyapunov_solution`]; `stability` is a W > 0 with `A'WA - W < 0`. Undecided in particular if two eigenvalues of
/// A have the product 1.
/// # Errors
/// As [`lyapunov_solution`].
/// ```
/// use luenberger_proof::{Interval, Matrix, Ring, statement::stein_solution};
/// # fn main() -> Result<(), luenberger_proof::ProofError> {
/// // p/4 - p + 3 = 0.
/// let number = |x: f64| Matrix::from_rows([[Interval::from_f64(x).expect("finite")]]);
/// let one = Matrix::from_rows([[1.0]]);
/// let found = stein_solution(&number(0.5), &number(3.0), &[Matrix::from_rows([[4.0]])], Some(&one))?;
/// let p = found.enclosed().expect("unique").p[(0, 0)];
/// assert!(p.is_point() && p.contains(4.0));
/// # Ok(())
/// # }
/// ```
pub fn stein_solution(
    a: &Matrix<Interval>,
    q: &Matrix<Interval>,
    approximation: &[Matrix<f64>],
    stability: Option<&Matrix<f64>>,
) -> Result<Enclosure, ProofError> {
    enclose(Kind::Stein, a, q, approximation, stability)
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Lyapunov,
    Stein,
}

impl Kind {
    /// `T(X)` for a symmetric X, symmetric entry by entry.
    fn apply<R: Ring>(self, a: &Matrix<R>, x: &Matrix<R>) -> Result<Matrix<R>, ProofError> {
        match self {
            Self::Lyapunov => x.product(a)?.plus_transpose(),
            Self::Stein => a.congruence(x)?.difference(x),
        }
    }
}

/// The equation and its approximate solution.
struct Posed<'a> {
    kind: Kind,
    a: &'a Matrix<Interval>,
    /// Enclosure of the residual of the approximation.
    residual: Matrix<Interval>,
    /// Enclosure of the entries of the approximation.
    near: Matrix<Interval>,
}

fn enclose(
    kind: Kind,
    a: &Matrix<Interval>,
    q: &Matrix<Interval>,
    approximation: &[Matrix<f64>],
    stability: Option<&Matrix<f64>>,
) -> Result<Enclosure, ProofError> {
    let n = a.rows();
    a.expect_shape("A", (n, n))?;
    q.expect_shape("Q", (n, n))?;
    bounded(a, "A")?;
    bounded(q, "Q")?;
    for row in 0..n {
        for column in row + 1..n {
            let (upper, lower) = (q[(row, column)], q[(column, row)]);
            if upper != lower {
                let middle = |x: Interval| f64::midpoint(x.lo(), x.hi());
                return Err(ProofError::NotSymmetric {
                    what: "Q",
                    row,
                    column,
                    upper: middle(upper),
                    lower: middle(lower),
                });
            }
        }
    }
    for part in approximation {
        embed_symmetric::<Interval>(part, "the approximation", n)?;
    }
    let posed = pose(kind, a, q, approximation)?;
    let mut why = UndecidedReason::NoProposal { status: "no stability matrix" };
    if let Some(w) = stability {
        let w = embed_symmetric::<Interval>(w, "W", n)?;
        match posed.by_comparison(&w)? {
            found @ Enclosure::Enclosed(_) => return Ok(found),
            Enclosure::Undecided { why: reason } => why = reason,
        }
    }
    if n <= ELIMINATION_ORDER { posed.by_elimination() } else { Ok(Enclosure::Undecided { why }) }
}

fn bounded(m: &Matrix<Interval>, what: &'static str) -> Result<(), ProofError> {
    for (k, x) in m.as_slice().iter().enumerate() {
        if !x.is_bounded() {
            let value = if x.lo().is_finite() { x.hi() } else { x.lo() };
            return Err(ProofError::NotFinite { what, row: k / m.cols(), column: k % m.cols(), value });
        }
    }
    Ok(())
}

fn total<R: Ring>(parts: &[Matrix<f64>], n: usize) -> Result<Matrix<R>, ProofError> {
    parts.iter().try_fold(Matrix::zeros(n, n), |sum, part| sum.sum(&embed(part, "the approximation", (n, n))?))
}

fn pose<'a>(
    kind: Kind,
    a: &'a Matrix<Interval>,
    q: &Matrix<Interval>,
    approximation: &[Matrix<f64>],
) -> Result<Posed<'a>, ProofError> {
    let n = a.rows();
    let near = total::<Exact>(approximation, n)?.map(Exact::enclosure);
    let single = a.as_slice().iter().chain(q.as_slice()).all(Interval::is_point);
    let residual = if single && n <= super::EXACT_ORDER {
        let numbers = |m: &Matrix<Interval>, what| embed::<Exact>(&m.map(Interval::lo), what, (n, n));
        kind.apply(&numbers(a, "A")?, &total(approximation, n)?)?.sum(&numbers(q, "Q")?)?.map(Exact::enclosure)
    } else {
        // The parts after the first are small, and so is the width of their terms when these are added one by one.
        let mut residual = q.clone();
        for part in approximation {
            residual = residual.sum(&kind.apply(a, &embed::<Interval>(part, "the approximation", (n, n))?)?)?;
        }
        residual
    };
    Ok(Posed { kind, a, residual, near })
}

impl Posed<'_> {
    /// The approximation corrected by the symmetric error enclosure `x`.
    fn corrected(&self, x: &Matrix<Interval>) -> Result<Enclosure, ProofError> {
        let distance = x.as_slice().iter().map(Interval::magnitude).fold(0.0, f64::max);
        if !distance.is_finite() {
            return Ok(Enclosure::Undecided { why: UndecidedReason::Overflow });
        }
        Ok(Enclosure::Enclosed(Enclosed { p: self.near.sum(x)?, distance }))
    }
}
