//! The deployed observer: its matrices as stored on the target, with the rounding errors of every step.
//!
//! The plant is `x+ = A x + B u`, `y = C x + v` with given real matrices A, B, C (binary64 numbers, taken as exact) and
//! measurement noise v. The target computes one of
//! ```text
//! joined        xhat+ = F xhat + B~ u + L~ y~
//! innovation    xhat+ = A~ xhat + B~ u + L~ z,                   z = y~ - C~ xhat
//! cubic         xhat+ = A~ (xhat - N~ i) + B~ u + L~ j,          i = z (1 - r)/w,  j = r z,  r = 1/sqrt(1 + 2 w h max(z'theta z, 0))
//! ```
//! Matrices with a tilde are those stored on the target ([`Format::stored`]: to nearest, ties to even), F is the
//! rounding of `A - L~ C`, and y~ the measurement rounded into the format of the computation. The input u is a number
//! of that format, and the plant receives exactly that number. F is the exact `A - L~ C` rounded **once**: computed in
//! binary64 it would be rounded twice, and might not be the nearest number of the format.
//!
//! # Stored matrices, exact arithmetic
//! Without rounding errors and with the plant's matrices equal to the stored ones, the error `e = x - xhat` obeys
//! `e+ = F e` with `F = A~ - L~ C~`, and `F'PF - P < 0`, `P > 0` are decided exactly for the stored numbers. For the
//! cubic observer, with `1 - r = w g`,
//! ```text
//! e+ = M(g) e,    M(g) = A~ - L~ C~ + g (A~ N~ + w L~) C~,    0 <= g < 1/w,
//! for **every N~, theta and h**: since `2 w h max(z'theta z, 0) >= 0`, r is in (0, 1] and g in [0, 1/w), also if theta
//! is not symmetric or not semidefinite, for example after rounding. (Without the maximum, a negative `z'theta z` would
//! give r > 1 or no real r, and V could grow.) M is affine in g and `M'PM` convex: if `M'PM < P` for `g = 0` and for
//! `g = 1/w`, that is
//! and `M'PM` convex: if `M'PM < P` for `g = 0` and for `g = 1/w`, that is
//! ```text
//! F'PF - P < 0    and    (w A~ + A~ N~ C~)' P (w A~ + A~ N~ C~) - w^2 P < 0,
//! ```
//! then V = e'Pe decreases by a fixed factor in every step, from every error. *No structure of N~ is needed*, in
//! particular not `P N~ = -C'S`, which rounding destroys. For the exact gain the second inequality follows from the
//! first: with `N = -P^-1 C'S`, `S = w (C P^-1 C')^-1`, the matrix `I + NC/w` is the P-orthogonal projector onto the
//! kernel of C.
//!
//! # Running, with rounding errors
//! All bounds are bounds of absolute values, entry by entry, affine in |e|: matrices acting on
//! `(1, |e_1|, ..., |e_n|)`, with the bounds of `|x|`, `|u|`, `|v|` given by the caller ([`Operation`]) and
//! `|xhat| <= |x| + |e|`.
//!
//! *One sum.* Let a target compute a sum of k terms, some of which are products, **in any order, as any binary tree,
//! with or without fused multiply-adds**. In floating point each term then passes at most k roundings (its product and
//! k - 1 additions; a fused operation merges two), so that
//! ```text
//! |computed - exact| <= gamma_k sum |terms| + 2 k (1 + gamma_k) tiny,    gamma_k = k u/(1 - k u),    u = 2^-24 or 2^-53,
//! ```
//! (Higham, *Accuracy and Stability of Numerical Algorithms*, 2nd ed., section 3.1), where tiny = 2^-126 or 2^-1022,
//! the smallest normal number, covers both gradual underflow and results flushed to zero. In fixed point additions are
//! exact, and each product has an error of at most half the spacing q, whether it is rounded individually or the sum as
//! a whole: `|computed - exact| <= (products) q/2`. If sums are accumulated without rounding ([`Step::Accumulated`], as
//! `observers::FixedPointObserver` does in 64 bits) there is one rounding per sum, and `|computed - exact| <= q/2` for
//! any length. Truncation is not rounding to nearest and is not covered. (In floating point each of at most k products
//! and k - 1 additions can underflow with an error of tiny, which is amplified by at most 1 + gamma_k.)
//!
//! *One step.* Subtracting the two recursions,
//! ```text
//! joined        e+ = F e + (A - F - L~ C) x + (B - B~) u - L~ (v + d) - s
//! innovation    e+ = F e + (A - A~) x + (B - B~) u - L~ zeta - s
//! cubic         e+ = M(g) e + (A - A~) x + (B - B~) u + (g A~ N~ - r L~) zeta + A~ N~ iota - L~ kappa - A~ m - s
//! ```
//! with d the rounding error of y, `zeta = (C - C~) x + v + d - (error of z)`, s and m the errors of the last sum and
//! of `xhat - N~ i`, and iota, kappa the errors of i and j relative to the exact functions of the *computed* z. In
//! `g A~ N~ - r L~`, `0 <= g <= 1/w` and `0 <= r <= 1`.
//!
//! *The cubic flow.* `observers::cubic::flow` computes from z, with each operation rounded to nearest,
//! ```text
//! s = max |z_k|,   d = z/s,   q = max(d'theta d, 0),   k = 2q h,   b = sqrt(w k),   c = b s,
//! a = sqrt(1 + c c),   p = s/a,   p' = s/(1 + a)     if c <= 1/epsilon,   epsilon = 2u,
//! p = p' = 1/b                                       if c > 1/epsilon,
//! j = p d,   i = (((k p) p') s) d,                   and i = j = z if s = 0.
//! ```
//! (`observers::SampledCubicObserver` uses w = 0 if N = 0, so that c = 0: the linear observer, g = 0.) Let
//! `r = 1/sqrt(1 + c^2)` *with the computed c*. Then r is in (0, 1] whatever the errors before: those of d, q, k and of
//! the roots move g within `[0, 1/w)` and are no disturbance. It remains to bound the errors of i and j for this r,
//! that is of `j = r z` and `w i = (1 - r) z = (c^2/(w s^2)) (s/a) (s/(1 + a)) w z`. Count the factors `1 + delta`,
//! `|delta| <= u`, in numerators or denominators. a has 2: the sum and its square, both under the root, count one half
//! each, the root counts 1. So p has 3 and p' 4; d has 1, and j, one more product, has **5**. If c > 1/epsilon,
//! `b s = c` has 1 and 1/b another; p and p' differ from 1/b by the factors `sqrt(1 + c^-2)` and
//! `c^-1 + sqrt(1 + c^-2)`, which are within 1 and 2 factors: again 3 and 4. In `w k s^2 = c^2` there are 1 for the
//! product under the root, 2 for the root (it is squared) and 2 for c: 5. So i has 5 + 3 + 4, 3 for the products in the
//! parentheses, and 2 for d and the last product: **17**. By Higham's Lemma 3.1, gamma_17 and gamma_5 bound the
//! relative errors.
//!
//! A result below tiny has an absolute error of at most tiny instead. Its effect, with `0 <= p, 2 p' <= s`,
//! `w k p p' <= 1`: on j `tiny s` (d) and `2 tiny` (p, j); on `w i` `tiny (s + w)` (d, i), `tiny s^3/2` (w k), `tiny s`
//! (c), `2 tiny` (p, p': since b is at most the root of the largest number, they are that small only if s is below 3
//! tiny, where c is far below 1) and `w tiny (s^2/2 + s + 1)` (the products in the parentheses). With the factor
//! `1 + gamma`, this is below `4 tiny (1 + s)` for j and below `4 tiny (1 + w)(1 + s)^3` for `w i`.
//!
//! *All steps.* So `|e+ - M e| <= D (1, |e|)` with a matrix D >= 0. Let `|M e|_P <= rho |e|_P` (rho by bisection, each
//! value proved) and `s_i >= sqrt((P^-1)_ii)`, so that `|e_i| <= s_i |e|_P`; let `beta^2 = d'|P|d` for the first column
//! d of D, and `kappa^2 = t'|P|t` for `t = D_rest s`. Then
//! ```text
//! |e+|_P <= (rho + kappa) |e|_P + beta,    limsup |e|_P <= beta/(1 - rho - kappa),
//! ```
//! and the ball `|e|_P <= r` is invariant if r is at least that limit. The components are also bounded by the series
//! `limsup |e| <= sum_{j<k} |F^j| d + s rho^k limsup |e|_P` for each k, and the smallest bound is used; it does not
//! depend on the shape of the ball. Here d is the bound D (1, |e|) at the limit. For the cubic observer, whose map is
//! M(g) and not F, the difference `g (A~ N~ + w L~) C~ e` is added: `g = (1 - r)/w <= c^2/(2w)` is about `h z'theta z`,
//! small near 0. (With these bounds a smaller d holds in the limit, and the series is evaluated again.)
//!
//! *No overflow, no saturation.* For `|e|_P <= r` every partial sum, in any order, is at most the sum of the absolute
//! values of its terms plus the rounding error. The cubic flow is bounded operation by operation: rounding to nearest
//! is monotone, so `|x| <= m` before it gives `|x| <= m (1 + u) + tiny` after it. **Every result of an operation of the
//! step** has such a bound ([`Intermediate`]), and all must lie in the range of the format; a test records the
//! operations of the observers' code and checks that each is listed. The bounds hold for errors that start in the ball.
//!
//! *Uncertain plant.* If the plant is `x+ = (A + dA) x + (B + dB) u` with `|dA|`, `|dB|` bounded entry by entry
//! ([`Deviation`]), possibly different in every step, then e+ has the further terms `dA x + dB u` for each of the
//! observers: D grows by `|dA| |x| + |dB| |u|` in its first column. Nothing else changes: the maps M and the numbers of
//! a step do not depend on the plant's A and B, since y is that of x, and x keeps its bounds.
//!
//! # Not covered
//! Truncation; flushing of subnormal *operands* (none arise if results are flushed; a stored entry might be subnormal);
//! a flow computed otherwise than in `observers::cubic::flow`; the cubic observer in fixed point, whose square root is
//! not specified; a plant other than the given (A, B, C).

