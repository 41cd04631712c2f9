//! The papers, their claims, and the verdicts computed from them.
//!
//! A claim of a paper is a row of data (its place in the paper, the printed value, its accuracy) and a function that
//! computes; the verdict follows from the two by the rules in [`evidence`] and is never entered by hand. A paper is a
//! list of claims, of figures and of findings; [`run`] processes all of them and writes the ledger.
//!
//! This crate has no control algorithms of its own; it uses the other crates. The observers that a paper gives for one
//! specific plant are instances of theirs, and are defined beside its claims ([`kkl::cuk`],
//! [`kkl::exponential_cascade`]).
//!
//! - How to add a claim: [`claim`]. How to add a figure: [`paper`]. How to add a paper: a folder beside `cubic/` with a
//!   function that returns a [`Paper`], and its name in [`papers`].

#![deny(missing_docs)]

pub mod claim;
pub mod context;
mod cubic;
pub mod evidence;
mod hypotheses;
pub mod kkl;
pub mod ledger;
mod mvt;
pub mod paper;
mod progress;
pub mod report;
mod summary;
pub mod terminal;
mod threads;
pub mod value;

pub use claim::{CheckError, Claim, Class, DocProof, KernelTheorems, NoteTable, Outcome, Quote, Record};
pub use context::Context;
pub use evidence::{Counterexample, Evidence, Hypothesis, Standing, Tolerance, Verdict};
pub use ledger::{ReproduceError, Summary, run_papers, write_refutations};
pub use luenberger_figures::{Bar, Dash, Figure, Hue, Mark, Marker, Panel, Series, Table, figure, table};
pub use paper::{Dataset, Drawing, Finding, KernelRefutation, Kind, LiveExample, Paper, Plate};
pub use value::{Printed, Value};

use std::path::Path;

/// Every paper, in the order of the report.
pub fn papers() -> Vec<Paper> {
    vec![cubic::paper(), mvt::paper(), kkl::paper()]
}

/// Checks every claim and draws every figure of every paper; writes `claims.json`, `data/`, `figures/` and
/// `report.html` below `out`.
/// # Errors
/// [`ReproduceError`] where the output cannot be written. A check or figure that fails does not stop the run: it is
/// listed in [`Summary::failures`].
pub fn run(out: &Path) -> Result<Summary, ReproduceError> {
    run_papers(&papers(), out)
}
