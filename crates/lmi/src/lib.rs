//! Linear matrix inequalities, modelled as they are written and verified outside the solver.
#![deny(missing_docs)]

pub mod bisection;
mod coefficients;
mod conic;
mod equations;
pub mod error;
pub mod expression;
pub mod inequality;
mod interior;
mod margin;
pub mod problem;
mod rational;
mod refute;
pub mod sdpa;
pub mod solution;
mod standard;
pub mod variable;
mod verify;

pub use bisection::{Bisection, greatest_parameter};
pub use error::{Fault, LmiError};
pub use expression::{Expression, he, identity, trace, zeros};
pub use inequality::{Bound, Inequality};
pub use problem::{Problem, Settings};
pub use solution::{Effort, Infeasibility, Margin, Multiplier, Optimum, Solution};
pub use variable::{Structure, Variable};
