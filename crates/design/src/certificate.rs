//! Certificates: the inequalities behind a design, each decided outside floating point.
//!
//! A certificate states facts about the numbers that run: L, P and theta as stored, evaluated exactly or with outward rounding by
//! `luenberger-proof`. The cubic gain `N = -P^-1 C'S` is a rounding of a real matrix, so it has a statement of its own: from which errors the observer
//! with the stored N converges. What follows from the facts (stability, a rate) is a theorem, cited in [`crate::cubic`] and in `docs/theory-cubic.md`.

use core::fmt;

use luenberger_plants::DynamicPlant;
use luenberger_proof::statement::{self, DeployedCubic, Reach};
use luenberger_proof::{Direction, Interval, Matrix, ProofError, Verdict, positive_semidefinite};
use nalgebra::DMatrix;

use crate::cubic::CubicDesign;
use crate::number::coefficient;

/// One inequality and what is known of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Fact {
    /// The inequality, as it is written in the theory, with its equation number.
    pub statement: String,
    /// Proved, refuted or undecided.
    pub verdict: Verdict<Direction>,
}

/// The facts behind a design.
#[derive(Debug, Clone, PartialEq)]
pub struct Certificate {
    /// The inequalities, in the order in which the theory asks for them.
    pub facts: Vec<Fact>,
    /// For a cubic observer: from which errors the observer with the gains exactly as stored is proved to converge.
    pub deployed: Option<DeployedCubic>,
}

impl Certificate {
    /// Whether every fact is proved. The facts are about L and P as stored and about the real matrix `N = -P^-1 C'S`; for N as stored see
    /// [`converges_from_everywhere`](Self::converges_from_everywhere).
    pub fn is_proved(&self) -> bool {
        self.facts.iter().all(|fact| fact.verdict.is_proved())
    }

    /// Whether the cubic observer in continuous time with all its gains exactly as stored is proved to converge from every error. False for designs that
    /// make no such statement. (The facts of a sampled cubic observer include it: there [`is_proved`](Self::is_proved) says so.)
    pub fn converges_from_everywhere(&self) -> bool {
        matches!(self.deployed.as_ref().map(|deployed| &deployed.reach), Some(Reach::Everywhere { .. }))
    }
}

impl Fact {
    /// `P > 0`, under the name the theory gives that matrix.
    pub(crate) fn positive(name: &str, p: &DMatrix<f64>) -> Result<Self, ProofError> {
        Ok(Self { statement: format!("{name} > 0"), verdict: statement::positive(&exact(p)?)? })
    }

    /// (12) with a decay rate, for the gain as stored; `vertex` names which of several state matrices `a` is.
    pub(crate) fn decay(
        vertex: &str,
        (a, c): (&DMatrix<f64>, &DMatrix<f64>),
        l: &DMatrix<f64>,
        p: &DMatrix<f64>,
        rate: f64,
    ) -> Result<Self, ProofError> {
        // Of several vertices the inequality is not the paper's (12), which has one A.
        let place = if vertex.is_empty() { " (12)" } else { vertex };
        Ok(Self {
            statement: decay_at(place, rate),
            verdict: statement::decay_rate(&exact(a)?, &exact(l)?, &exact(c)?, &exact(p)?, rate)?,
        })
    }

    /// The decrease for every pair (A, C) between the bounds, for the gain as stored.
    pub(crate) fn decay_around(
        vertex: &str,
        (a, c): &(Matrix<Interval>, Matrix<Interval>),
        l: &DMatrix<f64>,
        p: &DMatrix<f64>,
        rate: f64,
    ) -> Result<Self, ProofError> {
        Ok(Self {
            statement: decay_at(vertex, rate),
            verdict: statement::decay_rate_within(a, &exact(l)?, c, &exact(p)?, rate)?,
        })
    }

    /// The decrease in discrete time, for the gain as stored.
    pub(crate) fn stein_decrease(
        (ad, c): (&DMatrix<f64>, &DMatrix<f64>),
        ld: &DMatrix<f64>,
        p: &DMatrix<f64>,
    ) -> Result<Self, ProofError> {
        Ok(Self {
            statement: "(Ad - Ld C)'P(Ad - Ld C) - P < 0".to_owned(),
            verdict: statement::stein_decrease(&exact(ad)?, &exact(ld)?, &exact(c)?, &exact(p)?)?,
        })
    }

