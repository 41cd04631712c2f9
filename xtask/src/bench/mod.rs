//! Benchmarks against other tools or published results, and of observers against each other.

pub(crate) mod linalg;
pub(crate) mod lmi;
pub(crate) mod observers;
pub(crate) mod proof;
pub(crate) mod sim;
pub(crate) mod sweep;

use crate::step::{Failure, program, root};
use std::fs;
use std::path::{Path, PathBuf};

/// Results are written between these lines of a page.
const MARKS: [&str; 2] = ["<!-- measured -->\n", "<!-- end of what was measured -->"];

/// The Python of a virtual environment under `target` with these packages, so that the user's own is unchanged.
fn python(environment: &str, packages: &[&str]) -> Result<PathBuf, Failure> {
    let environment = root().join("target").join(environment);
    let python = environment.join(if cfg!(windows) { "Scripts/python.exe" } else { "bin/python" });
    if !python.exists() {
        program("python3").arguments(&["-m", "venv"]).argument(&environment).step("virtual environment")?;
    }
    program(&python).arguments(&["-m", "pip", "install", "--quiet"]).arguments(packages).step("other tools")?;
    Ok(python)
}

/// Puts the text of a file between the marks of a page.
pub(crate) fn write_page(page: &str, summary: &Path) -> Result<(), Failure> {
    let page = root().join(page);
    let text = fs::read_to_string(&page).map_err(|source| Failure::io(&page, source))?;
    let table = fs::read_to_string(summary).map_err(|source| Failure::io(summary, source))?;
    let missing = || Failure::io(&page, std::io::Error::other("the marks of the table are not there"));
    let (before, rest) = text.split_once(MARKS[0]).ok_or_else(missing)?;
    let (_, after) = rest.split_once(MARKS[1]).ok_or_else(missing)?;
    let text = format!("{before}{}{table}{}{after}", MARKS[0], MARKS[1]);
    fs::write(&page, text).map_err(|source| Failure::io(&page, source))
}
