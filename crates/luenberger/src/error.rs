//! One error for programs that use several crates.

use thiserror::Error;

use crate::{design, linalg, lmi, observers, plants, proof, sim};

/// Any error of the crates behind this one: what `main` returns where `?` meets plants, designs and runs.
///
/// Nothing is added: message and source are those of the error within.
///
/// ```
/// use luenberger::prelude::*;
/// use nalgebra::{Matrix2, RowVector2, dmatrix};
///
/// fn gain() -> Result<f64, luenberger::Error> {
///     let (a, c) = (Matrix2::identity(), RowVector2::new(1.0, 0.0));
///     let placed = luenberger::linalg::place_observer(&a, &c, &[-1.0, -2.0])?;
///     let plant = StateSpace::new(dmatrix![0.0], dmatrix![1.0], dmatrix![1.0])?;
///     Ok(Scenario::new(plant).until(1.0, 2).run()?.x[(1, 0)] + placed.gain[(0, 0)])
/// }
/// let error = gain().unwrap_err();
/// assert!(matches!(error, luenberger::Error::Linalg(LinalgError::Unobservable { .. })));
/// println!("{error}");
/// ```
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum Error {
    /// Matrices that make no plant.
    #[error(transparent)]
    Plant(#[from] plants::PlantError),
    /// Matrices that make no observer.
    #[error(transparent)]
    Observer(#[from] observers::ObserverError),
    /// A matrix equation, a placement or a rank decision.
    #[error(transparent)]
    Linalg(#[from] linalg::LinalgError),
    /// A matrix inequality.
    #[error(transparent)]
    Lmi(#[from] lmi::LmiError),
    /// A semidefinite program in SDPA's format that cannot be read.
    #[error(transparent)]
    Sdpa(#[from] lmi::sdpa::ReadError),
    /// Data that make no statement to be proved.
    #[error(transparent)]
    Proof(#[from] proof::ProofError),
    /// A text that is no certificate.
    #[error(transparent)]
    CertificateFile(#[from] proof::certificate::FileError),
    /// A certificate that is not verified.
    #[error(transparent)]
    Rejection(#[from] proof::certificate::Rejection),
    /// A design.
    #[error(transparent)]
    Design(#[from] design::DesignError),
    /// An enclosure of a Jacobian over a region.
    #[error(transparent)]
    Enclosure(#[from] design::EnclosureError),
    /// A KKL observer from an explicit transformation.
    #[error(transparent)]
    Kkl(#[from] design::KklError),
    /// A design on a polytope of Jacobians.
    #[error(transparent)]
    Lpv(#[from] design::LpvError),
    /// A numerical KKL observer.
    #[error(transparent)]
    NumericalKkl(#[from] design::NumericalKklError),
    /// Nonlinear observability.
    #[error(transparent)]
    Observability(#[from] design::nonlinear_observability::ObservabilityError),
    /// A simulation.
    #[error(transparent)]
    Sim(#[from] sim::SimError),
}
