//! Matrix equations, spectra, placement and observability for control.
//!
//! Dense, double precision, `nalgebra` matrices in (static, dynamic or views: [`RealMatrixView`]), dynamic ones out.
//! Every answer carries its evidence (residual, separation, condition), every iteration is bounded, and bad input is an
//! error that names the offending entry.
//!
//! | equation | function |
//! |---|---|
//! | `A = Q T Q'` | [`schur()`], without allocation [`schur_into`]; its order and subspaces [`Schur::reorder`]; before it [`balanced`] |
//! | `A'P + P A + Q = 0` | [`lyapunov()`] |
//! | `A'P A - P + Q = 0` | [`stein()`] |
//! | `A'P + P A + C'C = 0`, `A'P A - P + C'C = 0`, for the factor of `P = U'U` | [`lyapunov_factor`], [`stein_factor`] |
//! | `A'P E + E'P A + Q = 0`, `A'P A - E'P E + Q = 0` | [`generalized_lyapunov`], [`generalized_stein`] |
//! | `A X + X B = C` | [`sylvester()`] |
//! | `A X B - X + C = 0` | [`discrete_sylvester`] |
//! | `A'X + X A - X B R^-1 B'X + Q = 0` | [`care`], and by duality [`kalman_gain`] |
//! | `A'X A - X - A'X B (R + B'X B)^-1 B'X A + Q = 0` | [`dare`], and by duality [`discrete_kalman_gain`] |
//! | the same with a cross term S and for `E x' = A x + B u` | [`generalized_care`], [`generalized_dare`] |
//! | `rank [A - lambda I; C]`, observability | [`observability()`], [`detectability`], [`discrete_detectability`] |
//! | `min sigma_min([A - lambda I; C])`, how far from unobservable | [`distance_to_unobservability`] |
//! | `rank [A - lambda I, B; C, D]`, invariant zeros | [`invariant_zeros`] |
//! | `T^-1 A T, T^-1 B, C T`, Kalman's four parts | [`kalman_decomposition`] |
//! | `eig(A - B K)`, `eig(A - L C)` | [`place`], [`place_observer`], with zeros in the gain [`place_structured`], [`place_observer_structured`] |
//! | `T A - F T = G C`, `M T + N C = K`, observers of lower order | [`reduced_order_observer`], [`functional_observer()`], [`least_functional_observer`] |
//! | `e^A`, `x+ = Ad x + Bd u`, `xhat+ = Fd xhat + Bd u + Ld y` | [`expm`], [`zero_order_hold`], [`zero_order_hold_observer`] |
//! | `x' = A x + B u` to `x+ = Ad x + Bd u` and back: zero- and first-order hold, Tustin, impulse, matched | [`c2d`], [`d2c`], [`c2d_matched`], [`logm`] |
//! | `V = R h`, `Qd = int_0^h e^{As} W e^{A's} ds`: noise in continuous and discrete time | [`measurement_intensity`], [`discrete_process_noise`] and their inverses |
//! | `C (jw I - A)^-1 B + D`, singular values | [`FrequencyResponse`] |
//! | frequencies in radians per unit of time, with or without a sampling period | [`FrequencyAxis`] |
//! | `S = (I + L)^-1` | [`sensitivity`] |
//! | `1 + L = 0`: gain, phase, delay and modulus margins | [`stability_margins`], [`discrete_stability_margins`] |
//! | `(y, u)` to xhat, `v` to e; loops `u = -K xhat`, S and T | [`ObserverTransfer`], [`LoopTransfer`], [`LoopMargins`] |
//! | poles from settling time and damping, of prototype filters | [`poles_from`] |
//!
//! # How far to trust a solution
//!
//! Three numbers come with a solution, and answer three questions.
//!
//! 1. *Does it solve the equation?* `residual`, relative to the terms of the equation. A multiple of `n eps` says that
//!    the answer is exact for data that differ from yours in the last digits. No double-precision method promises more,
//!    and a small residual says nothing about the error of the solution.
//! 2. *What do errors of my data do to it?* `condition`, from the `separation` of the spectra (of a Riccati equation,
//!    of the closed loop): data known to three digits and a condition of 100 leave one. Where it reaches `1 / eps`, the
//!    answer is refined with the defect in twice the working precision and given if that converges; if not, the error
//!    `UndecidedEquation` has the separation, the condition and the digits that it takes. The error `SingularEquation`
//!    means the coefficients as stored, and is decided in integers.
//! 3. *How far is it from the exact solution for the numbers I gave?* `forward_error`: a bound in the Frobenius norm,
//!    relative to the solution. It includes the rounding of the residual itself, and is typically ten to a thousand
//!    times the error. For Hurwitz and Schur stable coefficients, and for Riccati equations, the separation behind it
//!    is a bound; otherwise (and for Sylvester equations) it is Hager's and Higham's estimate, allowed to be wrong by a
//!    factor of three. An infinite one says that nothing is known. It is itself computed in floating point and is
//!    not a proof.
//!
//! Norms do not see small entries. If units of the state are decades apart, an error that is small beside `||P||` may
//! be larger than an entry of interest. Such units are balanced first; `forward_error` still speaks of the norm in the
//! units given.
//!
//! # What the answers do not depend on
//!
//! Multiply states, inputs, outputs, noise and time by powers of two: verdicts stay the same, and every number in its
//! units, as far as it is determined by the plant.
//!
//! * *To the bit*: observability and detectability with their margins, decompositions, invariant zeros, placement with
//!   one input (output), observers of lower order.
//! * *To the claimed accuracy*: eigenvalues, Lyapunov, Stein, Sylvester and Riccati equations, exponentials,
//!   conversions, noise of a period. Equations balance units that are more than a thousand apart.
//! * *With one unit for all inputs and one for all outputs*: norms, which add outputs.
//! * *Not*: the gain of a placement with several inputs, which makes the condition of the eigenvectors small in the
//!   units given, if those are within a thousand of balanced ones; the condition itself; the distance to
//!   unobservability; a Schur form; eigenvalues of a symmetric matrix.
//!
//! If the data are exact (or you want to know what the method contributed), [`LyapunovEquation::refine`],
//! [`SteinEquation::refine`], [`SylvesterEquation::refine`] and [`DiscreteSylvesterEquation::refine`] compute the
//! defect in twice the working precision: a step or two take the error from `condition * n eps` to the last bit of the
//! solution, and return what they changed, which is an estimate of the error there was. A solution for `Q = C'C` keeps
//! the small directions of `P` if asked for by its factor ([`lyapunov_factor`], [`stein_factor`]).
//!
//! ```
//! use luenberger_linalg::LyapunovEquation;
//! use nalgebra::dmatrix;
//! let a = dmatrix![-1.0, 300.0; 0.0, -2.0];
//! let q = dmatrix![2.0, 1.0; 1.0, 2.0];
//! let mut equation = LyapunovEquation::new(&a)?;
//! let mut found = equation.solve(&q)?;
//! let bound = found.forward_error();
//! let error = equation.refine(&q, &mut found.p)?;
//! println!("residual {:e}, condition {:e}, error {error:e}, at most {bound:e}", found.residual, found.condition);
//! assert!(error <= bound);
//! # Ok::<(), luenberger_linalg::LinalgError>(())
//! ```

