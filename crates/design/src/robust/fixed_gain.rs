//! Certificates for a given cubic gain without P, and the margin with N fixed and P free.
//!
//! `sup eps : P > 0, (F + eps I)'P + P(F + eps I) < 0, P N = -C'S, S + S' > 0`, `F = A - L C`, a generalised eigenvalue
//! problem. The equation is solved away: for C N invertible, `P N = -C'S` holds iff `P = C'G C + T'Y T` with `T N = 0`
//! (T of n - p rows) and `S = -G C N`, G and Y symmetric. What is left is linear in G and Y.
//!
//! F and C N are computed exactly where needed; T is exact for one output and for as many outputs as states, and
//! rounded in between. The result carries the properties that are then proved for A, L, C and N as stored;
//! non-existence of P is claimed only if all numbers of the inequality are exact and its multipliers are verified, or
//! if exact arithmetic finds an unstable eigenvalue of C N.

use luenberger_linalg::{RealMatrixView, spectral_abscissa, symmetric_part};
use luenberger_lmi::{Expression, Infeasibility, Problem, greatest_parameter, he};
use luenberger_plants::StateSpace;
use luenberger_proof::certificate::Certificate;
use luenberger_proof::statement::hurwitz_spectrum;
use luenberger_proof::{Exact, Matrix, Ring, Verdict};
use nalgebra::DMatrix;

use crate::certificate::certified;
use crate::check;
use crate::cubic;
use crate::error::{DesignError, InfeasibilityReason};

certified!(GainCertificate);

/// A P (and S) for gains given without one, with the certificate.
#[readonly::make]
#[derive(Debug, Clone, PartialEq)]
pub struct GainCertificate {
    /// The plant: with `A + margin I` as rounded, if a margin was specified.
    pub plant: StateSpace,
    /// The gain L.
    pub l: DMatrix<f64>,
    /// The gain N.
    pub n: DMatrix<f64>,
    /// `P > 0` of (12).
    pub p: DMatrix<f64>,
    /// S, `P N = -C'S` up to rounding.
    pub s: DMatrix<f64>,
    /// `P > 0` and (12) for A, L and C as stored, and from which errors the observer with N as stored converges
    /// (`theta = I`).
    pub certificate: Certificate,
}

/// The robustness margin of a cubic observer with given gains.
///
/// The margin is one of the error dynamics `e' = (F + eps I) e + (y~'theta y~) N y~`. An observer that runs the nominal
/// A on a plant with `A + eps I` has the forcing `eps x` besides: its error is input-to-state stable, and tends to zero
/// only if x does.
#[derive(Debug, Clone, PartialEq)]
pub struct FixedGainMargin {
    /// The greatest eps found feasible.
    pub margin: f64,
    /// The least eps tried that was not; the supremum lies between the two when `refuted`.
    pub stopped_at: Option<f64>,
    /// Whether the inequality at `stopped_at` was refuted, by multipliers verified for the numbers as stored (else it
    /// stayed undecided).
    pub refuted: bool,
    /// The certificate at `margin`, for `A + margin I` as rounded.
    pub at_margin: GainCertificate,
}

/// The supremum of eps, to within `tolerance`, for which some `P > 0` proves the observer with gains L and N at
/// `A + eps I`.
///
/// L and N are n x p, C of full row rank. Cost: one SDP of about `n^2/2` unknowns for each of `log2(range / tolerance)`
/// bisection steps.
///
/// # Errors
/// [`DesignError::NotHurwitz`] when `A - L C` is not; [`DesignError::Infeasible`] when `C N` has an eigenvalue of
/// positive real part, decided exactly, so that no P allows this N at any eps; [`DesignError::DegenerateGain`] when C N
/// is not Hurwitz and that real part is zero up to rounding; [`DesignError::DependentOutputs`];
/// [`DesignError::Undecided`] when no eps could be proved.
pub fn fixed_gain_margin<'a>(
    plant: &StateSpace,
    l: impl Into<RealMatrixView<'a>>,
    n_gain: impl Into<RealMatrixView<'a>>,
    tolerance: f64,
) -> Result<FixedGainMargin, DesignError> {
    check::positive("tolerance", tolerance)?;
    let (l, n_gain) = (&check::owned(l), &check::owned(n_gain));
    let family = Family::new(plant, l, n_gain)?;
    let high = -check::hurwitz("A - L C", (&plant.a, l, &plant.c))?;
    let low = family.feasible_below(high)?;
    let bisection = greatest_parameter(low, high, tolerance, |eps| family.at(eps))?;
    let Some((margin, solution)) = bisection.proved else {
        return Err(family.not_proved(bisection.stopped.map(|(_, verdict)| verdict)));
    };
    Ok(FixedGainMargin {
        margin,
        stopped_at: bisection.stopped.as_ref().map(|(eps, _)| *eps),
        refuted: bisection.stopped.is_some_and(|(_, verdict)| verdict.is_refuted() && family.exact),
        at_margin: family.certify(margin, |name| solution.named(name).cloned())?,
    })
}

