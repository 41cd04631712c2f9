//! The workspace's own commands: `cargo xtask reproduce`, `cargo xtask test`, `cargo xtask bench linalg`,
//! `cargo xtask bench lmi`, `cargo xtask bench proof`, `cargo xtask stress proof`, `cargo xtask stress theorems`.
//!
//! Each is a row of cargo commands, run one after the other, with the time of each; the first that fails ends the row with
//! its exit code.

mod bench;
mod step;
mod stress;

use clap::{Parser, Subcommand, ValueEnum};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use step::{Failure, cargo};

#[derive(Parser)]
#[command(name = "cargo xtask", about = "The workspace's own commands")]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Reproduce the papers: claims.json, data, figures and report.html
    Reproduce {
        /// Where to write [default: target/reproduce]
        #[arg(long)]
        out: Option<PathBuf>,
    },
    /// Everything a change must pass: format, clippy, tests, documentation, the observers without an allocator
    Test,
    /// Measure beside other tools (needs python3 and the network, for the other tools)
    Bench {
        what: Subject,
        /// Only plants or matrices of at most this order (lmi, linalg)
        #[arg(long)]
        largest: Option<usize>,
        /// Put the table into docs/bench-linalg.md as well (linalg)
        #[arg(long)]
        document: bool,
        /// The folder of `.dat-s` files, from the root of the workspace (proof)
        #[arg(long, default_value = bench::proof::INSTANCES)]
        instances: PathBuf,
    },
    /// Try what is claimed on random and adversarial cases, with a table of what came of them
    Stress {
        what: Claimed,
        /// How many cases (proof)
        #[arg(long, default_value_t = 1_000_000)]
        matrices: u64,
        /// How many mutants of certificates of each theorem (theorems)
        #[arg(long, default_value_t = 100_000)]
        mutants: u64,
        /// Only the theorem of this name (theorems)
        #[arg(long)]
        kind: Option<String>,
        /// Which cases
        #[arg(long, default_value_t = 2019)]
        seed: u64,
    },
}

#[derive(Clone, Copy, ValueEnum)]
enum Claimed {
    /// Definiteness of matrices of numbers and of intervals, and the inequalities of Lyapunov, Stein and of feedback
    Proof,
    /// Certificates of random designs, changed and sealed again: the accepted ones against adversaries
    Theorems,
}

#[derive(Clone, Copy, ValueEnum)]
enum Subject {
    /// Schur form, matrix equations and placement, beside scipy, slycot, python-control and Rust crates
    Linalg,
    /// The joint design of the cubic observer, beside cvxpy with Clarabel and with SCS
    Lmi,
    /// Proved bounds of semidefinite programs, beside the published optima
    Proof,
}

fn main() -> ExitCode {
    let done = match Arguments::parse().command {
        Command::Reproduce { out } => reproduce(out.as_deref()),
        Command::Test => test(),
        Command::Bench { what: Subject::Linalg, largest, document, .. } => bench::linalg::run(largest, document),
        Command::Bench { what: Subject::Lmi, largest, .. } => bench::lmi::run(largest),
        Command::Bench { what: Subject::Proof, instances, .. } => bench::proof::run(&instances),
        Command::Stress { what: Claimed::Proof, matrices, seed, .. } => stress::proof::run(matrices, seed),
        Command::Stress { what: Claimed::Theorems, mutants, seed, kind, .. } => {
            stress::theorems::run(mutants, seed, kind.as_deref())
        }
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("xtask: {failure}");
            failure.exit_code()
        }
    }
}

/// Built and run in the development profile: dependencies are optimised in it too, and a newcomer, who runs the tests as
/// well, compiles them once.
fn reproduce(out: Option<&Path>) -> Result<(), Failure> {
    let out = match out {
        // Relative to where the user stands, while the steps run at the root.
        Some(out) => std::path::absolute(out).map_err(|source| Failure::io(out, source))?,
        None => step::root().join("target/reproduce"),
    };
    cargo(&["build", "--package", "luenberger-reproduce"]).step("build")?;
    // The README's counts are those of the run.
    let run = &["run", "--quiet", "--package", "luenberger-reproduce", "--", "--counted-in", "README.md"];
    cargo(run).argument(&out).step("reproduce")
}

fn test() -> Result<(), Failure> {
    cargo(&["fmt", "--all", "--check"]).step("format")?;
    cargo(&["clippy", "--workspace", "--all-targets", "--", "-D", "warnings"]).step("clippy")?;
    // Other members turn on the feature `clarabel` of lmi: with the workspace it is tested on, by itself off.
    cargo(&["test", "--workspace"]).step("tests")?;
    cargo(&["test", "--package", "luenberger-lmi"]).step("lmi without Clarabel")?;
    cargo(&["doc", "--workspace", "--no-deps"]).variable("RUSTDOCFLAGS", "-D warnings").step("documentation")?;
    let bare = ["test", "--package", "luenberger-observers", "--no-default-features", "--test", "it"];
    cargo(&bare).step("observers without allocator and dual numbers")
}
