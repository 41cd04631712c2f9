//! The theorems that a certificate can state, one file each.
//!
//! Each file has, in this order: the mathematical statement with its proof, in the head; the data; the hypotheses as
//! labels, which are decided as they read with the members by their [names](crate::label); the text, which claims no
//! more than the facts imply; the members in a file. A new theorem needs a file here and a line in the list below: in
//! its second part, which the feature `all-theorems` compiles, unless the pages of reports verify it.

mod contracting;
mod cubic;
mod decoupling;
mod definiteness;
mod deployed;
mod discrete;
mod discrete_input_to_state;
mod discrete_polytope;
mod feedback;
mod filter_problem;
mod h2;
mod h_infinity;
mod hurwitz;
mod inequality;
mod inequality_holds;
mod inequality_refuted;
mod input_to_state;
mod interval_observer;
mod kkl;
mod kkl_injectivity;
mod linear;
mod plant;
mod polytope;
mod reduced_order;
mod sampled;
mod sampled_interval;
mod schur;
mod sector;
mod semi_implicit;
mod semidefinite;
mod solution;
mod structured;
mod super_twisting;
mod theorem1;
mod unknown_input;
mod varying_periods;

use super::error::FileError;
use super::fields::Fields;
use super::members::Members;
use super::sentence::Reading;
use super::write::Out;
use super::{Fact, Witness};
use crate::definite::of_one_certificate;
use crate::error::ProofError;
use crate::interval::Interval;
use crate::label::Names;
use crate::matrix::Matrix;
use crate::number::Datum;
use crate::wording::{counted, exact};

pub use contracting::ContractionInCoordinates;
pub use cubic::{CubicConvergence, Region};
pub use decoupling::DecouplingConvergence;
pub use definiteness::{Definiteness, Sign};
pub use deployed::{ClaimedBall, DeployedObserver, LARGEST_DEPLOYED};
pub use discrete::DiscreteConvergence;
pub use discrete_input_to_state::DiscreteInputToStateStability;
pub use discrete_polytope::DiscreteJacobianPolytope;
pub use feedback::FeedbackLoop;
pub use filter_problem::FilterProblem;
pub use h_infinity::HInfinityFilter;
pub use h2::H2Filter;
pub use hurwitz::HurwitzStability;
pub use inequality::{Coefficient, Constraint, MatrixInequality};
pub use inequality_holds::InequalityHolds;
pub use inequality_refuted::InequalityRefuted;
pub use input_to_state::{CubicTerm, DisturbedPlant, InputToStateStability};
pub use interval_observer::{IntervalCoordinates, IntervalEnclosure};
pub use kkl::{KklBox, KklClaims, KklErrorBound, KklMapError, KklMapName, KklMaps, KklTexts, LARGEST_KKL};
pub use kkl_injectivity::KklInjectivity;
pub use linear::LinearConvergence;
pub use plant::{PlantMatrices, PlantWithin};
pub use polytope::{JacobianPolytope, PlantPolytope, Vertex};
pub use reduced_order::ReducedOrderConvergence;
pub use sampled::SampledCubicConvergence;
pub use sampled_interval::SampledIntervalEnclosure;
pub use schur::SchurStability;
pub use sector::{SectorConvergence, SectorTerm};
pub use semi_implicit::SemiImplicitCubicConvergence;
pub use semidefinite::{SemidefiniteEvidence, SemidefiniteProgram};
pub use solution::{Equation, SolutionWithin};
pub use structured::StructuredCubicConvergence;
pub use super_twisting::SuperTwistingConvergence;
pub use theorem1::CubicTheorem1;
pub use unknown_input::{StoredCubicTerm, UnknownInputConvergence};
pub use varying_periods::{CubicStep, MOST_MISSES, VaryingPeriodConvergence};

