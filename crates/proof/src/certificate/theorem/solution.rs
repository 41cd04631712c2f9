//! The exact solution of a Lyapunov or Stein equation lies in a matrix of intervals.
//!
//! **Theorem.** For all A and all symmetric Q between their bounds the equation has exactly one solution, and each of
//! its entries lies in its interval.
//!
//! The enclosure is derived again from A, Q and the approximate solution ([`lyapunov_solution`], [`stein_solution`],
//! which contain the proof). A claimed interval that is narrower than the derived one, by one unit in the last place of
//! one end, is rejected; a wider one is accepted.

use super::super::Rejection;
use super::super::members::members;
use super::super::write::{Out, Written};
use super::{Fact, Names, Statement, bounded, enclosed, intervals};
use crate::error::ProofError;
use crate::interval::Interval;
use crate::matrix::Matrix;
use crate::number::Datum;
use crate::statement::{Enclosure, lyapunov_solution, stein_solution};
use crate::verdict::{UndecidedReason, Verdict};

/// Which equation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Equation {
    /// `A'P + PA + Q = 0`.
    Lyapunov,
    /// `A'PA - P + Q = 0`.
    Stein,
}

impl Equation {
    const ALL: [Self; 2] = [Self::Lyapunov, Self::Stein];

    /// The equation, as the literature writes it.
    pub fn text(self) -> &'static str {
        match self {
            Self::Lyapunov => "A'P + PA + Q = 0",
            Self::Stein => "A'PA - P + Q = 0",
        }
    }
}

/// The data of the theorem; the head of the file has statement and proof.
#[derive(Debug, Clone, PartialEq)]
pub struct SolutionWithin {
    /// Which equation.
    pub equation: Equation,
    /// A, n x n.
    pub a: Matrix<Datum>,
    /// Q, symmetric n x n.
    pub q: Matrix<Datum>,
    /// Symmetric matrices whose sum is near the solution.
    pub approximation: Vec<Matrix<f64>>,
    /// A symmetric W that proves A stable, if one is to be tried.
    pub stability: Option<Matrix<f64>>,
    /// The intervals that are claimed, symmetric n x n.
    pub p: Matrix<Interval>,
}

impl SolutionWithin {
    /// The equation with the intervals that are derived from the approximate solution, for all A and Q in their
    /// intervals.
    ///
    /// ```
    /// use luenberger_proof::certificate::{CertificateFile, Equation, SolutionWithin, verify};
    /// use luenberger_proof::{Interval, Matrix};
    /// // -2p + 3 = 0: 3/2, to the last bit.
    /// let number = |x: f64| Matrix::from_rows([[Interval::around(x, 0.0).unwrap()]]);
    /// let near = [Matrix::from_rows([[1.5]])];
    /// let theorem = SolutionWithin::derive(Equation::Lyapunov, &number(-1.0), &number(3.0), &near, None)?;
    /// assert!(theorem.p[(0, 0)].contains(1.5) && theorem.p[(0, 0)].width() < 1e-15);
    /// let file = CertificateFile::prove("by hand", theorem)?.to_json();
    /// assert!(verify(file.as_bytes())?.statement.starts_with("The equation A'P + PA + Q = 0 with the 1 x 1 matrices"));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    /// # Errors
    /// [`Rejection::NotProved`] where the solution is not shown to be unique; [`Rejection::Proof`] for shapes that do
    /// not fit, entries that are unbounded, matrices that are not symmetric.
    pub fn derive(
        equation: Equation,
        a: &Matrix<Interval>,
        q: &Matrix<Interval>,
        approximation: &[Matrix<f64>],
        stability: Option<&Matrix<f64>>,
    ) -> Result<Self, Rejection> {
        let (a, q) = (bounded(a, "A")?, bounded(q, "Q")?);
        let (approximation, stability) = (approximation.to_vec(), stability.cloned());
        let mut theorem = Self { equation, a, q, approximation, stability, p: Matrix::zeros(0, 0) };
        match theorem.derived()? {
            Enclosure::Enclosed(found) => theorem.p = found.p,
            Enclosure::Undecided { why } => {
                let verdict = Box::new(Verdict::Undecided { why, best: f64::NAN });
                return Err(Rejection::NotProved { inequality: theorem.inequality(), verdict });
            }
        }
        Ok(theorem)
    }

    fn inequality(&self) -> String {
        format!("{} has one solution, and it lies in P", self.equation.text())
    }

    fn derived(&self) -> Result<Enclosure, ProofError> {
        let (a, q) = (intervals(&self.a), intervals(&self.q));
        let solve = match self.equation {
            Equation::Lyapunov => lyapunov_solution,
            Equation::Stein => stein_solution,
        };
        solve(&a, &q, &self.approximation, self.stability.as_ref())
    }

    /// The first end that lies within what is proved.
    fn too_tight(&self, proved: &Matrix<Interval>) -> Option<UndecidedReason> {
        for row in 0..proved.rows() {
            for column in 0..proved.cols() {
                let (claimed, proved) = (self.p[(row, column)], proved[(row, column)]);
                let (lo, hi) = ((claimed.lo(), proved.lo()), (claimed.hi(), proved.hi()));
                if let Some((claimed, proved)) =
                    [(lo, lo.0 > lo.1), (hi, hi.0 < hi.1)].iter().find(|x| x.1).map(|x| x.0)
                {
                    return Some(UndecidedReason::TighterThanProved { row, column, claimed, proved });
                }
            }
        }
        None
    }
}

impl Statement for SolutionWithin {
    const NAME: &'static str = "solution-within";

    fn facts(&self, _: Names<'_>) -> Result<Vec<Fact>, ProofError> {
        let verdict = match self.derived()? {
            Enclosure::Undecided { why } => Verdict::Undecided { why, best: f64::NAN },
            Enclosure::Enclosed(found) => match self.too_tight(&found.p) {
                Some(why) => Verdict::Undecided { why, best: f64::NAN },
                None => Verdict::Proved { margin: 0.0 },
            },
        };
        Ok(vec![Fact::stated(self.inequality(), verdict)])
    }

    fn words(&self) -> String {
        format!(
            "The equation {} with the {n} x {n} matrices A and Q has exactly one solution. It is symmetric, and each of its entries lies between the bounds that P gives.{}",
            self.equation.text(),
            enclosed([&self.a, &self.q], "Q"),
            n = self.a.rows(),
        )
    }
}

members! { SolutionWithin {
    {
        equation = "equation".word(&Equation::ALL.map(|equation| (equation.text(), equation)));
        a = "A".square_data();
        q = "Q".symmetric_data_of(a.rows());
    }
    "proposal" {
        approximation = "P".list_of(|p| p.symmetric(a.rows()));
        stability = optional "W".symmetric(a.rows());
    }
    { p = "P".symmetric_intervals(a.rows()); }
} }

impl Written for Equation {
    fn out(&self) -> Out {
        self.text().out()
    }
}
