//! The sampled observer at periods that vary, with samples missed in a row: jitter and dropouts.
//!
//! **Hypotheses.** `0 < shortest <= longest`, `misses` of 0 or more, `0 < factor < 1`, `P > 0`, and `factor^2 P - M'
//! exp(At)'P exp(At) M > 0` for every t from `k shortest` to `k longest`, k from 1 to `misses + 1`, for `M = I - KC`.
//! For the radial cubic step, w > 0 and the same for `M = I + NC/w`. For the semi-implicit one, `S + S' >= 0` and
//! `[(1 - factor^2)P/2, PN + C'S; *, N'PN] >= 0`.
//!
//! **Theorem.** The observer predicts between samples over the time that passes, and corrects at every sample that is
//! not missed. Its error tends to 0 exponentially from every e(0), whatever the periods between the bounds and the
//! samples missed are, as long as no more than `misses` are missed in a row. `V = e'Pe` before a correction
//! is at most `factor^2` times what it was before the last one; with the semi-implicit step,
//! `2 factor^2/(1 + factor^2)` times.
//!
//! **Proof.** Prediction is exact: `e(t) = exp(At) e(0+)` between corrections, whatever u is. The time between two
//! corrections is a sum of k periods, k from 1 to misses + 1. *Linear*: `e(0+) = (I - KC)e`. *Radial*: `e(0+) = (I + g
//! N C - (1 - w g)KC)e` with `0 <= g < 1/w`, which is affine in g, between `I - KC` and `I + NC/w`; `X'PX` is convex in
//! X.
//! *Semi-implicit*: `e(0+) = (I - KC)d` with `d - s N C d = e`, and as in `semi_implicit.rs`, `V(e) >= V(d) - (1 -
//! factor^2)V(d)/2 = (1 + factor^2)V(d)/2`, while V falls from d to the next correction to `factor^2 V(d)` at most.
//! Between corrections |e| grows by a bounded factor, since the times are bounded.

use super::super::Fault;
use super::super::fields::Fields;
use super::super::limits::MOST_MOTION;
use super::super::members::Members;
use super::super::sentence::{Reading, Represented};
use super::super::write::{Out, Written};
use super::{Fact, FileError, PlantMatrices, Statement};
use crate::error::ProofError;
use crate::interval::Interval;
use crate::label::Names;
use crate::matrix::Matrix;
use crate::statement::Effort;
use crate::wording::{at_most, counted, exact, shortest};

/// The largest number of samples missed in a row.
pub const MOST_MISSES: usize = 64;

/// The cubic part of a correction.
#[derive(Debug, Clone, PartialEq)]
pub enum CubicStep {
    /// None.
    Linear,
    /// In closed form, for a radial gain N (n x p) with the weight theta (p x p) and the rate w.
    Radial {
        /// The cubic gain, n x p.
        n: Matrix<f64>,
        /// The weight, p x p.
        theta: Matrix<f64>,
        /// The rate w, positive.
        w: f64,
    },
    /// Semi-implicit, for any gain.
    SemiImplicit {
        /// The cubic gain, n x p.
        n: Matrix<f64>,
        /// The weight, p x p.
        theta: Matrix<f64>,
        /// S, p x p: N is some rounding of `-P^-1 C'S`.
        s: Matrix<f64>,
    },
}

/// The data of the theorem; the head of the file has statement and proof.
#[derive(Debug, Clone, PartialEq)]
pub struct VaryingPeriodConvergence {
    /// The plant in continuous time.
    pub plant: PlantMatrices,
    /// The gain K of the correction, n x p.
    pub k: Matrix<f64>,
    /// The cubic part of the correction.
    pub step: CubicStep,
    /// The shortest period.
    pub shortest: f64,
    /// The longest period.
    pub longest: f64,
    /// How many samples in a row may be missed.
    pub misses: usize,
    /// P, n x n.
    pub p: Matrix<f64>,
    /// The factor by which the norm of P falls, above 0 and below 1.
    pub factor: f64,
}

