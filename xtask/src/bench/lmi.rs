//! Benchmark of the built-in solver against others on the same problems.
//!
//! The other tools are installed, at the versions below, into a virtual environment under `target`, so that the user's
//! environment is unchanged.

use crate::step::{Failure, cargo, program, root};
use serde_json::Value;
use std::fmt::Write as _;
use std::fs;

/// Versions are pinned, because a comparison with whatever is newest cannot be repeated.
const PACKAGES: [&str; 4] = ["cvxpy==1.9.3", "clarabel==0.11.1", "scs==3.3.1", "numpy==2.4.6"];

/// The joint design on plants of 3 to 60 states. Writes `target/bench/lmi.json` and `lmi.md`, and puts the latter into
/// its page in `docs` if that is asked for.
pub(crate) fn run(largest: Option<usize>, document: bool) -> Result<(), Failure> {
    let folder = root().join("target/bench");
    let plants = folder.join("plants");
    let limit = largest.map(|n| ["--largest".to_owned(), n.to_string()]);
    let limit: Vec<&str> = limit.iter().flatten().map(String::as_str).collect();
    fs::create_dir_all(&plants).map_err(|source| Failure::io(&plants, source))?;

    let ours = |name: &str| {
        cargo(&["run", "--release", "--package", "luenberger-lmi", "--features", "clarabel"])
            .arguments(&["--example", "bench_joint", "--", "--write"])
            .argument(&plants)
            .arguments(&limit)
            .output(name)
    };
    let python = super::python("bench-venv", &PACKAGES)?;
    // Before and after theirs: the machine may be busier at one time than at another.
    let before = ours("ours")?;
    let theirs = program(&python)
        .argument(root().join("xtask/bench/lmi.py"))
        .argument(&plants)
        .arguments(&limit)
        // One thread for each program.
        .variable("OPENBLAS_NUM_THREADS", "1")
        .variable("OMP_NUM_THREADS", "1")
        .output("theirs")?;
    let after = ours("ours again")?;

    let parsed = |text: &str| text.lines().filter_map(|line| serde_json::from_str(line).ok()).collect::<Vec<Value>>();
    let mut lines = parsed(&before);
    for (line, again) in lines.iter_mut().zip(parsed(&after)) {
        if again["ms"].as_f64() < line["ms"].as_f64() {
            *line = again;
        }
    }
    lines.extend(parsed(&theirs));
    let table = table(&lines);
    let json = folder.join("lmi.json");
    fs::write(&json, format!("{:#}\n", Value::from(lines))).map_err(|source| Failure::io(&json, source))?;
    let markdown = folder.join("lmi.md");
    fs::write(&markdown, &table).map_err(|source| Failure::io(&markdown, source))?;
    println!("\n{table}\n{}", markdown.display());
    if document { super::write_page("docs/bench-lmi.md", &markdown) } else { Ok(()) }
}

/// One row for each tool and plant, the ratio being that to the time of ours.
fn table(lines: &[Value]) -> String {
    let mut text =
        "| tool | posed | n | p | ms | ratio | outcome | margin |\n|---|---|---:|---:|---:|---:|---|---:|\n".to_owned();
    for line in lines {
        let word = |key: &str| match &line[key] {
            Value::String(word) => word.lines().next().unwrap_or_default().replace('|', "/"),
            Value::Null => "–".to_owned(),
            Value::Number(x) if key == "margin" => x.as_f64().map_or_else(|| x.to_string(), |x| format!("{x:.2e}")),
            other => other.to_string(),
        };
        let ours = lines.iter().find(|other| other["tool"] == "luenberger" && other["n"] == line["n"]);
        let ratio = ours.and_then(|ours| Some(line["ms"].as_f64()? / ours["ms"].as_f64()?));
        let ratio = ratio.map_or_else(|| "–".to_owned(), |ratio| format!("{ratio:.1}"));
        // Ours says what is proved, theirs what the solver believes.
        let outcome = if line["verdict"].is_null() { word("status") } else { word("verdict") };
        // Writing into a String cannot fail.
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} | {} | {ratio} | {outcome} | {} |",
            word("tool"),
            word("posed"),
            word("n"),
            word("p"),
            word("ms"),
            word("margin")
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn a_row_shows_a_proof_or_an_unproved_bound() {
        let table = table(&[
            json!({"tool": "luenberger", "n": 3, "p": 1, "ms": 1.5, "verdict": "Proved", "margin": 0.25}),
            json!({"tool": "cvxpy+SCS", "posed": "margin", "n": 50, "p": 3, "ms": 264.0, "status": "error: a | b\nmore", "margin": null}),
        ]);
        let rows: Vec<&str> = table.lines().skip(2).collect();
        assert_eq!(rows[0], "| luenberger | – | 3 | 1 | 1.5 | 1.0 | Proved | 2.50e-1 |");
        assert_eq!(rows[1], "| cvxpy+SCS | margin | 50 | 3 | 264.0 | – | error: a / b | – |");
    }
}
