//! The live section of the report: the experiment in the page is that of the study.

use std::path::Path;

use luenberger_live::{Experiment, GainVerdict, Sliders, verify};
use luenberger_study::{RunOptions, Study, run};

/// The experiment in the page of a template, and the report.
fn page(template: &str, test: &str) -> (Option<Experiment>, luenberger_study::Results) {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("live").join(test).join(template);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("templates").join(format!("{template}.toml"));
    let study = Study::from_path(&file).unwrap_or_else(|error| panic!("{error}"));
    let results = run(&study, &RunOptions { output: Some(folder.clone()), ..RunOptions::default() }).unwrap();
    let html = std::fs::read_to_string(folder.join("report.html")).unwrap();
    let data = html.split_once("id=\"live-data\">").and_then(|(_, rest)| rest.split_once("</script>"));
    let experiment = data.map(|(data, _)| {
        let mut data: serde_json::Value = serde_json::from_str(data).unwrap();
        serde_json::from_value(data["experiment"].take()).unwrap()
    });
    (experiment, results)
}

/// Linear, cubic, sampled, nonlinear and Kalman observers: the neutral positions give the scores and verdicts of the
/// study.
#[test]
fn neutral_sliders_give_the_scores_of_the_study() {
    for template in ["double-integrator", "chaotic"] {
        let (experiment, results) = page(template, "neutral");
        let experiment = experiment.unwrap();
        let outcome = luenberger_live::run(&experiment, &Sliders::NEUTRAL);
        let verdicts = verify(&experiment, &Sliders::NEUTRAL);
        let rows = &results.simulation.as_ref().unwrap().rows;
        assert_eq!(outcome.runs.len(), rows.len(), "{template}");
        for ((run, verdict), row) in outcome.runs.iter().zip(verdicts).zip(rows) {
            assert_eq!(run.name, row.observer);
            let scores = run.scores.unwrap_or_else(|| panic!("{template}: {:?}", run.failure));
            let found = row.merits.as_ref().unwrap().norm.as_ref();
            if let Some(norm) = found {
                assert_eq!((scores.rms, scores.peak, scores.settled), (norm.rms, norm.peak, norm.settling_last));
            }
            let design = results.observers.iter().find(|observer| observer.name == run.name).unwrap();
            let said = design.design.as_ref().unwrap().verdict == "proved";
            assert_eq!(matches!(verdict, Some(GainVerdict::Proved(_))), said, "{template}: {}", run.name);
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

/// A study with feedback, or on a log, has no live section.
#[test]
fn what_the_page_cannot_run_is_left_out() {
    assert!(page("mimo", "without").0.is_none());
    assert!(page("measured-log", "without").0.is_none());
}