mod ball;
mod disturbance;
mod format;

pub use crate::verdict::NoErrorBallReason;
pub use ball::{ErrorBall, Intermediate, Running};
pub use format::{Format, Formats};

use super::{Expression, embed, embed_symmetric, number, positive, stein_decrease};
use crate::definite::{Direction, Sense};
use crate::error::ProofError;
use crate::exact::Exact;
use crate::interval::Interval;
use crate::matrix::Matrix;
use crate::ring::Ring;
use crate::verdict::Verdict;
use disturbance::Disturbance;

/// The exact plant `x+ = A x + B u`, `y = C x + v`: A n x n, B n x m, C p x n.
#[derive(Debug, Clone, PartialEq)]
pub struct SampledPlant {
    /// State matrix.
    pub a: Matrix<f64>,
    /// Input matrix.
    pub b: Matrix<f64>,
    /// Output matrix.
    pub c: Matrix<f64>,
}

/// Operating range of the observer, guaranteed by the caller: bounds of absolute values, entry by entry.
#[derive(Debug, Clone, PartialEq)]
pub struct Operation {
    /// Bounds of `|x_i|`, n numbers.
    pub state: Vec<f64>,
    /// Bounds of `|u_j|`, m numbers.
    pub input: Vec<f64>,
    /// Bounds of `|v_k|` of the measurement noise, p numbers, without the rounding of y into the format.
    pub noise: Vec<f64>,
    /// Bounds of `|e_i|` at the start, n numbers.
    pub error: Vec<f64>,
    /// Bounds of the deviation of the plant from A and B, possibly different in every step; `None` for an exact plant.
    pub deviation: Option<Deviation>,
}

