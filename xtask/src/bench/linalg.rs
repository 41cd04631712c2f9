//! Benchmark of the matrix equations against scipy, slycot, python-control and other Rust crates, interleaved in one
//! run.
//!
//! The other tools are installed, at the versions below, into a virtual environment under `target`; the Rust crates are
//! dependencies of a separate package outside the workspace, which a script drives.

use crate::step::{Failure, cargo, program, root};
use std::fs;

/// Versions are pinned, because a comparison with whatever is newest cannot be repeated.
const PACKAGES: [&str; 4] = ["scipy==1.17.1", "numpy==2.4.6", "slycot==0.7.1", "control==0.10.2"];

/// Orders 2 to 1000, or to `largest`; the model-reduction plants of `../shared/data/mor` where they lie beside the
/// checkout. Writes `linalg.json`, `linalg.md` and `linalg-summary.md` in `target/bench`, and puts the last into its
/// page in `docs` if that is asked for.
pub(crate) fn run(largest: Option<usize>, document: bool) -> Result<(), Failure> {
    let folder = root().join("target/bench");
    fs::create_dir_all(&folder).map_err(|source| Failure::io(&folder, source))?;
    let build = root().join("target/bench-linalg");
    cargo(&["build", "--release", "--manifest-path", "xtask/bench/linalg/Cargo.toml", "--target-dir"])
        .argument(&build)
        .step("ours and the Rust peers")?;
    let python = super::python("bench-linalg-venv", &PACKAGES)?;
    let limit = largest.unwrap_or(1000).to_string();
    program(&python)
        .argument(root().join("xtask/bench/linalg/run.py"))
        .argument(build.join(if cfg!(windows) { "release/linalg-bench.exe" } else { "release/linalg-bench" }))
        .argument(&folder)
        .arguments(&["--largest", &limit, "--mor"])
        .argument(root().join("../shared/data/mor"))
        // One thread for each program.
        .variable("OPENBLAS_NUM_THREADS", "1")
        .variable("OMP_NUM_THREADS", "1")
        .step("interleaved")?;
    let markdown = folder.join("linalg.md");
    let table = fs::read_to_string(&markdown).map_err(|source| Failure::io(&markdown, source))?;
    println!("\n{table}\n{}", markdown.display());
    if document { super::write_page("docs/bench-linalg.md", &folder.join("linalg-summary.md")) } else { Ok(()) }
}
