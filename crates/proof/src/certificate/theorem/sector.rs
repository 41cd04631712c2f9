//! The observer of a plant with nonlinearities in sectors.
//!
//! **Hypotheses.** `P > 0` and the block inequality of the S-procedure, at the head of `statement/sector.rs`, for the
//! terms `G_k phi_k(H_k x)` in the incremental sectors `[low_k, high_k]`, for every pair (A, C) between its bounds.
//!
//! **Theorem.** `V = e'Pe` decays faster than `exp(-2 rate t)` along the error of `xhat' = A xhat + sum G_k phi_k(H_k
//! xhat) + L(y - C xhat)`, for every phi_k in its sector; and along `e' = (A(t) - L C(t))e + sum G_k w_k`, also where A
//! and C vary between their bounds, for all w_k in the sectors. The certificate does not show that the nonlinearities
//! of a plant lie in the sectors where x and xhat are; this must be shown separately.
//!
//! **Proof.** With the increments w the block inequality bounds `V' + 2 rate V` by minus the sum of the sectors'
//! quadratic forms times their multipliers, all of which are nonnegative, at each time for the A and C of that time:
//! see [`sector_decrease`](crate::statement::sector_decrease).

use super::super::Fault;
use super::super::fields::{Field, LARGEST_ORDER};
use super::super::members::members;
use super::super::sentence::{Reading, Represented, tends_to_zero};
use super::{Fact, FileError, Statement, are_points, check_rate, counted, decay, enclosed, intervals, rate_term};
use crate::error::ProofError;
use crate::matrix::Matrix;
use crate::number::Datum;
use crate::statement::{SectorTerm, positive, sector_decrease_within};
use crate::wording::{capital, exact};

/// The data of the theorem; the head of the file has statement and proof.
#[derive(Debug, Clone, PartialEq)]
pub struct SectorConvergence {
    /// The linear part, n x n.
    pub a: Matrix<Datum>,
    /// The output matrix, p x n.
    pub c: Matrix<Datum>,
    /// The nonlinearities with their multipliers.
    pub terms: Vec<SectorTerm>,
    /// The gain L, n x p, as stored.
    pub l: Matrix<f64>,
    /// P, n x n.
    pub p: Matrix<f64>,
    /// The rate, 0 or more.
    pub rate: f64,
}

/// What is assumed of the k-th nonlinearity, counted from 1. Where low = -high, H may have another number of rows than
/// phi.
fn sector(k: usize, term: &SectorTerm) -> String {
    if term.low == -term.high {
        return format!("|w_{k}| <= high |H_{k} e| for high = {}", exact(term.high));
    }
    let (low, high) = (exact(term.low), exact(term.high));
    format!("(w_{k} - low H_{k} e)'(high H_{k} e - w_{k}) >= 0 for low = {low}, high = {high}")
}

impl Statement for SectorConvergence {
    const NAME: &'static str = "sector-observer";

    fn facts(&self) -> Result<Vec<Fact>, ProofError> {
        check_rate(self.rate)?;
        if let Some(term) = self.terms.iter().find(|term| term.low > term.high) {
            let what = "the upper end of a sector less the lower, which should not be negative,";
            return Err(ProofError::Sign { what, value: term.high - term.low });
        }
        Ok(vec![
            Fact::new("P > 0", positive(&self.p)?),
            Fact::new(
                format!(
                    "[F'P + PF{} - sum tau low high H'H, PG + tau (low + high)/2 H'; *, -tau I] < 0 for F = A - LC",
                    rate_term(self.rate, "P")
                ),
                sector_decrease_within(
                    &intervals(&self.a),
                    &self.l,
                    &intervals(&self.c),
                    &self.p,
                    self.rate,
                    &self.terms,
                )?,
            ),
        ])
    }

    fn sentence(&self, reading: &Reading<'_>, margin: f64) -> Option<String> {
        let (hypothesis, given) = match reading.plant {
            Represented::Jacobians { hypothesis, .. } => (hypothesis, String::new()),
            Represented::InSectors { hypothesis } => {
                let which = match self.terms.len() {
                    1 => "every nonlinearity within its sector".to_owned(),
                    count => format!("all {count} nonlinearities within their sectors"),
                };
                (hypothesis, format!(", for {which}"))
            }
            _ => return None,
        };
        Some(format!("{}, the error {}{given}.", capital(hypothesis), tends_to_zero(self.rate, &self.p, margin)))
    }

    fn words(&self) -> String {
        let sectors: Vec<String> = self.terms.iter().enumerate().map(|(k, term)| sector(k + 1, term)).collect();
        let increments = match sectors.len() {
            0 => "without nonlinearities".to_owned(),
            _ => format!(
                "whose increments w_k = phi_k(t, H_k x, u) - phi_k(t, H_k xhat, u) satisfy {}",
                sectors.join(", and ")
            ),
        };
        let data = [&self.a, &self.c];
        let varying = if are_points(data) {
            String::new()
        } else {
            let enclosed = enclosed(data, "");
            format!("{enclosed} It holds for e' = (A(t) - L C(t))e + sum_k G_k w_k where they vary in time, too.")
        };
        format!(
            "For every plant x' = Ax + sum_k G_k phi_k(t, H_k x, u) + g(t, y, u), y = Cx with {}, {} and {}, {increments}, and the observer xhat' = A xhat + sum_k G_k phi_k(t, H_k xhat, u) + g(t, y, u) + L(y - C xhat), e = x - xhat: {}, from every e(0). That the nonlinearities of a plant satisfy this, where x and xhat are, is a hypothesis.{varying}",
            counted(self.a.rows(), "state"),
            counted(self.c.rows(), "output"),
            match self.terms.len() {
                1 => "1 nonlinearity".to_owned(),
                count => format!("{count} nonlinearities"),
            },
            decay("e'Pe", "e", self.rate),
        )
    }
}

members! { SectorConvergence {
    "plant" {
        a = "A".square_data();
        c = "C".data_with_columns(a.rows());
        terms = "sectors".by(|sectors| read_terms(sectors, a.rows()));
    }
    "observer" { l = "L".matrix((a.rows(), c.rows())); }
    "lyapunov" { p = "P".symmetric(a.rows()); rate = "rate".rate(); }
} }

members! { SectorTerm, states: usize { {
    g = "G".by(|g| g.any_matrix().and_then(|_| g.matrix_with_rows(states)));
    h = "H".matrix_with_columns(states);
    low = "low".binary64();
    high = "high".number(|high| low <= high, "the upper end of a sector is not below the lower");
    tau = "tau".binary64();
} } }

fn read_terms(list: &Field<'_>, states: usize) -> Result<Vec<SectorTerm>, FileError> {
    let mut order = states;
    list.some_of(|item| {
        let term: SectorTerm = item.part_of(states)?;
        let (expected, found) = ((term.g.cols(), states), term.h.shape());
        if term.low != -term.high && expected != found {
            return Err(item.member("H")?.error(Fault::Shape { expected, found }));
        }
        // The matrix of the S-procedure has a row for each state and each nonlinearity.
        order += term.g.cols();
        list.bounded_order(order, LARGEST_ORDER)?;
        Ok(term)
    })
}
