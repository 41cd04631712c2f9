//! The unknown-input observer, linear or cubic: convergence that does not depend on a disturbance.
//!
//! **Hypotheses.** C E has full column rank; with `H = E((CE)'CE)^-1(CE)'` and `T = I - HC`, `P~ > 0` and
//! `(TA - LC)'P~ + P~(TA - LC) + 2 rate P~ < 0` for the stored L; with a cubic term `theta >= 0` and `S~ + S~' >= 0`.
//!
//! **Theorem.** The error of `z' = TA xhat + TBu + L r - (r'theta r) N r`, `r = y - C xhat`, `xhat = z + Hy`, with the
//! real matrices H and T, tends to 0 exponentially from every e(0), for every d.
//!
//! **Proof.** In the head of `statement/unknown_input.rs`.

use super::super::members::members;
use super::super::sentence::{Reading, Represented, tends_to_zero};
use super::{Fact, PlantMatrices, Statement, check_rate, counted, decay, rate_term};
use crate::error::ProofError;
use crate::matrix::Matrix;
use crate::statement::{UnknownInput, unknown_input};

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

impl Statement for UnknownInputConvergence {
    const NAME: &'static str = "unknown-input-observer";

    fn facts(&self) -> Result<Vec<Fact>, ProofError> {
        check_rate(self.rate)?;
        let plant = UnknownInput {
            a: &self.plant.a,
            c: &self.plant.c,
            e: &self.e,
            l: &self.l,
            cubic: self.cubic.as_ref().map(|term| (&term.n, &term.theta, &term.x)),
        };
        let found = unknown_input(&plant, &self.p, self.rate)?;
        let p = if self.cubic.is_some() { "P~" } else { "P" };
        let mut facts = vec![
            Fact::new("(CE)'CE > 0", found.rank),
            Fact::new(format!("{p} > 0"), found.positive),
            Fact::new(format!("(TA - LC)'{p} + {p}(TA - LC){} < 0", rate_term(self.rate, p)), found.decrease),
        ];
        if let Some([weight, accretive]) = found.cubic {
            facts.push(Fact::new("theta >= 0", weight));
            facts.push(Fact::new("S~ + S~' >= 0", accretive));
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
