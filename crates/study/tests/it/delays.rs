//! Outputs that are measured late.

use std::fmt::Write as _;
use std::path::Path;

use luenberger_random::Random;
use luenberger_study::deployment::{ExportOptions, program};
use luenberger_study::{RunOptions, Step, execute};
use nalgebra::DMatrix;

use crate::studies::{designed, executed, mistakes, mistakes_of, scratch, study, study_in};

const KINDS: [&str; 3] = ["extended-kalman", "iterated-extended-kalman", "ukf"];

/// A pendulum, whose angle is known late and whose rate at once.
fn pendulum(plant: &str, rest: &str, keys: &str) -> String {
    let mut text = format!(
        "[plant]\nstates = [\"angle\", \"rate\"]\ninputs = [\"torque\"]\noutputs = [\"fix\", \"gyro\"]\nf = [\"rate\", \"torque - sin(angle)\"]\nh = [\"angle\", \"rate\"]\n{plant}{rest}"
    );
    for kind in KINDS {
        _ = write!(
            text,
            "[[observer]]\nkind = \"{kind}\"\ninitial = [0, 0]\np0 = [1, 1]\nw = [1e-6, 0.01]\nv = [1e-4, 0.04]\nperiod = 0.1\n{keys}"
        );
    }
    text
}

/// The last estimates and deviations on a log.
fn last(folder: &Path, text: &str) -> Vec<(String, Vec<f64>, Vec<f64>)> {
    let results = execute(&study_in(folder, text), Step::Run, &RunOptions::default());
    let results = results.unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(results.failures(), Vec::<String>::new());
    let row = |table: &Option<DMatrix<f64>>| {
        let table = table.as_ref().unwrap();
        table.row(table.nrows() - 1).iter().copied().collect::<Vec<f64>>()
    };
    results.runs.iter().map(|run| (run.observer.clone(), row(&run.estimate), row(&run.deviation))).collect()
}

/// Time, torque, fix with its variance, and gyro.
type Row = (f64, f64, Option<(f64, f64)>, Option<f64>);

/// The estimate at any row is that of the log in which the late column stands at its times and which ends there.
#[test]
fn a_late_column_is_the_column_at_its_times() {
    for (delay, rows) in [(0.25, 40), (0.3, 40), (0.25, 11), (0.72, 29)] {
        let folder = scratch("delays/log");
        let (mut random, mut late) = (Random(6), "t,torque,fix,gyro,sure\n".to_owned());
        // In order of times; the torque holds from row to row.
        let mut in_order: Vec<Row> = Vec::new();
        for k in 0..rows {
            let (t, torque) = (0.1 * f64::from(k), (0.1 * f64::from(k)).cos());
            let [a, b] = random.normal_pair();
            let gyro = 0.3 * t.sin() + 0.2 * a;
            let fix = (k % 3 == 1 && t >= delay).then_some(0.3 * (t - delay) + 0.01 * b);
            let cell = fix.map_or_else(String::new, |fix| fix.to_string());
            // The variance of the fix stands in its row.
            let sure =
                |fix: &str| if fix.is_empty() { String::new() } else { (1e-4 * f64::from(1 + k % 5)).to_string() };
            _ = writeln!(late, "{t},{torque},{cell},{gyro},{}", sure(&cell));
            in_order.push((t, torque, None, Some(gyro)));
            if let Some(fix) = fix {
                let of = t - delay;
                let held = (0.1 * (of * 10.0 + 1e-6).floor()).cos();
                in_order.push((of, held, Some((fix, 1e-4 * f64::from(1 + k % 5))), None));
            }
        }
        in_order.sort_by(|a, b| a.0.total_cmp(&b.0));
        in_order.dedup_by(|b, a| {
            let is_one = (a.0 - b.0).abs() < 1e-9;
            if is_one {
                (a.2, a.3) = (a.2.or(b.2), a.3.or(b.3));
            }
            is_one
        });
        let mut shifted = "t,torque,fix,gyro,sure\n".to_owned();
        for (t, torque, fix, gyro) in in_order {
            let cell = |value: Option<f64>| value.map_or_else(String::new, |value| value.to_string());
            let (fix, sure) = fix.unzip();
            _ = writeln!(shifted, "{t},{torque},{},{},{}", cell(fix), cell(gyro), cell(sure));
        }
        std::fs::write(folder.join("late.csv"), late).unwrap();
        std::fs::write(folder.join("shifted.csv"), shifted).unwrap();
        let text = |plant: &str, file: &str, (keys, variances): (&str, &str)| {
            pendulum(plant, &format!("[log]\nfile = \"{file}\"\n{variances}"), keys)
        };
        let delays = format!("delays = {{ fix = {delay} }}\n");
        // A reading that a gate rejects is no time at which a prediction is divided: only where it is a row anyway are
        // the sigma points drawn at the same times.
        let gate = if delay == 0.3 { "gate = 4\n" } else { "" };
        let bounds = "state_bounds = [[-inf, inf], [-0.3, 0.3]]\n";
        for keys in [("", ""), (gate, ""), (bounds, ""), ("", "variances = [\"sure\", \"-\"]\n")] {
            let found = last(&folder, &text(&delays, "late.csv", keys));
            let expected = last(&folder, &text("", "shifted.csv", keys));
            let ignored = last(&folder, &text("", "late.csv", keys));
            for ((name, estimate, deviation), (_, exact, own)) in found.iter().zip(&expected) {
                for i in 0..2 {
                    assert!((estimate[i] - exact[i]).abs() < 1e-9, "{name} {delay} {rows}: {estimate:?} {exact:?}");
                    assert!((deviation[i] - own[i]).abs() < 1e-9, "{name} {delay} {rows}: {deviation:?} {own:?}");
                }
            }
            assert!((ignored[0].1[0] - expected[0].1[0]).abs() > 1e-3, "{ignored:?} {expected:?}");
        }
    }
}

