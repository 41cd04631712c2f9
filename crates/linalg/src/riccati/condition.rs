//! Condition number of a Riccati equation, and a bound of the error of its solution (Kenney and Hewer, SIAM J. Control
//! Optim. 28, 1990).
//!
//! The derivative of the equation at X is the Lyapunov (Stein) operator of the closed loop F. Two solutions are needed:
//!
//! ```text
//! continuous   F'H0 + H0 F + I = 0        F'H2 + H2 F + X^2 = 0
//! discrete     F'H0 F - H0 + I = 0        F'H2 F - H2 + F'X^2 F = 0
//! ```
//! To first order and in the spectral norm, a change of Q, A and `G = B R^-1 B'` moves X by at most
//! `||H0|| ||dQ|| + 2 sqrt(||H0|| ||H2||) ||dA|| + ||H2|| ||dG||`; the bounds for Q alone and for G alone are attained.
//!
//! **Error.** Let X have the defect D, `-c I <= D <= c I`. If `4 c ||H0|| tr(H0 G) <= 1`, there is a solution that
//! differs from X by an E with `-2c H0 <= E <= 2c H0`. Reason: for such an E the quadratic term `E G E` is at most `4
//! c^2 ||H0^1/2 G H0^1/2|| H0 <= c I`, so the map from E to the solution for `D + E G E` maps this set into itself and
//! has a fixed point (Brouwer). In discrete time G becomes `B (R + B'X B)^-1 B'`, the quadratic term is `F'E G (I + E
//! G)^-1 E F`, and 4 becomes 8. With an indefinite R the same holds with `|G|` in place of G in the condition, `-|G| <=
//! G <= |G|`. The solution `X + E` is the stabilizing one: `|H0^1/2 (E G + G E) H0^1/2| <= I` in the coordinates of H0,
//! so that H0 is a Lyapunov function of its closed loop `F - G E` as well (in discrete time of `(I + G E)^-1 F`).

use super::coordinates::Frame;
use super::input_weight::InputWeight;
use super::scaled::Scaled;
use crate::forward_error::relative;
use crate::schur_operator::SchurEquation;
use crate::separation::norm;
use nalgebra::DMatrix;

/// `(condition, forward error)`, both relative to the norm of `x`, in the units of `problem`; infinite if the Lyapunov
/// equations of the closed loop cannot be solved. `equation` is that of the closed loop, `defect` the norm of the
/// defect.
pub(super) fn condition(
    problem: &Scaled,
    x: &DMatrix<f64>,
    k: &DMatrix<f64>,
    equation: &mut SchurEquation,
    defect: f64,
) -> (f64, f64) {
    let n = x.nrows();
    let seen = if problem.discrete { x * (&problem.a - &problem.b * k) } else { x.clone() };
    let weights = [DMatrix::identity(n, n), seen.tr_mul(&seen)];
    let [Some(h), Some(h2)] = weights.map(|weight| equation.substituted(&weight)) else {
        return (f64::INFINITY, f64::INFINITY);
    };
    let (h0, size) = (norm(&h), norm(x));
    let condition = relative_change(problem, h0, norm(&h2), size);
    // Defect plus its rounding error: three products, the quadratic one of large terms that may cancel.
    let a = norm(&problem.a);
    let (linear, steps) = if problem.discrete {
        ((a * a + 1.0) * size + norm(&problem.q), a)
    } else {
        (2.0 * a * size + norm(&problem.q), 1.0)
    };
    let quadratic = steps * size * norm(&problem.b) * norm(k);
    let rounding = 2.0 * n as f64 * f64::EPSILON * (linear + 2.0 * quadratic + problem.defect_of_gain(k));
    let defect = defect + rounding;
    let pull = problem.input_weight(&problem.b, x).map_or(f64::INFINITY, |weight| weight.pull(&problem.b, &h));
    // Rounding of the closed loop, where the bound has to verify that there is a solution.
    let (h0, pull) = if problem.is_definite() {
        (h0, pull)
    } else {
        let unknown = 2.0 * (n + k.nrows()) as f64 * f64::EPSILON * (a + norm(&problem.b) * norm(k));
        let steps = if problem.discrete { 2.0 * (a + norm(&problem.b) * norm(k)) } else { 2.0 };
        let factor = grown(steps * unknown * h0);
        (h0 * factor, pull * factor)
    };
    let forward = if dominated(problem, pull, h0, defect) { moved(defect, h0, n, size) } else { f64::INFINITY };
    (condition, known(forward))
}

/// The equation in the coordinates of `frame`.
pub(super) struct Local<'a> {
    pub(super) frame: &'a Frame,
    /// `A^ - B^ K^`.
    pub(super) f: &'a DMatrix<f64>,
    pub(super) b: &'a DMatrix<f64>,
    /// `Q^ + K^'R K^`.
    pub(super) q: &'a DMatrix<f64>,
    pub(super) k: &'a DMatrix<f64>,
    /// `R`, for the discrete equation `R + B^'X^ B^`.
    pub(super) input_weight: &'a InputWeight,
    /// Bound of the error of `f`.
    pub(super) unknown: f64,
}

