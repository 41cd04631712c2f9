//! A Riccati equation in coordinates of the state in which its solution is near the identity.
//!
//! With few inputs and many unstable states the eigenvalues of `X` spread: by twelve decades for 100 states and three
//! inputs, by twenty for 50 states and one. The error of the invariant subspace, relative to the norm of the
//! Hamiltonian matrix, then leaves few correct digits in the small directions, and Newton's iteration starts too far
//! away. With `X = V W V'` (eigenvalues W) and `T = V W^-1/2`, the equation for `A T = T A^`, `B = T B^`, `Q^ = T'Q T`
//! has the solution `X^ = T'X T` near `I`. Its closed loop satisfies `(A^ - B^ K^) + (A^ - B^ K^)' = -(Q^ + K^'R K^)`,
//! so its norm is bounded by these weights and no term is lost. The solution X^ in turn gives better coordinates
//! `T V^ W^^-1/2`. Each pass recovers what was below the rounding error of the pass before, about sixteen decades of X.
//!
//! **Gain and stability.** Rounded to doubles, X loses directions smaller than eps times the largest; T, a square root,
//! loses them at eps^2 only, and with them the gain. So K is computed from X^ in these coordinates and tested as
//! stored: the closed loop `T^-1 (A - B K) T`, formed in twice the working precision, must be stable, and remain so
//! under any change within its error bound, by the Lyapunov function of its own equation.

use super::bilinear::{self, Shifted};
use super::condition::{self, Local};
use super::coordinates::Frame;
use super::scaled::Scaled;
use super::{Evidence, Outcome, hamiltonian};
use crate::Result;
use crate::argument::symmetric_part;
use crate::schur_operator::{Kind, SchurEquation};
use nalgebra::DMatrix;

/// Maximum number of passes; each takes its coordinates from the solution of the previous one.
const PASSES: usize = 6;
/// Steps of Newton's iteration in the last coordinates.
const POLISH: usize = 2;

/// Solves in coordinates in which X is near the identity. `x` is an approximate solution in the coordinates of
/// `problem`, if there is one. `None` if no stabilizing gain is found.
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
        // First pass: eigenvalues of X below its rounding error are unknown. Later passes: only where X vanishes are
        // they so small, and there the coordinates do not matter.
        let floor = if pass == 0 { f64::EPSILON } else { 2.0_f64.powi(-6) };
        let Some(next) = frame.then(x, floor) else { return Ok(None) };
        // Near enough to the identity.
        if pass > 0 && next.extremes.1 <= 4.0 && (next.extremes.0 >= 0.01 || pass > 2) {
            break;
        }
        let Some(x) = guess(problem, &next, &k) else { return Ok(None) };
        (frame, found) = (next, Some(x));
    }
    let Some(x) = found else { return Ok(None) };
    judged(problem, &frame, &x, k)
}

/// Approximate X^ in `frame`; `k` is the present gain in the coordinates of the problem.
fn guess(problem: &Scaled, frame: &Frame, k: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    if !problem.discrete {
        // A mode with `S B` of size 1e8 would hide a slow one without the doubled precision.
        let none = DMatrix::zeros(k.nrows(), k.ncols());
        let (a, _) = frame.closed_loop(problem, &none);
        return hamiltonian::guess(&problem.in_coordinates(a, frame.driven(&problem.b), frame.form(&problem.q)));
    }
    let (f, _) = frame.closed_loop(problem, k);
    let k = frame.gain(k);
    let q = weight(problem, frame, &k);
    bilinear::guess(&Shifted { f: &f, b: &frame.driven(&problem.b), q: &q, k: &k, r: &problem.r })
}

/// State weight `T'Q T + K^'R K^`.
fn weight(problem: &Scaled, frame: &Frame, k: &DMatrix<f64>) -> DMatrix<f64> {
    frame.form(&problem.q) + symmetric_part(&(k.tr_mul(&problem.r) * k))
}

/// The gain of X^, in the coordinates of the problem. The discrete one is computed as a change of `k`, so that no term
/// as large as `A^` appears.
fn gain(problem: &Scaled, frame: &Frame, x: &DMatrix<f64>, k: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let b = frame.driven(&problem.b);
    let found = if problem.discrete {
        let (f, _) = frame.closed_loop(problem, k);
        let factor = problem.input_weight(&b, x)?;
        k + factor.solve(&(b.tr_mul(&(x * f)) - &problem.r * frame.gain(k))) * &frame.inverse
    } else {
        problem.input_weight(&b, x)?.solve(&b.tr_mul(x)) * &frame.inverse
    };
    found.iter().all(|e| e.is_finite()).then_some(found)
}

/// Newton's iteration from X^ in `frame`, then the stability test and error bound of the gain as stored.
fn judged(problem: &Scaled, frame: &Frame, x: &DMatrix<f64>, mut k: DMatrix<f64>) -> Result<Option<Outcome>> {
    let kind = Kind::of_time(problem.discrete);
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
        let Some(input_weight) = problem.input_weight(&b, &x) else { return Ok(None) };
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
