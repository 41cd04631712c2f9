//! Rigorous verification of definiteness and matrix inequalities.
//!
//! Approximate data come from floating point; this crate verifies them in exact or interval arithmetic. Every result is
//! a [`Verdict`]: `Proved` with a rigorous margin, `Refuted` with a witness that can be checked independently, or
//! `Undecided` with the reason. The crate depends on no solver and on no linear algebra library.
//!
//! Structure, from the bottom up:
//! - [`Interval`] (outward rounded) and [`Exact`] (dyadic rationals) are two [`Ring`]s in which binary64 data can be
//!   added and multiplied rigorously; a [`Matrix`] expression is written once for both;
//! - [`definite`] decides whether a symmetric matrix is (semi)definite: a floating-point Cholesky with a rigorous error
//!   bound proves it, a verified direction refutes it, exact elimination decides otherwise;
//! - [`semidefinite`] bounds the optimum of a semidefinite program from approximate points of a solver, or proves it
//!   infeasible;
//! - [`label`] decides an inequality that is given as text, such as `A'P + PA < 0`;
//! - [`statement`] evaluates the inequalities of control theory from the original data and verifies them;
//! - [`certificate`] reads and writes files that state a theorem with exact numbers, and checks them: the program
//!   `luenberger-verify`.
//!
//! ```
//! use luenberger_proof::{Matrix, positive_definite};
//! # fn main() -> Result<(), luenberger_proof::ProofError> {
//! let hilbert = Matrix::from_fn(8, 8, |i, j| 1.0 / (i + j + 1) as f64);
//! let margin = positive_definite(&hilbert)?.margin().expect("Hilbert matrices are positive definite, even rounded");
//! assert!(margin > 1.0e-10 && margin < 1.2e-10, "the smallest eigenvalue is 1.11e-10");
//! # Ok(())
//! # }
//! ```
//!
//! Assumption: IEEE 754 binary64 with rounding to nearest and gradual underflow, as Rust specifies.
#![deny(missing_docs)]

pub mod certificate;
#[cfg(feature = "all-theorems")]
pub mod coq;
pub mod definite;
mod embed;
pub mod error;
pub mod exact;
pub mod interval;
pub mod label;
pub mod matrix;
mod number;
mod polynomial;
pub mod ring;
pub mod semidefinite;
pub mod statement;
pub mod verdict;
mod witness;
pub mod wording;

pub use definite::{
    Direction, Entry, negative_definite, negative_semidefinite, positive_definite, positive_semidefinite,
    quadratic_form,
};
pub use error::ProofError;
pub use exact::Exact;
pub use interval::Interval;
pub use matrix::Matrix;
pub use ring::Ring;
pub use verdict::{UndecidedReason, Verdict};

/// For the tests of this crate, no part of its interface.
#[doc(hidden)]
pub mod internals {
    pub use crate::definite::cholesky::{factor, half_exponent, times_power_of_two};
    pub use crate::semidefinite::gram::{Equations, by_position, from_circles, scales};
    pub use crate::statement::deployed_cubic::structured_for;
    pub use crate::statement::exponential::exponential;
}

/// The example of `README.md`, compiled and run with the documentation's tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
