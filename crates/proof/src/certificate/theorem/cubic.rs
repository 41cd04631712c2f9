//! The cubic observer, with its gains as stored.

use super::super::fields::Fields;
use super::super::number::Number;
use super::super::write::Out;
use super::super::{Fault, Witness};
use super::{Fact, FileError, Plant, Statement, rate_term};
use crate::error::ProofError;
use crate::matrix::Matrix;
use crate::statement::{Reach, decay_rate, deployed_cubic};
use crate::verdict::{Doubt, Verdict};

/// From which errors convergence is claimed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Region {
    /// From all.
    Everywhere,
    /// From all with `e'Pe` below this level.
    Within(f64),
}

/// `P > 0`, `(A - LC)'P + P(A - LC) + 2 rate P < 0` (12), `theta >= 0`, `S + S' >= 0`, and what the stored N, which is a rounding of `-P^-1 C'S`, costs.
///
/// The error of `xhat' = A xhat + Bu + L ytilde - (ytilde'theta ytilde) N ytilde`, `ytilde = y - C xhat`, obeys `e' = (A - LC)e + (y'theta y) N y` with `y = Ce`. With the *real*
/// gain `N0 = -P^-1 C'S` the cubic term adds `-2 (y'theta y) y'Sy <= 0` to `V'`, so that V falls as fast as that of the linear observer (Theorem 2, of which Theorem 1 is the
/// form with P given, 4 and 5 those with an A that is not the nominal one). The *stored* N misses that by its last digit; from which errors it converges is the last
/// fact, proved as the head of `statement/deployed_cubic.rs` derives it: from all, by another Lyapunov matrix near P for which the stored N is exact; or from the ellipsoid
/// `e'Pe < level`, in which the miss is outweighed.
#[derive(Debug, Clone, PartialEq)]
pub struct CubicObserver {
    /// The plant.
    pub plant: Plant,
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

impl CubicObserver {
    pub(super) fn members(&self) -> Vec<(&'static str, Out)> {
        let region = match self.region {
            Region::Everywhere => Out::Text("everywhere".to_owned()),
            Region::Within(level) => Out::number(level),
        };
        vec![
            self.plant.write(),
            (
                "observer",
                Out::Object(vec![
                    ("L", Out::matrix(&self.l)),
                    ("N", Out::matrix(&self.n)),
                    ("theta", Out::matrix(&self.theta)),
                ]),
            ),
            (
                "lyapunov",
                Out::Object(vec![
                    ("P", Out::matrix(&self.p)),
                    ("S", Out::matrix(&self.s)),
                    ("rate", Out::number(self.rate)),
                    ("converges_from", region),
                ]),
            ),
        ]
    }

    /// "from every e(0)", or from which.
    pub(super) fn from(&self) -> String {
        match self.region {
            Region::Everywhere => "from every e(0)".to_owned(),
            Region::Within(level) => format!("from every e(0) with e(0)'P e(0) < {level:e}"),
        }
    }
}

impl Statement for CubicObserver {
    const NAME: &'static str = "cubic-observer";

    fn read(file: &mut Fields<'_>) -> Result<Self, FileError> {
        let plant = Plant::read(file)?;
        let (order, outputs) = plant.gain();
        let mut observer = file.object("observer")?;
        let l = observer.take("L")?.matrix((order, outputs))?;
        let n = observer.take("N")?.matrix((order, outputs))?;
        let theta = observer.take("theta")?.symmetric(outputs)?;
        observer.finish()?;
        let mut lyapunov = file.object("lyapunov")?;
        let p = lyapunov.take("P")?.symmetric(order)?;
        let s = lyapunov.take("S")?.matrix((outputs, outputs))?;
        let rate = lyapunov.rate()?;
        let field = lyapunov.take("converges_from")?;
        let region = if field.text()? == "everywhere" {
            Region::Everywhere
        } else {
            let level = field.binary64()?;
            if level <= 0.0 {
                let requirement =
                    "the level of e'Pe below which errors converge is positive, or the word \"everywhere\"";
                return Err(field.error(Fault::Range { value: level, requirement }));
            }
            Region::Within(level)
        };
        lyapunov.finish()?;
        Ok(Self { plant, l, n, theta, p, s, rate, region })
    }

    fn write(&self) -> Vec<(&'static str, Out)> {
        self.members()
    }

    fn words(&self) -> String {
        let rate = if self.rate == 0.0 {
            "V = e'Pe decreases and e tends to 0 exponentially, from every e(0)".to_owned()
        } else {
            format!("V = e'Pe satisfies V(t) <= exp(-2({})t) V(0), from every e(0)", self.rate)
        };
        format!(
            "For the plant x' = Ax + Bu, y = Cx with {} and the cubic observer xhat' = A xhat + Bu + L r - (r'theta r) N r, r = y - C xhat, the error e = x - xhat obeys e' = (A - LC)e + (e'C'theta C e) N C e. With the gains L and N exactly as stored, e tends to 0 exponentially, {}. With the real gain -P^-1 C'S, of which N is a rounding, {rate}.",
            self.plant.size(),
            self.from()
        )
    }

    fn facts(&self) -> Result<Vec<Fact>, ProofError> {
        let Plant { a, c, .. } = &self.plant;
        let deployed = deployed_cubic(a, &self.l, c, &self.p, &self.n, &self.s, &self.theta)?;
        let decrease =
            if self.rate == 0.0 { deployed.decrease } else { decay_rate(a, &self.l, c, &self.p, self.rate)? };
        let (reached, level) = match (&deployed.reach, self.region) {
            (Reach::Everywhere { .. }, _) => (true, f64::INFINITY),
            (Reach::Within(ellipsoid), Region::Within(level)) => (level <= ellipsoid.level, ellipsoid.level),
            (Reach::Within(ellipsoid), Region::Everywhere) => (false, ellipsoid.level),
            (Reach::Unproved, _) => (false, f64::NAN),
        };
        let convergence: Verdict<Witness> = if reached {
            Verdict::Proved { margin: 0.0 }
        } else {
            Verdict::Undecided { why: Doubt::NotByThisMatrix { name: "P" }, best: level }
        };
        let region = match self.region {
            Region::Everywhere => "everywhere".to_owned(),
            Region::Within(level) => {
                format!("e'Pe < {}", Number::from_f64(level).map_or_else(String::new, |level| level.to_string()))
            }
        };
        Ok(vec![
            Fact::new("P > 0", deployed.positive),
            Fact::new(format!("(A - LC)'P + P(A - LC){} < 0 (12)", rate_term(self.rate, "P")), decrease),
            Fact::new("theta >= 0", deployed.weight),
            Fact::new("S + S' >= 0", deployed.accretive),
            Fact { inequality: format!("convergence with N as stored, {region}"), verdict: convergence },
        ])
    }
}
