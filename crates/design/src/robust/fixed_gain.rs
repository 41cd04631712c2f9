//! Certificates for a cubic gain that came without a P, and the margin with N fixed and P free.
//!
//! `sup eps : P > 0, (F + eps I)'P + P(F + eps I) < 0, P N = -C'S, S + S' > 0`, `F = A - L C`, a generalised eigenvalue problem. The equation is solved
//! away: for C N invertible, `P N = -C'S` holds iff `P = C'G C + T'Y T` with `T N = 0` (T of n - p rows) and `S = -G C N`, G and Y symmetric.
//! What is left is linear in G and Y.
//!
//! The solver proposes P for F, C N and T as rounded; the answer carries what is then proved for A, L, C and N as stored.

use luenberger_linalg::spectral_abscissa;
use luenberger_lmi::{Expression, Problem, greatest_parameter, he};
use luenberger_plants::DynamicPlant;
use luenberger_proof::certificate::Certificate;
use nalgebra::DMatrix;

use crate::certificate::certified;
use crate::check;
use crate::cubic;
use crate::error::{DesignError, Obstruction};

certified!(GainCertificate);

/// A P (and S) for gains that came without one, with what is proved of them.
#[readonly::make]
#[derive(Debug, Clone, PartialEq)]
pub struct GainCertificate {
    /// The plant that it is about: with `A + margin I` as rounded, where a margin was asked for.
    pub plant: DynamicPlant,
    /// The gain L.
    pub l: DMatrix<f64>,
    /// The gain N.
    pub n: DMatrix<f64>,
    /// `P > 0` of (12).
    pub p: DMatrix<f64>,
    /// S, `P N = -C'S` up to rounding.
    pub s: DMatrix<f64>,
    /// `P > 0` and (12) for A, L and C as stored, and from which errors the observer with N as stored converges (`theta = I`).
    pub certificate: Certificate,
}

/// Where the proof of a cubic observer with given gains ends.
///
/// The margin is one of the error dynamics `e' = (F + eps I) e + (y~'theta y~) N y~`. An observer that runs the nominal A on a plant with `A + eps I` has
/// the forcing `eps x` besides: its error is input-to-state stable, and tends to zero only if x does.
#[derive(Debug, Clone, PartialEq)]
pub struct FixedGainMargin {
    /// The greatest eps found feasible.
    pub margin: f64,
    /// The least eps tried that was not; the supremum lies between the two when `refuted`.
    pub stopped_at: Option<f64>,
    /// Whether the inequality at `stopped_at` was refuted (else it stayed undecided).
    pub refuted: bool,
    /// What proves it at `margin`: the certificate is for `A + margin I` as rounded.
    pub at_margin: GainCertificate,
}

/// The supremum of eps, to within `tolerance`, for which some `P > 0` proves the observer with gains L and N at `A + eps I`.
///
/// L and N are n x p, C of full row rank. Cost: one SDP of about `n^2/2` unknowns for each of `log2(range / tolerance)` bisection steps.
///
/// # Errors
/// [`DesignError::NotHurwitz`] when `A - L C` is not; [`DesignError::Infeasible`] when `C N` has an eigenvalue of positive real part, so that no P allows
/// this N at any eps; [`DesignError::DegenerateGain`] when that real part is zero up to rounding; [`DesignError::DependentOutputs`];
/// [`DesignError::Undecided`] when no eps could be proved.
pub fn fixed_gain_margin(
    plant: &DynamicPlant,
    l: &DMatrix<f64>,
    n_gain: &DMatrix<f64>,
    tolerance: f64,
) -> Result<FixedGainMargin, DesignError> {
    check::positive("tolerance", tolerance)?;
    let family = Family::new(plant, l, n_gain)?;
    let high = -check::hurwitz("A - L C", &family.f)?;
    let low = family.feasible_below(high)?;
    let bisection = greatest_parameter(low, high, tolerance, |eps| family.at(eps))?;
    let Some((margin, solution)) = bisection.proved else {
        return Err(DesignError::not_proved(WHAT, bisection.stopped.map(|(_, verdict)| verdict)));
    };
    Ok(FixedGainMargin {
        margin,
        stopped_at: bisection.stopped.as_ref().map(|(eps, _)| *eps),
        refuted: bisection.stopped.is_some_and(|(_, verdict)| verdict.is_refuted()),
        at_margin: family.certify(margin, |name| solution.named(name).cloned())?,
    })
}

