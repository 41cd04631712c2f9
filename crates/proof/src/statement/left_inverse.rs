//! Enclosure of `B (S'S)^-1 S'`, a product with the left inverse of a matrix S of full column rank.
//!
//! S'S is not inverted, because its condition number is the square of that of S. With a diagonal D > 0 of powers of two
//! and a number `alpha > 0`, `X = B (S'S)^-1 S'` is the only solution of
//! ```text
//! S square:              D S' X' = D B'
//! S with more rows:      [alpha I, S D; D S', 0] [X'; Y'] = [0; D B']
//! ```
//! *Proof.* The first equation is X S = B. In the second, the first row gives X' = S Z with `Z = -D Y'/alpha`, and the
//! last one `S'S Z = B'`. Both matrices are nonsingular if S has full column rank. *qed.* The columns of S D have
//! entries up to 1 or 2, and alpha is near the smallest singular value of S D: the condition number of the second
//! matrix is then about that of S D (A. Bjorck, BIT 7, 1967), not its square.
//!
//! An approximate solution is corrected once. The residual of the sum of both is evaluated exactly, for S with up to
//! 160 columns, and the theorem of `linear_system.rs` encloses the error. With the condition number k and u = 1.1e-16,
//! the relative width is about `u + (k u)^3`.

use super::linear_system::VerifiedInverse;
use super::{EXACT_ORDER, Expression, number};
use crate::definite;
use crate::error::ProofError;
use crate::exact::{Exact, power_of_two};
use crate::interval::Interval;
use crate::matrix::Matrix;
use crate::ring::Ring;

/// `B (S'S)^-1 S'`; `None` if S does not have full column rank, or nearly so.
pub(crate) fn times_left_inverse(
    b: &impl Expression,
    s: &impl Expression,
) -> Result<Option<Matrix<Interval>>, ProofError> {
    let system = System::of(b, s)?;
    if system.rows < system.units.len() {
        return Ok(None);
    }
    let Ok(inverse) = VerifiedInverse::of(&system.matrix()?)? else { return Ok(None) };
    let solution = if system.units.len() <= EXACT_ORDER {
        system.solve(&inverse, Exact::enclosure)?
    } else {
        system.solve(&inverse, Interval::clone)?
    };
    Ok(solution.map(|x| Matrix::from_fn(x.cols(), system.rows, |i, j| x[(j, i)])))
}

/// The linear system in the head of this module.
struct System<'a, B, S> {
    b: &'a B,
    s: &'a S,
    /// Number of rows of S.
    rows: usize,
    /// Diagonal of D.
    units: Vec<f64>,
    /// alpha, if S has more rows than columns.
    alpha: Option<f64>,
}

impl<'a, B: Expression, S: Expression> System<'a, B, S> {
    fn of(b: &'a B, s: &'a S) -> Result<Self, ProofError> {
        let enclosed: Matrix<Interval> = s.evaluate()?;
        let size = |j: usize| {
            let column = (0..enclosed.rows()).map(|i| enclosed[(i, j)].magnitude());
            column.fold(0.0, f64::max).clamp(f64::MIN_POSITIVE, f64::MAX)
        };
        let units = (0..enclosed.cols()).map(|j| power_of_two(-(size(j).log2().floor() as i64))).collect();
        let mut system = Self { b, s, rows: enclosed.rows(), units, alpha: None };
        if enclosed.rows() > enclosed.cols() {
            let scaled: Matrix<Interval> = system.scaled()?;
            let gram = scaled.congruence(&Matrix::scalar(scaled.rows(), &Interval::ONE))?;
            // 2^-52 if the eigenvalue is below rounding level.
            let square = definite::proved_eigenvalue_bound(&gram).unwrap_or(f64::EPSILON);
            system.alpha = Some(power_of_two((square.log2() / 2.0).floor() as i64));
        }
        Ok(system)
    }

    /// `S D`.
    fn scaled<R: Ring>(&self) -> Result<Matrix<R>, ProofError> {
        let (s, units) = (self.s.evaluate::<R>()?, self.units::<R>()?);
        Ok(Matrix::from_fn(s.rows(), s.cols(), |i, j| s[(i, j)].mul(&units[j])))
    }

    fn units<R: Ring>(&self) -> Result<Vec<R>, ProofError> {
        self.units.iter().map(|&x| number(x, "a power of two")).collect()
    }

    fn matrix<R: Ring>(&self) -> Result<Matrix<R>, ProofError> {
        let scaled = self.scaled::<R>()?;
        let Some(alpha) = self.alpha else { return Ok(scaled.transpose()) };
        let corner = Matrix::scalar(scaled.rows(), &number(alpha, "alpha")?);
        corner.bordered(&scaled, &Matrix::zeros(scaled.cols(), scaled.cols()))
    }

    fn right_side<R: Ring>(&self) -> Result<Matrix<R>, ProofError> {
        let (b, units) = (self.b.evaluate::<R>()?, self.units::<R>()?);
        let above = if self.alpha.is_some() { self.rows } else { 0 };
        Ok(Matrix::from_fn(above + b.cols(), b.rows(), |i, j| match i.checked_sub(above) {
            Some(i) => b[(j, i)].mul(&units[i]),
            None => R::zero(),
        }))
    }

    /// Enclosure of the solution, with residuals in the ring R.
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