const LINEAR: &str = "linear";
const RADIAL: &str = "radial";
const SEMI_IMPLICIT: &str = "semi-implicit";

impl CubicStep {
    fn name(&self) -> &'static str {
        match self {
            Self::Linear => LINEAR,
            Self::Radial { .. } => RADIAL,
            Self::SemiImplicit { .. } => SEMI_IMPLICIT,
        }
    }

    /// The maps of a correction whose decrease is shown.
    fn maps(&self) -> usize {
        if matches!(self, Self::Radial { .. }) { 2 } else { 1 }
    }
}

impl VaryingPeriodConvergence {
    /// The factor of `V = e'Pe` from correction to correction, rounded upwards: with f the [factor](Self::factor) of
    /// the norm, `f^2` or, for the semi-implicit step, `2f^2/(1+f^2)`.
    #[must_use]
    pub fn decrease(&self) -> f64 {
        let square = (self.factor * self.factor).next_up();
        match self.step {
            // Grows with the square; 2 square is exact.
            CubicStep::SemiImplicit { .. } => (2.0 * square / (1.0 + square).next_down()).next_up(),
            CubicStep::Linear | CubicStep::Radial { .. } => square,
        }
    }

    /// `I + G C s` for a gain G.
    fn corrected(&self, gain: &Matrix<f64>, sign: f64) -> Result<Matrix<Interval>, ProofError> {
        let PlantMatrices { a, c, .. } = &self.plant;
        gain.expect_shape("the gain", (a.rows(), c.rows()))?;
        let product = Matrix::<Interval>::embed(gain, "the gain")?.product(&Matrix::embed(c, "C")?)?;
        Matrix::scalar(a.rows(), &Interval::point(1.0)).sum(&product.scaled(&Interval::of(sign)))
    }

    /// `I + NC/w`: an enclosure, for the quotient is not exact.
    fn saturated(&self, n: &Matrix<f64>, w: f64) -> Result<Matrix<Interval>, ProofError> {
        let inverse = 1.0 / w;
        let inverse = Interval::new(inverse.next_down(), inverse.next_up()).unwrap_or(Interval::UNBOUNDED);
        let PlantMatrices { a, c, .. } = &self.plant;
        let product = Matrix::<Interval>::embed(n, "N")?.product(&Matrix::embed(c, "C")?)?;
        Matrix::scalar(a.rows(), &Interval::point(1.0)).sum(&product.scaled(&inverse))
    }

    fn falls(
        &self,
        name: &str,
        map: &Matrix<Interval>,
        effort: &mut Effort,
        facts: &mut Vec<Fact>,
    ) -> Result<(), ProofError> {
        for count in 1..=self.misses + 1 {
            // Counts are small: exact in binary64, the products rounded outward.
            let (least, most) = (count as f64 * self.shortest, count as f64 * self.longest);
            let times = if count == 1 { (least, most) } else { (least.next_down(), most.next_up()) };
            let verdict = effort.decrease_over_times(&self.plant.a, map, &self.p, self.factor, times)?;
            facts.push(Fact::new(
                format!(
                    "factor^2 P - M'exp(At)'P exp(At)M > 0 with M = {name} for t from {count} shortest to {count} longest"
                ),
                verdict,
            ));
        }
        Ok(())
    }

    fn check(&self) -> Result<(), ProofError> {
        let sign = |what, value| Err(ProofError::Sign { what, value });
        let positive = |value: f64| value > 0.0;
        if !positive(self.shortest) {
            return sign("the shortest period, which should be positive,", self.shortest);
        }
        if !(self.longest >= self.shortest && self.longest.is_finite()) {
            return sign("the longest period, which should be the shortest or more,", self.longest);
        }
        if !(self.factor > 0.0 && self.factor < 1.0) {
            return sign("a factor, which should be above 0 and below 1,", self.factor);
        }
        if self.misses > MOST_MISSES {
            return sign("the number of missed samples, which should be 64 or less,", self.misses as f64);
        }
        match &self.step {
            CubicStep::Radial { w, .. } if !positive(*w) => return sign("w, which should be positive,", *w),
            _ => {}
        }
        let states = self.plant.order();
        let (spans, motion) = motion(states, self.step.maps(), self.misses);
        if motion > MOST_MOTION {
            return Err(ProofError::TooMuchMotion { states, spans, motion, allowed: MOST_MOTION });
        }
        Ok(())
    }
}

