//! From an approximate solution to one that is refined, stabilizes, and has its evidence.
//!
//! One Schur form of the closed loop `F = A - B K` serves everything: its eigenvalues are the poles, the Lyapunov
//! (Stein) equation with it gives the correction of Newton's iteration `F'D + D F + defect = 0` (Kleinman, IEEE TAC 13,
//! 1968; Hewer, IEEE TAC 16, 1971), and the condition. It is computed anew only where a correction moves F by more than
//! rounding.

use super::scaled::Scaled;
use super::{Evidence, Outcome, condition, popov};
use crate::forward_error::relative;
use crate::schur_operator::{Kind, SchurEquation};
use crate::{LinalgError, Result};
use nalgebra::DMatrix;

/// The invariant subspace and the doubling leave few digits to restore; each step doubles them.
pub(super) const NEWTON_STEPS: usize = 3;
/// In roundings: a residual of this size is what sums of this length leave of any solution, and a step would polish
/// digits that the data do not have.
const ROUNDINGS: f64 = 4.0;
/// Costs of the states further apart than this: the residual is that of the largest, and says nothing of the others.
const GRADED: f64 = 1024.0;

/// Refines `x` by Newton's iteration as long as it lowers the residual, and looks at the closed loop.
///
/// # Errors
/// Of [`popov::confirm`], if the closed loop is not stable.
pub(super) fn settle(problem: &Scaled, mut x: DMatrix<f64>) -> Result<Outcome> {
    let unknown = || LinalgError::Overflow { what: "the gain k" };
    let kind = if problem.discrete { Kind::Stein } else { Kind::Lyapunov };
    let mut k = problem.gain(&x).ok_or_else(unknown)?;
    let (mut defect, terms) = problem.defect(&x, &k);
    let mut residual = relative(defect.norm(), terms);
    let closed = problem.closed_loop(&k)?;
    let rounding = problem.a.nrows() as f64 * f64::EPSILON * closed.norm();
    let mut equation = SchurEquation::untested(kind, &closed, None)?;
    let costs = x.diagonal();
    let enough = if costs.max() <= GRADED * costs.min() { ROUNDINGS * f64::EPSILON } else { 0.0 };
    for _ in 0..NEWTON_STEPS {
        if residual <= enough {
            break;
        }
        let Some(correction) = equation.substituted(&defect) else { break };
        let better = &x + correction;
        let Some(next) = problem.gain(&better) else { break };
        let (left, terms) = problem.defect(&better, &next);
        let found = relative(left.norm(), terms);
        if found.is_nan() || found >= residual {
            break;
        }
        let moved = (&problem.b * (&next - &k)).norm();
        (x, k, defect, residual) = (better, next, left, found);
        if moved.is_nan() || moved > rounding {
            equation = SchurEquation::untested(kind, &problem.closed_loop(&k)?, None)?;
        }
    }
    let poles = equation.eigenvalues();
    popov::confirm(problem, &poles)?;
    let (condition, forward_error) = condition::condition(problem, &x, &k, &mut equation, defect.norm());
    if forward_error.is_infinite() {
        popov::resolved(problem, &poles, 10.0 * rounding)?;
    }
    Ok(Outcome { x, k, evidence: Evidence { poles, residual, condition, forward_error } })
}
