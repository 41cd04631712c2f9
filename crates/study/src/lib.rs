//! Implementation of the command `luenberger`: reads a study, builds its plant, designs, simulates and compares
//! observers.
//!
//! A study is a text file ([`schema`] has its keys, [`template`] examples). [`Study::from_path`] reads it and reports
//! every mistake with line and column; [`execute()`] executes one step or all, and writes a folder of results.
//!
//! | file | subject |
//! |---|---|
//! | [`study`], [`diagnostic`] | content of a study, with the specifications of its observers; error messages |
//! | `keys`, `reader` | keys and types; what the kinds read theirs with |
//! | [`schema`], [`read`] | all keys of a study; the parser |
//! | [`model`], [`structure`] | the plant of a study: matrices, expressions (`luenberger-expression`), or from the library; what depends on what |
//! | [`signal`] | inputs and references: expressions of time, tables, state feedback |
//! | [`table`] | CSV: measured logs, tables of inputs |
//! | `designed` | an observer as designed: ready to run, with its evidence |
//! | `synthesis`, `steps`, `tuning` | what the kinds share: designs and hypotheses; steps for samples; tuning rules |
//! | [`kinds`] | the kinds of observers, a module each: keys, design, step on a target, tuning rule |
//! | [`design`] | the design of an observer, or why it is not applicable, with alternatives that were tried |
//! | `trajectory`, `operation` | the plant with its observers in a simulation; bounds of its magnitudes |
//! | [`maps`] | phi, Lambda, B and the other maps of observers as expressions |
//! | [`deployment`] | observers of a study as they run on a target |
//! | [`stream`] | an observer on rows that arrive one after the other |
//! | [`closed_loop`] | the feedback of a study on a target |
//! | [`execute`](mod@execute), [`results`] | the steps; their results |
//! | [`statistics`] | moments, percentiles and the Pareto front of scores |
//! | [`advise`](mod@advise) | every kind of observer that applies, tuned from the same information and ranked |
//! | [`tune`](mod@tune) | what a filter assumes, fitted to a log by the likelihood of its innovations |
//! | [`template`], [`import`](mod@import) | commented example studies; plants from MATLAB, numpy and JSON files |

#![deny(missing_docs)]

pub mod advise;
pub mod deployment;
pub mod design;
mod designed;
pub mod diagnostic;
mod digest;
pub mod error;
pub mod execute;
pub mod import;
mod keys;
pub mod kinds;
mod limits;
pub mod maps;
pub mod model;
mod operation;
pub mod read;
mod reader;
pub mod results;
pub mod schema;
pub mod signal;
pub mod statistics;
mod steps;
pub mod stream;
pub mod structure;
pub mod study;
mod synthesis;
pub mod table;
pub mod template;
mod trajectory;
pub mod tune;
mod tuning;

pub use deployment::closed_loop;
pub use diagnostic::{Diagnostic, Diagnostics};
pub use error::StudyError;
pub use execute::{
    Estimate, Excess, Limits, MemoryFolder, Output, Progress, RunOptions, Step, SweepError, estimate, estimate_roughly,
    execute, execute_in_part, replay_designed, run, simulate_designed, write_folder,
};
pub use luenberger_expression::nearest;
pub use nalgebra;
pub use read::Format;
pub use results::Results;
pub use study::Study;
pub use template::{TEMPLATES, Template};

/// For the tests of this crate, no part of its interface.
#[doc(hidden)]
pub mod internals {
    pub use crate::advise::ranking::{Ranked, preferred, rank, tied};
    pub use crate::execute::pictures::drawn;
    pub use crate::execute::sweep::percentiles::Percentiles;
    pub use crate::tuning::{chain_settling, compositions};
}

/// The example of `README.md`, compiled and run with the documentation's tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