/// A `P > 0` that proves the observer with gains L and N: (12) and (13').
///
/// # Errors
/// As [`fixed_gain_margin`]; [`DesignError::Infeasible`] also with verified multipliers that exclude every P;
/// [`DesignError::RefutedAsRounded`] with such that exclude it only for T as rounded.
pub fn certify_gain<'a>(
    plant: &StateSpace,
    l: impl Into<RealMatrixView<'a>>,
    n_gain: impl Into<RealMatrixView<'a>>,
) -> Result<GainCertificate, DesignError> {
    let (l, n_gain) = (&check::owned(l), &check::owned(n_gain));
    let family = Family::new(plant, l, n_gain)?;
    check::hurwitz("A - L C", (&plant.a, l, &plant.c))?;
    let solution = family.at(0.0).solve()?;
    if solution.verdict.is_proved() {
        family.certify(0.0, |name| solution.named(name).cloned())
    } else {
        Err(family.not_proved(Some(solution.verdict)))
    }
}

/// The inequality in G and Y, for every eps.
struct Family<'a> {
    plant: &'a StateSpace,
    l: &'a DMatrix<f64>,
    n_gain: &'a DMatrix<f64>,
    f: DMatrix<f64>,
    cn: DMatrix<f64>,
    t: DMatrix<f64>,
    /// Whether `T N = 0` without rounding.
    exact: bool,
}

impl<'a> Family<'a> {
    fn new(plant: &'a StateSpace, l: &'a DMatrix<f64>, n_gain: &'a DMatrix<f64>) -> Result<Self, DesignError> {
        check::plant(plant)?;
        let c = &plant.c;
        let (n, outputs) = (plant.a.nrows(), c.nrows());
        check::matrix("L", l, (n, outputs))?;
        check::matrix("N", n_gain, (n, outputs))?;
        check::independent_outputs(c)?;
        let cn = c * n_gain;
        let abscissa = spectral_abscissa(&cn)?;
        let exact_cn = check::exactly(c)?.product(&check::exactly(n_gain)?)?;
        // Eigenvalues of a defective C N are known to a root of the rounding only: exact arithmetic decides.
        if abscissa > 0.0 && has_eigenvalue_beyond(&exact_cn, 0.5 * abscissa) {
            return Err(DesignError::Infeasible { what: WHAT, reason: InfeasibilityReason::SignOfCn(abscissa) });
        }
        if hurwitz_spectrum(&exact_cn).map_or(abscissa >= 0.0, |stable| !stable) {
            return Err(DesignError::DegenerateGain { real_part: abscissa });
        }
        let t = orthogonal_rows(n_gain);
        let exact = check::exactly(&t)?.product(&check::exactly(n_gain)?)?.as_slice().iter().all(Ring::is_zero);
        Ok(Self { plant, l, n_gain, f: &plant.a - l * c, cn, t, exact })
    }

    /// The error for a verdict. A refutation with rounded T is not a refutation.
    fn not_proved(&self, verdict: Option<Verdict<Infeasibility>>) -> DesignError {
        match verdict {
            Some(Verdict::Refuted { witness }) if !self.exact => {
                DesignError::RefutedAsRounded { what: WHAT, rounded: "T N = 0", witness }
            }
            other => DesignError::not_proved(WHAT, other),
        }
    }

