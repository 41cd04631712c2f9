//! What the command `luenberger` does: a study is read, its plant is made from text, observers are designed, run and
//! compared.
//!
//! A study is a text file ([`schema`] has its keys, [`template`] examples). [`Study::from_path`] reads it, with every
//! mistake at its line and column; [`execute()`] does one of its steps or all of them, and leaves a folder of results.
//!
//! | file | subject |
//! |---|---|
//! | [`study`], [`read`], [`schema`], [`diagnostic`] | what a file says; reading it; what it may say; mistakes in it |
//! | [`model`] | the plant of a study: matrices, text (`luenberger-expression`), or built in |
//! | [`signal`] | inputs and references: expressions of time, tables, feedback |
//! | [`table`] | CSV: measured logs, tables of inputs |
//! | [`design`] | each observer of a study, or why it does not fit |
//! | [`execute`](mod@execute), [`results`] | the steps; what comes of them |
//! | [`template`], [`import`](mod@import) | commented studies to start from; plants from MATLAB's, numpy's and JSON files |

#![deny(missing_docs)]

pub mod design;
pub mod diagnostic;
pub mod error;
pub mod execute;
pub mod import;
pub mod model;
pub mod read;
pub mod results;
pub mod schema;
pub mod signal;
pub mod study;
pub mod table;
pub mod template;

pub use diagnostic::{Diagnostic, Diagnostics};
pub use error::StudyError;
pub use execute::{Estimate, Progress, RunOptions, Step, estimate, execute, run};
pub use luenberger_expression::nearest;
pub use read::Format;
pub use results::Results;
pub use study::Study;
pub use template::{TEMPLATES, Template};

/// The example of `README.md`, compiled and run with the documentation's tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
