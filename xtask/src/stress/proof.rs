//! Tests the verdicts of `proof` on random and adversarial matrices against an independent reference. The program is an
//! example of that crate, so that xtask links nothing of the workspace.

use crate::step::{Failure, cargo};

/// Fails if one verdict, margin or witness is wrong.
pub(crate) fn run(matrices: u64, seed: u64) -> Result<(), Failure> {
    cargo(&["build", "--release", "--package", "luenberger-proof", "--example", "stress"]).step("build")?;
    cargo(&["run", "--release", "--quiet", "--package", "luenberger-proof", "--example", "stress", "--"])
        .arguments(&["--matrices", &matrices.to_string(), "--seed", &seed.to_string()])
        .step("stress")
}