/// `x+ = (A + dA) x + (B + dB) u` with `|dA| <= a` and `|dB| <= b`, entry by entry.
#[derive(Debug, Clone, PartialEq)]
pub struct Deviation {
    /// Bounds of `|dA|`, n x n.
    pub a: Matrix<f64>,
    /// Bounds of `|dB|`, n x m.
    pub b: Matrix<f64>,
}

/// Formula of the step of a linear observer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Step {
    /// `xhat+ = F xhat + B u + L y`, with F the exact `A - L C` (A and C of the plant, L as stored) rounded once.
    Joined,
    /// `xhat+ = A xhat + B u + L (y - C xhat)`, as `observers::DiscreteLinearObserver` does.
    Innovation,
    /// As [`Step::Innovation`], with `y - C xhat` and `A xhat + B u + L z` each accumulated without rounding and then
    /// rounded once, as `observers::FixedPointObserver` does.
    Accumulated,
}

/// Matrices stored on the target; each entry is a number of the format.
#[derive(Debug, Clone, PartialEq)]
pub struct Stored {
    /// A, or F for [`Step::Joined`].
    pub a: Matrix<f64>,
    /// Input matrix.
    pub b: Matrix<f64>,
    /// Output matrix; for [`Step::Joined`], where it is not stored, that of the plant.
    pub c: Matrix<f64>,
    /// Gain.
    pub l: Matrix<f64>,
    /// Cubic part.
    pub cubic: Option<CubicGains>,
}

