//! Benchmark of the integrators against scipy and other Rust crates, interleaved in one run.

use crate::step::{Failure, cargo, program, root};
use std::fs;
use std::path::PathBuf;

/// Versions are pinned, because a comparison with whatever is newest cannot be repeated.
const PACKAGES: [&str; 2] = ["scipy==1.17.1", "numpy==2.4.6"];

/// The programs of `xtask/bench/sim`, built.
fn programs() -> Result<PathBuf, Failure> {
    let build = root().join("target/bench-sim");
    cargo(&["build", "--release", "--manifest-path", "xtask/bench/sim/Cargo.toml", "--target-dir"])
        .argument(&build)
        .step("ours and the Rust peers")?;
    Ok(build.join("release"))
}

/// One step of each sampled observer: prints the table, and puts it into its page in `docs` if that is asked for.
pub(crate) fn steps(document: bool) -> Result<(), Failure> {
    let output = program(programs()?.join(if cfg!(windows) { "step.exe" } else { "step" })).output("steps")?;
    println!("\n{output}");
    let table = root().join("target/bench/step.md");
    fs::write(&table, output).map_err(|source| Failure::io(&table, source))?;
    if document { super::write_page("docs/bench-step.md", &table) } else { Ok(()) }
}

/// Writes `sim.json` and `sim.md` in `target/bench`, and puts the latter into its page in `docs` if that is asked for.
pub(crate) fn run(document: bool) -> Result<(), Failure> {
    let folder = root().join("target/bench");
    fs::create_dir_all(&folder).map_err(|source| Failure::io(&folder, source))?;
    let programs = programs()?;
    let python = super::python("bench-sim-venv", &PACKAGES)?;
    program(&python)
        .argument(root().join("xtask/bench/sim/run.py"))
        .argument(programs.join(if cfg!(windows) { "sim-bench.exe" } else { "sim-bench" }))
        .argument(programs.join(if cfg!(windows) { "runs.exe" } else { "runs" }))
        .argument(&folder)
        // One thread for each program.
        .variable("OPENBLAS_NUM_THREADS", "1")
        .step("interleaved")?;
    let table = folder.join("sim.md");
    let text = fs::read_to_string(&table).map_err(|source| Failure::io(&table, source))?;
    println!("\n{text}\n{}", table.display());
    if document { super::write_page("docs/bench-sim.md", &table) } else { Ok(()) }
}
