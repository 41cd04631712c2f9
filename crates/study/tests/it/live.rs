//! The live section of the report: the experiment in the page is that of the study.

use std::path::{Path, PathBuf};

use luenberger_live::{Experiment, GainVerdict, Sliders, verify};
use luenberger_study::{Results, RunOptions, Study, run};

use crate::studies::{self, study, study_in};

/// An empty folder.
fn scratch(name: &str) -> PathBuf {
    studies::scratch(&format!("live/{name}"))
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
    let results = run(study, &RunOptions { output: Some(folder.join("out").into()), ..RunOptions::default() }).unwrap();
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
        assert!(run.failure.is_none(), "{name}: {:?}", run.failure);
        let merits = row.merits.as_ref().unwrap();
        assert_eq!(run.states.len(), merits.states.len(), "{name}");
        for (of, state) in run.states.iter().zip(&merits.states) {
            assert_eq!((of.rms, of.peak, of.settled), (state.rmse, state.peak, state.settling_5), "{name}");
        }
        let norm = merits.norm.as_ref().map(|norm| (norm.rms, norm.peak, norm.settling_last));
        assert_eq!(run.scores.map(|of| (of.rms, of.peak, of.settled)), norm, "{name}");
        assert_eq!(run.norm.is_empty(), norm.is_none(), "{name}");
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
            let said = design.design.as_ref().unwrap().verdict.word() == "proved";
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

/// The servo's `A - g L C` has the polynomial `s^2 + (2 + g l1) s + g (l2 + 2 l1)` with l1, l2 > 0, which is Hurwitz
/// for every factor g > 0 by Routh, and not for g = 0: where the P of the design does not prove it, another one does.
#[test]
fn a_gain_that_the_p_of_the_design_does_not_serve_gets_another_p() {
    let (experiment, _) = page("servo", "another-p");
    let experiment = experiment.unwrap();
    let place = experiment.observers.iter().position(|observer| observer.name == "Luenberger").unwrap();
    let verdict = |gain: f64| verify(&experiment, &Sliders { gain, ..Sliders::NEUTRAL })[place].clone();
    assert!(matches!(verdict(1.0), Some(GainVerdict::Proved(_))), "{:?}", verdict(1.0));
    for gain in [0.01, 0.3, 0.8, 1.2, 2.0, 10.0] {
        let found = verdict(gain);
        assert!(matches!(found, Some(GainVerdict::ProvedAnew(Some(margin))) if margin > 0.0), "{gain}: {found:?}");
    }
    assert!(matches!(verdict(0.0), Some(GainVerdict::Open(_))), "{:?}", verdict(0.0));
    let json = serde_json::to_string(&verdict(2.0)).unwrap();
    assert!(json.starts_with("{\"proved-anew\":"), "{json}");
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
        let study = study_in(&folder, &text);
        let (experiment, results, _) = page_of(&study, &scratch("inputs-out"));
        let experiment = experiment.unwrap_or_else(|| panic!("{input}"));
        same_scores(input, &experiment, &results);
        // The noise of a sensor has a slider.
        let quiet = luenberger_live::run(&experiment, &Sliders { noise: 0.0, ..Sliders::NEUTRAL });
        assert_ne!(quiet, luenberger_live::run(&experiment, &Sliders::NEUTRAL), "{input}");
    }
}

