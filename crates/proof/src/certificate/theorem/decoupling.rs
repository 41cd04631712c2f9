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
//! **Proof.** In the head of `statement/decoupling.rs`.

use super::super::members::members;
use super::super::sentence::{Reading, Represented, tends_to_zero};
use super::filter_problem::TIMES;
use super::{Fact, PlantMatrices, Statement, counted};
use crate::error::ProofError;
use crate::matrix::Matrix;
use crate::statement::{Decoupling, TimeDomain, decoupling};

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

impl Statement for DecouplingConvergence {
    const NAME: &'static str = "decoupling-observer";

    fn facts(&self) -> Result<Vec<Fact>, ProofError> {
        let PlantMatrices { a, c, .. } = &self.plant;
        let of = Decoupling { time: self.time, a, c, e: &self.e, f: &self.f, l: &self.l };
        let found = decoupling(&of, &self.p)?;
        let decrease = match self.time {
            TimeDomain::Continuous => "(TA - JC)'P + P(TA - JC) < 0",
            TimeDomain::Discrete => "(TA - JC)'P(TA - JC) - P < 0",
        };
        Ok(vec![
            Fact::new("S'S > 0", found.rank),
            Fact::new("P > 0", found.positive),
            Fact::new(decrease, found.decrease),
        ])
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
