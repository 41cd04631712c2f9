//! Benchmark of sweeps against the same study in scipy, interleaved in one run, and their memory and files.

use crate::step::{Failure, cargo, program, root};
use std::fs;

/// Versions are pinned, because a comparison with whatever is newest cannot be repeated.
const PACKAGES: [&str; 2] = ["scipy==1.17.1", "numpy==2.4.6"];

/// Runs of the largest sweep.
const LARGEST: usize = 100_000;

/// Writes `sweep.json` and `sweep.md` in `target/bench`, and puts the latter into its page in `docs` if that is asked
/// for.
pub(crate) fn run(largest: Option<usize>, document: bool) -> Result<(), Failure> {
    let folder = root().join("target/bench");
    fs::create_dir_all(&folder).map_err(|source| Failure::io(&folder, source))?;
    cargo(&["build", "--release", "--package", "luenberger-cli"]).step("build")?;
    let python = super::python("bench-sim-venv", &PACKAGES)?;
    let binary = if cfg!(windows) { "release/luenberger.exe" } else { "release/luenberger" };
    program(&python)
        .argument(root().join("xtask/bench/sweep/run.py"))
        .argument(crate::step::target().join(binary))
        .argument(root().join("xtask/bench/sweep/study.toml"))
        .argument(&folder)
        .argument(largest.unwrap_or(LARGEST).to_string())
        // One thread for BLAS, unless a program sets another number.
        .variable("OPENBLAS_NUM_THREADS", "1")
        .step("interleaved")?;
    let table = folder.join("sweep.md");
    let text = fs::read_to_string(&table).map_err(|source| Failure::io(&table, source))?;
    println!("\n{text}\n{}", table.display());
    if document { super::write_page("docs/scale.md", &table) } else { Ok(()) }
}