impl Stored {
    /// The largest magnitude of a stored number.
    fn largest(&self) -> f64 {
        let mut matrices = vec![&self.a, &self.b, &self.c, &self.l];
        let mut scalars = Vec::new();
        if let Some(cubic) = &self.cubic {
            matrices.extend([&cubic.n, &cubic.theta]);
            scalars.extend([cubic.w, cubic.h]);
        }
        let entries = matrices.into_iter().flat_map(|m| m.as_slice().iter().copied());
        entries.chain(scalars).fold(0.0, |largest, x| largest.max(x.abs()))
    }
}

/// The cubic part of a sampled cubic observer.
#[derive(Debug, Clone, PartialEq)]
pub struct CubicGains {
    /// Gain N, n x p.
    pub n: Matrix<f64>,
    /// Weight theta, p x p.
    pub theta: Matrix<f64>,
    /// The rate w of `C N = -w I`, positive; the stored N may satisfy this only approximately.
    pub w: f64,
    /// The sampling period h.
    pub h: f64,
}

/// Results for a deployed observer.
#[derive(Debug, Clone, PartialEq)]
pub struct Deployed {
    /// The numbers stored on the target, to which the verdicts refer.
    pub stored: Stored,
    /// `P > 0`.
    pub positive: Verdict<Direction>,
    /// `F'PF - P < 0` for the stored matrices, exactly.
    pub decrease: Verdict<Direction>,
    /// For the cubic observer also `(w A + A N C)'P(w A + A N C) - w^2 P < 0`, exactly, with all matrices as stored.
    pub saturated: Option<Verdict<Direction>>,
    /// Invariant ball and ultimate bound of the error, rounding errors included.
    pub running: Running,
}

impl Deployed {
    /// Whether the observer with the stored matrices converges in exact arithmetic from every initial error.
    pub fn is_stable(&self) -> bool {
        self.positive.is_proved() && self.decrease.is_proved() && self.saturated.as_ref().is_none_or(Verdict::is_proved)
    }

    /// The invariant ball and ultimate bound, if they are proved.
    pub fn ball(&self) -> Option<&ErrorBall> {
        match &self.running {
            Running::Within(ball) => Some(ball),
            Running::Unproved(_) => None,
        }
    }
}

