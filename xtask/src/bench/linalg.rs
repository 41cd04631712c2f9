//! Benchmark of the matrix equations against scipy, slycot, python-control and other Rust crates, interleaved in one
//! run.
//!
//! The other tools are installed, at the versions below, into a virtual environment under `target`; the Rust crates are
//! dependencies of a separate package outside the workspace, which a script drives.

use crate::step::{Failure, cargo, program, root};
use std::fs;
use std::path::Path;

/// Versions are pinned, because a comparison with whatever is newest cannot be repeated.
const PACKAGES: [&str; 4] = ["scipy==1.17.1", "numpy==2.4.6", "slycot==0.7.1", "control==0.10.2"];

/// The results are written between these lines of the page.
const MARKS: [&str; 2] = ["<!-- measured -->\n", "<!-- end of what was measured -->"];

/// Orders 2 to 1000, or to `largest`; the model-reduction plants of `../shared/data/mor` where they lie beside the
/// checkout. Writes `linalg.json`, `linalg.md` and `linalg-summary.md` in `target/bench`, and puts the last into its
/// page in `docs` if that is asked for.
pub(crate) fn run(largest: Option<usize>, document: bool) -> Result<(), Failure> {
    let folder = root().join("target/bench");
    let environment = root().join("target/bench-linalg-venv");
    let python = environment.join(if cfg!(windows) { "Scripts/python.exe" } else { "bin/python" });
    fs::create_dir_all(&folder).map_err(|source| Failure::io(&folder, source))?;
    let build = root().join("target/bench-linalg");
    cargo(&["build", "--release", "--manifest-path", "xtask/bench/linalg/Cargo.toml", "--target-dir"])
        .argument(&build)
        .step("ours and the Rust peers")?;
    if !python.exists() {
        program("python3").arguments(&["-m", "venv"]).argument(&environment).step("virtual environment")?;
    }
    program(&python).arguments(&["-m", "pip", "install", "--quiet"]).arguments(&PACKAGES).step("other tools")?;
    let limit = largest.unwrap_or(1000).to_string();
    program(&python)
        .argument(root().join("xtask/bench/linalg/run.py"))
        .argument(build.join(if cfg!(windows) { "release/linalg-bench.exe" } else { "release/linalg-bench" }))
        .argument(&folder)
        .arguments(&["--largest", &limit, "--mor"])
        .argument(root().join("../shared/data/mor"))
        // One thread for everybody.
        .variable("OPENBLAS_NUM_THREADS", "1")
        .variable("OMP_NUM_THREADS", "1")
        .step("interleaved")?;
    let markdown = folder.join("linalg.md");
    let table = fs::read_to_string(&markdown).map_err(|source| Failure::io(&markdown, source))?;
    println!("\n{table}\n{}", markdown.display());
    if document { write_page(&folder.join("linalg-summary.md")) } else { Ok(()) }
}

fn write_page(summary: &Path) -> Result<(), Failure> {
    let page = root().join("docs/bench-linalg.md");
    let text = fs::read_to_string(&page).map_err(|source| Failure::io(&page, source))?;
    let table = fs::read_to_string(summary).map_err(|source| Failure::io(summary, source))?;
    let missing = || Failure::io(&page, std::io::Error::other("the marks of the table are not there"));
    let (before, rest) = text.split_once(MARKS[0]).ok_or_else(missing)?;
    let (_, after) = rest.split_once(MARKS[1]).ok_or_else(missing)?;
    let text = format!("{before}{}{table}{}{after}", MARKS[0], MARKS[1]);
    fs::write(&page, text).map_err(|source| Failure::io(&page, source))
}
