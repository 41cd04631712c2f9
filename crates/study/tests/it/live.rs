//! The live section of the report: the experiment in the page is that of the study.

use std::path::{Path, PathBuf};

use luenberger_live::{Experiment, GainVerdict, Sliders, verify};
use luenberger_study::{Format, Results, RunOptions, Study, run};

/// An empty folder.
fn scratch(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("live").join(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

/// The experiment in the page of a template, and the report.
fn page(template: &str, test: &str) -> (Option<Experiment>, Results) {
    let folder = scratch(&format!("{test}-{template}"));
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("templates").join(format!("{template}.toml"));
    let study = Study::from_path(&file).unwrap_or_else(|error| panic!("{error}"));
    let (experiment, results, _) = page_of(&study, &folder);
    (experiment, results)
}

/// The experiment in the page of a study, the results, and the page.
fn page_of(study: &Study, folder: &Path) -> (Option<Experiment>, Results, String) {
    let results = run(study, &RunOptions { output: Some(folder.join("out")), ..RunOptions::default() }).unwrap();
    let html = std::fs::read_to_string(folder.join("out/report.html")).unwrap();
    let data = html.split_once("id=\"live-data\">").and_then(|(_, rest)| rest.split_once("</script>"));
    let experiment = data.map(|(data, _)| {
        let mut data: serde_json::Value = serde_json::from_str(data).unwrap();
        serde_json::from_value(data["experiment"].take()).unwrap()
    });
    (experiment, results, html)
}

/// The page has the scores of the study, of every observer.
fn same_scores(name: &str, experiment: &Experiment, results: &Results) {
    let outcome = luenberger_live::run(experiment, &Sliders::NEUTRAL);
    let rows = &results.simulation.as_ref().unwrap().rows;
    assert_eq!(outcome.runs.len(), rows.len(), "{name}");
    for (run, row) in outcome.runs.iter().zip(rows) {
        assert_eq!(run.name, row.observer);
        let scores = run.scores.unwrap_or_else(|| panic!("{name}: {:?}", run.failure));
        if let Some(norm) = &row.merits.as_ref().unwrap().norm {
            assert_eq!((scores.rms, scores.peak, scores.settled), (norm.rms, norm.peak, norm.settling_last), "{name}");
        }
    }
}

/// Linear, cubic, sampled, nonlinear and Kalman observers: the neutral positions give the scores and verdicts of the
/// study.
#[test]
fn neutral_sliders_give_the_scores_of_the_study() {
    for template in ["double-integrator", "chaotic"] {
        let (experiment, results) = page(template, "neutral");
        let experiment = experiment.unwrap();
        same_scores(template, &experiment, &results);
        let verdicts = verify(&experiment, &Sliders::NEUTRAL);
        for (observer, verdict) in experiment.observers.iter().zip(verdicts) {
            let design = results.observers.iter().find(|of| of.name == observer.name).unwrap();
            let said = design.design.as_ref().unwrap().verdict == "proved";
            assert_eq!(matches!(verdict, Some(GainVerdict::Proved(_))), said, "{template}: {}", observer.name);
        }
    }
}

/// Gains that the certificate's P does not serve are not certified, and the scores become worse.
#[test]
fn a_gain_that_is_too_small_is_not_certified() {
    let (experiment, _) = page("double-integrator", "weak");
    let experiment = experiment.unwrap();
    let weak = Sliders { gain: 0.0, cubic: 0.0, ..Sliders::NEUTRAL };
    let linear = &verify(&experiment, &weak)[0];
    assert!(matches!(linear, Some(GainVerdict::Open(_))), "{linear:?}");
    let rms = |sliders: &Sliders| luenberger_live::run(&experiment, sliders).runs[0].scores.unwrap().rms;
    assert!(rms(&weak) > 3.0 * rms(&Sliders::NEUTRAL));
    // Another period: the sampled observer's certificate is for its own.
    let slow = Sliders { period: 2.0, ..Sliders::NEUTRAL };
    let sampled = verify(&experiment, &slow).pop().unwrap();
    assert!(matches!(&sampled, Some(GainVerdict::Open(why)) if why.contains("sampling period")), "{sampled:?}");
}

/// A carriage with two sensors at instants of their own, and a place for its input.
const CARRIAGE: &str = r#"
[plant]
a = [[0, 1], [0, -0.5]]
b = [[0], [1]]
c = [[1, 0], [0, 1]]
inputs = ["force"]
[input]
INPUT
[simulation]
x0 = [1, 0]
duration = 4
samples = 81
scale = [1, 1]
[[simulation.sensor]]
output = "y1"
period = 0.2
amplitude = 0.05
seed = 4
[[simulation.sensor]]
output = "y2"
period = 0.3
offset = 0.1
[[observer]]
name = "filter"
kind = "extended-kalman"
w = 0.01
v = 0.01
period = 0.1
[[observer]]
name = "fixed"
kind = "luenberger"
poles = [-2, -3]
"#;

/// Feedback from the estimate of one observer, inputs from a table, and sensors of their own periods are in the page.
#[test]
fn feedback_tables_and_sensors_give_the_scores_of_the_study() {
    let (experiment, results) = page("mimo", "feedback");
    same_scores("mimo", &experiment.unwrap(), &results);
    let folder = scratch("inputs");
    std::fs::write(folder.join("force.csv"), "t,force\n0,1\n0.55,-1\n1.25,0.5\n4,0\n").unwrap();
    for input in [
        "table = \"force.csv\"",
        "table = \"force.csv\"\ninterpolation = \"linear\"",
        "expressions = [\"sin(t)\"]\nfeedback = { k = [[2, 1]], observer = \"fixed\" }",
    ] {
        let text = CARRIAGE.replace("INPUT", input);
        let study = Study::from_text("study.toml", &text, Format::Toml, &folder).unwrap_or_else(|e| panic!("{e}"));
        let (experiment, results, _) = page_of(&study, &scratch("inputs-out"));
        let experiment = experiment.unwrap_or_else(|| panic!("{input}"));
        same_scores(input, &experiment, &results);
        // The noise of a sensor has a slider.
        let quiet = luenberger_live::run(&experiment, &Sliders { noise: 0.0, ..Sliders::NEUTRAL });
        assert_ne!(quiet, luenberger_live::run(&experiment, &Sliders::NEUTRAL), "{input}");
    }
}

/// What the page cannot run has a sentence in its place; a study on a log has no such section.
#[test]
fn what_the_page_cannot_run_is_said() {
    assert!(page("measured-log", "without").0.is_none());
    for (input, more, why) in [
        ("expressions = [\"0\"]", "[truth]\ninput_delay = 0.1\n", "its plant is simulated with disturbances"),
        ("law = [\"-x1\"]", "", "its input is a law with the true state"),
    ] {
        let text = CARRIAGE.replace("INPUT", input) + more;
        let study = Study::from_text("study.toml", &text, Format::Toml, ".".as_ref()).unwrap_or_else(|e| panic!("{e}"));
        let (experiment, _, html) = page_of(&study, &scratch("refused"));
        assert!(experiment.is_none() && html.contains(why) && !html.contains("live-module"), "{why}");
    }
}
