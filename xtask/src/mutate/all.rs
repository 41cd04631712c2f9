//! The mutants that cargo-mutants finds by itself, in the files where results are formed: `.cargo/mutants.toml` lists
//! these, and the mutants that no test can notice, with the reasons.
//!
//! They are put into the copy under `target/mutate`, all mutants of a package at once, each behind a switch, by a
//! program of its own (`xtask/mutants`), which needs a parser of Rust that nothing else here waits for.

use clap::Args;

use crate::step::{Failure, cargo, root, target};

use super::copy;

/// Which of them.
#[derive(Args)]
pub(crate) struct Chosen {
    /// A package, with or without its prefix; may be repeated
    #[arg(long, short, requires = "all")]
    package: Vec<String>,
    /// A sample of these, k/n: every n-th of them, from the k-th on (counted from 0)
    #[arg(long, requires = "all")]
    shard: Option<String>,
    /// Only those that survived the last time
    #[arg(long, requires = "all")]
    again: bool,
    /// How many tests run at once; all cores by default
    #[arg(long, requires = "all")]
    jobs: Option<usize>,
    /// Seconds of tests after which a mutant counts as one that survives; all tests that reach it by default
    #[arg(long, requires = "all")]
    seconds: Option<u64>,
}

/// Runs them. What each did is in `target/mutate/results`.
///
/// Fails if one survives. Says so and does nothing without cargo-mutants.
pub(crate) fn run(chosen: &Chosen, only: &[String], list: bool) -> Result<(), Failure> {
    if cargo(&["mutants", "--version"]).quiet_output("version of cargo-mutants").is_err() {
        crate::skipped("mutants of the files where results are formed", "cargo-mutants");
        return Ok(());
    }
    let folder = root().join("target/mutate");
    let tree = folder.join("workspace");
    copy::mirror(&root(), &tree)?;
    // The dependencies that the tests are compiled with are there.
    let target = target();
    let mut step =
        cargo(&["run", "--quiet", "--locked", "--manifest-path", "xtask/mutants/Cargo.toml", "--target-dir"])
            .argument(target.join("mutants"));
    let places = [
        ("--tree", tree),
        ("--target", target),
        ("--config", root().join(".cargo/mutants.toml")),
        ("--out", folder.join("results")),
    ];
    step = places.iter().fold(step.argument("--"), |step, (name, path)| step.argument(name).argument(path));
    let repeated = [("--package", &chosen.package[..]), ("--only", only)];
    for (name, values) in repeated {
        step = values.iter().fold(step, |step, value| step.argument(name).argument(value));
    }
    let jobs = chosen.jobs.map(|jobs| jobs.to_string());
    let seconds = chosen.seconds.map(|seconds| seconds.to_string());
    for (name, value) in [("--shard", &chosen.shard), ("--jobs", &jobs), ("--seconds", &seconds)] {
        step = value.iter().fold(step, |step, value| step.argument(name).argument(value));
    }
    for (name, is_set) in [("--again", chosen.again), ("--list", list)] {
        step = if is_set { step.argument(name) } else { step };
    }
    step.step("mutants")
}