/// Which estimates are scored is in the page too, and a table that is too large for a page is said to be.
#[test]
fn predicted_estimates_are_scored_and_large_tables_are_refused() {
    let text = CARRIAGE.replace("INPUT", "expressions = [\"sin(t)\"]");
    let predicted = text.replace("[simulation]\n", "[simulation]\nestimates = \"predicted\"\n");
    let of = |text: &str| of_text("predicted", text);
    let ((filtered, ..), (predicted, results, _)) = (of(&text), of(&predicted));
    same_scores("predicted", &predicted, &results);
    assert_ne!(
        luenberger_live::run(&filtered, &Sliders::NEUTRAL).runs[0].scores,
        luenberger_live::run(&predicted, &Sliders::NEUTRAL).runs[0].scores
    );
    let folder = scratch("large-table");
    for (rows, is_there) in [(20_000, true), (20_001, false)] {
        let table: Vec<String> = (0..rows).map(|k| format!("{},1\n", 1e-3 * f64::from(k))).collect();
        std::fs::write(folder.join("force.csv"), format!("t,force\n{}", table.concat())).unwrap();
        let study = study_in(&folder, &CARRIAGE.replace("INPUT", "table = \"force.csv\""));
        let (experiment, _, html) = page_of(&study, &scratch("large-table-out"));
        assert_eq!(experiment.is_some(), is_there);
        assert_eq!(html.contains("the table of its input has more than 20000 numbers"), !is_there);
    }
}

/// Every observer of the page has the scores of the study, also where others of the study are not in the page.
fn scores_of_those_in_the_page(name: &str, experiment: &Experiment, results: &Results) {
    let rows = &results.simulation.as_ref().unwrap().rows;
    let outcome = luenberger_live::run(experiment, &Sliders::NEUTRAL);
    assert!(!outcome.runs.is_empty());
    for run in &outcome.runs {
        let row = rows.iter().find(|row| row.observer == run.name).unwrap();
        let scores = run.scores.unwrap_or_else(|| panic!("{name}, {}: {:?}", run.name, run.failure));
        let norm = row.merits.as_ref().unwrap().norm.as_ref().unwrap();
        let found = (scores.rms, scores.peak, scores.settled);
        assert_eq!(found, (norm.rms, norm.peak, norm.settling_last), "{name}, {}", run.name);
    }
}

fn of_text(name: &str, text: &str) -> (Experiment, Results, String) {
    let study = study(text);
    let (experiment, results, html) = page_of(&study, &scratch(name));
    (experiment.unwrap_or_else(|| panic!("{name}")), results, html)
}

/// Feedback about an operating point is of the deviations: u = u* - K (xhat - x*), with x* = (5.405, 0) and u* = 1.
#[test]
fn feedback_about_an_operating_point_gives_the_scores_of_the_study() {
    let text = "[plant]\nf = [\"x2\", \"9.81 - 2*x1 - x2 + u1\"]\nh = [\"x1\"]\n[operating_point]\nu = [1]\n\
                [input]\nfeedback = { k = [[1, 0.5]], observer = \"o\" }\n\
                [simulation]\nx0 = [5, 1]\nduration = 3\nscale = [1, 1]\n\
                [[observer]]\nname = \"o\"\nkind = \"luenberger\"\npoles = [-4, -5]\n";
    let (experiment, results, _) = of_text("about-a-point", text);
    let shift = &experiment.feedback.as_ref().unwrap().shift;
    assert!(shift.len() == 1 && (shift[0] - (1.0 + 5.405)).abs() < 1e-12, "{shift:?}");
    same_scores("about a point", &experiment, &results);
}

/// The templates whose plant is not the model: observers of disturbances, interval and sliding-mode observers.
#[test]
fn plants_that_are_not_the_model_give_the_scores_of_the_study() {
    for (template, observers) in [("servo", 3), ("two-tanks", 3), ("load-torque", 5)] {
        let (experiment, results) = page(template, "truth");
        let experiment = experiment.unwrap_or_else(|| panic!("{template}"));
        assert!(experiment.truth.is_some());
        assert_eq!(experiment.observers.len(), observers, "{template}");
        scores_of_those_in_the_page(template, &experiment, &results);
    }
}

/// Takes a part of the truth away.
type Without = fn(&mut luenberger_live::Truth);