/// Simulated sensors are late, and the filters that know it are consistent; one that does not know is far off.
#[test]
fn simulated_sensors_are_late() {
    let simulation = |truth: &str| {
        format!(
            "[input]\nexpressions = [\"cos(t)\"]\n[simulation]\nx0 = [0.5, 1]\nduration = 40\nnoise = {{ amplitude = [0.01, 0.2], period = 0.1, seed = 3 }}\n{truth}"
        )
    };
    let rmse = |text: &str| -> Vec<f64> {
        let results = executed(text, Step::Simulate);
        assert!(results.filters.iter().all(|filter| filter.nis.is_some()));
        let rows = &results.simulation.as_ref().unwrap().rows;
        rows.iter().map(|row| row.merits.as_ref().unwrap().states[0].steady_rmse).collect()
    };
    let known = rmse(&pendulum("delays = { fix = 0.3 }\n", &simulation(""), ""));
    let on_time = rmse(&pendulum("", &simulation(""), ""));
    let unknown = rmse(&pendulum("", &simulation("[truth]\nmeasurement_delay = 0.3\n"), ""));
    for k in 0..KINDS.len() {
        assert!(known[k] < 3.0 * on_time[k], "{known:?} {on_time:?}");
        assert!(unknown[k] > 5.0 * known[k], "{unknown:?} {known:?}");
    }
    let results = executed(&pendulum("delays = { fix = 0.3 }\n", &simulation(""), ""), Step::Simulate);
    let words = results.observers[0].design.as_ref().unwrap().statement.to_string();
    assert!(words.contains("Measurements are late (fix by 0.3)"), "{words}");

    // In discrete time, by whole samples.
    let map = |keys: &str| {
        format!(
            "[plant]\nf = [\"0.9*x1 + 0.3*sin(t)\"]\nh = [\"x1\"]\ndt = 0.5\n{keys}[simulation]\nx0 = [1]\nduration = 50\nnoise = {{ amplitude = [0.01], period = 0.5, seed = 3 }}\n[[observer]]\nkind = \"ukf\"\nw = 1e-4\nv = 1e-4\nperiod = 0.5\n"
        )
    };
    let score = |text: &str| {
        let results = executed(text, Step::Simulate);
        results.simulation.unwrap().rows[0].merits.as_ref().unwrap().states[0].steady_rmse
    };
    let (late, on_time) = (score(&map("delays = { y1 = 1 }\n")), score(&map("")));
    assert!(late < 2.0 * on_time, "{late} {on_time}");
}

#[test]
fn what_does_not_take_late_measurements_says_so() {
    let delays = "delays = { fix = 0.25 }\n";
    let with = |kind: &str, keys: &str| {
        pendulum(delays, "", keys).replace("kind = \"extended-kalman\"", &format!("kind = \"{kind}\""))
    };
    let refused = designed(&study(&with("mhe", ""))).unwrap_err().to_string();
    assert!(
        refused.contains("outputs are measured late (fix by 0.25), and the kind mhe takes a reading for one of now"),
        "{refused}"
    );
    let text = pendulum(delays, "", "");
    let options = ExportOptions::default();
    let refusal = program(&study(&text), Some("ukf"), &options, None).unwrap_err().to_string();
    assert!(refusal.contains("the exported step of ukf takes no late measurements"), "{refusal}");
    let folder = scratch("delays/refused");
    std::fs::write(folder.join("log.csv"), "t,torque,fix,gyro\n0,0,0,0\n0.1,0,0,0\n0.2,0,0,0\n").unwrap();
    let log = "[log]\nfile = \"log.csv\"\n";
    let smooth = study_in(&folder, &pendulum(delays, log, "smooth = true\n"));
    let refused = designed(&smooth).unwrap_err().to_string();
    assert!(refused.contains("`smooth` with outputs that are measured late"), "{refused}");
    let tuned = pendulum(delays, log, "").replace("kind = \"ukf\"", "name = \"mhe\"\nkind = \"mhe\"")
        + "[tune]\nobserver = \"mhe\"\nparameters = [\"w\"]\n";
    let read = luenberger_study::Study::from_text("study.toml", &tuned, luenberger_study::Format::Toml, &folder);
    let said = &mistakes_of(&tuned, read)[0].message;
    assert!(said.starts_with("outputs are measured late (fix by 0.25), and the kind mhe takes"), "{said}");
    for (keys, said) in [
        ("delays = { angle = 1 }\n", "the plant has no output `angle`"),
        ("delays = { fix = -1 }\n", "the delay of fix is no time"),
        ("delays = { fix = \"1 s\" }\n", "the delay of fix is no time"),
        ("dt = 0.1\ndelays = { fix = 0.25 }\n", "the delay of fix is 0.25, not a multiple of `dt` = 0.1"),
    ] {
        assert_eq!(mistakes(&pendulum(keys, "", ""))[0].message, said);
    }
    // A delay of zero is none.
    assert!(study(&pendulum("delays = { fix = 0 }\n", "", "")).plant.delays.is_empty());
}
