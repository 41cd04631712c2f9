//! Theorem 1 of the cubic paper, for gains from any source.
//!
//! **Hypotheses.** `P > 0`, `F'P + PF < 0` (12) for `F = A - LC`, `theta >= 0`, and `P N C + C'N'P <= 0` (13') exactly
//! for L and N as stored.
//!
//! **Theorem.** `V = e'Pe` decreases along the error of the cubic observer with the stored N, from every e(0). An N
//! that was rounded does not satisfy (13'): for those see `cubic.rs`.
//!
//! **Proof.** As in `structured.rs`.

use super::super::fields::Fields;
use super::super::write::Out;
use super::{Fact, FileError, PlantMatrices, Statement, decay};
use crate::definite::positive_semidefinite;
use crate::error::ProofError;
use crate::matrix::Matrix;
use crate::statement::{cubic_dissipation, lyapunov_decrease, positive};

/// The data of the theorem; the head of the file has statement and proof.
#[derive(Debug, Clone, PartialEq)]
pub struct CubicTheorem1 {
    /// The plant.
    pub plant: PlantMatrices,
    /// The linear gain L, n x p.
    pub l: Matrix<f64>,
    /// The cubic gain N, n x p.
    pub n: Matrix<f64>,
    /// The weight theta, p x p.
    pub theta: Matrix<f64>,
    /// P, n x n.
    pub p: Matrix<f64>,
}

impl Statement for CubicTheorem1 {
    const NAME: &'static str = "cubic-observer-theorem-1";

    fn facts(&self) -> Result<Vec<Fact>, ProofError> {
        let PlantMatrices { a, c, .. } = &self.plant;
        Ok(vec![
            Fact::new("P > 0", positive(&self.p)?),
            Fact::new("(A - LC)'P + P(A - LC) < 0 (12)", lyapunov_decrease(a, &self.l, c, &self.p)?),
            Fact::new("theta >= 0", positive_semidefinite(&self.theta)?),
            Fact::new("P N C + C'N'P <= 0 (13')", cubic_dissipation(&self.p, &self.n, c)?),
        ])
    }

    fn words(&self) -> String {
        format!(
            "For the plant x' = Ax + Bu, y = Cx with {} and the cubic observer xhat' = A xhat + Bu + L r - (r'theta r) N r, r = y - C xhat, with L and N exactly as stored: the error e = x - xhat obeys e' = (A - LC)e + (e'C'theta C e) N C e, and {}, from every e(0).",
            self.plant.size(),
            decay("e'Pe", "e", 0.0)
        )
    }

    fn read(file: &mut Fields<'_>) -> Result<Self, FileError> {
        let plant = PlantMatrices::read(file)?;
        let (order, outputs) = plant.gain();
        let mut observer = file.object("observer")?;
        let l = observer.take("L")?.matrix((order, outputs))?;
        let n = observer.take("N")?.matrix((order, outputs))?;
        let theta = observer.take("theta")?.symmetric(outputs)?;
        observer.finish()?;
        let mut lyapunov = file.object("lyapunov")?;
        let p = lyapunov.take("P")?.symmetric(order)?;
        lyapunov.finish()?;
        Ok(Self { plant, l, n, theta, p })
    }

    fn write(&self) -> Vec<(&'static str, Out)> {
        let observer =
            vec![("L", Out::matrix(&self.l)), ("N", Out::matrix(&self.n)), ("theta", Out::matrix(&self.theta))];
        vec![
            self.plant.write(),
            ("observer", Out::Object(observer)),
            ("lyapunov", Out::Object(vec![("P", Out::matrix(&self.p))])),
        ]
    }
}
