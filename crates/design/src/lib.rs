//! Observer design: from a plant and a specification to an observer with its certificate.
//!
//! [`LinearDesign`] computes from a plant and poles, noise intensities, a decay rate, an LMI or a given gain the linear
//! observer with its Lyapunov pair (P, Q). [`CubicDesign`] adds the cubic term that P admits, and
//! [`SampledCubicDesign`] does so for a sampling period. [`cubic_lmi_design`] computes both in one inequality.
//! [`FeedbackDesign`] puts the observer in the feedback loop. [`robust`] computes robustness margins. [`mean_value`]
//! has the mean-value-theorem observer with output injection, and the coordinates in which the printed one converges.
//! [`LipschitzDesign`] computes the gain of the copy of a nonlinear plant whose nonlinearities lie in known sectors.
//! For nonlinear plants, [`LpvDesign`] computes one gain for all mean Jacobians over a box, whose [`enclosure`] it
//! computes itself. [`lie_observability`] analyses the observability of a nonlinear plant along a trajectory. Every
//! design is [`Certified`]: it carries its theorems with their data, verified once in exact or interval arithmetic.
//! `certificate_file` writes them to a file that `luenberger-verify` checks without this crate. The fields of a design
//! are read-only, so that its certificate always matches its numbers. [`KklCandidate`] checks a user-supplied
//! transformation to a Kazantzis-Kravaris-Luenberger observer, and [`KklPebDesign`] a plant of the class of [KKL+PEB]
//! observers. [`deployed`] analyses an observer on its target, in f32 or fixed point. The exception is
//! [`NumericalKklDesign`], an observer computed by simulation for a plant of which only the right-hand side is known:
//! its evidence is measured.
//!
//! A matrix argument is a reference to any `nalgebra` matrix of doubles, static, dynamic or a view: [`RealMatrixView`].
//!
//! The properties of these observers, and errors in the literature, are in `docs/theory-cubic.md` and
//! `docs/theory-mvt.md` of the repository.
#![deny(missing_docs)]

mod certificate;
mod check;
pub mod conditions;
pub mod cubic;
pub mod deployed;
pub mod discrete;
mod display;
pub mod enclosure;
pub mod error;
pub mod error_bound;
pub mod feedback;
mod gain_lmi;
pub mod gain_options;
mod golden_sequence;
pub mod interval;
mod joint;
mod kalman_noise;
pub mod kkl;
pub mod kkl_peb;
pub mod linear;
pub mod lipschitz;
pub mod lpv;
mod lyapunov_choice;
pub mod mean_value;
mod modal;
pub mod names;
pub mod nonlinear_observability;
pub mod norm_filter;
pub mod number;
pub mod numerical_kkl;
pub mod operating_point;
pub mod optimal_cubic;
mod periods;
mod powers;
pub mod proportional_integral;
pub mod recovery;
mod reduced_order;
pub mod robust;
pub mod sampled;
mod separation;
pub mod sliding_mode;
mod symbolic_polynomial;
mod uncertain;
pub mod unknown_input;
mod unseen_modes;
mod varying_periods;
pub mod weights;

pub use conditions::Theorem1;
pub use cubic::{CubicDesign, CubicGain};
pub use deployed::{DeployedLinear, deployed_linear};
pub use discrete::DiscreteDesign;
pub use enclosure::{EnclosureError, IntervalDual, JacobianEnclosure, Region};
pub use error::{DesignError, InfeasibilityReason, NearlyHidden, Pair};
pub use error_bound::{DisturbanceBounds, ErrorBound};
pub use feedback::FeedbackDesign;
pub use gain_options::GainOptions;
pub use interval::{ErrorCoordinates, IntervalDesign, IntervalRequirements, SampledIntervalDesign, least_width_gain};
pub use joint::cubic_lmi_design;
pub use kalman_noise::KalmanNoise;
pub use kkl::{KklCandidate, KklDesign, KklError};
pub use kkl_peb::KklPebDesign;
pub use linear::{LinearDesign, LyapunovWeight};
pub use lipschitz::{LipschitzDesign, LipschitzPlant, Sector};
pub use lpv::{DiscreteLpvDesign, LpvDesign, LpvError};
pub use luenberger_linalg::RealMatrixView;
pub use luenberger_proof::certificate::{Certificate, Certified, Fact, ProvedTheorem};
pub use mean_value::{ContractingCoordinates, LeastSquares, MeanValueDesign, OutputCoordinates};
pub use nalgebra;
pub use names::Names;
pub use nonlinear_observability::{LieObservability, lie_observability};
pub use norm_filter::{GeneralizedPlant, NormFilterDesign, NormTarget, SystemNorm, TimeDomain};
pub use numerical_kkl::{NumericalKklDesign, NumericalKklError};
pub use operating_point::{OperatingPoint, OperatingPointError, operating_point};
pub use optimal_cubic::{EstimationProblem, OptimalCubicDesign};
pub use periods::{GrowingTimes, Periods};
pub use proportional_integral::{
    bandwidth_poles, disturbances_with_rate, disturbances_with_sampled_rate, proportional_integral, with_disturbance,
    with_disturbance_chain, with_sampled_disturbance_chain,
};
pub use recovery::{Recovery, RecoveryObstacle, loop_transfer_recovery, recovery_obstacle};
pub use reduced_order::ReducedOrderDesign;
pub use sampled::SampledCubicDesign;
pub use sliding_mode::{SuperTwistingDesign, sliding_mode_gains};
pub use symbolic_polynomial::SymbolicPolynomial;
pub use uncertain::{UncertainBound, Uncertainty};
pub use unknown_input::{DecoupledPlant, UnknownInputDesign};
pub use unseen_modes::UnseenModes;
pub use varying_periods::{VaryingPeriodDesign, at_varying_periods};
pub use weights::{theta_from_cost_shares, theta_from_importance};

#[doc(hidden)]
pub mod internals {
    //! For the tests of this crate, no part of its interface.

    pub use crate::enclosure::paths::{Way, comparison, explore, explore_ways, follow, note_undefined};
    pub use crate::numerical_kkl::extrapolation::{Extrapolation, Halt};
    pub use crate::numerical_kkl::interpolation::{check_grid, interpolate};
    pub use crate::numerical_kkl::low_rank::approximate;
    pub use crate::numerical_kkl::regression::{Budget, Samples, fit};
    pub use crate::optimal_cubic::cost::directions;
    pub use crate::symbolic_polynomial::polynomial::{constant, evaluate, number};
    pub use crate::symbolic_polynomial::{Arena, ELSEWHERE, collect, fail};
}

/// The example of `README.md`, compiled and run with the documentation's tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
