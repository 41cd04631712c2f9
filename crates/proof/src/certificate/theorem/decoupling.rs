//! The unknown-input observer of a plant whose unknown input enters the outputs as well, in continuous or discrete
//! time.
//!
//! **Hypotheses.** `S = [CE F1; F 0]` has full column rank, F1 being the columns of F that are not 0; with
//! `[H G] = [E - LF, 0] (S'S)^-1 S'`, `J = L + G` and `T = I - HC` for the stored L, `P > 0` and
//! `(TA - JC)'P + P(TA - JC) < 0`, in discrete time `(TA - JC)'P(TA - JC) - P < 0`.
//!
//! **Theorem.** The error of `z' = TA xhat + TBu + J r`, `r = y - C xhat`, `xhat = z + Hy` (or `z+`), with the real
//! matrices H, T and J, tends to 0 exponentially from every e(0), for every d.
//!
//! **Proof.** `e = x - xhat = T x - H F d - z`. If `H F = 0` and `T E = J F`, then `e' = (TA - JC) e + (TE - JF) d =
//! (TA - JC) e` for every d; in discrete time likewise. With `J = L + G` both conditions are `[H G] S = [E - LF, 0]`,
//! which `[H G] = [E - LF, 0] (S'S)^-1 S'` solves exactly if S has full column rank. H and G are rational functions of
//! the data and are enclosed as in `statement/left_inverse.rs`. V = e'Pe decreases by the last inequality. S has full
//! column rank iff the columns of F1 are independent and `rank [CE F; F 0] = q + rank(F)` (Hautus, Linear Algebra and
//! its Applications 50, 1983, for the estimate of x from y and y'). For F = 0 it is `H = E((CE)'CE)^-1(CE)'` and J = L.

use super::super::members::members;
use super::super::sentence::{Reading, Represented, tends_to_zero};
use super::filter_problem::TIMES;
use super::{Fact, Names, PlantMatrices, Statement, counted};
use crate::error::ProofError;
use crate::matrix::Matrix;
use crate::statement::{TimeDomain, times_left_inverse};

/// The data of the theorem; the head of the file has statement and proof.
#[derive(Debug, Clone, PartialEq)]
pub struct DecouplingConvergence {
    /// Continuous or discrete.
    pub time: TimeDomain,
    /// The plant.
    pub plant: PlantMatrices,
    /// How the unknown input enters the states, n x q.
    pub e: Matrix<f64>,
    /// How it enters the outputs, p x q.
    pub f: Matrix<f64>,
    /// The gain L, n x p, as stored.
    pub l: Matrix<f64>,
    /// P, n x n.
    pub p: Matrix<f64>,
}

impl DecouplingConvergence {
    /// F1, the columns of F that are not 0.
    fn fed(&self) -> Matrix<f64> {
        let f = &self.f;
        let fed: Vec<usize> = (0..f.cols()).filter(|j| (0..f.rows()).any(|i| f[(i, *j)] != 0.0)).collect();
        Matrix::from_fn(f.rows(), fed.len(), |i, j| f[(i, fed[j])])
    }
}

impl Statement for DecouplingConvergence {
    const NAME: &'static str = "decoupling-observer";

    fn facts(&self, names: Names<'_>) -> Result<Vec<Fact>, ProofError> {
        let PlantMatrices { a, c, .. } = &self.plant;
        let (order, outputs, fed) = (a.rows(), c.rows(), self.fed());
        let none = Matrix::from_fn(order, fed.cols(), |_, _| 0.0);
        let names = names.of(self).matrix("F1", &fed).matrix("O", &none).define("S", "[CE, F1; F, 0]")?;
        let mut facts = names.facts(["S'S > 0"])?;
        // [H G].
        let both = if facts.iter().all(|fact| fact.verdict.is_proved()) {
            times_left_inverse(&names.expression("[E - LF, O]")?, &names.expression("S")?)?
        } else {
            None
        };
        both.iter().try_for_each(|both| both.expect_shape("[H G]", (order, 2 * outputs)))?;
        let part =
            |first: usize| both.as_ref().map(|both| Matrix::from_fn(order, outputs, |i, j| both[(i, first + j)]));
        let names = names.enclosed("H", part(0).as_ref(), false).enclosed("G", part(outputs).as_ref(), false);
        let names = names.define("T", "I - HC")?.define("J", "L + G")?;
        let decrease = match self.time {
            TimeDomain::Continuous => "(TA - JC)'P + P(TA - JC) < 0",
            TimeDomain::Discrete => "(TA - JC)'P(TA - JC) - P < 0",
        };
        facts.extend(names.facts(["P > 0", decrease])?);
        Ok(facts)
    }

    fn sentence(&self, reading: &Reading<'_>, margin: f64) -> Option<String> {
        if !matches!(reading.plant, Represented::Itself) {
            return None;
        }
        let (d, falls) = match self.time {
            TimeDomain::Continuous => ("d(t)", tends_to_zero(0.0, &self.p, margin)),
            TimeDomain::Discrete => ("d(k)", "tends to 0".to_owned()),
        };
        Some(format!(
            "For every disturbance {d} the error of x {falls}, for all x(0) and xhat(0), with H, J and T = I - HC as real matrices."
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
        let (plant, next, step) = match self.time {
            TimeDomain::Continuous => ("plant", "'", ""),
            TimeDomain::Discrete => ("discrete-time plant", "+", " at each step"),
        };
        format!(
            "For the {plant} x{next} = Ax + Bu + Ed, y = Cx + Fd with {sizes}, any unknown input d, and the observer z{next} = TA xhat + TBu + J r, r = y - C xhat, xhat = z + Hy, with the real matrices [H G] = [E - LF, 0] (S'S)^-1 S', J = L + G and T = I - HC, where S = [CE F1; F 0], F1 the columns of F that are not 0, and L exactly as stored: HF = 0 and TE = JF, the error e = x - xhat obeys e{next} = (TA - JC)e whatever d is, V = e'Pe decreases{step}, and e tends to 0 exponentially, from every e(0). Nothing is said of a rounding of H, J, TA and TB."
        )
    }
}

members! { DecouplingConvergence {
    {
        time = "time".word(&TIMES);
        plant: PlantMatrices = "plant".part();
        e = "E".columns(plant.order());
        f = "F".matrix((plant.outputs(), e.cols()));
    }
    "observer" { l = "L".matrix(plant.gain()); }
    "lyapunov" { p = "P".symmetric(plant.order()); }
} }
