//! Linear matrix inequalities, modelled as they are written and verified outside the solver.
//!
//! A [`Problem`] has unknown matrices, strict inequalities between expressions in them, and perhaps an objective.
//! [`Problem::solve`] returns values with margins, and a verdict that `luenberger-proof` reached: nothing is believed
//! because a solver said so.
//!
//! | file | subject |
//! |---|---|
//! | [`problem`], [`variable`], [`expression`], [`inequality`] | how a problem is written |
//! | [`solution`] | values, margins, and the witness of infeasibility |
//! | [`bisection`] | the greatest parameter for which a problem is proved feasible |
//! | [`sdpa`] | semidefinite programs in SDPA's format, with proved bounds of their optimum |
//! | `standard`, `margin`, `verify` | what is asked of the solver, and how its answer is proved |
//! | `refute`, `equations`, `rational` | infeasibility by multipliers that are exact |
//! | `matrix` | matrices of `nalgebra` for the prover, and back |
//! | `certificate_file` | an answer as a file that `luenberger-verify` checks |
//! | [`solver`] | which solver proposes |
//! | `interior` | the house's solver: a primal-dual interior-point method |
//! | `clarabel` | the second opinion, behind the feature `clarabel` |
//! | `sequential` | faer's kernels, so that the same program has the same answer to the last bit |
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

/// The example of `README.md`, compiled and run with the documentation's tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
