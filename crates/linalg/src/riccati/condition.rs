//! Condition of a Riccati equation, and a bound of the error of its solution (Kenney and Hewer, SIAM J. Control Optim. 28, 1990).
//!
//! The derivative of the equation at X is the Lyapunov (Stein) operator of the closed loop F. With its solutions for two weights,
//!
//! ```text
//! continuous   F'H0 + H0 F + I = 0        F'H2 + H2 F + X^2 = 0
//! discrete     F'H0 F - H0 + I = 0        F'H2 F - H2 + F'X^2 F = 0
//! ```
//! a change of Q, A and `G = B R^-1 B'` moves X by at most `||H0|| ||dQ|| + 2 sqrt(||H0|| ||H2||) ||dA|| + ||H2|| ||dG||` to first order, in the
//! spectral norm, and the first and the last are attained.
//!
//! **Error.** A defect D with `-c I <= D <= c I` is that of an X off by E, `-2c H0 <= E <= 2c H0`, if `4 c ||H0|| tr(H0 G) <= 1`: the quadratic term `E G E` of such an E is at most
//! `4 c^2 ||H0^1/2 G H0^1/2|| H0 <= c I`, so that the map that takes E to the solution for `D + E G E` stays among them, and has a fixed point (Brouwer). Discrete, with `B (R + B'X B)^-1 B'` for G and
//! `E G (I + E G)^-1 E` between two factors F, whence 8 for 4.

use super::scaled::Scaled;
use crate::Result;
use crate::schur_operator::{Kind, SchurEquation};
use crate::separation::{norm, relative};
use nalgebra::DMatrix;

/// `(condition, forward error)`, both relative to the norm of `x`, in the units of `problem`; infinite where the closed loop `f` leaves none.
pub(super) fn condition(
    problem: &Scaled,
    x: &DMatrix<f64>,
    k: &DMatrix<f64>,
    f: &DMatrix<f64>,
    residual: f64,
) -> Result<(f64, f64)> {
    let n = x.nrows();
    let kind = if problem.discrete { Kind::Stein } else { Kind::Lyapunov };
    let mut equation = SchurEquation::untested(kind, f, None)?;
    let seen = if problem.discrete { x * f } else { x.clone() };
    let weights = [DMatrix::identity(n, n), seen.tr_mul(&seen)];
    let [Some(h), Some(h2)] = weights.map(|weight| equation.substituted(&weight)) else {
        return Ok((f64::INFINITY, f64::INFINITY));
    };
    let (h0, h2) = (norm(&h), norm(&h2));
    let (a, q, g) = (norm(&problem.a), norm(&problem.q), norm(&problem.g));
    let size = norm(x);
    let condition = relative(h0 * q + 2.0 * h0.sqrt() * h2.sqrt() * a + h2 * g, size);
    // What is left of the equation, and the rounding with which that is known: three products, the quadratic one of large terms that may cancel.
    let (linear, steps) = if problem.discrete { ((a * a + 1.0) * size + q, a) } else { (2.0 * a * size + q, 1.0) };
    let quadratic = steps * size * norm(&problem.b) * norm(k);
    let rounding = 2.0 * n as f64 * f64::EPSILON * (linear + 2.0 * quadratic);
    let defect = residual * problem.size_of_terms(x) + rounding;
    let curvature = problem.pull(x, &h) * if problem.discrete { 8.0 } else { 4.0 };
    let dominated = curvature * h0 * defect <= 1.0;
    let forward = if dominated { relative(2.0 * h0 * defect * (n as f64).sqrt(), size) } else { f64::INFINITY };
    // Out of range: nothing is known.
    let known = |x: f64| if x.is_nan() { f64::INFINITY } else { x };
    Ok((known(condition), known(forward)))
}
