//! Error bound of an approximate solution, by comparison with a matrix W that proves stability.

use super::{Enclosure, Kind, Posed};
use crate::definite::{self, Sense, proved_eigenvalue_bound};
use crate::error::ProofError;
use crate::interval::Interval;
use crate::matrix::Matrix;
use crate::ring::Ring;
use crate::verdict::UndecidedReason;

/// Maximum number of halvings of the first bound, which exceeds the best one at most by the condition number of D.
const HALVINGS: usize = 120;

impl Posed<'_> {
    pub(super) fn by_comparison(&self, w: &Matrix<Interval>) -> Result<Enclosure, ProofError> {
        let n = self.a.rows();
        let undecided = || Ok(Enclosure::Undecided { why: UndecidedReason::NotByThisMatrix { name: "W" } });
        let d = self.kind.apply(self.a, w)?.negative();
        let Some(least) = proved_eigenvalue_bound(&d).or((n == 0).then_some(1.0)) else { return undecided() };
        let is_definite = |sense| Ok::<_, ProofError>(definite::decide(w, sense)?.is_proved());
        let definite = is_definite(Sense::PositiveDefinite)?
            || (self.kind == Kind::Lyapunov && is_definite(Sense::NegativeDefinite)?);
        if !definite {
            return undecided();
        }
        let norm = super::super::norm_bound(&self.residual);
        let mut r = if norm == 0.0 { 0.0 } else { (norm / least).next_up() };
        for _ in 0..HALVINGS {
            if r == 0.0 || !self.is_dominated(&d, r / 2.0)? {
                break;
            }
            r /= 2.0;
        }
        // Improves the bound from within a factor of 2 to about 1.1 of the best.
        for share in [0.75, 0.9] {
            if r > 0.0 && self.is_dominated(&d, share * r)? {
                r *= share;
            }
        }
        let r = Interval::of(r);
        let x = Matrix::from_fn(n, n, |i, j| {
            let product = w[(i, i)].mul(&w[(j, j)]).abs();
            let bound = r.mul(&product.sqrt().unwrap_or(Interval::UNBOUNDED)).hi();
            Interval::new(-bound, bound).unwrap_or(Interval::UNBOUNDED)
        });
        self.corrected(&x)
    }

    /// Whether `-r D <= R <= r D` is proved.
    fn is_dominated(&self, d: &Matrix<Interval>, r: f64) -> Result<bool, ProofError> {
        let Some(r) = Interval::from_f64(r) else { return Ok(false) };
        let bound = d.scaled(&r);
        Ok(proved_eigenvalue_bound(&bound.difference(&self.residual)?).is_some()
            && proved_eigenvalue_bound(&bound.sum(&self.residual)?).is_some())
    }
}
