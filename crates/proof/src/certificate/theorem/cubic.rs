//! The cubic observer in continuous time, with its gains as stored.
//!
//! **Hypotheses.** `P > 0`, `F'P + PF + 2 rate P < 0` (12) for `F = A - LC`, `theta >= 0`, `S + S' >= 0`, and
//! convergence with N as stored (below).
//!
//! **Theorem.** The error of `xhat' = A xhat + Bu + L r - (r'theta r) N r`, `r = y - C xhat`, tends to 0 exponentially,
//! from every e(0) or from those with `e'Pe < level`. With the real matrix `N0 = -P^-1 C'S` in place of N, `V = e'Pe`
//! falls at the rate of the linear observer, from every e(0).
//!
//! **Proof.** The error obeys `e' = Fe + (y'theta y) N y`, `y = Ce`. With N0 the cubic term adds `-2 (y'theta y) y'Sy
//! <= 0` to `V'` (Theorem 2 of the paper; Theorem 1 is the form with P given, 4 and 5 those with a perturbed A). For
//! the stored N the proof is in the head of `statement/deployed_cubic.rs`: from every e(0) by another Lyapunov matrix
//! near P for which the stored N has the structure exactly, or from an ellipsoid in which `|PN + C'S|` is dominated.

use super::super::fields::Field;
use super::super::members::members;
use super::super::sentence::{Reading, Represented, decay as decay_of, disturbance, has_disturbance};
use super::super::write::{Out, Written};
use super::super::{Certificate, Witness};
use super::{
    Fact, FileError, Names, PlantMatrices, PlantWithin, Statement, StructuredCubicConvergence, Theorem, check_rate,
    decay, decrease_label,
};
use crate::error::ProofError;
use crate::interval::Interval;
use crate::matrix::Matrix;
use crate::number::Number;
use crate::statement::{DeployedCubic, Reach, decay_rate, deployed_cubic_knowing, largest_eigenvalue_bound};
use crate::verdict::{UndecidedReason, Verdict};
use crate::wording::{exact, if_at_most};

/// From which errors convergence is claimed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Region {
    /// From all.
    Everywhere,
    /// From all with `e'Pe` below this level.
    Within(f64),
}

/// The data of the theorem; the head of the file has statement and proof.
#[derive(Debug, Clone, PartialEq)]
pub struct CubicConvergence {
    /// The plant.
    pub plant: PlantMatrices,
    /// The linear gain L, n x p, as stored.
    pub l: Matrix<f64>,
    /// The cubic gain N, n x p, as stored.
    pub n: Matrix<f64>,
    /// The weight theta, p x p.
    pub theta: Matrix<f64>,
    /// P, n x n.
    pub p: Matrix<f64>,
    /// S, p x p.
    pub s: Matrix<f64>,
    /// The rate of the observer with the real gain, 0 or more.
    pub rate: f64,
    /// From which errors the observer with the stored gain is claimed to converge.
    pub region: Region,
}

impl CubicConvergence {
    /// What is proved of these gains: convergence with N as stored from the largest region that is found, whatever
    /// [`region`](Self::region) says; or, where there is none, the theorem for the real gain `-P^-1 C'S`.
    ///
    /// # Errors
    /// [`ProofError`] for shapes that do not fit, entries that are not finite, a P or theta that is not symmetric.
    pub fn certify(self) -> Result<Certificate, ProofError> {
        self.certify_knowing(&Certificate::default())
    }

