//! Designs read from certificate files, which are verified on reading.
//!
//! A design is stored as its certificate file: it contains plant, gains and Lyapunov matrix exactly. Reading verifies
//! every inequality and every margin of the file, so that a file that was damaged or changed gives an error and not an
//! observer.
//!
//! ```
//! use luenberger_design::{Certified, LinearDesign, StoredDesign, StoredObserver};
//! use luenberger_plants::double_integrator;
//! let design = LinearDesign::with_poles(&double_integrator().to_dynamic(), &[-2.0, -5.0])?;
//! let file = design.certificate_file("a double integrator")?.to_json();
//!
//! let stored = StoredDesign::read(file.as_bytes())?;
//! assert!(stored.certificate().is_proved());
//! let StoredObserver::Linear(observer) = stored.observer else { unreachable!() };
//! assert_eq!(observer, design.observer);
//!
//! let other = file.replace("0x1.cp2", "0x1.cp3");
//! assert!(StoredDesign::read(other.as_bytes()).is_err());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use luenberger_lmi::dynamic_matrix;
use luenberger_observers::{
    CubicObserver, LinearObserver, ObserverError, SampledCubicGains, SampledCubicObserver, semi_implicit,
};
use luenberger_plants::{PlantError, StateSpace};
use luenberger_proof::certificate::{
    Certificate, CertificateFile, Datum, H2Filter, HInfinityFilter, PlantMatrices, PlantWithin, Rejection, Theorem,
};
use luenberger_proof::statement::TimeDomain;
use luenberger_proof::wording::entry;
use luenberger_proof::{Matrix, ProofError};
use nalgebra::{DMatrix, Dyn};

use crate::certificate::certified;

/// The observer of a certificate file, with its evidence.
#[derive(Debug, Clone)]
pub struct StoredDesign {
    /// The title of the file.
    pub title: String,
    /// The observer.
    pub observer: StoredObserver,
    /// The theorem of the file, proved again.
    pub certificate: Certificate,
}

certified!(StoredDesign);

/// The observer of a certificate file. The theorems are about the error, on which a feedthrough D has no influence, and
/// files do not contain it: add it where the plant has one.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum StoredObserver {
    /// From the theorem `linear-observer`, and from `h-infinity-filter` and `h2-filter` in continuous time.
    Linear(LinearObserver<f64, Dyn, Dyn, Dyn>),
    /// From the theorem `discrete-observer`, and from `h-infinity-filter` and `h2-filter` in discrete time. Their files
    /// do not contain the sampling period: plant and gain of
    /// [`DiscreteLinearObserver`](luenberger_observers::DiscreteLinearObserver).
    Discrete {
        /// The plant `x+ = A x + B u`, `y = C x`.
        plant: StateSpace,
        /// The gain, n x p.
        l: DMatrix<f64>,
    },
    /// From the theorems `cubic-observer` and `cubic-observer-theorem-1`.
    Cubic(CubicObserver<f64, Dyn, Dyn, Dyn>),
    /// From the theorem `sampled-cubic-observer`.
    SampledCubic(SampledCubicObserver<f64, Dyn, Dyn, Dyn>),
}