    /// The decrease at the other end of the cubic flow, for the stored N, which nothing else is asked of.
    pub(crate) fn saturated_decrease(
        (ad, c): (&DMatrix<f64>, &DMatrix<f64>),
        (n, w): (&DMatrix<f64>, f64),
        p: &DMatrix<f64>,
    ) -> Result<Self, ProofError> {
        Ok(Self {
            statement: "(w Ad + Ad N C)'P(w Ad + Ad N C) - w^2 P < 0".to_owned(),
            verdict: statement::saturated_decrease(&exact(ad)?, &exact(c)?, &exact(n)?, w, &exact(p)?)?,
        })
    }

    /// `theta >= 0`.
    pub(crate) fn weight(theta: &DMatrix<f64>) -> Result<Self, ProofError> {
        Ok(Self { statement: "theta >= 0".to_owned(), verdict: positive_semidefinite(&exact(theta)?)? })
    }

    /// `S + S' >= 0`.
    pub(crate) fn accretive(s: &DMatrix<f64>) -> Result<Self, ProofError> {
        Ok(Self { statement: "S + S' >= 0".to_owned(), verdict: statement::accretive(&exact(s)?)? })
    }

    /// (13') for the real gain `N = -P^-1 C'S`.
    pub(crate) fn dissipation(p: &DMatrix<f64>, s: &DMatrix<f64>, c: &DMatrix<f64>) -> Result<Self, ProofError> {
        Ok(Self {
            statement: "P N C + C'N'P <= 0 for N = -P^-1 C'S (13')".to_owned(),
            verdict: statement::cubic_dissipation_structured(&exact(p)?, &exact(s)?, &exact(c)?)?,
        })
    }

    /// The block inequality (25).
    pub(crate) fn feedback_block(
        design: &CubicDesign,
        k: &DMatrix<f64>,
        p1: &DMatrix<f64>,
    ) -> Result<Self, ProofError> {
        let o = &design.observer;
        let verdict = statement::feedback_block(
            &exact(&o.a)?,
            &exact(&o.b)?,
            &exact(k)?,
            &exact(&o.l)?,
            &exact(&o.c)?,
            &exact(p1)?,
            &exact(&design.p)?,
        )?;
        Ok(Self { statement: "the block inequality of the loop u = -K xhat (25)".to_owned(), verdict })
    }
}

/// From which errors the observer converges with its gains exactly as stored.
pub(crate) fn deployed(
    plant: &DynamicPlant,
    (l, n, theta): (&DMatrix<f64>, &DMatrix<f64>, &DMatrix<f64>),
    p: &DMatrix<f64>,
    s: &DMatrix<f64>,
) -> Result<DeployedCubic, ProofError> {
    statement::deployed_cubic(
        &exact(&plant.a)?,
        &exact(l)?,
        &exact(&plant.c)?,
        &exact(p)?,
        &exact(n)?,
        &exact(s)?,
        &exact(theta)?,
    )
}

/// The same numbers for the prover, which reads rows first.
/// ` + 2 rate P` with its number, nothing for the rate 0; twice a double is exact.
pub(crate) fn decay_term(rate: f64, p: &str) -> String {
    if rate == 0.0 { String::new() } else { format!(" + {}{p}", coefficient(2.0 * rate)) }
}

/// `(A - LC)'P + P(A - LC) + 2 rate P < 0` at one of several vertices.
pub(crate) fn decay_at(vertex: &str, rate: f64) -> String {
    format!("(A - LC)'P + P(A - LC){} < 0{vertex}", decay_term(rate, "P"))
}

pub(crate) fn exact(m: &DMatrix<f64>) -> Result<Matrix<f64>, ProofError> {
    Matrix::from_column_major(m.nrows(), m.ncols(), m.as_slice())
}

impl fmt::Display for Fact {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:<9}  {}", self.verdict.word(), self.statement)?;
        match &self.verdict {
            Verdict::Proved { margin } => write!(f, ", margin {margin:.3e}"),
            Verdict::Refuted { witness } => write!(f, ": {witness}"),
            Verdict::Undecided { why, best } => write!(f, ": {why} (best margin {best:.3e})"),
        }
    }
}

impl fmt::Display for Certificate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for fact in &self.facts {
            writeln!(f, "{fact}")?;
        }
        match self.deployed.as_ref().map(|deployed| &deployed.reach) {
            None => Ok(()),
            Some(Reach::Everywhere { .. }) => writeln!(f, "As stored, the observer converges from every error."),
            Some(Reach::Within(region)) => {
                writeln!(f, "As stored, the observer converges from every error shorter than {:.3e}.", region.ball)
            }
            Some(Reach::Unproved) => writeln!(f, "As stored, convergence is not proved."),
        }
    }
}
