//! Rigorous bounds of semidefinite programs: every `.dat-s` file of a folder, compared with the published optimum if
//! known.

use crate::step::{Failure, cargo, root};
use serde_json::{Value, json};
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

/// Default folder of SDPLIB.
pub(crate) const INSTANCES: &str = "../shared/data/sdplib";

/// Optima as SDPLIB prints them (B. Borchers, SDPLIB 1.2, Optimization Methods and Software 11, 1999); those of hinf
/// are known to few digits.
const PUBLISHED: [(&str, &str); 10] = [
    ("control1", "17.78463"),
    ("control2", "8.300000"),
    ("control3", "13.63327"),
    ("control4", "19.79423"),
    ("hinf1", "2.0326"),
    ("hinf2", "10.967"),
    ("hinf5", "363"),
    ("hinf7", "391"),
    ("theta1", "23.00000"),
    ("truss1", "-8.999996"),
];

/// Bounds all instances of a folder, which is taken from the root of the workspace. Writes `target/bench/proof.json`
/// and `proof.md`.
pub(crate) fn run(instances: &Path) -> Result<(), Failure> {
    let folder = root().join("target/bench");
    fs::create_dir_all(&folder).map_err(|source| Failure::io(&folder, source))?;
    let instances = root().join(instances);
    let listed = fs::read_dir(&instances).map_err(|source| Failure::io(&instances, source))?;
    let mut files: Vec<_> = listed.filter_map(|entry| Some(entry.ok()?.path())).collect();
    files.retain(|file| file.to_string_lossy().ends_with(".dat-s"));
    files.sort();
    let mut rows = Vec::new();
    for file in &files {
        let name = file.file_name().map(|name| name.to_string_lossy().replace(".dat-s", "")).unwrap_or_default();
        let line =
            cargo(&["run", "--release", "--quiet", "--package", "luenberger-lmi", "--example", "sdpa", "--", "--json"])
                .argument(file)
                .output(&name)?;
        let mut row: Value =
            serde_json::from_str(line.trim()).unwrap_or_else(|error| json!({ "error": error.to_string() }));
        let published = PUBLISHED.iter().find(|(known, _)| *known == name).map(|(_, optimum)| *optimum);
        row["name"] = json!(name);
        row["published"] = json!(published);
        row["encloses"] = json!(published.and_then(|optimum| encloses(optimum, &row["lower"], &row["upper"])));
        rows.push(row);
    }
    let table = table(&rows);
    let json = folder.join("proof.json");
    fs::write(&json, format!("{:#}\n", Value::from(rows))).map_err(|source| Failure::io(&json, source))?;
    let markdown = folder.join("proof.md");
    fs::write(&markdown, &table).map_err(|source| Failure::io(&markdown, source))?;
    println!("\n{table}\n{}", markdown.display());
    Ok(())
}

/// Whether the finite bounds agree with an optimum known to half a unit of its last digit; nothing is said of bounds
/// that are both infinite.
fn encloses(optimum: &str, lower: &Value, upper: &Value) -> Option<bool> {
    let value: f64 = optimum.parse().ok()?;
    let digits = optimum.split_once('.').map_or(0, |(_, fraction)| fraction.len());
    // SDPLIB prints some optima with the last digit cut off instead of rounded.
    let unit = 10f64.powi(-i32::try_from(digits).ok()?);
    let (lower, upper) = (lower.as_f64(), upper.as_f64());
    if lower.is_none() && upper.is_none() {
        return None;
    }
    Some(lower.is_none_or(|lower| lower <= value + unit) && upper.is_none_or(|upper| value - unit <= upper))
}

fn table(rows: &[Value]) -> String {
    let mut text = "| instance | status | lower | upper | width | published | agrees | solve ms | verify ms |\n|---|---|---:|---:|---:|---:|---|---:|---:|\n".to_owned();
    for row in rows {
        let word = |key: &str| row[key].as_str().unwrap_or("–").to_owned();
        let number = |key: &str| row[key].as_f64().map_or_else(|| "–".to_owned(), |x| format!("{x:.9}"));
        let milliseconds = |key: &str| row[key].as_f64().map_or_else(|| "–".to_owned(), |x| format!("{:.1}", 1e3 * x));
        let width = match (row["lower"].as_f64(), row["upper"].as_f64()) {
            (Some(lower), Some(upper)) => format!("{:.1e}", upper - lower),
            _ => "–".to_owned(),
        };
        let agrees = row["encloses"].as_bool().map_or("–", |agrees| if agrees { "yes" } else { "NO" });
        // Writing into a String cannot fail.
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} | {width} | {} | {agrees} | {} | {} |",
            word("name"),
            word("status"),
            number("lower"),
            number("upper"),
            word("published"),
            milliseconds("solve_seconds"),
            milliseconds("verify_seconds"),
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bound_on_the_wrong_side_is_seen() {
        assert_eq!(encloses("17.78463", &json!(17.784626), &json!(17.784627)), Some(true));
        assert_eq!(encloses("17.78463", &json!(17.7848), &json!(17.7849)), Some(false));
        assert_eq!(encloses("363", &json!(null), &json!(362.3)), Some(true));
        assert_eq!(encloses("363", &json!(null), &json!(361.9)), Some(false));
        assert_eq!(encloses("363", &json!(null), &json!(null)), None);
    }

    #[test]
    fn a_row_shows_what_is_known() {
        let table = table(&[
            json!({"name": "a", "status": "undecided", "lower": null, "upper": 2.0, "encloses": true, "published": "2"}),
        ]);
        assert_eq!(table.lines().last(), Some("| a | undecided | – | 2.000000000 | – | 2 | yes | – | – |"));
    }
}