/// Why no observer can be read from a file.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum StoredError {
    /// The file is not a certificate, or its verification failed.
    #[error(transparent)]
    Rejected(#[from] Rejection),
    /// The theorem is proved, and has no observer that runs without further data: a nonlinear plant, for example, is
    /// not in its file.
    #[error("the file proves the theorem `{theorem}`, which does not contain a whole observer")]
    NoObserver {
        /// Name of the theorem.
        theorem: &'static str,
    },
    /// The plant is known within bounds only.
    #[error("{matrix}{} of the plant is given by bounds: the observer needs a number", entry(*row, *column))]
    Bounds {
        /// The matrix.
        matrix: &'static str,
        /// Row of the entry, from 0.
        row: usize,
        /// Column of the entry, from 0.
        column: usize,
    },
    /// The matrices satisfy the theorem but do not define an observer.
    #[error(transparent)]
    Observer(#[from] ObserverError),
}

impl From<ProofError> for StoredError {
    fn from(error: ProofError) -> Self {
        Self::Rejected(error.into())
    }
}

impl From<PlantError> for StoredError {
    fn from(error: PlantError) -> Self {
        Self::Observer(error.into())
    }
}

impl StoredDesign {
    /// Reads a certificate file and proves it.
    ///
    /// # Errors
    /// [`StoredError`]: what is wrong with the file, or which inequality fails.
    pub fn read(bytes: &[u8]) -> Result<Self, StoredError> {
        let file = CertificateFile::read(bytes).map_err(Rejection::from)?;
        file.check()?;
        let observer = observer(file.theorem())?;
        let certificate = Certificate::of([file.theorem().clone()])?;
        Ok(Self { title: file.title().to_owned(), observer, certificate })
    }
}

fn observer(theorem: &Theorem) -> Result<StoredObserver, StoredError> {
    Ok(match theorem {
        Theorem::LinearConvergence(data) => {
            StoredObserver::Linear(LinearObserver::of(within(&data.plant)?, dynamic_matrix(&data.l))?)
        }
        Theorem::DiscreteConvergence(data) => {
            StoredObserver::Discrete { plant: exact(&data.plant)?, l: dynamic_matrix(&data.l) }
        }
        Theorem::CubicConvergence(data) => cubic(&data.plant, &data.l, &data.n, &data.theta)?,
        Theorem::CubicTheorem1(data) => cubic(&data.plant, &data.l, &data.n, &data.theta)?,
        Theorem::SampledCubicConvergence(data) => {
            let StateSpace { a: ad, b: bd, c, .. } = exact(&data.plant)?;
            StoredObserver::SampledCubic(SampledCubicObserver::new(SampledCubicGains {
                ad,
                bd,
                c,
                ld: dynamic_matrix(&data.l),
                n: dynamic_matrix(&data.n),
                theta: dynamic_matrix(&data.theta),
                w: data.w,
                period: data.period,
            })?)
        }
        Theorem::SemiImplicitCubicConvergence(data) => {
            let StateSpace { a: ad, b: bd, c, .. } = exact(&data.plant)?;
            let [ld, n, theta] = [&data.l, &data.n, &data.theta].map(dynamic_matrix);
            let coupling = semi_implicit::coupling(&c, &n);
            let gains = SampledCubicGains { ad, bd, c, ld, n, theta, w: 0.0, period: data.period };
            StoredObserver::SampledCubic(SampledCubicObserver::semi_implicit(gains, coupling)?)
        }
        Theorem::HInfinityFilter(HInfinityFilter(data)) | Theorem::H2Filter(H2Filter(data)) => {
            let (plant, l) = (exact(&data.plant)?, dynamic_matrix(&data.l));
            match data.time {
                TimeDomain::Continuous => StoredObserver::Linear(LinearObserver::of(plant, l)?),
                TimeDomain::Discrete => StoredObserver::Discrete { plant, l },
            }
        }
        other => return Err(StoredError::NoObserver { theorem: other.name() }),
    })
}

fn cubic(
    plant: &PlantMatrices,
    l: &Matrix<f64>,
    n: &Matrix<f64>,
    theta: &Matrix<f64>,
) -> Result<StoredObserver, StoredError> {
    let [l, n, theta] = [l, n, theta].map(dynamic_matrix);
    Ok(StoredObserver::Cubic(CubicObserver::of(exact(plant)?, l, n, theta)?))
}

fn exact(plant: &PlantMatrices) -> Result<StateSpace, PlantError> {
    StateSpace::new(dynamic_matrix(&plant.a), dynamic_matrix(&plant.b), dynamic_matrix(&plant.c))
}

fn within(plant: &PlantWithin) -> Result<StateSpace, StoredError> {
    let [a, b, c] = [("A", &plant.a), ("B", &plant.b), ("C", &plant.c)].map(|(matrix, data)| numbers(matrix, data));
    Ok(StateSpace::new(a?, b?, c?)?)
}

fn numbers(matrix: &'static str, data: &Matrix<Datum>) -> Result<DMatrix<f64>, StoredError> {
    let mut m = DMatrix::zeros(data.rows(), data.cols());
    for row in 0..data.rows() {
        for column in 0..data.cols() {
            let datum = &data[(row, column)];
            if !datum.is_point() {
                return Err(StoredError::Bounds { matrix, row, column });
            }
            m[(row, column)] = datum.interval().lo();
        }
    }
    Ok(m)
}