    /// The same; `P > 0` and (12) are taken over from a [`LinearConvergence`](super::LinearConvergence) of `known` with
    /// the same A, B, C, L, P and rate.
    ///
    /// # Errors
    /// As [`certify`](Self::certify).
    pub fn certify_knowing(mut self, known: &Certificate) -> Result<Certificate, ProofError> {
        let known = self.known(known)?;
        let deployed = self.decided(known)?;
        self.region = match &deployed.reach {
            Reach::Everywhere { .. } => Region::Everywhere,
            Reach::Within(ellipsoid) => Region::Within(ellipsoid.level),
            Reach::Unproved => {
                let Self { plant, l, theta, p, s, rate, .. } = self;
                return Certificate::of([StructuredCubicConvergence { plant, l, theta, p, s, rate }]);
            }
        };
        let facts = self.facts_from(deployed, known)?;
        let mut certificate = Certificate::default();
        certificate.add(self.into(), facts);
        Ok(certificate)
    }

    /// A radius: every error that is shorter lies in the region. Infinite for all errors.
    pub fn ball(&self) -> f64 {
        match self.region {
            Region::Everywhere => f64::INFINITY,
            Region::Within(level) => (level / largest_eigenvalue_bound(&self.p)).next_down().sqrt().next_down(),
        }
    }

    /// The margins of `P > 0` and (12), where they are proved.
    fn known(&self, known: &Certificate) -> Result<Option<[f64; 2]>, ProofError> {
        for proved in known.theorems() {
            let Theorem::LinearConvergence(linear) = proved.theorem() else { continue };
            let PlantMatrices { a, b, c } = &self.plant;
            let is_same = (&linear.l, &linear.p, linear.rate) == (&self.l, &self.p, self.rate);
            if is_same && linear.plant == PlantWithin::exactly(a, b, c)? {
                let margins: Vec<f64> = proved.facts().iter().filter_map(|fact| fact.verdict.margin()).collect();
                return Ok(margins.try_into().ok());
            }
        }
        Ok(None)
    }

    fn decided(&self, known: Option<[f64; 2]>) -> Result<DeployedCubic, ProofError> {
        let PlantMatrices { a, c, .. } = &self.plant;
        // (12) is the decrease at the rate 0.
        let known = known.map(|[positive, decrease]| (positive, (self.rate == 0.0).then_some(decrease)));
        deployed_cubic_knowing(a, &self.l, c, (&self.p, known), &self.n, &self.s, &self.theta)
    }

    fn facts_from(&self, deployed: DeployedCubic, known: Option<[f64; 2]>) -> Result<Vec<Fact>, ProofError> {
        check_rate(self.rate)?;
        if let Region::Within(level) = self.region
            && !(level > 0.0 && level.is_finite())
        {
            return Err(ProofError::Sign { what: "the level of a region, which should be positive,", value: level });
        }
        let PlantMatrices { a, c, .. } = &self.plant;
        let decrease = match known {
            _ if self.rate == 0.0 => deployed.decrease,
            Some([_, margin]) => Verdict::Proved { margin },
            None => decay_rate(a, &self.l, c, &self.p, self.rate)?,
        };
        let (reached, level) = match (&deployed.reach, self.region) {
            (Reach::Everywhere { .. }, _) => (true, f64::INFINITY),
            (Reach::Within(ellipsoid), Region::Within(level)) => (level <= ellipsoid.level, ellipsoid.level),
            (Reach::Within(ellipsoid), Region::Everywhere) => (false, ellipsoid.level),
            (Reach::Unproved, _) => (false, f64::NAN),
        };
        let convergence: Verdict<Witness> = if reached {
            Verdict::Proved { margin: 0.0 }
        } else {
            Verdict::Undecided { why: UndecidedReason::NotByThisMatrix { name: "P" }, best: level }
        };
        let region = match self.region {
            Region::Everywhere => "everywhere".to_owned(),
            Region::Within(level) => {
                format!("e'Pe < {}", Number::from_f64(level).map_or_else(String::new, |level| level.to_string()))
            }
        };
        Ok(vec![
            Fact::new("P > 0", deployed.positive),
            Fact::new(decrease_label(self.rate), decrease),
            Fact::new("theta >= 0", deployed.weight),
            Fact::new("S + S' >= 0", deployed.accretive),
            Fact::stated(format!("convergence with N as stored, {region}"), convergence),
        ])
    }

