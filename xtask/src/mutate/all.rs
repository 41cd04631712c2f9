//! The mutants that cargo-mutants finds by itself, in the files where results are formed: `.cargo/mutants.toml` lists
//! these, and the mutants that no test can notice, with the reasons.
//!
//! They are made in the copy under `target/mutate`, one after the other in the same place, so that each is built from
//! what the one before has left.

use crate::step::{Failure, cargo, root};

use super::copy;

/// Runs all of them, or a shard `k/n`: every n-th, from the k-th on. What each did is in `target/mutate/mutants.out`.
///
/// Fails if one survives. Says so and does nothing without cargo-mutants.
pub(crate) fn run(shard: Option<&str>, list: bool) -> Result<(), Failure> {
    if cargo(&["mutants", "--version"]).quiet_output("version of cargo-mutants").is_err() {
        crate::skipped("mutants of the files where results are formed", "cargo-mutants");
        return Ok(());
    }
    let folder = root().join("target/mutate");
    let tree = folder.join("workspace");
    copy::mirror(&root(), &tree)?;
    let config = root().join(".cargo/mutants.toml");
    let mut mutants = cargo(&["mutants", "--workspace", "--in-place", "--no-shuffle", "--colors", "never"])
        .argument("--config")
        .argument(config)
        .argument("--output")
        .argument(&folder)
        .folder(&tree);
    if let Some(shard) = shard {
        mutants = mutants.arguments(&["--sharding", "round-robin", "--shard", shard]);
    }
    if list {
        return mutants.argument("--list").step("list of mutants");
    }
    // A failing case is enough: none is made smaller, and none is kept for the next mutant.
    let variables = [("PROPTEST_MAX_SHRINK_ITERS", "0"), ("PROPTEST_DISABLE_FAILURE_PERSISTENCE", "true")];
    let mutants = variables.iter().fold(mutants, |step, (name, value)| step.variable(name, value));
    mutants.variable("CARGO_TARGET_DIR", &folder.join("target").to_string_lossy()).step("mutants")
}
