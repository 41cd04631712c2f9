//! Golden vectors for fmpy: a table, and a script that simulates the FMU and compares every bit.

use std::fmt::Write;

use crate::error::ExportError;
use crate::golden::steps;
use crate::{Export, File};

pub(super) fn files(export: &Export, period: f64) -> Result<Vec<File>, ExportError> {
    let name = &export.identifier;
    let file = |name: String, text| File { name, text };
    Ok(vec![file(format!("{name}_golden.csv"), table(export)?), file(format!("test_{name}.py"), script(name, period))])
}

/// A row for each step: what goes in at its beginning and the estimate at its end. Decimals are read back to the same
/// bits.
fn table(export: &Export) -> Result<String, ExportError> {
    let names = &export.names;
    let columns = |prefix: &str, names: &[String]| names.iter().map(|name| format!("{prefix}.{name}")).collect();
    let fed = export.feedback.is_some();
    let mut header: Vec<String> = columns(if fed { "r" } else { "u" }, &names.inputs);
    header.extend::<Vec<String>>(columns("y", &names.outputs));
    header.extend::<Vec<String>>(columns("xhat", &names.states));
    let quoted = |text: &String| format!("\"{}\"", text.replace('"', "\"\""));
    let mut text = header.iter().map(quoted).collect::<Vec<_>>().join(",") + "\n";
    for step in steps(export, export.test_steps)? {
        let row: Vec<String> =
            [&step.u, &step.y, &step.estimate].into_iter().flatten().map(|x| format!("{x:?}")).collect();
        _ = writeln!(text, "{}", row.join(","));
    }
    Ok(text)
}

fn script(name: &str, period: f64) -> String {
    format!(
        "\"\"\"Simulates {name}.fmu with fmpy and compares each estimate with that of the design, bit by bit.

    python3 -m pip install fmpy
    python3 test_{name}.py
\"\"\"

import csv
import pathlib
import sys

import fmpy.validation
import numpy

PERIOD = {period:?}

folder = pathlib.Path(__file__).resolve().parent
fmu = str(folder / \"{name}.fmu\")
with open(folder / \"{name}_golden.csv\", newline=\"\", encoding=\"utf-8\") as file:
    names, *rows = csv.reader(file)
golden = numpy.array(rows, dtype=float)
inputs = [k for k, name in enumerate(names) if not name.startswith(\"xhat.\")]
outputs = [k for k, name in enumerate(names) if name.startswith(\"xhat.\")]

signals = numpy.zeros(len(golden), dtype=[(\"time\", float)] + [(names[k], float) for k in inputs])
signals[\"time\"] = [k * PERIOD for k in range(len(golden))]
for k in inputs:
    signals[names[k]] = golden[:, k]

problems = fmpy.validation.validate_fmu(fmu)
result = fmpy.simulate_fmu(
    fmu,
    start_time=0.0,
    stop_time=len(golden) * PERIOD,
    output_interval=PERIOD,
    input=signals,
    output=[names[k] for k in outputs],
    fmi_type=\"CoSimulation\",
)
found = numpy.array([result[names[k]][1:] for k in outputs]).T
same = [row.tobytes() == expected.tobytes() for row, expected in zip(found, golden[:, outputs])]
for problem in problems:
    print(problem)
print(f\"{name}: {{sum(same)}} of {{len(golden)}} steps agree to the last bit\")
sys.exit(0 if sum(same) == len(golden) == len(found) and not problems else 1)
"
    )
}