#![deny(missing_docs)]
// A function that is not inlined into a kernel is compiled without the kernel's instruction set (`kernel.rs`).
#![allow(clippy::inline_always)]

mod argument;
mod balance;
mod compensated;
pub mod conversion;
pub mod decomposition;
pub mod definite;
pub mod discretize;
pub mod distance;
mod equilibration;
pub mod error;
mod error_estimate;
mod exactly_singular;
pub mod factored;
mod forward_error;
mod frequency_axis;
pub mod frequency_response;
pub mod functional_observer;
mod functional_order;
pub mod generalized;
mod kernel;
mod least_visible;
mod linear_block;
pub mod lyapunov;
pub mod margins;
pub mod observability;
pub mod placement;
mod product;
pub mod prototype;
pub mod riccati;
mod rosenbrock;
pub mod schur;
mod schur_operator;
mod separation;
mod sequential;
pub mod spectrum;
mod staircase;
pub mod stein;
mod subspace_refinement;
pub mod sylvester;
pub mod system_norm;
pub mod transfer;
mod triangular;
mod units;
pub mod zeros;

pub use argument::{RealMatrixView, symmetric, symmetric_part};
pub use balance::state_units;
pub use conversion::{
    Discretization, Realization, StandardForm, ZerosPolesGain, c2d, c2d_delayed, c2d_matched, continuous_process_noise,
    d2c, discrete_process_noise, logm, measurement_intensity, sampled_measurement_covariance, standard_form,
};
pub use decomposition::{KalmanDecomposition, KalmanPart, kalman_decomposition};
pub use definite::{positive_definite, positive_semidefinite};
pub use discretize::{ZeroOrderHold, ZeroOrderHoldObserver, expm, zero_order_hold, zero_order_hold_observer};
pub use distance::{UnobservabilityDistance, distance_to_unobservability};
pub use error::LinalgError;
pub use factored::{Factored, lyapunov_factor, stein_factor};
pub use frequency_axis::FrequencyAxis;
pub use frequency_response::{FrequencyResponse, unwrapped_phase};
pub use functional_observer::{FunctionalObserver, functional_observer, reduced_order_observer};
pub use functional_order::{LeastFunctionalObserver, least_functional_observer};
pub use generalized::{GeneralizedLyapunov, GeneralizedStein, generalized_lyapunov, generalized_stein};
pub use lyapunov::{Lyapunov, LyapunovEquation, SymmetricEquation, lyapunov};
pub use margins::{
    GainMargin, PhaseMargin, StabilityMargins, discrete_stability_margins, sensitivity, stability_margins,
};
pub use nalgebra;
pub use observability::{
    Detectability, Mode, Observability, StabilityRegion, detectability, discrete_detectability, observability,
    observability_within,
};
pub use placement::{
    Placement, StructuredPlacement, place, place_observer, place_observer_structured, place_structured,
};
pub use prototype::{PolePattern, damping_from_overshoot, poles_from};
pub use riccati::{
    Kalman, MeasurementUpdate, Riccati, care, correlated_kalman_gain, dare, discrete_correlated_kalman_gain,
    discrete_kalman_gain, dlqr, generalized_care, generalized_dare, kalman_gain, lqr, measurement_update,
};
pub use schur::{Balanced, Reordered, Schur, SchurWorkspace, balanced, schur, schur_into};
pub use spectrum::{eigenvalues, lambda_max, lambda_min, spectral_abscissa, spectral_radius, symmetric_eigenvalues};
pub use stein::{Stein, SteinEquation, stein};
pub use sylvester::{
    DiscreteSylvester, DiscreteSylvesterEquation, PairEquation, Sylvester, SylvesterEquation, discrete_sylvester,
    sylvester,
};
pub use system_norm::{HInfinityNorm, discrete_h_infinity_norm, discrete_h2_norm, h_infinity_norm, h2_norm};
pub use transfer::{LoopMargins, LoopTransfer, ObserverTransfer};
pub use zeros::{InvariantZeros, invariant_zeros};

