//! The deployed observer: its matrices as stored on the target, with the rounding errors of every step.
//!
//! The plant is `x+ = A x + B u`, `y = C x + v` with given real matrices A, B, C (binary64 numbers, taken as exact) and
//! measurement noise v. The observer is linear, with an innovation or with `F = A - LC` formed before, or the sampled
//! cubic one. Matrices are stored in a [`Format`], to nearest, ties to even. Decided are a decrease of `V = e'Pe` for
//! the stored numbers in exact arithmetic, and a ball for the error of the steps as they run. The theorems and their
//! proofs are in `docs/theory-deployed.md`.

mod ball;
mod disturbance;
mod format;

pub use crate::verdict::NoErrorBallReason;
#[cfg(feature = "all-theorems")]
pub(crate) use ball::RunningBound;
pub use ball::{ErrorBall, Intermediate, Running};
pub use format::{Format, Formats};

use super::{embed, embed_symmetric, positive, stein_decrease};
use crate::definite::Direction;
use crate::error::ProofError;
use crate::exact::Exact;
use crate::interval::Interval;
use crate::label::Names;
use crate::matrix::Matrix;
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
/// does not prove stability, not that the observer is unstable. The theory is in `docs/theory-deployed.md`.
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
/// matrices are verified, not the running observer. The theory is in `docs/theory-deployed.md`, including the reason
/// why two Stein inequalities suffice for a rounded N.
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

#[cfg(feature = "all-theorems")]
/// The numbers by which the ball of a deployed observer is proved, if it has one.
pub(crate) fn running_bound(
    plant: &SampledPlant,
    deployed: &Deployed,
    p: &Matrix<f64>,
    step: Step,
    format: Format,
    operation: &Operation,
) -> Result<Option<RunningBound>, ProofError> {
    let Some(ball) = deployed.ball() else { return Ok(None) };
    let disturbance = Disturbance { plant, stored: &deployed.stored, step, format, operation };
    ball::running_bound(p, &disturbance, ball)
}

/// `(w A + A N C)'P(w A + A N C) - w^2 P < 0`: the error map of the sampled cubic observer decreases V in the limit of
/// a strong cubic correction, `g = 1/w`, for N and w exactly as given.
///
/// A n x n and C p x n of the sampled plant, N n x p, w > 0. Together with [`stein_decrease`] of the same A, C and P
/// and with [`positive`] of P it proves exponential convergence of the observer with this N from every error. The proof
/// is in `docs/theory-deployed.md`; no other property of N is needed.
/// # Errors
/// [`ProofError`] for inconsistent shapes, entries that are not finite, or a `P` that is not symmetric.
pub fn saturated_decrease(
    a: &Matrix<f64>,
    c: &Matrix<f64>,
    n: &Matrix<f64>,
    w: f64,
    p: &Matrix<f64>,
) -> Result<Verdict<Direction>, ProofError> {
    let names = Names::new().matrix("A", a).matrix("C", c).matrix("N", n).number("w", w).symmetric("P", p);
    names.decide("(wA + ANC)'P(wA + ANC) - w^2 P < 0")
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