/// The spans of time over which the decrease is shown, and their product with the cube of the states.
fn motion(states: usize, maps: usize, misses: usize) -> (usize, usize) {
    let spans = maps * (misses + 1);
    (spans, states.saturating_pow(3).saturating_mul(spans))
}

impl Statement for VaryingPeriodConvergence {
    const NAME: &'static str = "sampled-observer-at-varying-periods";

    fn facts(&self, names: Names<'_>) -> Result<Vec<Fact>, ProofError> {
        self.check()?;
        let mut facts = names.clone().symmetric("P", &self.p).facts(["P > 0"])?;
        let mut effort = Effort::default();
        self.falls("I - KC", &self.corrected(&self.k, -1.0)?, &mut effort, &mut facts)?;
        match &self.step {
            CubicStep::Linear => {}
            CubicStep::Radial { n, w, .. } => {
                self.falls("I + NC/w", &self.saturated(n, *w)?, &mut effort, &mut facts)?;
            }
            CubicStep::SemiImplicit { n, s, .. } => {
                let names = names.of(&self.plant).symmetric("P", &self.p).number("factor", self.factor);
                let names = names.matrix("N", n).matrix("S", s);
                facts.extend(names.facts(["S + S' >= 0", "[(1 - factor^2)P/2, PN + C'S; *, N'PN] >= 0"])?);
            }
        }
        Ok(facts)
    }

    fn sentence(&self, reading: &Reading<'_>, _margin: f64) -> Option<String> {
        if !matches!(reading.plant, Represented::Itself) {
            return None;
        }
        let missed = match self.misses {
            0 => String::new(),
            misses => format!(" with at most {} in a row", counted(misses, "missed sample")),
        };
        Some(format!(
            "For periods from {} to {}{missed}, with the correction gain K and a prediction over the time that passes: before each correction V = e'Pe is at most {} times what it was before the last one and the error tends to 0, for every initial error.",
            shortest(self.shortest),
            shortest(self.longest),
            at_most(self.decrease(), 4)
        ))
    }

    fn words(&self) -> String {
        let (correction, errors, falls) = match &self.step {
            CubicStep::Linear => (
                "xhat+ = xhat + K z, z = y - C xhat".to_owned(),
                "e+ = exp(At)(I - KC)e".to_owned(),
                "factor^2",
            ),
            CubicStep::Radial { w, .. } => (
                format!(
                    "xhat+ = xhat - g N z + r K z, z = y - C xhat, r = 1/sqrt(1 + 2 w T max(z'theta z, 0)), g = (1 - r)/w, with w = {} and any T >= 0",
                    exact(*w)
                ),
                "e+ = exp(At)(I + g N C - r K C)e with 0 <= g < 1/w".to_owned(),
                "factor^2",
            ),
            CubicStep::SemiImplicit { .. } => (
                "xhat+ = xhat - s N r + K r, (I - s C N) r = z, z = y - C xhat, s = T max(z'theta z, 0), with any T >= 0"
                    .to_owned(),
                "e+ = exp(At)(I - KC)d with (I - s N C)d = e".to_owned(),
                "2 factor^2/(1 + factor^2)",
            ),
        };
        let missed = match self.misses {
            0 => "of which none is missed".to_owned(),
            misses => format!("of which at most {} in a row {} missed", misses, if misses == 1 { "is" } else { "are" }),
        };
        format!(
            "For the plant x' = Ax + Bu, y = Cx with {}, sampled at periods from {} to {}, each of any length between, {missed}, and the observer that predicts by xhat' = A xhat + Bu and corrects at each sample that is not missed by {correction}, with all numbers as given, in exact arithmetic: the error e = x - xhat before a correction obeys {errors}, t being the time to the next correction, V = e'Pe is before the next correction at most {falls} times what it is before this one, with factor = {}, and e tends to 0 exponentially, from every e(0). Nothing is said of the rounding of its steps.",
            self.plant.size(),
            exact(self.shortest),
            exact(self.longest),
            exact(self.factor)
        )
    }
}

