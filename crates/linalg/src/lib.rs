//! Matrix equations, spectra, placement and observability for control.
//!
//! Dense, double precision, `nalgebra` matrices in and out. Every answer carries its evidence (residual, separation,
//! condition), every iteration is bounded, and bad input is an error that names the offending entry.
//!
//! | equation | function |
//! |---|---|
//! | `A = Q T Q'` | [`schur()`], without allocation [`schur_into`]; its order and subspaces [`Schur::reorder`]; before it [`balanced`] |
//! | `A'P + P A + Q = 0` | [`lyapunov()`] |
//! | `A'P A - P + Q = 0` | [`stein()`] |
//! | `A'P + P A + C'C = 0`, `A'P A - P + C'C = 0`, for the factor of `P = U'U` | [`lyapunov_factor`], [`stein_factor`] |
//! | `A'P E + E'P A + Q = 0` | [`generalized_lyapunov`] |
//! | `A X + X B = C` | [`sylvester()`] |
//! | `A'X + X A - X B R^-1 B'X + Q = 0` | [`care`], and by duality [`kalman_gain`] |
//! | `A'X A - X - A'X B (R + B'X B)^-1 B'X A + Q = 0` | [`dare`], and by duality [`discrete_kalman_gain`] |
//! | `rank [A - lambda I; C]`, what the outputs see | [`observability()`], [`detectability`], [`discrete_detectability`] |
//! | `eig(A - B K)`, `eig(A - L C)` | [`place`], [`place_observer`] |
//! | `e^A`, `x+ = Ad x + Bd u`, `xhat+ = Fd xhat + Bd u + Ld y` | [`expm`], [`zero_order_hold`], [`zero_order_hold_injection`] |

#![deny(missing_docs)]

mod argument;
mod balance;
mod compensated;
pub mod discretize;
pub mod error;
pub mod factored;
pub mod generalized;
mod linear_block;
pub mod lyapunov;
pub mod observability;
pub mod placement;
mod product;
pub mod riccati;
pub mod schur;
mod schur_operator;
mod separation;
mod shadow;
pub mod spectrum;
mod staircase;
pub mod stein;
pub mod sylvester;
mod triangular;
mod units;

pub use discretize::{ZeroOrderHold, ZeroOrderHoldInjection, expm, zero_order_hold, zero_order_hold_injection};
pub use error::LinalgError;
pub use factored::{Factored, lyapunov_factor, stein_factor};
pub use generalized::{GeneralizedLyapunov, generalized_lyapunov};
pub use lyapunov::{Lyapunov, LyapunovEquation, lyapunov};
pub use observability::{
    Detectability, Mode, Observability, TimeDomain, detectability, discrete_detectability, observability,
    observability_within,
};
pub use placement::{Placement, place, place_observer};
pub use riccati::{Kalman, Riccati, care, dare, discrete_kalman_gain, dlqr, kalman_gain, lqr};
pub use schur::{Balanced, Reordered, Schur, SchurWorkspace, balanced, schur, schur_into};
pub use spectrum::{eigenvalues, lambda_max, lambda_min, spectral_abscissa, spectral_radius, symmetric_eigenvalues};
pub use stein::{Stein, SteinEquation, stein};
pub use sylvester::{Sylvester, SylvesterEquation, sylvester};

/// The result of this crate's functions.
pub type Result<T> = core::result::Result<T, LinalgError>;