/// A `P > 0` that proves the observer with gains L and N: (12) and (13').
///
/// # Errors
/// As [`fixed_gain_margin`]; [`DesignError::Infeasible`] also with verified multipliers that exclude every P.
pub fn certify_gain(
    plant: &DynamicPlant,
    l: &DMatrix<f64>,
    n_gain: &DMatrix<f64>,
) -> Result<GainCertificate, DesignError> {
    let family = Family::new(plant, l, n_gain)?;
    check::hurwitz("A - L C", &family.f)?;
    let solution = family.at(0.0).solve()?;
    if solution.verdict.is_proved() {
        family.certify(0.0, |name| solution.named(name).cloned())
    } else {
        Err(DesignError::not_proved(WHAT, Some(solution.verdict)))
    }
}

/// The inequality in G and Y, for every eps.
struct Family<'a> {
    plant: &'a DynamicPlant,
    l: &'a DMatrix<f64>,
    n_gain: &'a DMatrix<f64>,
    f: DMatrix<f64>,
    cn: DMatrix<f64>,
    t: DMatrix<f64>,
}

impl<'a> Family<'a> {
    fn new(plant: &'a DynamicPlant, l: &'a DMatrix<f64>, n_gain: &'a DMatrix<f64>) -> Result<Self, DesignError> {
        check::plant(plant)?;
        let c = &plant.c;
        let (n, outputs) = (plant.a.nrows(), c.nrows());
        check::matrix("L", l, (n, outputs))?;
        check::matrix("N", n_gain, (n, outputs))?;
        check::independent_outputs(c)?;
        let cn = c * n_gain;
        let abscissa = spectral_abscissa(&cn)?;
        // The rounding of the product and of its eigenvalues.
        let rounding = 8.0 * n as f64 * f64::EPSILON * c.norm() * n_gain.norm();
        if abscissa > rounding {
            return Err(DesignError::Infeasible { what: WHAT, reason: Obstruction::SignOfCn(abscissa) });
        }
        if abscissa >= -rounding {
            return Err(DesignError::DegenerateGain { real_part: abscissa });
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
        // An entry that is rounding would be taken for a coefficient in small units.
        let t = q
            .columns(outputs, n - outputs)
            .transpose()
            .map(|x| if x.abs() < 4.0 * n as f64 * f64::EPSILON { 0.0 } else { x });
        Ok(Self { plant, l, n_gain, f: &plant.a - l * c, cn, t })
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
        let shifted = &self.f + DMatrix::identity(n, n) * eps;
        lmi.constrain("P > 0", &p >> 0.0);
        lmi.constrain("decrease", he(&p * &shifted) << 0.0);
        lmi.constrain("S + S' > 0", he(&g * &self.cn) << 0.0);
        lmi
    }

    /// Some eps at which the inequality is proved: any P of the form serves once F + eps I is dissipative enough, which can be far to the left
    /// when C and N are nearly orthogonal.
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
        Err(DesignError::not_proved(WHAT, last))
    }

    fn certify(&self, eps: f64, value: impl Fn(&str) -> Option<DMatrix<f64>>) -> Result<GainCertificate, DesignError> {
        let c = &self.plant.c;
        let (n, outputs) = (self.f.nrows(), c.nrows());
        let g = value("G").unwrap_or_else(|| DMatrix::zeros(outputs, outputs));
        let mut p = c.transpose() * &g * c;
        if let Some(y) = value("Y") {
            p += self.t.transpose() * y * &self.t;
        }
        let p = check::symmetric_part(&p);
        let s = -(g * &self.cn);
        let mut shifted = self.plant.clone();
        shifted.a += DMatrix::identity(n, n) * eps;
        let theta = DMatrix::identity(outputs, outputs);
        let theorem = cubic::theorem((&shifted.a, &shifted.b, c), (self.l, self.n_gain, &theta), (&p, &s), 0.0)?;
        let certificate = theorem.certify()?;
        let (l, n) = (self.l.clone(), self.n_gain.clone());
        Ok(GainCertificate { plant: shifted, l, n, p, s, certificate })
    }
}

const WHAT: &str = "P > 0, (F + eps I)'P + P(F + eps I) < 0, P N = -C'S, S + S' > 0";
