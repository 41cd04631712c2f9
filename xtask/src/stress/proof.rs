//! Random and adversarial matrices through the judges of `proof`, held against an oracle that shares no code with them.
//! The program is an example of that crate, so that nothing of the workspace is linked here.

use crate::step::{Failure, cargo};

/// Fails if one verdict, margin or witness is wrong.
pub(crate) fn run(matrices: u64, seed: u64) -> Result<(), Failure> {
    cargo(&["build", "--release", "--package", "luenberger-proof", "--example", "stress"]).step("build")?;
    cargo(&["run", "--release", "--quiet", "--package", "luenberger-proof", "--example", "stress", "--"])
        .arguments(&["--matrices", &matrices.to_string(), "--seed", &seed.to_string()])
        .step("stress")
}
