//! Interface to the numerical solvers.
//!
//! A solver takes a conic program and returns iterates. They are not trusted: `luenberger-proof` verifies every result,
//! for each solver.

use std::fmt;

use luenberger_clock::Instant;
use thiserror::Error;

use crate::conic::ConicProgram;
use crate::interior::{self, Path};

/// The solver that computes approximate values and multipliers.
///
/// ```
/// use luenberger_lmi::{LmiError, Problem, Settings, Solver, he};
/// use nalgebra::dmatrix;
/// let mut lmi = Problem::new();
/// let p = lmi.symmetric("P", 2);
/// lmi.constrain("P > 0", &p >> 0.0);
/// lmi.constrain("decrease", he(&p * dmatrix![0.0, 1.0; -2.0, -3.0]) << 0.0);
/// match lmi.solve_with(&Settings { solver: Solver::Clarabel, ..Settings::default() }) {
///     Ok(solution) => assert!(solution.verdict.is_proved()),
///     Err(error) => assert!(matches!(error, LmiError::NotBuiltIn(missing) if missing.feature == "clarabel")),
/// }
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Solver {
    /// The interior-point method of this crate, on the Schur complement of sparse constraints.
    #[default]
    Interior,
    /// Clarabel, a general third-party conic solver: slower for these problems. Needs the feature `clarabel`.
    Clarabel,
}

/// The solver is not compiled in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("the solver {solver} is not part of this build: it needs the feature `{feature}` of luenberger-lmi")]
pub struct NotBuiltIn {
    /// The requested solver.
    pub solver: Solver,
    /// The required feature.
    pub feature: &'static str,
}

impl Solver {
    /// Its name, in lower case.
    pub fn name(self) -> &'static str {
        match self {
            Self::Interior => "interior",
            Self::Clarabel => "clarabel",
        }
    }

    /// Whether it is part of this build.
    ///
    /// # Errors
    /// [`NotBuiltIn`] names the required feature.
    pub fn require(self) -> Result<(), NotBuiltIn> {
        match self {
            Self::Clarabel if !cfg!(feature = "clarabel") => Err(NotBuiltIn { solver: self, feature: "clarabel" }),
            Self::Interior | Self::Clarabel => Ok(()),
        }
    }

    /// The solver's iterates, with no iteration started after `end`; `None` if it has none.
    pub(crate) fn propose(
        self,
        program: &ConicProgram,
        iterations: u32,
        end: Option<Instant>,
    ) -> Result<Option<Path>, NotBuiltIn> {
        self.require()?;
        Ok(match self {
            Self::Interior => interior::solve_until(program, iterations, end),
            #[cfg(feature = "clarabel")]
            Self::Clarabel => crate::clarabel::solve_until(program, iterations, end),
            #[cfg(not(feature = "clarabel"))]
            Self::Clarabel => None,
        })
    }
}

impl fmt::Display for Solver {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
