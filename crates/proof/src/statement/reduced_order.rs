//! Convergence of the reduced-order observer.
//!
//! Plant `x' = A x + B u`, `y = C x`, and a matrix T, q x n, for which `S = [C; T]` has full column rank. With
//! `S'S = C'C + T'T`, `N = (S'S)^-1 C'` and `M = (S'S)^-1 T'` have `N C + M T = I`. The observer
//! ```text
//! w' = F w + G y + TB u,    xhat = M w + N y,    F = TAM,    G = TAN
//! ```
//! has `w - Tx = v` with `v' = F w + TAN Cx + TBu - TAx - TBu = F w - TAM Tx = F v`, since `TAN C = TA - TAM T`, and
//! `xhat - x = M w + N C x - x = M v`. All of it is exact for the real matrices M, N, F and G, which are rational
//! functions of A, C and T. F is enclosed here, and `F'P + PF + 2 rate P < 0` with `P > 0` is decided.
//!
//! **Enclosure of F.** `[N M] = (S'S)^-1 S'` is the left inverse of S, so that `[G F] = TA (S'S)^-1 S'`. S'S is not
//! inverted: its condition number is the square of that of S. With a diagonal D > 0 of powers of two and a number
//! `alpha > 0`, X = [G F] is the only solution of
//! ```text
//! p + q = n:    D S' X' = D (TA)'
//! p + q > n:    [alpha I, S D; D S', 0] [X'; Y'] = [0; D (TA)']
//! ```
//! *Proof.* The first is X S = TA. In the second the first row says X' = S Z with `Z = -D Y'/alpha`, and the last
//! `S'S Z = (TA)'`. Both matrices are nonsingular where S has full column rank. *qed.* The columns of S D have entries
//! up to 1 or 2, and alpha is near the least singular value of S D: the condition number of the second matrix is then
//! about that of S D (A. Bjorck, BIT 7, 1967), not its square.
//!
//! An approximate solution is corrected once. The residual of the sum of both is evaluated exactly, for plants of order
//! up to 160, and encloses the error by the theorem of `linear_system.rs`. With k the condition number and u = 1.1e-16,
//! the relative width is about `u + (k u)^3`.

use super::linear_system::VerifiedInverse;
use super::{EXACT_ORDER, Expression, embed, embed_symmetric, number};
use crate::definite::{self, Direction, Sense};
use crate::error::ProofError;
use crate::exact::{Exact, power_of_two};
use crate::interval::Interval;
use crate::matrix::Matrix;
use crate::ring::Ring;
use crate::verdict::{UndecidedReason, Verdict};

/// What is proved of a reduced-order observer.
#[derive(Debug, Clone, PartialEq)]
pub struct ReducedOrder {
    /// `C'C + T'T > 0`.
    pub rank: Verdict<Direction>,
    /// `P > 0`.
    pub positive: Verdict<Direction>,
    /// `F'P + PF + 2 rate P < 0`.
    pub decrease: Verdict<Direction>,
}

/// Convergence of the reduced-order observer with the stored T at a rate; P is q x q.
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
/// [`ProofError`] for shapes that do not fit, entries that are not finite, a P that is not symmetric.
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

/// An enclosure of F, given that S has full column rank; `None` where it is too near to losing it.
fn flow(a: &Matrix<f64>, c: &Matrix<f64>, t: &Matrix<f64>) -> Result<Option<Matrix<Interval>>, ProofError> {
    let system = System::of(a, c, t)?;
    let Ok(inverse) = VerifiedInverse::of(&system.matrix()?)? else { return Ok(None) };
    let solution = if a.rows() <= EXACT_ORDER {
        system.solve(&inverse, Exact::enclosure)?
    } else {
        system.solve(&inverse, Interval::clone)?
    };
    let (outputs, order) = (c.rows(), t.rows());
    Ok(solution.map(|x| Matrix::from_fn(order, order, |i, j| x[(outputs + j, i)])))
}

/// The linear system of the head of this module.
struct System<'a> {
    a: &'a Matrix<f64>,
    c: &'a Matrix<f64>,
    t: &'a Matrix<f64>,
    /// The diagonal of D.
    units: Vec<f64>,
    /// alpha, where S has more rows than columns.
    alpha: Option<f64>,
}

