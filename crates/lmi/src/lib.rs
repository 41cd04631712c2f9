//! Modelling language for linear matrix inequalities, with rigorous verification of the solutions.
//!
//! A [`Problem`] has unknown matrices, strict inequalities between expressions in them, and optionally an objective.
//! [`Problem::solve`] returns values with margins, and a verdict by `luenberger-proof`; the solver's result is never
//! trusted.
//!
//! | file | subject |
//! |---|---|
//! | [`problem`], [`variable`], [`expression`], [`inequality`] | formulation of a problem |
//! | [`solution`] | values, margins, and the witness of infeasibility |
//! | [`bisection`] | the largest parameter for which a problem is proved feasible |
//! | [`sdpa`] | semidefinite programs in SDPA's format, with rigorous bounds on their optimum |
//! | `standard`, `margin`, `verify` | the problem passed to the solver, and the verification of its solution |
//! | `refute`, `equations`, `rational` | proof of infeasibility by exact multipliers |
//! | `matrix` | conversion of `nalgebra` matrices to `proof` matrices and back |
//! | `certificate_file` | a result as a file that `luenberger-verify` checks |
//! | [`solver`] | choice of the solver |
//! | `interior` | the built-in solver: a primal-dual interior-point method |
//! | `clarabel` | an alternative solver, behind the feature `clarabel` |
//! | `sequential` | single-threaded faer kernels, for bitwise reproducible results |
#![deny(missing_docs)]

pub mod bisection;
mod certificate_file;
#[cfg(feature = "clarabel")]
mod clarabel;
mod coefficients;
mod conic;
mod equations;
pub mod error;
pub mod expression;
pub mod inequality;
mod interior;
mod margin;
mod matrix;
pub mod problem;
mod products;
mod rational;
mod refute;
pub mod sdpa;
mod sequential;
pub mod solution;
pub mod solver;
mod standard;
pub mod variable;
mod verify;

pub use bisection::{Bisection, greatest_parameter, greatest_parameter_with};
pub use error::{Fault, LmiError};
pub use expression::{Expression, he, identity, trace, zeros};
pub use inequality::{Bound, Inequality};
pub use luenberger_proof::Verdict;
pub use matrix::{dynamic_matrix, proof_matrix};
pub use nalgebra;
pub use problem::{Problem, Settings};
pub use solution::{Effort, Infeasibility, Margin, Multiplier, Optimum, Solution};
pub use solver::{NotBuiltIn, Solver};
pub use variable::{Structure, Variable};

/// For the tests of this crate, no part of its interface.
#[doc(hidden)]
pub mod internals {
    pub use crate::coefficients::{Rounded, evaluate, expand};
    pub use crate::conic::ConicProgram;
    pub use crate::equations::{Row, solve_near};
    pub use crate::interior::program::Scaled;
    pub use crate::interior::schur::{assemble, joined};
    pub use crate::products::products;
    pub use crate::rational::near_rational;
    pub use crate::sdpa::centre::{draw, last};
    pub use crate::sdpa::face::confines_dual;
    pub use crate::sequential::{Cholesky, eigenvalues, product};
    pub use crate::standard::{Anchor, Small, standard_form};
}

/// The example of `README.md`, compiled and run with the documentation's tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