/// Every disturbance, other parameters, events, a lookup table and a chosen integrator.
#[test]
fn every_disturbance_is_in_the_page() {
    let text = r#"
[plant]
states = ["level"]
inputs = ["pump"]
f = ["pump - k*drain(level)"]
h = ["level"]
parameters = { k = 1.0, unused = 2 }
tables.drain = { x = [0, 1, 4], y = [0, 1, 2], method = "monotone-cubic", extrapolation = "linear" }
[input]
expressions = ["1 + 0.2*sin(t)"]
[simulation]
x0 = [1]
duration = 5
samples = 101
scale = [1]
integrator = "explicit"
noise = { amplitude = [0.01], period = 0.05, seed = 3 }
[truth]
parameters = { k = 1.1 }
input_delay = 0.03
measurement_delay = 0.04
actuator = { gain = [0.9], bias = [0.1], from = 1 }
sensor = { bias = [0.02], from = 2 }
quantisation = [0.005]
dropout = 0.1
outliers = { probability = 0.02, size = [1] }
process_noise = { amplitude = [0.05], period = 0.1, seed = 8 }
[[truth.event]]
at = 2.5
parameters = { k = 0.8 }
[[truth.event]]
at = 4
jump = [0.3]
[[observer]]
name = "filter"
kind = "extended-kalman"
w = 0.01
v = 0.01
period = 0.05
gate = 4
initial = [2]
"#;
    let (experiment, results, html) = of_text("disturbances", text);
    same_scores("disturbances", &experiment, &results);
    assert!(html.contains("The simulated plant is that of <code>[truth]</code>."), "the page says whose plant it is");
    // Each part of it counts: without one the scores are others.
    let with = luenberger_live::run(&experiment, &Sliders::NEUTRAL);
    let parts: [(&str, Without); 9] = [
        ("parameters", |truth| truth.plant = None),
        ("events", |truth| truth.events.clear()),
        ("process noise", |truth| truth.process_noise = None),
        ("input delay", |truth| truth.input_delay = 0.0),
        ("output delay", |truth| truth.output_delay = 0.0),
        ("actuator", |truth| truth.actuator = None),
        ("sensor", |truth| truth.sensor = None),
        ("quantisation", |truth| truth.quantisation.clear()),
        ("channel", |truth| truth.channel = None),
    ];
    for (part, without) in parts {
        let mut other = experiment.clone();
        without(other.truth.as_mut().unwrap());
        assert_ne!(luenberger_live::run(&other, &Sliders::NEUTRAL), with, "{part}");
    }
}

/// A plant in discrete time with every kind of observer that the page has for it.
const DISCRETE: &str = r#"
[plant]
a = [[1, 0.1], [-0.05, 0.95]]
b = [[0], [0.1]]
c = [[1, 0]]
dt = 0.1
[input]
expressions = ["sin(t)"]
[simulation]
x0 = [1, -1]
duration = 6
scale = [1, 1]
noise = { amplitude = [0.02], period = 0.1, seed = 2 }
[[observer]]
name = "Luenberger"
kind = "luenberger"
poles = [0.4, 0.6]
[[observer]]
name = "Kalman"
kind = "kalman"
w = 0.001
v = 0.0004
[[observer]]
name = "filter form"
kind = "kalman"
w = 0.001
v = 0.0004
form = "filter"
[[observer]]
name = "EKF"
kind = "extended-kalman"
w = 0.001
v = 0.0004
period = 0.1
[[observer]]
name = "LPV"
kind = "lpv"
region = { states = [[-2, 2], [-2, 2]] }
decay_rate = 1
[[observer]]
name = "PI"
kind = "proportional-integral"
poles = [0.3, 0.4, 0.5]
e = [[0], [0.1]]
[[observer]]
name = "ESO"
kind = "extended-state"
bandwidth = 5
e = [[0], [0.1]]
"#;

