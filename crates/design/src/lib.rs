//! From a plant and a specification to an observer with its certificate.
//!
//! The way: [`LinearDesign`] turns a plant and poles, noise intensities, a decay rate, an LMI or a given gain into the
//! linear observer with its Lyapunov pair (P, Q); [`CubicDesign`] adds the cubic term that P allows,
//! [`SampledCubicDesign`] does so for a sampling period; [`FeedbackDesign`] puts the observer in the loop.
//! [`joint_design`] does the first two in one inequality. [`robust`] says how much uncertainty they tolerate.
//! [`mean_value`] repairs the mean-value-theorem observer, and finds the coordinates in which it converges as printed.
//! [`LipschitzDesign`] finds the gain of the copy of a nonlinear plant whose nonlinearities are known by their sectors.
//! For nonlinear plants, [`LpvDesign`] finds one gain for all mean Jacobians over a box, whose [`enclosure`] it
//! computes itself. [`lie_observability`] says beforehand what the outputs of a nonlinear plant see along a trajectory.
//! Every design is [`Certified`]: it carries the theorems that are proved of it, with their data, decided outside
//! floating point once and kept. `certificate_file` makes a file of them that `luenberger-verify` checks without this
//! crate. The fields of a design are read-only, so that its evidence stays that of its numbers. [`KklCandidate`] checks
//! a transformation supplied by the user to a Kazantzis-Kravaris-Luenberger observer, and [`KklPebDesign`] a plant of
//! the class that a [KKL+PEB] observer serves. [`deployed`] says what is left of an observer on its target, in f32 or
//! fixed point. The exception is [`NumericalKklDesign`], an observer computed by simulation for a plant of which only
//! the right-hand side is known: its evidence is measured.
//!
//! What is true of these observers and what the literature gets wrong stands in `docs/theory-cubic.md` and
//! `docs/theory-mvt.md` of the repository.
#![deny(missing_docs)]

mod certificate;
mod check;
pub mod conditions;
pub mod cubic;
pub mod deployed;
mod display;
pub mod enclosure;
pub mod error;
mod exact_solution;
pub mod feedback;
mod gain_lmi;
mod golden_sequence;
mod joint;
pub mod kkl;
pub mod kkl_peb;
pub mod linear;
pub mod lipschitz;
pub mod lpv;
pub mod mean_value;
pub mod names;
pub mod nonlinear_observability;
pub mod number;
pub mod numerical_kkl;
mod real_field;
pub mod robust;
pub mod sampled;
mod separation;
mod symbolic_polynomial;
pub mod weights;

pub use conditions::Theorem1;
pub use cubic::{CubicDesign, CubicGain};
pub use deployed::{DeployedLinear, deployed_linear};
pub use enclosure::{EnclosureError, IntervalDual, JacobianEnclosure, Region};
pub use error::{DesignError, InfeasibilityReason, NearlyHidden};
pub use exact_solution::{enclosed_lyapunov, enclosed_stein, lyapunov_certificate_file, stein_certificate_file};
pub use feedback::FeedbackDesign;
pub use joint::joint_design;
pub use kkl::{KklCandidate, KklDesign, KklError};
pub use kkl_peb::KklPebDesign;
pub use linear::{LinearDesign, LyapunovWeight};
pub use lipschitz::{LipschitzDesign, LipschitzPlant, Sector};
pub use lpv::{LpvDesign, LpvError};
pub use luenberger_proof::certificate::{Certificate, Certified, Fact, ProvedTheorem};
pub use mean_value::{ContractingCoordinates, LeastSquares, MeanValueDesign, OutputCoordinates};
pub use nalgebra;
pub use names::Names;
pub use nonlinear_observability::{LieObservability, lie_observability};
pub use numerical_kkl::{NumericalKklDesign, NumericalKklError};
pub use sampled::SampledCubicDesign;
pub use symbolic_polynomial::SymbolicPolynomial;
pub use weights::{theta_from_cost_shares, theta_from_importance};

/// The example of `README.md`, compiled and run with the documentation's tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