/// The members of `observer` and `lyapunov` depend on the step.
impl Members for VaryingPeriodConvergence {
    fn read(file: &mut Fields<'_>, (): ()) -> Result<Self, FileError> {
        let plant: PlantMatrices = file.take("plant")?.part()?;
        let (gain, square) = (plant.gain(), (plant.outputs(), plant.outputs()));
        let (name, k, cubic, w) = file.object("observer", |observer| {
            let name = observer.take("step")?.word(&[LINEAR, RADIAL, SEMI_IMPLICIT].map(|name| (name, name)))?;
            let k = observer.take("K")?.matrix(gain)?;
            let cubic = if name == LINEAR {
                None
            } else {
                Some((observer.take("N")?.matrix(gain)?, observer.take("theta")?.matrix(square)?))
            };
            let w = if name == RADIAL {
                observer.take("w")?.positive("the rate w of the cubic flow is positive")?
            } else {
                0.0
            };
            Ok((name, k, cubic, w))
        })?;
        let (shortest, longest, misses) = file.object("periods", |periods| {
            let shortest = periods.take("shortest")?.positive("a sampling period is positive")?;
            let longest =
                periods.take("longest")?.number(|h| h >= shortest, "the longest period is not below the shortest")?;
            let field = periods.take("misses")?;
            let misses = field.count()?;
            if misses > MOST_MISSES {
                let requirement = "at most 64 samples in a row are missed";
                return Err(field.error(Fault::Range { value: misses as f64, requirement }));
            }
            let (states, maps) = (plant.order(), if name == RADIAL { 2 } else { 1 });
            let (spans, motion) = motion(states, maps, misses);
            if motion > MOST_MOTION {
                return Err(field.error(Fault::TooMuchMotion { states, misses, spans, motion }));
            }
            Ok((shortest, longest, misses))
        })?;
        let (p, factor, step) = file.object("lyapunov", |lyapunov| {
            let p = lyapunov.take("P")?.symmetric(plant.order())?;
            let factor =
                lyapunov.take("factor")?.number(|x| x > 0.0 && x < 1.0, "the factor is above 0 and below 1")?;
            let step = match cubic {
                None => CubicStep::Linear,
                Some((n, theta)) if name == RADIAL => CubicStep::Radial { n, theta, w },
                Some((n, theta)) => CubicStep::SemiImplicit { n, theta, s: lyapunov.take("S")?.matrix(square)? },
            };
            Ok((p, factor, step))
        })?;
        Ok(Self { plant, k, step, shortest, longest, misses, p, factor })
    }

    fn write(&self) -> Vec<(&'static str, Out)> {
        let mut observer = vec![("step", self.step.name().out()), ("K", self.k.out())];
        let mut lyapunov = vec![("P", self.p.out()), ("factor", self.factor.out())];
        match &self.step {
            CubicStep::Linear => {}
            CubicStep::Radial { n, theta, w } => {
                observer.extend([("N", n.out()), ("theta", theta.out()), ("w", w.out())]);
            }
            CubicStep::SemiImplicit { n, theta, s } => {
                observer.extend([("N", n.out()), ("theta", theta.out())]);
                lyapunov.push(("S", s.out()));
            }
        }
        let periods =
            vec![("shortest", self.shortest.out()), ("longest", self.longest.out()), ("misses", self.misses.out())];
        vec![
            ("plant", self.plant.out()),
            ("observer", Out::Object(observer)),
            ("periods", Out::Object(periods)),
            ("lyapunov", Out::Object(lyapunov)),
        ]
    }
}
