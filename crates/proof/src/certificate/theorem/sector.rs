//! The observer of a plant with nonlinearities in sectors.
//!
//! Plant `x' = Ax + sum_k G_k phi_k(H_k x)`, observer `xhat' = A xhat + sum_k G_k phi_k(H_k xhat) + L(y - C xhat)`.
//! With `e = x - xhat` and `w_k = phi_k(H_k x) - phi_k(H_k xhat)`, the incremental sector `[low, high]` is `(w_k - low
//! H_k e)'(high H_k e - w_k) >= 0`: for a scalar phi_k bounds of its slope, for `low = -high` the Lipschitz condition
//! `|w_k| <= high |H_k e|`.
//!
//! **Hypotheses.** `P > 0` and, for every pair (A, C) between its bounds and `F = A - LC`,
//! ```text
//! [ F'P + PF + 2 rate P - sum tau_k low_k high_k H_k'H_k    P G_k + tau_k (low_k + high_k)/2 H_k' ]
//! [ its transpose                                                        -tau_k I                 ]  < 0,
//! ```
//! which includes `tau_k > 0`.
//!
//! **Theorem.** `V = e'Pe` decays faster than `exp(-2 rate t)` along the error of `xhat' = A xhat + sum G_k phi_k(H_k
//! xhat) + L(y - C xhat)`, for every phi_k in its sector; and along `e' = (A(t) - L C(t))e + sum G_k w_k`, also where A
//! and C vary between their bounds, for all w_k in the sectors. The certificate does not show that the nonlinearities
//! of a plant lie in the sectors where x and xhat are; this must be shown separately.
//!
//! **Proof.** With the increments w the block inequality bounds `V' + 2 rate V` by minus the sum of the sectors'
//! quadratic forms times their multipliers, all of which are nonnegative, at each time for the A and C of that time
//! (S-procedure). Proved with margin q: `V' <= -2 rate V - q (|e|^2 + |w|^2)`. A witness is the stacked direction
//! `(e, w_1, w_2, ..)`; it refutes this P and these multipliers, not the observer.
//!
//! Sources: R. Rajamani, Observers for Lipschitz nonlinear systems, IEEE Transactions on Automatic Control 43, 1998; M.
//! Arcak and P. Kokotovic, Nonlinear observers: a circle criterion design and robustness analysis, Automatica 37, 2001.

use super::super::Fault;
use super::super::fields::{Field, LARGEST_ORDER};
use super::super::members::members;
use super::super::sentence::{Reading, Represented, tends_to_zero};
use super::{Fact, FileError, Names, Statement, are_points, check_rate, counted, decay, enclosed, rate_term};
use crate::embed::number;
use crate::error::ProofError;
use crate::interval::Interval;
use crate::matrix::Matrix;
use crate::number::Datum;
use crate::wording::{capital, exact};

/// One nonlinearity `G phi(H x)` in the incremental sector `[low, high]`, and its multiplier.
#[derive(Debug, Clone, PartialEq)]
pub struct SectorTerm {
    /// Input matrix of the nonlinearity, n x q.
    pub g: Matrix<f64>,
    /// Argument matrix of the nonlinearity, r x n; `r = q` unless `low = -high`.
    pub h: Matrix<f64>,
    /// Lower bound of the sector.
    pub low: f64,
    /// Upper bound of the sector.
    pub high: f64,
    /// Multiplier tau of the S-procedure.
    pub tau: f64,
}

impl SectorTerm {
    fn is_symmetric(&self) -> bool {
        self.low == -self.high
    }

    fn check(&self, states: usize) -> Result<(), ProofError> {
        for (what, x) in [("low", self.low), ("high", self.high), ("tau", self.tau)] {
            number::<Interval>(x, what)?;
        }
        if self.low > self.high {
            let what = "the upper end of a sector less the lower, which should not be negative,";
            return Err(ProofError::Sign { what, value: self.high - self.low });
        }
        let columns = self.g.cols();
        self.g.expect_shape("G", (states, columns))?;
        self.h.expect_shape("H", (if self.is_symmetric() { self.h.rows() } else { columns }, states))
    }
}

/// The numbers of the term behind each column of G, or behind each row of H.
fn numbers(places: &[(&SectorTerm, usize)]) -> [Vec<f64>; 3] {
    let of = |number: fn(&SectorTerm) -> f64| places.iter().map(|(term, _)| number(term)).collect();
    [of(|term| term.tau), of(|term| term.low), of(|term| term.high)]
}

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
    if term.is_symmetric() {
        return format!("|w_{k}| <= high |H_{k} e| for high = {}", exact(term.high));
    }
    let (low, high) = (exact(term.low), exact(term.high));
    format!("(w_{k} - low H_{k} e)'(high H_{k} e - w_{k}) >= 0 for low = {low}, high = {high}")
}

impl Statement for SectorConvergence {
    const NAME: &'static str = "sector-observer";

    fn facts(&self, names: Names<'_>) -> Result<Vec<Fact>, ProofError> {
        check_rate(self.rate)?;
        let states = self.a.rows();
        self.terms.iter().try_for_each(|term| term.check(states))?;
        // G and H of all terms side by side; of a symmetric sector nothing but PG is in the corner.
        let columns: Vec<(&SectorTerm, usize)> =
            self.terms.iter().flat_map(|term| (0..term.g.cols()).map(move |k| (term, k))).collect();
        let rows: Vec<(&SectorTerm, usize)> =
            self.terms.iter().flat_map(|term| (0..term.h.rows()).map(move |k| (term, k))).collect();
        let g = Matrix::from_fn(states, columns.len(), |i, j| columns[j].0.g[(i, columns[j].1)]);
        let h = Matrix::from_fn(rows.len(), states, |i, j| rows[i].0.h[(rows[i].1, j)]);
        let skew = Matrix::from_fn(columns.len(), states, |i, j| match columns[i] {
            (term, _) if term.is_symmetric() => 0.0,
            (term, k) => term.h[(k, j)],
        });
        let ([tau, low, high], [tau_h, low_h, high_h]) = (numbers(&columns), numbers(&rows));
        let names = names.of(self).matrix("G", &g).matrix("H", &h).matrix("skew", &skew);
        let names = names.list("tau", &tau).list("low", &low).list("high", &high);
        let names = names.list("tau_h", &tau_h).list("low_h", &low_h).list("high_h", &high_h);
        let names = names.define("F", "A - LC")?.define("tau I", "diag(tau)")?;
        let names = names.define("sum tau low high H'H", "H'diag(tau_h)diag(low_h)diag(high_h)H")?;
        let names = names.define("tau (low + high)/2 H'", "skew'(diag(low) + diag(high))diag(tau)/2")?;
        let rate = rate_term(self.rate, "P");
        names.facts([
            "P > 0".to_owned(),
            format!(
                "[F'P + PF{rate} - sum tau low high H'H, PG + tau (low + high)/2 H'; *, -tau I] < 0 for F = A - LC"
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
        if !term.is_symmetric() && expected != found {
            return Err(item.member("H")?.error(Fault::Shape { expected, found }));
        }
        // The matrix of the S-procedure has a row for each state and each nonlinearity.
        order += term.g.cols();
        list.bounded_order(order, LARGEST_ORDER)?;
        Ok(term)
    })
}
