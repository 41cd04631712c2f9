//! What the steps of a command took: printed at its end, kept in `target/times`, and written into docs/build.md by
//! `cargo xtask times --document`.

use crate::bench::write_page;
use crate::step::{self, Failure, program, target};
use serde_json::{Value, json};
use std::fmt::Write;
use std::fs;
use std::path::PathBuf;
use std::time::Instant;

/// The commands of the table, in the order in which they are run after a fresh clone.
const COMMANDS: [&str; 11] =
    ["reproduce", "test", "lint", "test --all", "firmware", "deploy", "cluster", "kernel", "live", "studio", "python"];

/// Steps below this many seconds share a row.
const SHORT: f64 = 5.0;

/// Prints the steps of a command that has ended, and keeps them. Steps that run at the same time overlap: their sum is
/// not the time of the command.
pub(crate) fn keep(command: &str, began: Instant) -> Result<(), Failure> {
    let steps = step::ended();
    let wall = began.elapsed().as_secs_f64();
    if steps.len() < 2 {
        return Ok(());
    }
    for (name, seconds) in steps.iter().filter(|(_, seconds)| *seconds >= 1.0) {
        eprintln!("── {seconds:>7.1} s  {name}");
    }
    eprintln!("── {wall:>7.1} s  cargo xtask {command}");
    let folder = folder();
    fs::create_dir_all(&folder).map_err(|source| Failure::io(&folder, source))?;
    let file = file(command);
    let kept = json!({
        "wall": wall, "cpu": processor_time(), "date": date(), "machine": machine(), "steps": steps,
    });
    fs::write(&file, format!("{kept}\n")).map_err(|source| Failure::io(&file, source))
}

/// Prints the table of what was kept; with `document` it goes into docs/build.md as well.
pub(crate) fn run(document: bool) -> Result<(), Failure> {
    let mut kept = Vec::new();
    for command in COMMANDS {
        let file = file(command);
        if let Ok(text) = fs::read_to_string(&file) {
            let value = serde_json::from_str(&text).map_err(|source| Failure::io(&file, source.into()))?;
            kept.push((command, value));
        }
    }
    let table = table(&kept);
    println!("{table}");
    let path = folder().join("times.md");
    fs::create_dir_all(folder()).map_err(|source| Failure::io(folder(), source))?;
    fs::write(&path, table).map_err(|source| Failure::io(&path, source))?;
    if document { write_page("docs/build.md", &path) } else { Ok(()) }
}

/// Commands, and below each its steps.
fn table(kept: &[(&str, Value)]) -> String {
    let mut text =
        String::from("\n| command, and its steps | wall clock, s | CPU time, s | measured |\n|---|---:|---:|---|\n");
    for (command, value) in kept {
        let seconds = |key: &str| value[key].as_f64().map_or_else(String::new, |seconds| format!("{seconds:.0}"));
        let word = |key: &str| value[key].as_str().unwrap_or_default();
        let measured = format!("{}, {}", word("date"), word("machine"));
        _ = writeln!(text, "| `cargo xtask {command}` | {} | {} | {measured} |", seconds("wall"), seconds("cpu"));
        let steps = value["steps"].as_array().into_iter().flatten();
        let steps = steps.filter_map(|step| Some((step[0].as_str()?, step[1].as_f64()?)));
        let (long, short): (Vec<_>, Vec<_>) = steps.partition(|(_, seconds)| *seconds >= SHORT);
        for (name, seconds) in long {
            _ = writeln!(text, "| – {name} | {seconds:.0} | | |");
        }
        if !short.is_empty() {
            let sum: f64 = short.iter().map(|(_, seconds)| seconds).sum();
            _ = writeln!(text, "| – {} shorter ones | {sum:.0} | | |", short.len());
        }
    }
    text.push('\n');
    text
}

fn folder() -> PathBuf {
    target().join("times")
}

fn file(command: &str) -> PathBuf {
    folder().join(format!("{}.json", command.replace(' ', "")))
}

/// CPU time of all that this program has run, user and system, where the system says so (Linux).
fn processor_time() -> Option<f64> {
    let stat = fs::read_to_string("/proc/self/stat").ok()?;
    // The name in parentheses may have spaces. Times are in hundredths of a second.
    let fields: Vec<&str> = stat.rsplit_once(')')?.1.split_whitespace().collect();
    let ticks = |k: usize| fields.get(k).and_then(|field| field.parse::<f64>().ok());
    Some((ticks(13)? + ticks(14)?) / 100.0)
}

fn date() -> String {
    let said = program("date").argument("+%Y-%m-%d").quiet_output("date").unwrap_or_default();
    said.trim().to_owned()
}

/// The number of cores and, where the system says so (Linux), the processor.
fn machine() -> String {
    let cores = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    let info = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = info.lines().find_map(|line| line.strip_prefix("model name")).and_then(|rest| rest.split_once(": "));
    let cores = if cores == 1 { "1 core".to_owned() } else { format!("{cores} cores") };
    model.map_or_else(|| cores.clone(), |(_, model)| format!("{cores} of {model}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The steps of a run by hand: two long ones, and two of 1.5 s and 2 s that share a row.
    #[test]
    fn short_steps_share_a_row() {
        let value = json!({
            "wall": 99.6, "cpu": 180.2, "date": "2026-11-27", "machine": "2 cores",
            "steps": [["compiling the tests", 60.4], ["format", 1.5], ["study", 35.0], ["random", 2.0]],
        });
        let table = table(&[("test", value)]);
        let rows: Vec<&str> = table.lines().skip(3).take_while(|line| !line.is_empty()).collect();
        assert_eq!(
            rows,
            [
                "| `cargo xtask test` | 100 | 180 | 2026-11-27, 2 cores |",
                "| – compiling the tests | 60 | | |",
                "| – study | 35 | | |",
                "| – 2 shorter ones | 4 | | |",
            ]
        );
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn time_of_programs_is_counted() {
        let before = processor_time().unwrap();
        let arguments = ["-c", "i=0; while [ $i -lt 200000 ]; do i=$((i+1)); done"];
        program("sh").arguments(&arguments).quiet_output("a loop").unwrap();
        let took = processor_time().unwrap() - before;
        assert!(took > 0.0 && took < 60.0, "{took}");
    }
}
