//! Benchmark of the matrix equations against scipy, slycot, python-control and other Rust crates, interleaved in one
//! run.
//!
//! The other tools are installed, at the versions below, into a virtual environment under `target`; the Rust crates are
//! dependencies of a separate package outside the workspace, which a script drives. With a commit the same package is
//! built for the sources of that commit as well, and both are timed in turn.

use crate::step::{Failure, Step, cargo, program, root};
use std::fs;
use std::path::{Path, PathBuf};

/// Versions are pinned, because a comparison with whatever is newest cannot be repeated.
const PACKAGES: [&str; 4] = ["scipy==1.17.1", "numpy==2.4.6", "slycot==0.7.1", "control==0.10.2"];

/// Orders 2 to 1000, or to `largest`, of all routines or those named; the model-reduction plants of
/// `../shared/data/mor` where they lie beside the checkout. Writes `linalg.json`, `linalg.md` and `linalg-summary.md`
/// in `target/bench`, and puts the last into its page in `docs` if that is asked for.
pub(crate) fn run(
    largest: Option<usize>,
    routines: &[String],
    document: bool,
    against: Option<&str>,
) -> Result<(), Failure> {
    if let Some(commit) = against {
        return compare(commit, largest.unwrap_or(100));
    }
    let folder = root().join("target/bench");
    fs::create_dir_all(&folder).map_err(|source| Failure::io(&folder, source))?;
    let server = built(&root())?;
    let python = super::python("bench-linalg-venv", &PACKAGES)?;
    let limit = largest.unwrap_or(1000).to_string();
    let step = program(&python)
        .argument(root().join("xtask/bench/linalg/run.py"))
        .argument(server)
        .argument(&folder)
        .arguments(&["--largest", &limit, "--mor"])
        .argument(root().join("../shared/data/mor"));
    let chosen = routines.iter().flat_map(|routine| ["--routine", routine]);
    chosen
        .fold(step, Step::argument)
        // One thread for each program.
        .variable("OPENBLAS_NUM_THREADS", "1")
        .variable("OMP_NUM_THREADS", "1")
        .step("interleaved")?;
    let markdown = folder.join("linalg.md");
    let table = fs::read_to_string(&markdown).map_err(|source| Failure::io(&markdown, source))?;
    println!("\n{table}\n{}", markdown.display());
    if document { super::write_page("docs/bench-linalg.md", &folder.join("linalg-summary.md")) } else { Ok(()) }
}

/// The program that runs the routines of the sources in this folder, built there.
fn built(sources: &Path) -> Result<PathBuf, Failure> {
    let build = sources.join("target/bench-linalg");
    cargo(&["build", "--release", "--manifest-path"])
        .argument(sources.join("xtask/bench/linalg/Cargo.toml"))
        .arguments(&["--target-dir"])
        .argument(&build)
        .step("ours and the Rust peers")?;
    Ok(build.join("release").join(format!("linalg-bench{}", std::env::consts::EXE_SUFFIX)))
}

/// The times of this tree relative to those of a commit, routine by routine, in turn. Its sources are put into
/// `target`, and get the program of this tree.
fn compare(commit: &str, largest: usize) -> Result<(), Failure> {
    let folder = root().join("target/bench-against").join(commit);
    fs::create_dir_all(&folder).map_err(|source| Failure::io(&folder, source))?;
    let archive = folder.join("sources.tar");
    program("git").arguments(&["archive", "--output"]).argument(&archive).arguments(&[commit]).step("sources")?;
    program("tar").arguments(&["-xf"]).argument(&archive).arguments(&["-C"]).argument(&folder).step("unpacked")?;
    for file in ["Cargo.toml", "Cargo.lock", "src/main.rs", "src/against.rs"] {
        let (from, to) = (root().join("xtask/bench/linalg").join(file), folder.join("xtask/bench/linalg").join(file));
        fs::copy(&from, &to).map_err(|source| Failure::io(&to, source))?;
    }
    let (earlier, now) = (built(&folder)?, built(&root())?);
    program(now).argument(earlier).arguments(&[&largest.to_string()]).step("in turn")
}