/// The result of this crate's functions. With another error it is the standard one, so that a glob import does not
/// hide that.
///
/// ```
/// use luenberger_linalg::*;
/// fn parsed(text: &str) -> Result<f64, std::num::ParseFloatError> {
///     text.parse()
/// }
/// fn abscissa() -> Result<f64> {
///     spectral_abscissa(&nalgebra::dmatrix![-1.0])
/// }
/// assert_eq!(parsed("-1"), Ok(-1.0));
/// assert_eq!(abscissa(), Ok(-1.0));
/// ```
pub type Result<T, E = LinalgError> = core::result::Result<T, E>;

/// For the tests of this crate, no part of its interface.
#[doc(hidden)]
pub mod internals {
    pub use crate::argument::unit_scale;
    pub use crate::balance::{Balance, sizes};
    pub use crate::compensated::{product, sum};
    pub use crate::error_estimate::{Closest, contraction, refined};
    pub use crate::exactly_singular::{Regularity, characteristic, power, prime_below, regularity, residue};
    pub use crate::forward_error::{ErrorScale, forward_error, of_exact};
    pub use crate::kernel::dispatch;
    pub use crate::least_visible::least_visible;
    pub use crate::placement::eigenvectors::{Eigenvectors, Part, norm};
    pub use crate::placement::extremes::extreme_singular_values;
    pub use crate::placement::poles::RequestedPoles;
    pub use crate::placement::sensitivity::{Eigen, conditions};
    pub use crate::product::{multiply, view, view_mut};
    pub use crate::riccati::near_identity;
    pub use crate::schur::hessenberg::{Blocked, Reduction, reflector};
    pub use crate::schur::standard::{Standard, standardise};
    pub use crate::schur::triangular_factor;
    pub use crate::separation::{rescale, separation, separation_by_three};
    pub use crate::staircase::Staircase;
    pub use crate::subspace_refinement::refine;
    pub use crate::triangular::pair::{Block, eliminate, solve as solve_pair};
    pub use crate::triangular::{Coefficient, Equation, Sizes, solve, solve_symmetric};
    pub use crate::units::Units;
}

/// The example of `README.md`, compiled and run with the documentation's tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
