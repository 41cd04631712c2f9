//! The linear observer, in continuous time.

use super::super::fields::Fields;
use super::super::write::Out;
use super::{Fact, FileError, PlantWithin, Statement, decay, enclosed, intervals, rate_term};
use crate::error::ProofError;
use crate::matrix::Matrix;
use crate::statement::{decay_rate_within, positive};

/// `P > 0` and `(A - LC)'P + P(A - LC) + 2 rate P < 0` (12).
///
/// Then `V = e'Pe` of the error `e = x - xhat` of the observer `xhat' = A xhat + B u + L(y - C xhat)`, which obeys `e' = (A - LC)e`, has
/// `V' < -2 rate V` for e other than 0: `V(t) <= exp(-2 rate t) V(0)`, and `|e(t)| <= sqrt(cond P) exp(-rate t) |e(0)|`. With rate 0 and the margin q of (12), `V' <= -q |e|^2`
/// still gives exponential decay, at the rate `q / (2 lambda_max(P))`. B does not matter.
///
/// Where entries of A, B, C are bounds, all of this holds for every plant between them, with the one L and P.
#[derive(Debug, Clone, PartialEq)]
pub struct LinearObserver {
    /// The plant.
    pub plant: PlantWithin,
    /// The gain L, n x p, as stored.
    pub l: Matrix<f64>,
    /// P, n x n.
    pub p: Matrix<f64>,
    /// The rate, 0 or more.
    pub rate: f64,
}

impl Statement for LinearObserver {
    const NAME: &'static str = "linear-observer";

    fn read(file: &mut Fields<'_>) -> Result<Self, FileError> {
        let plant = PlantWithin::read(file)?;
        let mut observer = file.object("observer")?;
        let l = observer.take("L")?.matrix(plant.gain())?;
        observer.finish()?;
        let mut lyapunov = file.object("lyapunov")?;
        let p = lyapunov.take("P")?.symmetric(plant.a.rows())?;
        let rate = lyapunov.rate()?;
        lyapunov.finish()?;
        Ok(Self { plant, l, p, rate })
    }

    fn write(&self) -> Vec<(&'static str, Out)> {
        vec![
            self.plant.write(),
            ("observer", Out::Object(vec![("L", Out::matrix(&self.l))])),
            ("lyapunov", Out::Object(vec![("P", Out::matrix(&self.p)), ("rate", Out::number(self.rate))])),
        ]
    }

    fn words(&self) -> String {
        format!(
            "For the plant x' = Ax + Bu, y = Cx with {} and the observer xhat' = A xhat + Bu + L(y - C xhat), the error e = x - xhat obeys e' = (A - LC)e, and {}.{}",
            self.plant.size(),
            decay(self.rate),
            enclosed([&self.plant.a, &self.plant.b, &self.plant.c])
        )
    }

    fn facts(&self) -> Result<Vec<Fact>, ProofError> {
        let (a, c) = (intervals(&self.plant.a), intervals(&self.plant.c));
        Ok(vec![
            Fact::new("P > 0", positive(&self.p)?),
            Fact::new(
                format!("(A - LC)'P + P(A - LC){} < 0 (12)", rate_term(self.rate, "P")),
                decay_rate_within(&a, &self.l, &c, &self.p, self.rate)?,
            ),
        ])
    }
}