/// In discrete time the page gives the scores and the verdicts of the study; the period is that of the plant.
#[test]
fn a_plant_in_discrete_time_gives_the_scores_of_the_study() {
    let (experiment, results, html) = of_text("discrete", DISCRETE);
    same_scores("discrete", &experiment, &results);
    assert!(!html.contains("data-slider=\"period\""));
    let slow = Sliders { period: 2.0, ..Sliders::NEUTRAL };
    assert_eq!(luenberger_live::run(&experiment, &slow), luenberger_live::run(&experiment, &Sliders::NEUTRAL));
    for (observer, verdict) in experiment.observers.iter().zip(verify(&experiment, &Sliders::NEUTRAL)) {
        let design = results.observers.iter().find(|of| of.name == observer.name).unwrap();
        let said = design.design.as_ref().unwrap().verdict.word() == "proved";
        assert_eq!(matches!(verdict, Some(GainVerdict::Proved(_))), said, "{}: {verdict:?}", observer.name);
    }
    // Both eigenvalues of A have the square det A = 0.955, so that the error tends to 0 without correction too, which
    // the P of the design does not prove. A - g L C has the trace 1.95 - 0.95 g: with g = 100 it is not Schur.
    let without = verify(&experiment, &Sliders { gain: 1e-3, ..Sliders::NEUTRAL });
    assert!(matches!(&without[0], Some(GainVerdict::ProvedAnew(_))), "{:?}", without[0]);
    let large = verify(&experiment, &Sliders { gain: 100.0, ..Sliders::NEUTRAL });
    assert!(matches!(&large[0], Some(GainVerdict::Open(_))), "{:?}", large[0]);
}

/// A law with the true state, with jumps.
#[test]
fn a_law_with_the_true_state_gives_the_scores_of_the_study() {
    let text = CARRIAGE.replace("INPUT", "law = [\"-x1 - step(t - 1.5)*x2 + force_of\"]\njumps = [1.5]");
    let text = text.replace(
        "a = [[0, 1], [0, -0.5]]\nb = [[0], [1]]\nc = [[1, 0], [0, 1]]",
        "f = [\"x2\", \"force - 0.5*x2\"]\nh = [\"x1\", \"x2\"]\nparameters = { force_of = 0.3 }",
    );
    let (experiment, results, _) = of_text("law", &text);
    same_scores("law", &experiment, &results);
    let mut other = experiment.clone();
    other.law.as_mut().unwrap().rows = vec!["-x1".to_owned()];
    let outcomes = [&experiment, &other].map(|of| luenberger_live::run(of, &Sliders::NEUTRAL));
    assert_ne!(outcomes[0], outcomes[1]);
}

/// Metres and pascals have no norm: without a scale neither the page nor its table adds them up. Two temperatures have
/// one in their unit.
#[test]
fn states_of_several_units_have_no_norm_in_the_page() {
    let study = |units: &str| {
        format!(
            "[plant]\na = [[-1, 0.5], [0, -2]]\nc = [[1, 0]]\nstates = [\"one\", \"two\"]\nunits = {units}\n[simulation]\nx0 = \
             [1, 2]\nduration = 3\n[[observer]]\nname = \"linear\"\nkind = \"luenberger\"\npoles = [-3, -4]\n"
        )
    };
    for (name, units, scale) in [
        ("several", "{ one = \"m\", two = \"Pa\" }", None),
        ("partly", "{ one = \"m\" }", None),
        ("common", "{ one = \"degC\", two = \"degC\" }", Some(vec![1.0, 1.0])),
    ] {
        let (experiment, results, html) = of_text(&format!("units-{name}"), &study(units));
        assert_eq!(experiment.scale, scale, "{name}");
        same_scores(name, &experiment, &results);
        assert_eq!(html.contains("The states have no norm in common"), scale.is_none(), "{name}");
        let said = results.simulation.unwrap().scoring.words.join(" ");
        assert_eq!(said.contains("scale = [1 degC, 1 degC], the unit of all states"), scale.is_some(), "{said}");
        // The first screen has scores either way.
        let summary = html.split_once(">Summary<").unwrap().1.split_once("</table>").unwrap().0;
        assert_eq!(summary.contains("RMSE of two"), scale.is_none(), "{summary}");
        assert_eq!(summary.contains("rms |e|"), scale.is_some(), "{summary}");
    }
}