/// As [`condition`], from X^ and the closed loop in the coordinates of `frame`: the right-hand side I becomes `T'T`,
/// and so on; the results are in the units of `problem`. `None` if the error `dF` of the closed loop might make it
/// unstable: with H0 as Lyapunov function it cannot if `2 |dF| ||H0|| < 1`.
pub(super) fn in_frame(
    problem: &Scaled,
    local: &Local<'_>,
    x: &DMatrix<f64>,
    equation: &mut SchurEquation,
) -> Option<(f64, f64)> {
    let n = x.nrows();
    let (frame, f) = (local.frame, local.f);
    let h = equation.substituted(&DMatrix::identity(n, n))?;
    let h0 = norm(&h);
    let size_of_f = norm(f);
    let steps = if problem.discrete { 2.0 * size_of_f + local.unknown } else { 2.0 };
    let stable = steps * local.unknown * h0 < 1.0;
    if !stable {
        return None;
    }
    let seen = &frame.inverse.transpose() * if problem.discrete { x * f } else { x.clone() };
    let weights = [frame.t.tr_mul(&frame.t), seen.tr_mul(&seen)];
    let [h_user, h2_user] = weights.map(|weight| equation.substituted(&weight).map(|h| norm(&frame.back(&h))));
    let size = norm(&frame.back(x));
    let condition = relative_change(problem, h_user?, h2_user?, size);
    // Defect for this gain, and its difference from the gain of X.
    let image = f.tr_mul(x);
    let left = if problem.discrete { &image * f - x } else { &image + image.transpose() } + local.q;
    let optimal = if problem.discrete {
        let a = f + local.b * local.k;
        local.input_weight.solve(&(local.b.tr_mul(x) * a))
    } else {
        local.input_weight.solve(&local.b.tr_mul(x))
    };
    let other = optimal - local.k;
    let (missed, moved_loop) = (norm(&local.input_weight.half(&other)), norm(&(local.b * other)));
    let (size_of_x, size_of_t) = (norm(x), norm(&frame.t));
    let linear = if problem.discrete { (size_of_f * size_of_f + 1.0) * size_of_x } else { 2.0 * size_of_f * size_of_x };
    let terms = linear + norm(local.q) + size_of_t * size_of_t * norm(&problem.q) + problem.defect_of_gain(local.k);
    let rounding = 2.0 * n as f64 * f64::EPSILON * terms;
    let defect = norm(&left) + missed * missed + steps * local.unknown * size_of_x + rounding;
    // The derivative at X has the closed loop of the gain of X.
    let unknown = local.unknown + moved_loop;
    let factor = grown(if problem.discrete { 2.0 * size_of_f + unknown } else { 2.0 } * unknown * h0);
    let pull = local.input_weight.pull(local.b, &h) * factor;
    let forward = if dominated(problem, pull, h0 * factor, defect) {
        let size_of_s = norm(&frame.inverse);
        // Rounding of X = S'X^ S, entry by entry.
        let rounded = relative(2.0 * n as f64 * f64::EPSILON * size_of_s * size_of_s * size_of_x, size);
        moved(defect, norm(&frame.back(&h)) * factor, n, size) + rounded
    } else {
        f64::INFINITY
    };
    Some((condition, known(forward)))
}

/// Relative condition number from the norms of H0, H2 and X.
fn relative_change(problem: &Scaled, h0: f64, h2: f64, size: f64) -> f64 {
    let (a, q, g) = (norm(&problem.a), norm(&problem.q), norm(&problem.g));
    known(relative(h0 * q + 2.0 * h0.sqrt() * h2.sqrt() * a + h2 * g, size))
}

/// Whether the linear term dominates the quadratic one, `4 c ||H0|| tr(H0 G) <= 1` (8 in discrete time).
fn dominated(problem: &Scaled, pull: f64, h0: f64, defect: f64) -> bool {
    let curvature = pull * if problem.discrete { 8.0 } else { 4.0 };
    curvature * h0 * defect <= 1.0
}

fn moved(defect: f64, h0: f64, n: usize, size: f64) -> f64 {
    relative(2.0 * h0 * defect * (n as f64).sqrt(), size)
}

/// The factor by which the solutions of the Lyapunov equation grow at most with a closed loop that is not known
/// exactly; `decrease` is by how much its error may reduce the identity.
fn grown(decrease: f64) -> f64 {
    if decrease < 1.0 { 1.0 / (1.0 - decrease) } else { f64::INFINITY }
}

/// NaN means that no bound is known.
fn known(x: f64) -> f64 {
    if x.is_nan() { f64::INFINITY } else { x }
}
