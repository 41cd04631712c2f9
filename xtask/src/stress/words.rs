//! Designs random studies and holds their sentences against simulations. The program is a binary of the workspace's
//! tests, so that xtask links nothing of the workspace; in the development profile, in which the tests have compiled
//! it.

use crate::step::{Failure, cargo};

/// Fails if one sentence is contradicted, or has no check.
pub(crate) fn run(studies: u64, seed: u64, kind: Option<&str>, only_design: bool) -> Result<(), Failure> {
    let (studies, seed) = (studies.to_string(), seed.to_string());
    let mut arguments = vec!["--studies", &studies, "--seed", &seed];
    if let Some(kind) = kind {
        arguments.extend(["--kind", kind]);
    }
    if only_design {
        arguments.push("--only-design");
    }
    cargo(&["build", "--package", "luenberger-tests", "--bin", "words"]).step("build")?;
    cargo(&["run", "--quiet", "--package", "luenberger-tests", "--bin", "words", "--"])
        .arguments(&arguments)
        .step("stress")
}