    fn at(&self, eps: f64) -> Problem {
        let c = &self.plant.c;
        let (n, outputs) = (self.f.nrows(), c.nrows());
        let mut lmi = Problem::new();
        let g = lmi.symmetric("G", outputs);
        let mut p: Expression = c.transpose() * &g * c;
        if n > outputs {
            let y = lmi.symmetric("Y", n - outputs);
            p = p + self.t.transpose() * &y * &self.t;
        }
        // The factors one by one: what is refuted is then refuted for exactly these numbers.
        let half = &p * &self.plant.a - &p * self.l * c;
        lmi.constrain("P > 0", &p >> 0.0);
        lmi.constrain("decrease", (he(half) + (2.0 * eps) * &p) << 0.0);
        lmi.constrain("S + S' > 0", he(&g * c * self.n_gain) << 0.0);
        lmi
    }

    /// Some eps at which the inequality is proved: any P of the form serves once F + eps I is dissipative enough, which
    /// can be far to the left when C and N are nearly orthogonal.
    fn feasible_below(&self, high: f64) -> Result<f64, DesignError> {
        let scale = self.f.norm().max(high.abs()).max(f64::MIN_POSITIVE);
        let mut last = None;
        for doubling in 0..40 {
            let eps = high - scale * f64::powi(2.0, doubling);
            let verdict = self.at(eps).solve()?.verdict;
            if verdict.is_proved() {
                return Ok(eps);
            }
            last = Some(verdict);
        }
        Err(self.not_proved(last))
    }

    fn certify(&self, eps: f64, value: impl Fn(&str) -> Option<DMatrix<f64>>) -> Result<GainCertificate, DesignError> {
        let c = &self.plant.c;
        let (n, outputs) = (self.f.nrows(), c.nrows());
        let g = value("G").unwrap_or_else(|| DMatrix::zeros(outputs, outputs));
        let mut p = c.transpose() * &g * c;
        if let Some(y) = value("Y") {
            p += self.t.transpose() * y * &self.t;
        }
        let p = symmetric_part(&p);
        let s = -(g * &self.cn);
        let mut shifted = self.plant.clone();
        shifted.a += DMatrix::identity(n, n) * eps;
        let theta = DMatrix::identity(outputs, outputs);
        let theorem = cubic::theorem((&shifted.a, &shifted.b, c), (self.l, self.n_gain, &theta), (&p, &s), 0.0);
        let certificate = theorem.certify()?;
        let (l, n) = (self.l.clone(), self.n_gain.clone());
        Ok(GainCertificate { plant: shifted, l, n, p, s, certificate })
    }
}

/// Whether a matrix has an eigenvalue of real part `bound` or more, decided exactly.
fn has_eigenvalue_beyond(m: &Matrix<Exact>, bound: f64) -> bool {
    let Some(bound) = Exact::from_f64(bound) else { return false };
    let shifted =
        Matrix::from_fn(m.rows(), m.cols(), |i, j| if i == j { m[(i, j)].sub(&bound) } else { m[(i, j)].clone() });
    hurwitz_spectrum(&shifted) == Some(false)
}

/// T of full row rank with `T N = 0`, for N of full column rank. For a single column with entries of N itself, without
/// rounding; else the last columns of the full Q factor of N.
pub(crate) fn orthogonal_rows(n_gain: &DMatrix<f64>) -> DMatrix<f64> {
    let (n, outputs) = n_gain.shape();
    if outputs == 1 {
        // N_k e_j - N_j e_k, with the largest N_k.
        let k = n_gain.column(0).icamax();
        return DMatrix::from_fn(n - 1, n, |row, column| {
            let j = if row < k { row } else { row + 1 };
            if column == j {
                n_gain[(k, 0)]
            } else if column == k {
                -n_gain[(j, 0)]
            } else {
                0.0
            }
        });
    }
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
    // An entry that is rounding would be taken for a coefficient in small units.
    q.columns(outputs, n - outputs).transpose().map(|x| if x.abs() < 4.0 * n as f64 * f64::EPSILON { 0.0 } else { x })
}

const WHAT: &str = "P > 0, (F + eps I)'P + P(F + eps I) < 0, P N = -C'S, S + S' > 0";
