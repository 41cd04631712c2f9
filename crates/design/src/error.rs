//! What can go wrong on the way from a plant to an observer.

use luenberger_linalg::LinalgError;
use luenberger_lmi::{Infeasibility, LmiError};
use luenberger_observers::ObserverError;
use luenberger_plants::PlantError;
use luenberger_proof::ProofError;
use nalgebra::Complex;
use thiserror::Error;

/// Why a design was not possible. Every variant names the quantity and its value.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum DesignError {
    /// A matrix equation, a placement or an observability test failed, or a matrix is not symmetric or not definite.
    #[error(transparent)]
    Linalg(#[from] LinalgError),
    /// A matrix inequality could not be posed or solved.
    #[error(transparent)]
    Lmi(#[from] LmiError),
    /// A matrix has the wrong shape or an entry that is not finite.
    #[error(transparent)]
    Matrix(#[from] PlantError),
    /// The observer's matrices do not fit together.
    #[error(transparent)]
    Observer(#[from] ObserverError),
    /// A statement could not be handed to the prover.
    #[error(transparent)]
    Proof(#[from] ProofError),
    /// A scalar that must be positive is not.
    #[error("{what} must be positive and finite; it is {value}")]
    NotPositive {
        /// Which scalar.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// A pole asked for an observer that would not converge.
    #[error("the observer pole {pole} is not in the open left half plane")]
    UnstablePole {
        /// The pole.
        pole: Complex<f64>,
    },
    /// A gain does not stabilise.
    #[error("{what} is not Hurwitz: its spectral abscissa is {abscissa:e}")]
    NotHurwitz {
        /// Which matrix.
        what: &'static str,
        /// Its largest real part of an eigenvalue.
        abscissa: f64,
    },
    /// The rows of C are linearly dependent, so that gains of the form `-P^-1 C'S` do not exhaust the admissible ones.
    #[error(
        "C does not have full row rank: its smallest singular value is {sigma_min:e} against a largest of {sigma_max:e}"
    )]
    DependentOutputs {
        /// Smallest singular value of C.
        sigma_min: f64,
        /// Largest singular value of C.
        sigma_max: f64,
    },
    /// A method for one output was asked for a plant with several.
    #[error("{what} needs a plant with one output; this one has {outputs}")]
    SeveralOutputs {
        /// The method.
        what: &'static str,
        /// Number of outputs.
        outputs: usize,
    },
    /// No P exists for the gains that were given.
    #[error("{what} is infeasible: {reason}")]
    Infeasible {
        /// The inequality.
        what: &'static str,
        /// The quantity that refutes it.
        reason: Obstruction,
    },
    /// Neither a solution nor a refutation was found.
    #[error("{what} stayed undecided: {why} (best margin {best:e})")]
    Undecided {
        /// The inequality.
        what: &'static str,
        /// What stood in the way.
        why: luenberger_proof::Doubt,
        /// The best margin seen.
        best: f64,
    },
}

/// What makes an inequality infeasible.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum Obstruction {
    /// Multipliers of the inequalities, verified exactly.
    #[error("{0}")]
    Dual(Infeasibility),
    /// The sign of `C N` excludes `P N = -C'S` with `S + S' >= 0`.
    #[error("C N + (C N)' has the positive eigenvalue {0:e}, but P N = -C'S makes N'PN = -(C N)'S")]
    SignOfCn(f64),
    /// The linear part cannot be stabilised by this gain.
    #[error("A - L C has spectral abscissa {0:e}")]
    Unstable(f64),
}
