//! The margin with N fixed and P free: a generalised eigenvalue problem.
//!
//! `sup eps : P > 0, (F + eps I)'P + P(F + eps I) < 0, P N = -C'S, S + S' > 0`. The equation is solved away: for N of full
//! column rank and `C N` invertible, `P N = -C'S` holds iff `P = C'G C + T'Y T` with `T N = 0` (T of n - p rows) and `S = -G C N`, G and
//! Y symmetric. What is left is linear in G and Y, and strictly feasible wherever it is feasible.

use luenberger_linalg::spectral_abscissa;
use luenberger_lmi::{Expression, Infeasibility, Problem, greatest_parameter, he};
use luenberger_proof::{Doubt, Verdict};
use nalgebra::DMatrix;

use crate::check;
use crate::error::{DesignError, Obstruction};

/// Where the proof of a cubic observer with given gains ends.
#[derive(Debug, Clone, PartialEq)]
pub struct FixedGainMargin {
    /// The greatest eps proved.
    pub margin: f64,
    /// The least eps tried that was not proved; the supremum lies between the two when `refuted`.
    pub stopped_at: Option<f64>,
    /// Whether the inequality at `stopped_at` was refuted (else it stayed undecided).
    pub refuted: bool,
    /// P at `margin`.
    pub p: DMatrix<f64>,
    /// S at `margin`, `P N = -C'S` up to rounding.
    pub s: DMatrix<f64>,
}

/// The supremum of eps, to within `tolerance`, for which some `P > 0` proves the observer with gains L and N at `A + eps I`.
///
/// `f = A - L C` is n x n, `c` p x n of full row rank, `n_gain` n x p of full column rank. Cost: one SDP of about `n^2/2` unknowns for each of
/// `log2(range / tolerance)` bisection steps.
///
/// # Errors
/// [`DesignError::NotHurwitz`] when F is not; [`DesignError::Infeasible`] when `C N` has an eigenvalue that is not in the open left half plane, so that
/// no P allows this N even at `eps = -inf`; [`DesignError::DependentOutputs`].
pub fn fixed_gain_margin(
    f: &DMatrix<f64>,
    c: &DMatrix<f64>,
    n_gain: &DMatrix<f64>,
    tolerance: f64,
) -> Result<FixedGainMargin, DesignError> {
    check::positive("tolerance", tolerance)?;
    let high = -check::hurwitz("A - L C", f)?;
    let family = Family::new(f, c, n_gain)?;
    // Far to the left F + eps I is so dissipative that any P of the form serves; the bracket starts there.
    let low = high - 4.0 * f.norm();
    let bisection = greatest_parameter(low, high, tolerance, |eps| family.at(eps))?;
    let Some((margin, solution)) = bisection.proved else {
        return Err(not_proved(bisection.stopped.map(|(_, verdict)| verdict)));
    };
    let (p, s) = family.read(|name| solution.named(name).cloned());
    Ok(FixedGainMargin {
        margin,
        stopped_at: bisection.stopped.as_ref().map(|(eps, _)| *eps),
        refuted: bisection.stopped.is_some_and(|(_, verdict)| verdict.is_refuted()),
        p,
        s,
    })
}

/// A `P > 0` (and S) that proves the observer with gains L and N: (12) and (13') with `P N = -C'S` up to rounding.
///
/// # Errors
/// [`DesignError::Infeasible`] with the quantity that excludes every P: the sign of `C N`, or a verified dual.
pub fn lyapunov_matrix_for_gain(
    f: &DMatrix<f64>,
    c: &DMatrix<f64>,
    n_gain: &DMatrix<f64>,
) -> Result<(DMatrix<f64>, DMatrix<f64>), DesignError> {
    check::hurwitz("A - L C", f)?;
    let family = Family::new(f, c, n_gain)?;
    let solution = family.at(0.0).solve()?;
    if solution.verdict.is_proved() {
        Ok(family.read(|name| solution.named(name).cloned()))
    } else {
        Err(not_proved(Some(solution.verdict)))
    }
}

/// The inequality in G and Y, for every eps.
struct Family {
    f: DMatrix<f64>,
    c: DMatrix<f64>,
    cn: DMatrix<f64>,
    t: DMatrix<f64>,
}

impl Family {
    fn new(f: &DMatrix<f64>, c: &DMatrix<f64>, n_gain: &DMatrix<f64>) -> Result<Self, DesignError> {
        let (n, outputs) = (f.nrows(), c.nrows());
        check::matrix("C", c, (outputs, n))?;
        check::matrix("N", n_gain, (n, outputs))?;
        check::independent_outputs(c)?;
        let cn = c * n_gain;
        let abscissa = spectral_abscissa(&cn)?;
        if abscissa >= 0.0 {
            return Err(DesignError::Infeasible { what: WHAT, reason: Obstruction::SignOfCn(abscissa) });
        }
        // C N is invertible, so N has full column rank, and the last n - p columns of its full Q factor are orthogonal to it.
        let full = DMatrix::from_fn(n, n + outputs, |i, j| {
            if j < outputs {
                n_gain[(i, j)]
            } else if i == j - outputs {
                1.0
            } else {
                0.0
            }
        });
        let q = full.qr().q();
        let t = q.columns(outputs, n - outputs).transpose();
        Ok(Self { f: f.clone(), c: c.clone(), cn, t })
    }

    fn at(&self, eps: f64) -> Problem {
        let (n, outputs) = (self.f.nrows(), self.c.nrows());
        let mut lmi = Problem::new();
        let g = lmi.symmetric("G", outputs);
        let mut p: Expression = self.c.transpose() * &g * &self.c;
        if n > outputs {
            let y = lmi.symmetric("Y", n - outputs);
            p = p + self.t.transpose() * &y * &self.t;
        }
        let shifted = &self.f + DMatrix::identity(n, n) * eps;
        lmi.constrain("P > 0", &p >> 0.0);
        lmi.constrain("decrease", he(&p * &shifted) << 0.0);
        lmi.constrain("S + S' > 0", he(&g * &self.cn) << 0.0);
        lmi
    }

    fn read(&self, value: impl Fn(&str) -> Option<DMatrix<f64>>) -> (DMatrix<f64>, DMatrix<f64>) {
        let outputs = self.c.nrows();
        let g = value("G").unwrap_or_else(|| DMatrix::zeros(outputs, outputs));
        let mut p = self.c.transpose() * &g * &self.c;
        if let Some(y) = value("Y") {
            p += self.t.transpose() * y * &self.t;
        }
        let s = -(g * &self.cn);
        ((&p + p.transpose()) * 0.5, s)
    }
}

/// The error behind a verdict that is not `Proved`.
fn not_proved(verdict: Option<Verdict<Infeasibility>>) -> DesignError {
    match verdict {
        Some(Verdict::Refuted { witness }) => {
            DesignError::Infeasible { what: WHAT, reason: Obstruction::Dual(witness) }
        }
        Some(Verdict::Undecided { why, best }) => DesignError::Undecided { what: WHAT, why, best },
        Some(Verdict::Proved { .. }) | None => {
            DesignError::Undecided { what: WHAT, why: Doubt::NoProposal { status: "nothing was tried" }, best: 0.0 }
        }
    }
}

const WHAT: &str = "P > 0, (F + eps I)'P + P(F + eps I) < 0, P N = -C'S, S + S' > 0";