/// Metadata of a theorem.
trait Statement: Members {
    /// The value of the field `theorem` in the file.
    const NAME: &'static str;
    /// The hypotheses, decided. What labels stand for is added to `names`, which has none.
    fn facts(&self, names: Names<'_>) -> Result<Vec<Fact>, ProofError>;
    /// What is proved when all facts are. Numbers in it are exact, and names from outside are quoted.
    fn words(&self) -> String;
    /// The theorem in a sentence of a report that reads its data so, its least margin being this one. Claims no more
    /// than the words; numbers are rounded to the safe side.
    fn sentence(&self, reading: &Reading<'_>, margin: f64) -> Option<String> {
        let _ = (reading, margin);
        None
    }
}

macro_rules! theorems {
    ({ $($(#[$doc:meta])* $name:ident),* $(,)? } { $($(#[$more_doc:meta])* $more:ident),* $(,)? }) => {
        /// What a certificate states, with all the data that it takes.
        #[derive(Debug, Clone, PartialEq)]
        #[non_exhaustive]
        pub enum Theorem {
            $($(#[$doc])* $name($name),)*
            $(#[cfg(feature = "all-theorems")] $(#[$more_doc])* $more($more),)*
        }

        $(impl From<$name> for Theorem {
            fn from(theorem: $name) -> Self {
                Self::$name(theorem)
            }
        })*

        $(#[cfg(feature = "all-theorems")]
        impl From<$more> for Theorem {
            fn from(theorem: $more) -> Self {
                Self::$more(theorem)
            }
        })*

        impl Theorem {
            /// The name of the theorem in files.
            pub fn name(&self) -> &'static str {
                match self {
                    $(Self::$name(_) => <$name as Statement>::NAME,)*
                    $(#[cfg(feature = "all-theorems")]
                    Self::$more(_) => <$more as Statement>::NAME,)*
                }
            }

            /// The names of all theorems.
            pub const NAMES: &[&'static str] = &[
                $(<$name as Statement>::NAME,)*
                $(#[cfg(feature = "all-theorems")] <$more as Statement>::NAME,)*
            ];

            pub(super) fn read(file: &mut Fields<'_>) -> Result<Self, FileError> {
                let name = file.take("theorem")?;
                match name.text()? {
                    $(<$name as Statement>::NAME => Ok(Self::$name(Members::read(file, ())?)),)*
                    $(#[cfg(feature = "all-theorems")]
                    <$more as Statement>::NAME => Ok(Self::$more(Members::read(file, ())?)),)*
                    found => Err(name.unknown_word(found, Self::NAMES.iter().copied())),
                }
            }

            pub(super) fn write(&self) -> Vec<(&'static str, Out)> {
                let mut members = vec![("theorem", Out::Text(self.name().to_owned()))];
                members.extend(match self {
                    $(Self::$name(theorem) => Members::write(theorem),)*
                    $(#[cfg(feature = "all-theorems")]
                    Self::$more(theorem) => Members::write(theorem),)*
                });
                members
            }

            /// What is proved when all its inequalities are, in words generated from the data.
            pub fn words(&self) -> String {
                match self {
                    $(Self::$name(theorem) => Statement::words(theorem),)*
                    $(#[cfg(feature = "all-theorems")]
                    Self::$more(theorem) => Statement::words(theorem),)*
                }
            }

            /// As [`ProvedTheorem::sentence`](super::ProvedTheorem::sentence), of a theorem that is proved.
            pub(super) fn sentence(&self, reading: &Reading<'_>, margin: f64) -> Option<String> {
                match self {
                    $(Self::$name(theorem) => Statement::sentence(theorem, reading, margin),)*
                    $(#[cfg(feature = "all-theorems")]
                    Self::$more(theorem) => Statement::sentence(theorem, reading, margin),)*
                }
            }

            /// The inequalities of the theorem, each decided from the data.
            ///
            /// # Errors
            /// [`ProofError`] for shapes that do not fit and entries that are not finite: what
            /// [`CertificateFile::read`](super::CertificateFile::read) lets through has neither.
            pub fn facts(&self) -> Result<Vec<Fact>, ProofError> {
                self.facts_with(Names::new())
            }

            /// As [`facts`](Self::facts), each label and each definition decided as what `read` makes of its text: for
            /// tests of whether a wrong hypothesis would be noticed. The facts have the text of the theorem.
            ///
            /// # Errors
            /// As [`facts`](Self::facts), and [`ProofError::Label`] for a text that cannot be read.
            pub fn facts_read_by(&self, read: &dyn Fn(&str) -> String) -> Result<Vec<Fact>, ProofError> {
                self.facts_with(Names::read_by(read))
            }

            fn facts_with(&self, names: Names<'_>) -> Result<Vec<Fact>, ProofError> {
                of_one_certificate(|| match self {
                    $(Self::$name(theorem) => Statement::facts(theorem, names),)*
                    $(#[cfg(feature = "all-theorems")]
                    Self::$more(theorem) => Statement::facts(theorem, names),)*
                })
            }
        }
    };
}

theorems! {
    {
        /// The linear observer (12), perhaps with a rate.
        LinearConvergence,
        /// The linear observer in discrete time.
        DiscreteConvergence,
        /// The cubic observer with its gains as stored.
        CubicConvergence,
        /// The cubic observer with the real gain `N = -P^-1 C'S`.
        StructuredCubicConvergence,
        /// The sampled cubic observer.
        SampledCubicConvergence,
        /// The sampled cubic observer with a semi-implicit cubic step.
        SemiImplicitCubicConvergence,
        /// One gain for a polytope of linear plants.
        PlantPolytope,
        /// One gain for a polytope of mean Jacobians.
        JacobianPolytope,
        /// One gain for a polytope of mean Jacobians in discrete time.
        DiscreteJacobianPolytope,
        /// The observer of a plant with nonlinearities in sectors.
        SectorConvergence,
    }
    {
        /// All eigenvalues in the open left half plane.
        HurwitzStability,
        /// All eigenvalues inside the unit circle.
        SchurStability,
        /// Theorem 1 for gains of any origin.
        CubicTheorem1,
        /// The unknown-input observer.
        UnknownInputConvergence,
        /// The unknown-input observer in both times, of an unknown input that may enter the outputs.
        DecouplingConvergence,
        /// The reduced-order observer.
        ReducedOrderConvergence,
        /// A bound of the error under bounded disturbances and noise.
        InputToStateStability,
        /// The same in discrete time.
        DiscreteInputToStateStability,
        /// The interval observer in continuous time.
        IntervalEnclosure,
        /// The sampled interval observer, with the rounding of its steps.
        SampledIntervalEnclosure,
        /// The super-twisting observer in continuous time.
        SuperTwistingConvergence,
        /// A bound of the H-infinity norm of the error.
        HInfinityFilter,
        /// A bound of the H2 norm of the error.
        H2Filter,
        /// The sampled observer at periods that vary, with missed samples.
        VaryingPeriodConvergence,
        /// An observer in the numbers of its target, with the rounding of its steps.
        DeployedObserver,
        /// The loop `u = -K xhat` around the cubic observer (25).
        FeedbackLoop,
        /// Coordinates in which the unmeasured states contract.
        ContractionInCoordinates,
        /// A bound of the estimation error of a KKL observer over a box.
        KklErrorBound,
        /// A matrix is definite.
        Definiteness,
        /// The solution of a Lyapunov or Stein equation lies within.
        SolutionWithin,
        /// A point satisfies linear matrix inequalities.
        InequalityHolds,
        /// No point satisfies them.
        InequalityRefuted,
        /// The optimum of a semidefinite program is bounded, or there is none.
        SemidefiniteProgram,
    }
}

/// The numbers of the data, as intervals.
fn intervals(m: &Matrix<Datum>) -> Matrix<Interval> {
    m.map(Datum::interval)
}

/// Numbers as data; an error that names the first that is not finite.
fn data(m: &Matrix<f64>, what: &'static str) -> Result<Matrix<Datum>, ProofError> {
    let mut entries = Vec::with_capacity(m.as_slice().len());
    for (k, &value) in m.as_slice().iter().enumerate() {
        let not_finite = ProofError::NotFinite { what, row: k / m.cols(), column: k % m.cols(), value };
        entries.push(Datum::from_f64(value).ok_or(not_finite)?);
    }
    Matrix::from_row_major(m.rows(), m.cols(), entries)
}

/// Intervals as data; an error that names the first that is unbounded.
fn bounded(m: &Matrix<Interval>, what: &'static str) -> Result<Matrix<Datum>, ProofError> {
    let mut entries = Vec::with_capacity(m.as_slice().len());
    for (k, interval) in m.as_slice().iter().enumerate() {
        let value = if interval.lo().is_finite() { interval.hi() } else { interval.lo() };
        let unbounded = ProofError::NotFinite { what, row: k / m.cols(), column: k % m.cols(), value };
        entries.push(Datum::from_interval(interval).ok_or(unbounded)?);
    }
    Matrix::from_row_major(m.rows(), m.cols(), entries)
}

/// Whether every entry is a single number of binary64.
fn are_points<'a>(matrices: impl IntoIterator<Item = &'a Matrix<Datum>>) -> bool {
    matrices.into_iter().flat_map(Matrix::as_slice).all(Datum::is_point)
}

/// What is to be added to the words where some data are not single numbers of binary64. `symmetric` names the matrices
/// of which only the symmetric ones between the bounds are meant.
fn enclosed<'a>(matrices: impl IntoIterator<Item = &'a Matrix<Datum>>, symmetric: &str) -> String {
    if are_points(matrices) {
        return String::new();
    }
    let symmetric = if symmetric.is_empty() { String::new() } else { format!(" that makes {symmetric} symmetric") };
    format!(
        " Entries given by two bounds, and fractions that binary64 does not have, stand for all numbers between: the statement holds for every choice of them{symmetric}."
    )
}

/// `x_1 F_1 + ... + x_m F_m`; 0 where there is no unknown.
fn combination(matrix: &str, unknowns: usize) -> String {
    match unknowns {
        0 => "0".to_owned(),
        1 => format!("x_1 {matrix}1"),
        2 => format!("x_1 {matrix}1 + x_2 {matrix}2"),
        m => format!("x_1 {matrix}1 + ... + x_{m} {matrix}{m}"),
    }
}

/// ` + 2 rate P`, or nothing for the rate 0.
fn rate_term(rate: f64, p: &str) -> String {
    if rate == 0.0 { String::new() } else { format!(" + 2 rate {p}") }
}

/// A rate is 0 or more: the words say that the error decays.
fn check_rate(rate: f64) -> Result<(), ProofError> {
    if rate >= 0.0 && rate.is_finite() {
        return Ok(());
    }
    Err(ProofError::Sign { what: "a rate of decay, which should be 0 or more,", value: rate })
}

/// (12), with a rate or without.
fn decrease_label(rate: f64) -> String {
    format!("(A - LC)'P + P(A - LC){} < 0 (12)", rate_term(rate, "P"))
}

/// What a Lyapunov function `name` says of its argument.
fn decay(name: &str, variable: &str, rate: f64) -> String {
    if rate == 0.0 {
        format!("V = {name} decreases and {variable} tends to 0 exponentially")
    } else {
        format!(
            "V = {name} satisfies V(t) <= exp(-2 rate t) V(0) with rate = {}, so that {variable} tends to 0 at least like exp(-rate t)",
            exact(rate)
        )
    }
}
