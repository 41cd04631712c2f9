//! FMUs in an importer: each is validated by fmpy and simulated by it against the golden vectors, bit for bit.
//!
//! fmpy is installed, at the version below, into a virtual environment under `target`. Without python3 or a C compiler
//! nothing can be compared, and the command fails.

use crate::step::{Failure, cargo, program, root};
use std::fs;

/// Pinned, so that a failure can be repeated.
const FMPY: &str = "fmpy==0.3.32";

/// Observers of the template, in each version of the standard and each format of numbers.
pub(crate) fn run() -> Result<(), Failure> {
    let folder = root().join("target/fmu");
    let environment = root().join("target/fmu-venv");
    let python = environment.join(if cfg!(windows) { "Scripts/python.exe" } else { "bin/python" });
    fs::create_dir_all(&folder).map_err(|source| Failure::io(&folder, source))?;
    if !python.exists() {
        program("python3").arguments(&["-m", "venv"]).argument(&environment).step("virtual environment")?;
    }
    program(&python).arguments(&["-m", "pip", "install", "--quiet", FMPY]).step("fmpy")?;
    cargo(&["build", "--package", "luenberger-cli"]).step("build")?;
    let luenberger =
        |arguments: &[&str]| cargo(&["run", "--quiet", "--package", "luenberger-cli", "--"]).arguments(arguments);
    let study = folder.join("study.toml");
    luenberger(&["new", "--force", "-o"]).argument(&study).step("study")?;
    for observer in ["linear", "cubic", "sampled"] {
        for version in ["2", "3"] {
            for format in ["f32", "f64"] {
                let name = format!("{observer}, FMI {version}, {format}");
                let out = folder.join(format!("{observer}-{version}-{format}"));
                luenberger(&["export", "--observer", observer, "--to", "fmu", "--fmi", version, "--format", format])
                    .arguments(&["--force", "-o"])
                    .argument(&out)
                    .argument(&study)
                    .quiet_output(&name)?;
                program(&python).argument(out.join(format!("test_{observer}.py"))).step(&name)?;
            }
        }
    }
    Ok(())
}