/// The verdict of the report is on the gains of the report.
#[test]
fn a_verdict_that_the_page_does_not_verify_is_for_the_gains_of_the_report() {
    let (experiment, _) = page("two-tanks", "elsewhere");
    let experiment = experiment.unwrap();
    let interval = |sliders: &Sliders| verify(&experiment, sliders).swap_remove(0);
    assert_eq!(interval(&Sliders::NEUTRAL), Some(GainVerdict::Elsewhere));
    let moved = interval(&Sliders { gain: 1.5, ..Sliders::NEUTRAL });
    assert!(matches!(&moved, Some(GainVerdict::Open(why)) if why.contains("gains of the design")), "{moved:?}");
}

/// The verdict on the observer of this name.
fn verdict(experiment: &Experiment, name: &str, sliders: &Sliders) -> Option<GainVerdict> {
    let at = experiment.observers.iter().position(|observer| observer.name == name).unwrap();
    verify(experiment, sliders).swap_remove(at)
}

/// An interval observer is certified up to the noise and the first error of its certificate, and not beyond. The first
/// error is (0.3, -0.1), and the certificate is for |e1| <= 0.4, |e2| <= 0.2.
#[test]
fn an_interval_observer_beyond_its_bounds_is_not_certified() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("templates/two-tanks.toml");
    let text = std::fs::read_to_string(file).unwrap();
    let (experiment, _, html) = of_text("beyond", &text);
    assert!(html.contains("Where a slider goes beyond"));
    let loud = |factor: f64| Sliders { noise: factor, ..Sliders::NEUTRAL };
    let far = |factor: f64| Sliders { error: factor, ..Sliders::NEUTRAL };
    let is_within = |experiment: &Experiment, name: &str, sliders: &Sliders| match verdict(experiment, name, sliders) {
        Some(GainVerdict::Elsewhere) => true,
        Some(GainVerdict::Open(_)) => false,
        other => panic!("{other:?}"),
    };
    let names = ["plant coordinates", "modal coordinates"];
    for name in names {
        for sliders in [Sliders::NEUTRAL, loud(0.0), loud(0.5), far(0.0), far(0.5), far(1.3)] {
            assert!(is_within(&experiment, name, &sliders), "{name} at {sliders:?}");
        }
        // Neither has a cubic gain or a period.
        assert!(is_within(&experiment, name, &Sliders { cubic: 2.0, period: 0.5, ..Sliders::NEUTRAL }));
        let Some(GainVerdict::Open(why)) = verdict(&experiment, name, &loud(1.05)) else { panic!("{name}") };
        assert_eq!(why, "the noise of output 1 is up to 0.00525, and the certificate is for 0.005");
        let Some(GainVerdict::Open(why)) = verdict(&experiment, name, &far(1.55)) else { panic!("{name}") };
        assert_eq!(why, "the first error is larger than those that the certificate is for");
    }
    // min(0.4/0.3, 0.2/0.1) in the coordinates of the plant. The left eigenvectors of A - L C for the poles -0.4 and
    // -1.5 are (1, -1) and (1, -6.5): min(0.6/0.4, 1.7/0.95).
    for (name, limit) in names.into_iter().zip([4.0 / 3.0, 1.5]) {
        assert!(is_within(&experiment, name, &far(limit * (1.0 - 1e-9))));
        assert!(!is_within(&experiment, name, &far(limit * (1.0 + 1e-9))));
    }
    // Convergence without noise is for every noise and first error: nothing is left by the linear observer.
    for sliders in [loud(5.0), far(5.0)] {
        assert!(matches!(verdict(&experiment, "Luenberger", &sliders), Some(GainVerdict::Proved(_))));
    }
    // The bound of the certificate counts, not the amplitude of the study.
    let bounds = "bounds = { disturbance = [0.01]";
    let wider = text.replace(bounds, "bounds = { noise = [0.0125], disturbance = [0.01]");
    let (wider, _, _) = of_text("wider", &wider);
    for name in names {
        assert!(is_within(&wider, name, &loud(2.5)) && !is_within(&wider, name, &loud(2.55)));
    }
    // One below the noise of the study as well.
    let narrower = text.replace(bounds, "bounds = { noise = [0.004], disturbance = [0.01]");
    let (narrower, _, _) = of_text("narrower", &narrower);
    for name in names {
        assert!(is_within(&narrower, name, &loud(0.75)) && !is_within(&narrower, name, &Sliders::NEUTRAL));
    }
    // A sensor has noise as well.
    let mut with_sensor = wider.clone();
    let (period, offset, gaussian, seed) = (0.1, 0.0, false, 1);
    with_sensor.sensors.push(luenberger_live::Sensor { output: 0, period, offset, gaussian, amplitude: 0.01, seed });
    assert!(is_within(&with_sensor, names[0], &loud(1.25)) && !is_within(&with_sensor, names[0], &loud(1.3)));
    // Gaussian noise has no bound, whatever the slider is.
    let mut gaussian = wider;
    gaussian.noise.as_mut().unwrap().gaussian = true;
    assert!(is_within(&gaussian, names[0], &loud(0.0)));
    for factor in [0.5, 1.0, 1.05] {
        let Some(GainVerdict::Open(why)) = verdict(&gaussian, names[0], &loud(factor)) else { panic!("{factor}") };
        assert!(why.contains("Gaussian"), "{why}");
    }
}

