//! Runs the checker on mutated certificates and tests the accepted ones by an independent implementation. The program
//! is a binary of the workspace's tests, so that xtask links nothing of the workspace.

use crate::step::{Failure, cargo};

/// Fails if one accepted mutant is contradicted.
pub(crate) fn run(mutants: u64, seed: u64, kind: Option<&str>) -> Result<(), Failure> {
    let (mutants, seed) = (mutants.to_string(), seed.to_string());
    let mut arguments = vec!["--mutants", &mutants, "--seed", &seed];
    if let Some(kind) = kind {
        arguments.extend(["--kind", kind]);
    }
    cargo(&["build", "--release", "--package", "luenberger-tests", "--bin", "falsify"]).step("build")?;
    cargo(&["run", "--release", "--quiet", "--package", "luenberger-tests", "--bin", "falsify", "--"])
        .arguments(&arguments)
        .step("stress")
}
