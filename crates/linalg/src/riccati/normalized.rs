//! A Riccati equation in coordinates of the state in which its solution is near the identity.
//!
//! Few inputs and many unstable states make `X` grow in some directions and not in others: by twelve decades for 100
//! states and three inputs, by twenty for 50 states and one. The invariant subspace, accurate beside the norm of the
//! Hamiltonian matrix, then leaves few digits or none of what is small, and Newton's iteration starts too far away.
//! With `X = V W V'` (eigenvalues W) and `T = V W^-1/2`, the equation of `A T = T A^`, `B = T B^`, `Q^ = T'Q T` has the
//! solution `X^ = T'X T` near `I`: its closed loop satisfies `(A^ - B^ K^) + (A^ - B^ K^)' = -(Q^ + K^'R K^)`, is as
//! large as these, and nothing in it is drowned. Solved there, the equation gives an X^ from which still better
//! coordinates come, `T V^ W^^-1/2`, and so on: a pass finds what the one before had left below its rounding, sixteen
//! decades of X at a time.
//!
//! **What is found.** The entries of X, rounded, say little of the small directions of an X that is larger than 1/eps
//! beside them; T, the root of X, loses as much at 1/eps^2 only, and with it the gain. So K is taken from X^ and these
//! coordinates, and judged there as it is stored: the closed loop `T^-1 (A - B K) T`, formed in twice the working
//! precision, has to be stable, and to stay so under any change as large as what is not known of it, by the Lyapunov
//! function of its own equation.

use super::bilinear::{self, Shifted};
use super::condition::{self, Local};
use super::coordinates::Frame;
use super::scaled::Scaled;
use super::{Evidence, Outcome, hamiltonian};
use crate::Result;
use crate::argument::symmetric_part;
use crate::schur_operator::{Kind, SchurEquation};
use nalgebra::{Cholesky, DMatrix};

/// Each pass takes the coordinates from the solution of the one before.
const PASSES: usize = 6;
/// Steps of Newton's iteration in the last coordinates.
const POLISH: usize = 2;

/// The solution from coordinates of its own, `x` being one in those of `problem` if there is any; `None` if no gain is
/// found that stabilizes.
pub(super) fn solve(problem: &Scaled, x: Option<&DMatrix<f64>>) -> Result<Option<Outcome>> {
    let n = problem.a.nrows();
    let mut frame = Frame::identity(n);
    let mut k = DMatrix::zeros(problem.b.ncols(), n);
    let mut found = match x {
        Some(x) => Some(x.clone()),
        None => guess(problem, &frame, &k),
    };
    for pass in 0..PASSES {
        let Some(x) = &found else { return Ok(None) };
        if let Some(better) = gain(problem, &frame, x, &k) {
            k = better;
        }
        // At first what is below the rounding of X has no size. Later nothing is that small but where X vanishes, for
        // which no coordinates are asked.
        let floor = if pass == 0 { f64::EPSILON } else { 2.0_f64.powi(-6) };
        let Some(next) = frame.then(x, floor) else { return Ok(None) };
        // As near to the identity as coordinates need to be.
        if pass > 0 && next.extremes.1 <= 4.0 && (next.extremes.0 >= 0.01 || pass > 2) {
            break;
        }
        let Some(x) = guess(problem, &next, &k) else { return Ok(None) };
        (frame, found) = (next, Some(x));
    }
    let Some(x) = found else { return Ok(None) };
    judged(problem, &frame, &x, k)
}

/// X^ in `frame`, `k` being the gain so far in the coordinates of the problem.
fn guess(problem: &Scaled, frame: &Frame, k: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    if !problem.discrete {
        // A fast mode of size 1e8 in `S B` leaves nothing of a slow one, unless this cancels in twice the precision.
        let none = DMatrix::zeros(k.nrows(), k.ncols());
        let (a, _) = frame.closed_loop(problem, &none);
        return hamiltonian::guess(&problem.in_coordinates(a, frame.driven(&problem.b), frame.form(&problem.q)));
    }
    let (f, _) = frame.closed_loop(problem, k);
    let k = frame.gain(k);
    let q = weight(problem, frame, &k);
    bilinear::guess(&Shifted { f: &f, b: &frame.driven(&problem.b), q: &q, k: &k, r: &problem.r })
}

/// `T'Q T + K^'R K^`.
fn weight(problem: &Scaled, frame: &Frame, k: &DMatrix<f64>) -> DMatrix<f64> {
    frame.form(&problem.q) + symmetric_part(&(k.tr_mul(&problem.r) * k))
}

/// The gain of X^, in the coordinates of the problem; the discrete one as a change of `k`, so that nothing as large as
/// `A^` appears.
fn gain(problem: &Scaled, frame: &Frame, x: &DMatrix<f64>, k: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let b = frame.driven(&problem.b);
    let found = if problem.discrete {
        let (f, _) = frame.closed_loop(problem, k);
        let factor = input_weight(problem, &b, x)?;
        k + factor.solve(&(b.tr_mul(&(x * f)) - &problem.r * frame.gain(k))) * &frame.inverse
    } else {
        input_weight(problem, &b, x)?.solve(&b.tr_mul(x)) * &frame.inverse
    };
    found.iter().all(|e| e.is_finite()).then_some(found)
}

/// `R`, for the discrete equation `R + B^'X^ B^`.
fn input_weight(problem: &Scaled, b: &DMatrix<f64>, x: &DMatrix<f64>) -> Option<Cholesky<f64, nalgebra::Dyn>> {
    let pulled = if problem.discrete { &problem.r + b.tr_mul(&(x * b)) } else { problem.r.clone() };
    Cholesky::new(symmetric_part(&pulled))
}

/// Newton's iteration from X^ in `frame`, and the verdict on the gain as it is stored.
fn judged(problem: &Scaled, frame: &Frame, x: &DMatrix<f64>, mut k: DMatrix<f64>) -> Result<Option<Outcome>> {
    let kind = if problem.discrete { Kind::Stein } else { Kind::Lyapunov };
    if let Some(better) = gain(problem, frame, x, &k) {
        k = better;
    }
    for step in 0..=POLISH {
        let (f, unknown) = frame.closed_loop(problem, &k);
        let kt = frame.gain(&k);
        let q = weight(problem, frame, &kt);
        if !f.iter().chain(q.iter()).all(|e| e.is_finite()) {
            return Ok(None);
        }
        let mut equation = SchurEquation::untested(kind, &f, None)?;
        if !equation.is_stable() {
            return Ok(None);
        }
        let Some(better) = equation.substituted(&q) else { return Ok(None) };
        if step < POLISH {
            let Some(next) = gain(problem, frame, &better, &k) else { return Ok(None) };
            k = next;
            continue;
        }
        let x = better;
        let b = frame.driven(&problem.b);
        let Some(input_weight) = input_weight(problem, &b, &x) else { return Ok(None) };
        let local = Local { frame, f: &f, b: &b, q: &q, k: &kt, input_weight: &input_weight, unknown };
        let Some((condition, forward_error)) = condition::in_frame(problem, &local, &x, &mut equation) else {
            return Ok(None);
        };
        let poles = equation.eigenvalues();
        let x = frame.back(&x);
        let residual = problem.residual(&x);
        if residual.is_nan() || !x.iter().all(|e| e.is_finite()) {
            return Ok(None);
        }
        return Ok(Some(Outcome { x, k, evidence: Evidence { poles, residual, condition, forward_error } }));
    }
    Ok(None)
}
