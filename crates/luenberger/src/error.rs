//! One error for programs that use several crates.

use thiserror::Error;

use crate::{design, linalg, lmi, observers, plants, proof, sim};

/// Any error of the re-exported crates, for functions such as `main` that use `?` on several of them.
///
/// Message and source are those of the wrapped error.
///
/// ```
/// use luenberger::prelude::*;
/// use nalgebra::{Matrix2, RowVector2};
///
/// fn gain() -> Result<f64, luenberger::Error> {
///     let (a, c) = (Matrix2::identity(), RowVector2::new(1.0, 0.0));
///     let placed = luenberger::linalg::place_observer(&a, &c, &[-1.0, -2.0])?;
///     let plant = StateSpace::new(dmatrix![0.0], dmatrix![1.0], dmatrix![1.0])?;
///     Ok(Scenario::new(plant).until(1.0, 2).run()?.x[(1, 0)] + placed.gain[(0, 0)])
/// }
/// let error = gain().unwrap_err();
/// assert!(matches!(error, luenberger::Error::Linalg(LinalgError::Unobservable { .. })));
/// assert_eq!(error.clone(), error);
/// println!("{error}");
/// ```
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum Error {
    /// The matrices or parameters do not define a plant.
    #[error(transparent)]
    Plant(#[from] plants::PlantError),
    /// A duty cycle outside of its interval.
    #[error(transparent)]
    DutyCycle(#[from] plants::cuk::DutyCycleError),
    /// The matrices or parameters do not define an observer.
    #[error(transparent)]
    Observer(#[from] observers::ObserverError),
    /// A matrix equation, a pole placement or a rank decision failed.
    #[error(transparent)]
    Linalg(#[from] linalg::LinalgError),
    /// A linear matrix inequality is ill-posed, or could not be solved.
    #[error(transparent)]
    Lmi(#[from] lmi::LmiError),
    /// A solver is not compiled in.
    #[error(transparent)]
    NotBuiltIn(#[from] lmi::NotBuiltIn),
    /// A semidefinite program in SDPA's format that cannot be read.
    #[error(transparent)]
    Sdpa(#[from] lmi::sdpa::ReadError),
    /// Invalid data of a statement that is to be verified.
    #[error(transparent)]
    Proof(#[from] proof::ProofError),
    /// A text is not a number of a certificate.
    #[error(transparent)]
    Number(#[from] proof::certificate::NumberError),
    /// An expression of a KKL observer that cannot be read.
    #[error(transparent)]
    KklMap(#[from] proof::certificate::KklMapError),
    /// Invalid data of a semidefinite program.
    #[error(transparent)]
    SemidefiniteProgram(#[from] proof::semidefinite::ProgramError),
    /// A text is not a certificate file.
    #[error(transparent)]
    CertificateFile(#[from] proof::certificate::FileError),
    /// A certificate was rejected.
    #[error(transparent)]
    Rejection(#[from] proof::certificate::Rejection),
    /// A design failed.
    #[error(transparent)]
    Design(#[from] design::DesignError),
    /// The Jacobian of a plant has no enclosure over a region.
    #[error(transparent)]
    Enclosure(#[from] design::EnclosureError),
    /// The check of a user-supplied KKL observer failed.
    #[error(transparent)]
    Kkl(#[from] design::KklError),
    /// A design on a polytope of Jacobians failed.
    #[error(transparent)]
    Lpv(#[from] design::LpvError),
    /// The design of a numerical KKL observer failed.
    #[error(transparent)]
    NumericalKkl(#[from] design::NumericalKklError),
    /// The plant has no operating point.
    #[error(transparent)]
    OperatingPoint(#[from] design::OperatingPointError),
    /// The observability test of a nonlinear plant failed.
    #[error(transparent)]
    Observability(#[from] design::nonlinear_observability::ObservabilityError),
    /// A simulation could not be set up or finished.
    #[error(transparent)]
    Sim(#[from] sim::SimError),
}
