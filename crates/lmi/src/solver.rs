//! Which solver proposes: the one seam between this layer and its solvers.
//!
//! A conic program goes in and iterates come out. Nothing is believed of them: `luenberger-proof` decides every
//! verdict, whoever proposed.

use std::fmt;
use std::time::Instant;

use thiserror::Error;

use crate::conic::ConicProgram;
use crate::interior::{self, Path};

/// The solver that proposes values and multipliers.
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
    /// Clarabel, a general conic solver: slower here, and written by others. Needs the feature `clarabel`.
    Clarabel,
}

/// The solver was left out of this build.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("the solver {solver} is not part of this build: it needs the feature `{feature}` of luenberger-lmi")]
pub struct NotBuiltIn {
    /// The solver that was asked for.
    pub solver: Solver,
    /// The feature that it needs.
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
    /// [`NotBuiltIn`] names the feature that it needs.
    pub fn require(self) -> Result<(), NotBuiltIn> {
        match self {
            Self::Clarabel if !cfg!(feature = "clarabel") => Err(NotBuiltIn { solver: self, feature: "clarabel" }),
            Self::Interior | Self::Clarabel => Ok(()),
        }
    }

    /// What the solver proposes, with no iteration begun after `end`; `None` if it has nothing.
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
