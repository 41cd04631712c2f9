//! The mutants that cargo-mutants finds.

use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

use crate::Failure;

/// A mutant as cargo-mutants lists it.
#[derive(Clone, Debug)]
pub(crate) struct Mutant {
    /// File, line, column, what is replaced and in which function.
    pub(crate) name: String,
    pub(crate) package: String,
    /// Relative to the workspace.
    pub(crate) file: PathBuf,
    /// Lines and columns from 1 on, columns in characters.
    pub(crate) start: (usize, usize),
    pub(crate) end: (usize, usize),
    pub(crate) replacement: String,
    pub(crate) genre: Genre,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Genre {
    /// The body of a function becomes a value.
    Value,
    /// An operator becomes another one, or is deleted.
    Operator,
    Arm,
    Guard,
    /// A field is left to the base of its structure.
    Field,
}

/// Lists the mutants of the workspace in `tree`.
pub(crate) fn list(tree: &Path, config: &Path) -> Result<Vec<Mutant>, Failure> {
    let mut command = Command::new("cargo");
    command.args(["mutants", "--list", "--json", "--workspace", "--colors", "never", "--config"]).arg(config);
    let output = command.current_dir(tree).output().map_err(|error| Failure(format!("cargo mutants: {error}")))?;
    if !output.status.success() {
        return Err(Failure(format!("cargo mutants: {}", String::from_utf8_lossy(&output.stderr))));
    }
    parse(&String::from_utf8_lossy(&output.stdout))
}

/// Reads the list of cargo-mutants.
pub(crate) fn parse(json: &str) -> Result<Vec<Mutant>, Failure> {
    let value: Value = serde_json::from_str(json).map_err(|error| Failure(format!("list of mutants: {error}")))?;
    let rows = value.as_array().ok_or_else(|| Failure("the list of mutants is not an array".to_owned()))?;
    rows.iter().map(|row| mutant(row).ok_or_else(|| Failure(format!("not a known mutant: {row}")))).collect()
}

fn mutant(row: &Value) -> Option<Mutant> {
    let text = |key: &str| row[key].as_str().map(str::to_owned);
    let place = |key: &str| {
        let number = |part: &str| row["span"][key][part].as_u64().and_then(|number| usize::try_from(number).ok());
        Some((number("line")?, number("column")?))
    };
    let genre = match row["genre"].as_str()? {
        "FnValue" => Genre::Value,
        "BinaryOperator" | "UnaryOperator" => Genre::Operator,
        "MatchArm" => Genre::Arm,
        "MatchArmGuard" => Genre::Guard,
        "StructField" => Genre::Field,
        _ => return None,
    };
    Some(Mutant {
        name: text("name")?,
        package: text("package")?,
        file: text("file")?.into(),
        start: place("start")?,
        end: place("end")?,
        replacement: text("replacement")?,
        genre,
    })
}