    /// The region behind "every initial error", with the name of the error; nothing for all errors.
    pub(super) fn within(&self, error: &str) -> String {
        match self.region {
            Region::Everywhere => String::new(),
            Region::Within(level) => format!(
                " {error} with e'Pe < {}, such as all of norm below {}",
                if_at_most(level, 6),
                if_at_most(self.ball(), 5)
            ),
        }
    }

    /// "from every e(0)", or from which.
    pub(super) fn from(&self) -> String {
        match self.region {
            Region::Everywhere => "from every e(0)".to_owned(),
            Region::Within(level) => format!("from every e(0) with e(0)'P e(0) < {}", exact(level)),
        }
    }
}

impl Statement for CubicConvergence {
    const NAME: &'static str = "cubic-observer";

    fn facts(&self, _: Names<'_>) -> Result<Vec<Fact>, ProofError> {
        self.facts_from(self.decided(None)?, None)
    }

    fn sentence(&self, reading: &Reading<'_>, margin: f64) -> Option<String> {
        let stored = match reading.plant {
            Represented::Itself => {
                format!("With the gains as stored it converges from every initial error{}.", self.within("e"))
            }
            Represented::WithDisturbance { states, order } => {
                let (a, c) = (self.plant.a.map(|x| Interval::of(*x)), self.plant.c.map(|x| Interval::of(*x)));
                if !has_disturbance(&a, &c, states, order) {
                    return None;
                }
                let from = match self.region {
                    Region::Everywhere => "for all x(0), xhat(0) and d".to_owned(),
                    Region::Within(_) => format!("from every initial error{}", self.within("e of x and d")),
                };
                format!(
                    "For {}, with the gains as stored, the errors of x and of d tend to 0, {from}.",
                    disturbance(order)
                )
            }
            _ => return None,
        };
        Some(format!("{} {stored}", of_real_gain(self.rate, &self.p, margin)))
    }

    fn words(&self) -> String {
        format!(
            "For the plant x' = Ax + Bu, y = Cx with {} and the cubic observer xhat' = A xhat + Bu + L r - (r'theta r) N r, r = y - C xhat, the error e = x - xhat obeys e' = (A - LC)e + (e'C'theta C e) N C e. With the gains L and N exactly as stored, e tends to 0 exponentially, {}. With the real matrix -P^-1 C'S in place of N, {}, from every e(0).",
            self.plant.size(),
            self.from(),
            decay("e'Pe", "e", self.rate)
        )
    }
}

/// What is proved of V with the real gain.
pub(super) fn of_real_gain(rate: f64, p: &Matrix<f64>, margin: f64) -> String {
    let rate = decay_of(rate, p, margin)
        .map_or_else(String::new, |decay| format!(", and the error decays at least as fast as {decay}"));
    format!(
        "With the real matrix -P^-1 C'S in place of N, V = e'Pe decreases at least as fast as without the cubic term{rate}, for every error."
    )
}

members! { CubicConvergence {
    { plant: PlantMatrices = "plant".part(); }
    "observer" {
        l = "L".matrix(plant.gain());
        n = "N".matrix(plant.gain());
        theta = "theta".symmetric(plant.outputs());
    }
    "lyapunov" {
        p = "P".symmetric(plant.order());
        s = "S".matrix((plant.outputs(), plant.outputs()));
        rate = "rate".rate();
        region = "converges_from".by(Region::read);
    }
} }

impl Region {
    fn read(field: &Field<'_>) -> Result<Self, FileError> {
        if field.text()? == "everywhere" {
            return Ok(Self::Everywhere);
        }
        let requirement = "the level of e'Pe below which errors converge is positive, or the word \"everywhere\"";
        field.positive(requirement).map(Self::Within)
    }
}

impl Written for Region {
    fn out(&self) -> Out {
        match self {
            Self::Everywhere => "everywhere".out(),
            Self::Within(level) => level.out(),
        }
    }
}
