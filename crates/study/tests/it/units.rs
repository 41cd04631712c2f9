//! Units of states, inputs, outputs and parameters: where a study gives them, and where they are shown.

use luenberger_study::{RunOptions, Step, Study, execute, run};

use crate::page;
use crate::studies::{self, scratch};

const TANK: &str = r#"
[plant]
states = ["level"]
inputs = ["pump"]
outputs = ["gauge"]
f = ["(pump - k*level)/A"]
h = ["c*level"]
parameters = { A = 0.5, k = 0.1, c = 2 }
UNITS
time_unit = "s"
[input]
expressions = ["0.05"]
[simulation]
x0 = [1]
duration = 2
samples = 21
scale = [1]
noise = { amplitude = [0.01], period = 0.1 }
[[observer]]
name = "filter"
kind = "extended-kalman"
w = 0.01
v = 0.01
period = 0.1
[plot]
show = ["states", "errors", "inputs", "outputs", "innovations"]
"#;

const TABLE: &str = r#"units = { level = "m", pump = "m3/s", gauge = "V", A = "m2", c = "V/m" }"#;

fn study(units: &str) -> Study {
    let text = TANK.replace("UNITS", units);
    studies::study(&text)
}

#[test]
fn units_are_in_the_report_and_in_the_results() {
    let folder = scratch("units");
    let options = RunOptions { output: Some(folder.clone().into()), ..RunOptions::default() };
    let results = run(&study(TABLE), &options).unwrap();
    let plant = serde_json::to_value(&results.plant).unwrap();
    assert_eq!(plant["units"], serde_json::json!(["m"]));
    assert_eq!(plant["input_units"], serde_json::json!(["m3/s"]));
    assert_eq!(plant["output_units"], serde_json::json!(["V"]));
    let parameters =
        [("A", 0.5, Some("m2")), ("c", 2.0, Some("V/m")), ("k", 0.1, None)].map(|(name, value, unit)| match unit {
            Some(unit) => serde_json::json!({ "name": name, "value": value, "unit": unit }),
            None => serde_json::json!({ "name": name, "value": value }),
        });
    assert_eq!(plant["parameters"], serde_json::json!(parameters));
    let html = page::read(&folder.join("report.html"));
    for part in [
        "<td>A</td><td class=\"number\">0.5</td><td>m2</td>",
        "gauge: Gaussian, standard deviation 0.01 V, a new value every 0.1 s",
        "pump (m3/s)",
        "gauge (V)",
        "error of level (m)",
        "innovation of gauge (V)",
    ] {
        assert!(html.contains(part), "{part}");
    }
    // The columns of files are names alone.
    let csv = std::fs::read_to_string(folder.join("trajectories/filter.csv")).unwrap();
    assert!(csv.starts_with("t,level,pump,gauge,level_hat"), "{}", csv.lines().next().unwrap_or_default());
}

/// The list form gives the units of the states; a study without units has none.
#[test]
fn a_list_is_of_the_states() {
    let plant = |units: &str| {
        let results = execute(&study(units), Step::Observe, &RunOptions::default()).unwrap();
        serde_json::to_value(&results.plant).unwrap()
    };
    let listed = plant("units = [\"m\"]");
    assert_eq!(listed["units"], serde_json::json!(["m"]));
    assert!(listed.get("input_units").is_none() && listed.get("output_units").is_none());
    assert_eq!(plant("")["units"], serde_json::json!([]));
    assert_eq!(plant("units = {}")["units"], serde_json::json!([]));
    // Of the inputs only: the states have none.
    let table = plant("units = { pump = \"m3/s\" }");
    assert_eq!((&table["units"], &table["input_units"]), (&serde_json::json!([]), &serde_json::json!(["m3/s"])));
}

/// A measured output with the name of the state that it measures has its unit.
#[test]
fn a_name_has_one_unit() {
    let text = TANK.replace("UNITS", "units = [\"m\"]").replace("\"gauge\"", "\"level\"");
    let study = studies::study(&text);
    assert_eq!(study.plant.units_of(&study.plant.outputs), ["m"]);
}