/// The linear observer with gain `l` (n x p), with matrices stored and steps computed in the given formats.
///
/// `p` is a symmetric n x n matrix that should prove the stability of the *stored* error matrix. The better it is
/// conditioned and the faster its quadratic form decreases, the smaller the ball. A refuted decrease means that this P
/// does not prove stability, not that the observer is unstable. The theory is in the head of this module.
///
/// ```
/// use luenberger_proof::Matrix;
/// use luenberger_proof::statement::{Format, Operation, SampledPlant, Step, deployed_linear};
/// # fn main() -> Result<(), luenberger_proof::ProofError> {
/// // x+ = 0.9 x, observed with l = 0.4: e+ = 0.5 e, in f32 and in a byte.
/// let number = |x: f64| Matrix::from_rows([[x]]);
/// let plant = SampledPlant { a: number(0.9), b: Matrix::from_fn(1, 0, |_, _| 0.0), c: number(1.0) };
/// let meets = Operation { state: vec![1.0], input: vec![], noise: vec![0.0], error: vec![1.0], deviation: None };
/// let single = deployed_linear(&plant, &number(0.4), &number(1.0), Step::Innovation, Format::Binary32.into(), &meets)?;
/// assert!(single.is_stable() && single.ball().expect("proved").entries[0] < 1e-6);
/// let byte = Format::Fixed { integer_bits: 4, fraction_bits: 4 };
/// let byte = deployed_linear(&plant, &number(0.4), &number(1.0), Step::Innovation, byte.into(), &meets)?;
/// assert!(byte.is_stable() && byte.ball().expect("proved").entries[0] < 0.25);
/// # Ok(())
/// # }
/// ```
/// # Errors
/// [`ProofError`] for inconsistent shapes, entries that are not finite or that the format cannot store, a P that is not
/// symmetric, negative bounds, or an unsupported format.
pub fn deployed_linear(
    plant: &SampledPlant,
    l: &Matrix<f64>,
    p: &Matrix<f64>,
    step: Step,
    formats: Formats,
    operation: &Operation,
) -> Result<Deployed, ProofError> {
    check(plant, l, p, formats, operation)?;
    let l = formats.stored.stored(l, "L")?;
    let stored = match step {
        Step::Joined => {
            let lc = Matrix::<Exact>::embed(&l, "L")?.product(&Matrix::embed(&plant.c, "C")?)?;
            let f = Matrix::<Exact>::embed(&plant.a, "A")?.difference(&lc)?;
            Stored {
                a: formats.stored.stored_exact(&f, "A - LC")?,
                b: formats.stored.stored(&plant.b, "B")?,
                c: plant.c.clone(),
                l,
                cubic: None,
            }
        }
        Step::Innovation | Step::Accumulated => Stored {
            a: formats.stored.stored(&plant.a, "A")?,
            b: formats.stored.stored(&plant.b, "B")?,
            c: formats.stored.stored(&plant.c, "C")?,
            l,
            cubic: None,
        },
    };
    let decrease = match step {
        Step::Joined => {
            let none = (Matrix::from_fn(p.rows(), 0, |_, _| 0.0), Matrix::from_fn(0, p.rows(), |_, _| 0.0));
            stein_decrease(&stored.a, &none.0, &none.1, p)?
        }
        Step::Innovation | Step::Accumulated => stein_decrease(&stored.a, &stored.l, &stored.c, p)?,
    };
    let disturbance = Disturbance { plant, stored: &stored, step, format: formats.running, operation };
    let positive = positive(p)?;
    let running = if positive.is_proved() && decrease.is_proved() {
        ball::running(p, &disturbance)?
    } else {
        Running::Unproved(NoErrorBallReason::NotStable)
    };
    Ok(Deployed { stored, positive, decrease, saturated: None, running })
}

/// The sampled cubic observer with gains `l` and `cubic`, with matrices stored and steps computed in the given formats.
///
/// As [`deployed_linear`], for the step of `observers::SampledCubicObserver`. In fixed point only the stored
/// matrices are verified, not the running observer. The theory is in the head of this module, including the reason why
/// two Stein inequalities suffice for a rounded N.
/// # Errors
/// As [`deployed_linear`], and for a stored `w` or `h` that is not positive.
pub fn deployed_sampled_cubic(
    plant: &SampledPlant,
    l: &Matrix<f64>,
    cubic: &CubicGains,
    p: &Matrix<f64>,
    formats: Formats,
    operation: &Operation,
) -> Result<Deployed, ProofError> {
    check(plant, l, p, formats, operation)?;
    let (n, outputs) = l.shape();
    cubic.n.expect_shape("N", (n, outputs))?;
    cubic.theta.expect_shape("theta", (outputs, outputs))?;
    let scalar = |x: f64, name, what| {
        let stored = formats.stored.stored(&Matrix::from_rows([[x]]), name)?[(0, 0)];
        if stored > 0.0 { Ok(stored) } else { Err(ProofError::Sign { what, value: stored }) }
    };
    let stored = Stored {
        a: formats.stored.stored(&plant.a, "A")?,
        b: formats.stored.stored(&plant.b, "B")?,
        c: formats.stored.stored(&plant.c, "C")?,
        l: formats.stored.stored(l, "L")?,
        cubic: Some(CubicGains {
            n: formats.stored.stored(&cubic.n, "N")?,
            theta: formats.stored.stored(&cubic.theta, "theta")?,
            w: scalar(cubic.w, "w", "w, which should be positive as stored,")?,
            h: scalar(cubic.h, "h", "h, which should be positive as stored,")?,
        }),
    };
    let positive = positive(p)?;
    let decrease = stein_decrease(&stored.a, &stored.l, &stored.c, p)?;
    let saturated = match &stored.cubic {
        Some(cubic) => saturated_decrease(&stored.a, &stored.c, &cubic.n, cubic.w, p)?,
        None => decrease.clone(),
    };
    let disturbance =
        Disturbance { plant, stored: &stored, step: Step::Innovation, format: formats.running, operation };
    let running = if !(positive.is_proved() && decrease.is_proved() && saturated.is_proved()) {
        Running::Unproved(NoErrorBallReason::NotStable)
    } else if matches!(formats.running, Format::Fixed { .. }) {
        Running::Unproved(NoErrorBallReason::RootInFixedPoint)
    } else {
        ball::running(p, &disturbance)?
    };
    Ok(Deployed { stored, positive, decrease, saturated: Some(saturated), running })
}

