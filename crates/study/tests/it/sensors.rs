//! Sensors with sampling periods of their own, and measurements that do not arrive.

use luenberger_study::{RunOptions, Step, execute};

use crate::studies::{executed, mistake, scratch, study};

/// A carriage: position every 0.3 s from 0.2 s on, speed every 0.2 s, a filter at 10 Hz.
const CARRIAGE: &str = r#"
[plant]
dt = 0.1
f = ["x + 0.1*v", "v"]
h = ["x", "v"]
states = ["x", "v"]
outputs = ["place", "speed"]
time_unit = "s"
[simulation]
x0 = [1, -0.5]
duration = 2
samples = 21
estimates = "predicted"
[[simulation.sensor]]
output = "place"
period = 0.3
offset = 0.2
[[simulation.sensor]]
output = "speed"
period = 0.2
[[observer]]
name = "filter"
kind = "extended-kalman"
w = [[0, 0], [0, 0.01]]
v = [[0.04, 0], [0, 0.25]]
p0 = 1
period = 0.1
"#;

/// filterpy 1.4.5: `update` with the rows of H and R that are measured, then `predict`, 20 times.
#[test]
fn a_filter_is_updated_by_the_sensors_that_measured() {
    let folder = scratch("sensors");
    let options = RunOptions { output: Some(folder.clone().into()), ..RunOptions::default() };
    let results = execute(&study(CARRIAGE), Step::Simulate, &options).unwrap();
    let text = std::fs::read_to_string(folder.join("trajectories/filter.csv")).unwrap();
    let rows: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(rows[0], ["t", "x", "v", "place", "speed", "x_hat", "v_hat", "x_2sigma", "v_2sigma"]);
    let last: Vec<f64> = rows[21][5..].iter().map(|cell| cell.parse().unwrap()).collect();
    let [p11, p22] = [0.026_486_846_505_486_05f64, 0.071_936_510_617_245_58f64];
    let expected = [0.004_409_353_795_072_46, -0.494_665_613_399_897_2, 2.0 * p11.sqrt(), 2.0 * p22.sqrt()];
    for (found, expected) in last.iter().zip(expected) {
        assert!((found - expected).abs() < 1e-12, "{found} {expected}");
    }
    // No measurement is an empty cell.
    assert_eq!((rows[1][3], rows[1][4], rows[2][4]), ("", "-0.5", ""));
    assert_eq!((1..21).filter(|k| !rows[*k][3].is_empty()).count(), 6);
    assert_eq!((1..21).filter(|k| !rows[*k][4].is_empty()).count(), 10);
    // Six places and ten speeds.
    let nis = results.filters[0].nis.as_ref().unwrap();
    assert_eq!(nis.samples, 13);
    assert_eq!(
        results.simulation.unwrap().measurements.unwrap(),
        "place is measured every 0.3 s from t = 0.2 s on. speed is measured every 0.2 s. Only measurements correct the estimates. At a sample without a measurement a Kalman filter predicts."
    );
}

/// A filter that gets nothing after the start: the covariance of free motion.
#[test]
fn a_dropped_measurement_is_none() {
    let text = CARRIAGE.replace("[[observer]]", "[truth]\ndropout = 1\n[[observer]]");
    let filters = executed(&text, Step::Compare).filters;
    assert_eq!(filters[0].nis, None);
    let nees = filters[0].nees.as_ref().unwrap();
    assert_eq!(nees.samples, 20);
}

/// The variance of a held measurement: for e' = -L e + L v with v of variance S every h the error has the variance
/// S (1 - a)^2/(1 - a^2) at the end of each period, a = exp(-L h).
#[test]
fn reports_count_the_noise_of_sensors() {
    let text = r#"
[plant]
a = [[0]]
c = [[1]]
outputs = ["level"]
[simulation]
x0 = [1]
duration = 100
noise = { amplitude = [3], period = 0.01, distribution = "uniform" }
[[simulation.sensor]]
output = "level"
period = 0.5
amplitude = 0.2
distribution = "gaussian"
[[observer]]
name = "slow"
kind = "luenberger"
poles = [-1]
"#;
    let results = executed(text, Step::Compare);
    let a = (-0.5f64).exp();
    let expected = 0.2 * (1.0 - a) / (1.0 - a * a).sqrt();
    let found = results.observers[0].design.as_ref().unwrap().noise_deviation[0];
    assert!((found / expected - 1.0).abs() < 1e-12);
    assert!(results.simulation.unwrap().measurements.unwrap().ends_with(
        "Observers in continuous time hold a measurement until the next one is due, and take the output that they predict where none arrives."
    ));
    // Without an amplitude of its own a sensor has that of its output.
    let uniform = text.replace("amplitude = 0.2\ndistribution = \"gaussian\"\n", "");
    let results = executed(&uniform, Step::Design);
    let found = results.observers[0].design.as_ref().unwrap().noise_deviation[0];
    assert!((found / (expected * 3f64.sqrt() / 0.2) - 1.0).abs() < 1e-12);
}

#[test]
fn measurements_between_samples_are_warned_of() {
    let text = r#"
[plant]
a = [[0, 1], [0, 0]]
c = [[1, 0]]
[simulation]
x0 = [1, 0]
duration = 3
[[simulation.sensor]]
output = "y1"
period = 0.15
[[observer]]
name = "filter"
kind = "extended-kalman"
w = 1
v = 1
p0 = 1
period = 0.1
"#;
    let warnings = executed(text, Step::Compare).warnings;
    let expected = "filter: Only 11 of 21 measurements of y1 (every 0.15) lie on the observer's samples (every 0.1); the others are not used";
    assert!(warnings.iter().any(|warning| warning == expected), "{warnings:?}");
}

#[test]
fn mistakes_in_sensors() {
    let of = |old: &str, new: &str| mistake(&CARRIAGE.replacen(old, new, 1));
    let unknown = of("output = \"place\"", "output = \"plac\"");
    assert_eq!((unknown.line, unknown.message.as_str()), (15, "there is no output named \"plac\""));
    let twice = of("output = \"speed\"", "output = \"place\"");
    assert_eq!((twice.line, twice.message.as_str()), (19, "output \"place\" has two sensors"));
    let off = of("period = 0.3", "period = 0.25");
    assert_eq!(off.message, "`period` is 0.25, not a multiple of `dt` = 0.1");
    let negative = of("offset = 0.2", "offset = -0.2");
    assert!(negative.message.contains("`offset` is -0.2"), "{}", negative.message);
}
