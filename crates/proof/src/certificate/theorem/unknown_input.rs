//! The unknown-input observer, linear or cubic: convergence that does not depend on a disturbance.
//!
//! **Hypotheses.** C E has full column rank; with `H = E((CE)'CE)^-1(CE)'` and `T = I - HC`, `P~ > 0` and
//! `(TA - LC)'P~ + P~(TA - LC) + 2 rate P~ < 0` for the stored L; with a cubic term `theta >= 0` and `S~ + S~' >= 0`,
//! `S~ = -XCN`. P~ is P without a cubic term.
//!
//! **Theorem.** The error of `z' = TA xhat + TBu + L r - (r'theta r) N r`, `r = y - C xhat`, `xhat = z + Hy`, with the
//! real matrices H and T, tends to 0 exponentially from every e(0), for every d.
//!
//! **Proof.** `H C E = E`, so that `TE = 0` is an identity. `e = x - xhat = T x - z`, and `e' = T(Ax + Bu + Ed) - z' =
//! (TA - LC)e + (r'theta r) N r`, `r = Ce`: the error equation of the observer of (TA, C), for every d. H and T are
//! rational functions of C and E; their entries are enclosed, H as in `statement/left_inverse.rs`. For the stored L and
//! N convergence is proved with P, or with a cubic term with the P~ in the head of `statement/deployed_cubic.rs`, for
//! which `P~ N = -C'S~` exactly.

use super::super::members::members;
use super::super::sentence::{Reading, Represented, tends_to_zero};
use super::{Fact, Names, PlantMatrices, Statement, check_rate, counted, decay, rate_term};
use crate::error::ProofError;
use crate::interval::Interval;
use crate::matrix::Matrix;
use crate::statement::{structured_for, times_left_inverse};

/// The cubic term of an unknown-input observer.
#[derive(Debug, Clone, PartialEq)]
pub struct StoredCubicTerm {
    /// N, n x p, as stored.
    pub n: Matrix<f64>,
    /// theta, p x p, symmetric.
    pub theta: Matrix<f64>,
    /// X of P~, p x p, symmetric.
    pub x: Matrix<f64>,
}

/// The data of the theorem; the head of the file has statement and proof.
#[derive(Debug, Clone, PartialEq)]
pub struct UnknownInputConvergence {
    /// The plant.
    pub plant: PlantMatrices,
    /// How the unknown input enters, n x q.
    pub e: Matrix<f64>,
    /// The linear gain L, n x p, as stored.
    pub l: Matrix<f64>,
    /// The cubic term; none for the linear observer.
    pub cubic: Option<StoredCubicTerm>,
    /// P, n x n.
    pub p: Matrix<f64>,
    /// The rate, 0 or more.
    pub rate: f64,
}

impl UnknownInputConvergence {
    /// Enclosure of `T = I - HC`; `None` if full column rank of C E cannot be proved.
    fn decoupler(&self, names: &Names<'_>) -> Result<Option<Matrix<Interval>>, ProofError> {
        let c = &self.plant.c;
        let Some(h) = times_left_inverse(&self.e, &names.expression("CE")?)? else { return Ok(None) };
        let measured = h.product(&Matrix::embed(c, "C")?)?;
        Ok(Some(Matrix::scalar(c.cols(), &Interval::ONE).difference(&measured)?))
    }
}

impl Statement for UnknownInputConvergence {
    const NAME: &'static str = "unknown-input-observer";

    fn facts(&self, names: Names<'_>) -> Result<Vec<Fact>, ProofError> {
        check_rate(self.rate)?;
        let mut names = names.of(self);
        let mut facts = names.facts(["(CE)'CE > 0"])?;
        let decoupler = if facts.iter().all(|fact| fact.verdict.is_proved()) { self.decoupler(&names)? } else { None };
        names = names.enclosed("T", decoupler.as_ref(), false);
        let mut p = "P";
        if let Some(term) = &self.cubic {
            p = "P~";
            let metric = structured_for(&self.p, &self.plant.c, &term.x, &term.n)?;
            names = names.enclosed(p, metric.as_ref(), true).define("S~", "-XCN")?;
        }
        let decrease = format!("(TA - LC)'{p} + {p}(TA - LC){} < 0", rate_term(self.rate, p));
        facts.extend(names.facts([format!("{p} > 0"), decrease])?);
        if self.cubic.is_some() {
            facts.extend(names.facts(["theta >= 0", "S~ + S~' >= 0"])?);
        }
        Ok(facts)
    }

    fn sentence(&self, reading: &Reading<'_>, margin: f64) -> Option<String> {
        if !matches!(reading.plant, Represented::Itself) {
            return None;
        }
        // The margin of a cubic observer is one of P~.
        let falls = tends_to_zero(self.rate, &self.p, if self.cubic.is_some() { 0.0 } else { margin });
        Some(format!(
            "For every disturbance d(t) the error of x {falls}, for all x(0) and xhat(0), with H and T = I - HC as real matrices."
        ))
    }

    fn words(&self) -> String {
        let sizes = format!(
            "{}, {}, {} and {}",
            counted(self.plant.a.rows(), "state"),
            counted(self.plant.b.cols(), "input"),
            counted(self.e.cols(), "unknown input"),
            counted(self.plant.c.rows(), "output")
        );
        let (term, gains, flow, metric, function) = if self.cubic.is_some() {
            (
                " - (r'theta r) N r",
                "gains L and N",
                " + (e'C'theta C e) N C e",
                ", with P~ = C'XC + (I - R)(P - C'XC)(I - R), R the orthogonal projector on the range of N",
                "e'P~e",
            )
        } else {
            ("", "gain L", "", "", "e'Pe")
        };
        format!(
            "For the plant x' = Ax + Bu + Ed, y = Cx with {sizes}, any unknown input d, and the observer z' = TA xhat + TBu + L r{term}, r = y - C xhat, xhat = z + Hy, with the real matrices H = E((CE)'CE)^-1(CE)' and T = I - HC and the {gains} exactly as stored: TE = 0, the error e = x - xhat obeys e' = (TA - LC)e{flow} whatever d is, and {}, from every e(0){metric}. Nothing is said of a rounding of H, TA and TB.",
            decay(function, "e", self.rate)
        )
    }
}

members! { StoredCubicTerm, (order, outputs): (usize, usize) { {
    n = "N".matrix((order, outputs));
    theta = "theta".symmetric(outputs);
    x = "X".symmetric(outputs);
} } }

members! { UnknownInputConvergence {
    { plant: PlantMatrices = "plant".part(); e = "E".columns(plant.order()); }
    "observer" { l = "L".matrix(plant.gain()); }
    { cubic = optional "cubic".part_of(plant.gain()); }
    "lyapunov" { p = "P".symmetric(plant.order()); rate = "rate".rate(); }
} }