/// Theorems without a bound of noise and first errors are not left by these sliders.
#[test]
fn noise_and_first_errors_leave_no_other_certificate() {
    for template in ["servo", "load-torque"] {
        let (experiment, _) = page(template, "unbounded");
        let experiment = experiment.unwrap();
        let neutral = verify(&experiment, &Sliders::NEUTRAL);
        assert!(neutral.contains(&Some(GainVerdict::Elsewhere)), "{template}: {neutral:?}");
        let moved = Sliders { noise: 5.0, error: 5.0, ..Sliders::NEUTRAL };
        assert_eq!(verify(&experiment, &moved), neutral, "{template}");
    }
}

/// An observer without code in the page is named with its kind.
#[test]
fn an_observer_that_is_not_in_the_page_is_named_with_its_kind() {
    let text = CARRIAGE.replace("INPUT", "expressions = [\"0\"]").replacen("extended-kalman", "ukf", 1);
    let (experiment, results, html) = page_of(&study(&text), &scratch("in-part"));
    let name = &study(&text).observers[0].name;
    // Its period is that of the scores of all the same.
    scores_of_those_in_the_page("in part", experiment.as_ref().unwrap(), &results);
    assert!(experiment.is_some_and(|experiment| experiment.observers.iter().all(|of| of.name != *name)));
    let said = format!("Not simulated in this page, which has no code for them: {name} (kind ukf).");
    assert!(html.contains(&said), "{said}");
}

/// What the page cannot run has a sentence in its place; a study on a log has no such section.
#[test]
fn what_the_page_cannot_run_is_said() {
    assert!(page("measured-log", "without").0.is_none());
    let library = "[plant]\nbuiltin = \"cuk\"\n[simulation]\nx0 = [0.5, 24, -0.5, -12]\nduration = 0.001\n\
                   [[observer]]\nkind = \"extended-kalman\"\nw = 1\nv = 1\nperiod = 5e-5\n";
    let unscented = CARRIAGE.replace("INPUT", "expressions = [\"0\"]").replace("extended-kalman", "ukf");
    let (alone, _) = unscented.split_once("[[observer]]\nname = \"fixed\"").unwrap();
    for (text, why) in [
        (library, "the page has no code for its plant, which is one of the library"),
        (alone, "the page has no code for its observers"),
    ] {
        let study = study(text);
        let (experiment, _, html) = page_of(&study, &scratch("refused"));
        assert!(experiment.is_none() && html.contains(why) && !html.contains("live-module"), "{why}");
    }
}
