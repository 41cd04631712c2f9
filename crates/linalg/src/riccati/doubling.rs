//! The discrete equation by structure-preserving doubling (Chu, Fan, Lin and Wang, Int. J. Control 77, 2004).
//!
//! ```text
//! W = I + G H        A+ = A W^-1 A        G+ = G + A W^-1 G A'        H+ = H + A'H W^-1 A        from (A, G, Q)
//! ```
//!
//! Step k is equivalent to 2^k steps of the Riccati recursion from zero: `H` grows monotonically to the smallest
//! positive semidefinite solution and converges quadratically. It is the stabilizing solution iff `(A, Q)` is
//! detectable. If it is not, the gain for a weight of every state stabilizes, and Newton's iteration (Hewer, IEEE TAC
//! 16, 1971) from it decreases to the stabilizing solution.

use super::popov;
use super::scaled::Scaled;
use crate::argument::symmetric_part;
use crate::stein::stein_step;
use crate::{LinalgError, Result, eigenvalues};
use nalgebra::{Complex, DMatrix};

/// 2^60 steps of the recursion: a pole within 2^-60 of the unit circle cannot be distinguished from one on it.
const DOUBLINGS: usize = 60;
/// Newton's iteration at least halves the error (if a pole lies on the unit circle), and converges quadratically
/// otherwise.
const NEWTON_STEPS: usize = 60;

pub(super) fn solve(problem: &Scaled) -> Result<DMatrix<f64>> {
    if let Ok(x) = double(problem)
        && stabilizes(problem, &x)?
    {
        return Ok(x);
    }
    // A weight of every state is detectable: only an uncontrollable eigenvalue can then prevent a solution.
    let n = problem.a.nrows();
    let weight = [problem.q.norm(), problem.g.norm().recip(), 1.0].into_iter().find(|w| *w > 0.0 && w.is_finite());
    let seen = problem.with_weight(&problem.q + DMatrix::identity(n, n) * weight.unwrap_or(1.0));
    let start = match double(&seen) {
        Ok(x) if stabilizes(&seen, &x)? => x,
        _ => return Err(popov::explain(problem, None)),
    };
    descend(problem, &start)
}

fn double(problem: &Scaled) -> Result<DMatrix<f64>> {
    let n = problem.a.nrows();
    let (mut a, mut g, mut h) = (problem.a.clone(), problem.g.clone(), problem.q.clone());
    let mut change = f64::INFINITY;
    for _ in 0..DOUBLINGS {
        let lu = (DMatrix::identity(n, n) + &g * &h).lu();
        let (Some(wa), Some(wg)) = (lu.solve(&a), lu.solve(&g)) else { break };
        let step = symmetric_part(&(a.transpose() * &h * &wa));
        g += symmetric_part(&(&a * wg * a.transpose()));
        a *= wa;
        h += &step;
        change = step.norm();
        let allowed = f64::EPSILON * h.norm();
        if !(change.is_finite() && a.iter().chain(g.iter()).all(|e| e.is_finite())) {
            break;
        }
        if change <= allowed {
            return Ok(h);
        }
    }
    Err(LinalgError::NotConverged {
        method: "the doubling algorithm",
        iterations: DOUBLINGS,
        remaining: change,
        allowed: f64::EPSILON * h.norm(),
    })
}

/// The eigenvalue of largest modulus.
fn worst(m: &DMatrix<f64>) -> Result<Complex<f64>> {
    Ok(eigenvalues(m)?.into_iter().max_by(|x, y| x.norm().total_cmp(&y.norm())).unwrap_or_default())
}

fn stabilizes(problem: &Scaled, x: &DMatrix<f64>) -> Result<bool> {
    match problem.gain(x) {
        Some(k) if k.iter().all(|e| e.is_finite()) => Ok(worst(&problem.closed_loop(&k)?)?.norm() < 1.0),
        _ => Ok(false),
    }
}

/// Newton's iteration `(A - B K)'X+ (A - B K) - X+ + Q + K'R K = 0`, `K` from `X`, until X no longer decreases.
fn descend(problem: &Scaled, start: &DMatrix<f64>) -> Result<DMatrix<f64>> {
    let mut x = start.clone();
    let mut change = f64::INFINITY;
    for _ in 0..NEWTON_STEPS {
        let Some(k) = problem.gain(&x) else { break };
        let Ok(closed) = problem.closed_loop(&k) else { break };
        let weight = symmetric_part(&(&problem.q + k.transpose() * &problem.r * &k));
        if !weight.iter().all(|e| e.is_finite()) {
            break;
        }
        let Some(next) = stein_step(&closed, &weight)? else { break };
        let step = (&next - &x).norm();
        let allowed = problem.a.nrows() as f64 * f64::EPSILON * next.norm();
        x = next;
        // At rounding level the decrease is no longer monotone.
        if step <= allowed || (step <= allowed.sqrt() && step >= change) {
            return Ok(x);
        }
        change = step;
    }
    Err(popov::explain(problem, None))
}
