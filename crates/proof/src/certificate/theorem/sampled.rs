//! The sampled cubic observer with the real gain.

use super::super::Fault;
use super::super::fields::Fields;
use super::super::write::Out;
use super::{Fact, FileError, Plant, Statement};
use crate::definite::positive_semidefinite;
use crate::error::ProofError;
use crate::matrix::Matrix;
use crate::statement::{cubic_dissipation_structured, positive, stein_decrease};

/// `P > 0`, `(A - LC)'P(A - LC) - P < 0`, `theta >= 0`, and `P N C + C'N'P <= 0` (13') for the real matrix `N = -P^-1 C'S`.
///
/// Then `V = e'Pe` falls in the linear step `e+ = (A - LC)e` by a factor below 1, and does not grow along the cubic flow `e' = (y'theta y) N y`, `y = Ce`, however long that
/// takes: the two in turn make e tend to 0 exponentially, from every e(0) and whatever the period.
#[derive(Debug, Clone, PartialEq)]
pub struct SampledCubicObserver {
    /// The sampled plant `x+ = A x + B u`, `y = C x`.
    pub plant: Plant,
    /// The linear gain L, n x p, as stored.
    pub l: Matrix<f64>,
    /// The weight theta, p x p.
    pub theta: Matrix<f64>,
    /// The sampling period, in units of the plant's time.
    pub period: f64,
    /// P, n x n.
    pub p: Matrix<f64>,
    /// S, p x p, which defines N.
    pub s: Matrix<f64>,
}

impl Statement for SampledCubicObserver {
    const NAME: &'static str = "sampled-cubic-observer";

    fn read(file: &mut Fields<'_>) -> Result<Self, FileError> {
        let plant = Plant::read(file)?;
        let (order, outputs) = plant.gain();
        let mut observer = file.object("observer")?;
        let l = observer.take("L")?.matrix((order, outputs))?;
        let theta = observer.take("theta")?.symmetric(outputs)?;
        let s = observer.take("S")?.matrix((outputs, outputs))?;
        let field = observer.take("period")?;
        let period = field.binary64()?;
        if period <= 0.0 {
            return Err(field.error(Fault::Range { value: period, requirement: "a sampling period is positive" }));
        }
        observer.finish()?;
        let mut lyapunov = file.object("lyapunov")?;
        let p = lyapunov.take("P")?.symmetric(order)?;
        lyapunov.finish()?;
        Ok(Self { plant, l, theta, period, p, s })
    }

    fn write(&self) -> Vec<(&'static str, Out)> {
        let observer = vec![
            ("L", Out::matrix(&self.l)),
            ("theta", Out::matrix(&self.theta)),
            ("S", Out::matrix(&self.s)),
            ("period", Out::number(self.period)),
        ];
        vec![
            self.plant.write(),
            ("observer", Out::Object(observer)),
            ("lyapunov", Out::Object(vec![("P", Out::matrix(&self.p))])),
        ]
    }

    fn words(&self) -> String {
        format!(
            "For the sampled plant x+ = Ax + Bu, y = Cx with {} and the sampled cubic observer, whose error e = x - xhat is carried over one period ({:e}) by the exact flow of e' = (e'C'theta C e) N C e with the real gain N = -P^-1 C'S and by the step e+ = (A - LC)e, V = e'Pe falls over each period by a factor below 1, and e tends to 0 exponentially, from every e(0). Nothing is said of a rounding of N or of the step as computed.",
            self.plant.size(),
            self.period
        )
    }

    fn facts(&self) -> Result<Vec<Fact>, ProofError> {
        let Plant { a, c, .. } = &self.plant;
        Ok(vec![
            Fact::new("P > 0", positive(&self.p)?),
            Fact::new("(A - LC)'P(A - LC) - P < 0", stein_decrease(a, &self.l, c, &self.p)?),
            Fact::new("theta >= 0", positive_semidefinite(&self.theta)?),
            Fact::new("P N C + C'N'P <= 0 for N = -P^-1 C'S (13')", cubic_dissipation_structured(&self.p, &self.s, c)?),
        ])
    }
}
