//! Refinement of an approximate solution by Newton's iteration, stability of its closed loop, condition and error
//! bound.
//!
//! One Schur form of the closed loop `F = A - B K` serves all of them: its eigenvalues are the poles, and the Lyapunov
//! (Stein) equation with F gives the Newton correction `F'D + D F + defect = 0` (Kleinman, IEEE TAC 13, 1968; Hewer,
//! IEEE TAC 16, 1971) and the condition number. It is computed anew only if a correction moves F by more than rounding.

use super::scaled::Scaled;
use super::{Evidence, Outcome, condition, popov};
use crate::forward_error::relative;
use crate::schur_operator::{Kind, SchurEquation};
use crate::{LinalgError, Result};
use nalgebra::DMatrix;

/// The invariant subspace and the doubling lose few digits; each Newton step doubles the number of correct ones.
pub(super) const NEWTON_STEPS: usize = 3;
/// A relative residual of this many eps is rounding error: a further step would not improve X.
const ROUNDINGS: f64 = 4.0;
/// If the diagonal entries of X differ by more than this factor, the residual says nothing about the small ones;
/// Newton's iteration then continues as long as the residual decreases.
const GRADED: f64 = 1024.0;

/// Refines `x` by Newton's iteration as long as it lowers the residual, and checks the closed loop.
///
/// # Errors
/// Those of [`popov::confirm`], if the closed loop is not stable.
pub(super) fn settle(problem: &Scaled, mut x: DMatrix<f64>) -> Result<Outcome> {
    let unknown = || LinalgError::Overflow { what: "the gain k" };
    let kind = Kind::of_time(problem.discrete);
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
