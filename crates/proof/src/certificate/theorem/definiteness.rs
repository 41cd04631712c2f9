//! A matrix is definite.
//!
//! **Theorem.** `v'Mv` has the given sign for every v (other than 0, if strict). The only condition is the definiteness
//! itself; its margin is a lower bound of the smallest eigenvalue of M, or of -M. Where entries are intervals, this
//! holds for every symmetric matrix within them.

use super::super::members::members;
use super::super::write::{Out, Written};
use super::{Fact, Names, Statement, enclosed};
use crate::error::ProofError;
use crate::matrix::Matrix;
use crate::number::Datum;

/// Which definiteness.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sign {
    /// `M > 0`.
    PositiveDefinite,
    /// `M >= 0`.
    PositiveSemidefinite,
    /// `M < 0`.
    NegativeDefinite,
    /// `M <= 0`.
    NegativeSemidefinite,
}

impl Sign {
    const ALL: [Self; 4] =
        [Self::PositiveDefinite, Self::PositiveSemidefinite, Self::NegativeDefinite, Self::NegativeSemidefinite];

    /// In words, as the file has them.
    pub fn words(self) -> &'static str {
        match self {
            Self::PositiveDefinite => "positive definite",
            Self::PositiveSemidefinite => "positive semidefinite",
            Self::NegativeDefinite => "negative definite",
            Self::NegativeSemidefinite => "negative semidefinite",
        }
    }
}

/// The data of the theorem; the head of the file has statement and proof.
#[derive(Debug, Clone, PartialEq)]
pub struct Definiteness {
    /// M, symmetric.
    pub m: Matrix<Datum>,
    /// The sense.
    pub sign: Sign,
}

impl Definiteness {
    /// A matrix of numbers.
    ///
    /// # Errors
    /// [`ProofError::NotFinite`].
    pub fn new(m: &Matrix<f64>, sign: Sign) -> Result<Self, ProofError> {
        Ok(Self { m: super::data(m, "M")?, sign })
    }
}

impl Statement for Definiteness {
    const NAME: &'static str = "definiteness";

    fn facts(&self, names: Names<'_>) -> Result<Vec<Fact>, ProofError> {
        names.of(self).facts([match self.sign {
            Sign::PositiveDefinite => "M > 0",
            Sign::PositiveSemidefinite => "M >= 0",
            Sign::NegativeDefinite => "M < 0",
            Sign::NegativeSemidefinite => "M <= 0",
        }])
    }

    fn words(&self) -> String {
        let n = self.m.rows();
        format!("The symmetric {n} x {n} matrix M is {}.{}", self.sign.words(), enclosed([&self.m], "M"))
    }
}

members! { Definiteness { {
    m = "M".symmetric_data();
    sign = "is".word(&Sign::ALL.map(|sign| (sign.words(), sign)));
} } }

impl Written for Sign {
    fn out(&self) -> Out {
        self.words().out()
    }
}