struct Saturated<'a> {
    a: &'a Matrix<f64>,
    c: &'a Matrix<f64>,
    n: &'a Matrix<f64>,
    w: f64,
    p: &'a Matrix<f64>,
}

impl Saturated<'_> {
    /// `w A + A N C`.
    fn map<R: Ring>(&self) -> Result<Matrix<R>, ProofError> {
        let order = self.a.rows();
        let a = embed::<R>(self.a, "A", (order, order))?;
        let c = embed::<R>(self.c, "C", (self.c.rows(), order))?;
        let n = embed::<R>(self.n, "N", (order, self.c.rows()))?;
        a.product(&Matrix::scalar(order, &number(self.w, "w")?).sum(&n.product(&c)?)?)
    }
}

impl Expression for Saturated<'_> {
    fn evaluate<R: Ring>(&self) -> Result<Matrix<R>, ProofError> {
        let order = self.a.rows();
        let p = embed_symmetric::<R>(self.p, "P", order)?;
        let w = number::<R>(self.w, "w")?;
        self.map::<R>()?.congruence(&p)?.difference(&p.scaled(&w.mul(&w)))
    }
}

/// `(w A + A N C)'P(w A + A N C) - w^2 P < 0`: the error map of the sampled cubic observer decreases V in the limit of
/// a strong cubic correction, `g = 1/w`, for N and w exactly as given.
///
/// A n x n and C p x n of the sampled plant, N n x p, w > 0. Together with [`stein_decrease`] of the same A, C and P
/// and with [`positive`] of P it proves exponential convergence of the observer with this N from every error. The proof
/// is in the head of the module; no other property of N is needed.
/// # Errors
/// [`ProofError`] for inconsistent shapes, entries that are not finite, or a `P` that is not symmetric.
pub fn saturated_decrease(
    a: &Matrix<f64>,
    c: &Matrix<f64>,
    n: &Matrix<f64>,
    w: f64,
    p: &Matrix<f64>,
) -> Result<Verdict<Direction>, ProofError> {
    Saturated { a, c, n, w, p }.decide(Sense::NegativeDefinite)
}

fn check(
    plant: &SampledPlant,
    l: &Matrix<f64>,
    p: &Matrix<f64>,
    formats: Formats,
    operation: &Operation,
) -> Result<(), ProofError> {
    formats.stored.check()?;
    formats.running.check()?;
    let (n, m, outputs) = (plant.a.rows(), plant.b.cols(), plant.c.rows());
    embed::<Interval>(&plant.a, "A", (n, n))?;
    embed::<Interval>(&plant.b, "B", (n, m))?;
    embed::<Interval>(&plant.c, "C", (outputs, n))?;
    embed::<Interval>(l, "L", (n, outputs))?;
    embed_symmetric::<Interval>(p, "P", n)?;
    let lists = [
        (&operation.state, n, "the bound of the state", "a bound of the state, which should not be negative,"),
        (&operation.input, m, "the bound of the input", "a bound of the input, which should not be negative,"),
        (&operation.noise, outputs, "the bound of the noise", "a bound of the noise, which should not be negative,"),
        (
            &operation.error,
            n,
            "the bound of the first error",
            "a bound of the first error, which should not be negative,",
        ),
    ];
    for (list, length, name, sign) in lists {
        if list.len() != length {
            return Err(ProofError::DimensionMismatch { what: name, expected: (length, 1), found: (list.len(), 1) });
        }
        if let Some(&value) = list.iter().find(|x| !(x.is_finite() && **x >= 0.0)) {
            return Err(ProofError::Sign { what: sign, value });
        }
    }
    if let Some(Deviation { a, b }) = &operation.deviation {
        a.expect_shape("the bound of the deviation of A", (n, n))?;
        b.expect_shape("the bound of the deviation of B", (n, m))?;
        let what = "a bound of a deviation, which should not be negative,";
        if let Some(&value) = a.as_slice().iter().chain(b.as_slice()).find(|x| !(x.is_finite() && **x >= 0.0)) {
            return Err(ProofError::Sign { what, value });
        }
    }
    Ok(())
}