impl<'a> System<'a> {
    fn of(a: &'a Matrix<f64>, c: &'a Matrix<f64>, t: &'a Matrix<f64>) -> Result<Self, ProofError> {
        let n = a.rows();
        let size = |j: usize| {
            let column = (0..c.rows()).map(|i| c[(i, j)]).chain((0..t.rows()).map(|i| t[(i, j)]));
            column.fold(0.0_f64, |largest, x| largest.max(x.abs())).clamp(f64::MIN_POSITIVE, f64::MAX)
        };
        let units = (0..n).map(|j| power_of_two(-(size(j).log2().floor() as i64))).collect();
        let mut system = Self { a, c, t, units, alpha: None };
        if c.rows() + t.rows() > n {
            let scaled: Matrix<Interval> = system.stacked()?;
            let gram = scaled.congruence(&Matrix::scalar(scaled.rows(), &Interval::ONE))?;
            // 2^-52 where rounding hides how small it is.
            let square = definite::proved_eigenvalue_bound(&gram).unwrap_or(f64::EPSILON);
            system.alpha = Some(power_of_two((square.log2() / 2.0).floor() as i64));
        }
        Ok(system)
    }

    /// `S D`.
    fn stacked<R: Ring>(&self) -> Result<Matrix<R>, ProofError> {
        let (c, t) = (Matrix::<R>::embed(self.c, "C")?, Matrix::<R>::embed(self.t, "T")?);
        let units = self.units::<R>()?;
        Ok(Matrix::from_fn(c.rows() + t.rows(), c.cols(), |i, j| {
            let entry = if i < c.rows() { &c[(i, j)] } else { &t[(i - c.rows(), j)] };
            entry.mul(&units[j])
        }))
    }

    fn units<R: Ring>(&self) -> Result<Vec<R>, ProofError> {
        self.units.iter().map(|&x| number(x, "a power of two")).collect()
    }

    fn matrix<R: Ring>(&self) -> Result<Matrix<R>, ProofError> {
        let stacked = self.stacked::<R>()?;
        let Some(alpha) = self.alpha else { return Ok(stacked.transpose()) };
        let corner = Matrix::scalar(stacked.rows(), &number(alpha, "alpha")?);
        corner.bordered(&stacked, &Matrix::zeros(stacked.cols(), stacked.cols()))
    }

    fn right_side<R: Ring>(&self) -> Result<Matrix<R>, ProofError> {
        let image = Matrix::<R>::embed(self.t, "T")?.product(&Matrix::embed(self.a, "A")?)?;
        let units = self.units::<R>()?;
        let above = if self.alpha.is_some() { self.c.rows() + self.t.rows() } else { 0 };
        Ok(Matrix::from_fn(above + image.cols(), image.rows(), |i, j| match i.checked_sub(above) {
            Some(i) => image[(j, i)].mul(&units[i]),
            None => R::zero(),
        }))
    }

    /// An enclosure of the solution, with residuals in the ring R.
    fn solve<R: Ring>(
        &self,
        inverse: &VerifiedInverse,
        enclosure: impl Fn(&R) -> Interval,
    ) -> Result<Option<Matrix<Interval>>, ProofError> {
        let matrix: Matrix<R> = self.matrix()?;
        let mut residual: Matrix<R> = self.right_side()?;
        let mut near = Matrix::<Exact>::zeros(residual.rows(), residual.cols());
        for _ in 0..2 {
            let Ok(correction) = inverse.times(&residual.map(&enclosure))? else { return Ok(None) };
            if !correction.as_slice().iter().all(Interval::is_bounded) {
                return Ok(None);
            }
            let part = correction.map(Interval::midpoint);
            residual = residual.difference(&matrix.product(&Matrix::embed(&part, "a correction")?)?)?;
            near = near.sum(&Matrix::embed(&part, "a correction")?)?;
        }
        let Ok(error) = inverse.times(&residual.map(enclosure))? else { return Ok(None) };
        Ok(Some(near.map(Exact::enclosure).sum(&error)?))
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
