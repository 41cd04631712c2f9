//! Interval observers in studies: bounds that enclose the state, their figures, tables, report and step for a target.

use luenberger_proof::statement::Format as Number;
use luenberger_study::deployment::{evidence, exported, sampled};
use luenberger_study::{RunOptions, Step, execute};

use crate::studies::read;

const MOTOR: &str = r#"
title = "motor"
[plant]
states = ["speed", "current"]
inputs = ["voltage"]
outputs = ["tacho"]
a = [[-1, 2], [-4, -8]]
b = [[0], [5]]
c = [[1, 0]]
[simulation]
duration = 4
x0 = [1, -0.5]
hold = 0.05
noise = { distribution = "uniform", amplitude = [0.05], period = 0.05, seed = 1 }
[input]
expressions = ["sin(t)"]
"#;

fn observer(rest: &str) -> String {
    format!("[[observer]]\nkind = \"interval\"\ninitial_bounds = [2, 2]\n{rest}\n")
}

const BOUNDS: &str = "bounds = { disturbance = [0.3], e = [[1], [0]] }";

#[test]
fn the_state_is_enclosed_in_a_run() {
    let all = ["poles = [-6, -9]", "poles = [[-6, 3], [-6, -3]]", "least_width = true"];
    let observers: String =
        all.iter().enumerate().map(|(k, gain)| observer(&format!("name = \"o{k}\"\n{gain}\n{BOUNDS}"))).collect();
    let study = read(&format!("{MOTOR}{observers}")).unwrap();
    let folder = crate::studies::scratch("interval-enclosed");
    let results = execute(&study, Step::Run, &RunOptions::default().output(folder.clone().into())).unwrap();
    assert!(results.failures().is_empty(), "{:?}", results.failures());
    assert_eq!(results.intervals.len(), 3);
    for (report, observer) in results.intervals.iter().zip(&results.observers) {
        let design = observer.design.as_ref().unwrap();
        assert_eq!(design.verdict.word(), "proved", "{:?}", design.facts);
        assert_eq!(report.coverage_in_words(), "100 %");
        for (state, end) in ["speed", "current"].iter().zip(&report.final_width) {
            let limit = design.number(&format!("half-width of {state} in the end")).unwrap();
            assert!(*end > limit && *end < 2.001 * limit, "{}: {end} and {limit}", report.observer);
        }
        // The bounds in the table of the run.
        let table = std::fs::read_to_string(folder.join(format!("trajectories/{}.csv", report.observer))).unwrap();
        let (head, rows) = table.split_once('\n').unwrap();
        let place = |name: String| head.split(',').position(|column| column == name).unwrap();
        for (i, state) in ["speed", "current"].iter().enumerate() {
            let [low, high] = ["lower", "upper"].map(|side| place(format!("{state}_{side}")));
            let cell = |line: &str, k: usize| line.split(',').nth(k).unwrap().parse::<f64>().unwrap();
            let widths: Vec<f64> = rows.lines().map(|line| cell(line, high) - cell(line, low)).collect();
            let mean = widths.iter().sum::<f64>() / widths.len() as f64;
            assert!(
                (report.mean_width[i] - mean).abs() <= 1e-9 * mean,
                "{}: {:?}, {mean}",
                report.observer,
                report.mean_width
            );
            assert!(
                (report.final_width[i] - widths[widths.len() - 1]).abs() <= 1e-9 * mean
                    && report.mean_width[i] > report.final_width[i]
            );
        }
    }
    // The linear program beats the poles in the sum of its widths.
    let total = |k: usize| results.intervals[k].final_width.iter().sum::<f64>();
    assert!(total(2) < total(0) && total(2) < total(1), "{} {} {}", total(0), total(1), total(2));
}

/// A - L C of the tanks is [-0.2, -l1; 0.2, -0.2 - l2].
#[test]
fn the_sign_of_the_entries_is_told() {
    let text = luenberger_study::template::text("two-tanks").unwrap();
    for (gain, words) in [("[[0], [0.8]]", " A - L C is Metzler."), ("[[0.1], [0.8]]", " A - L C is not Metzler:")] {
        let study = read(&text.replace("gain = [[0], [0.8]]", &format!("gain = {gain}"))).unwrap();
        let results = execute(&study, Step::Design, &RunOptions::default()).unwrap();
        let statement = &results.observers[0].design.as_ref().unwrap().statement;
        assert!(statement.contains(words), "{gain}: {statement}");
    }
}

#[test]
fn noise_beyond_its_bound_shows_in_the_report() {
    let quiet = observer("poles = [-6, -9]\nbounds = { noise = [0.001] }");
    let study = read(&format!("{MOTOR}{quiet}")).unwrap();
    let results = execute(&study, Step::Run, &RunOptions::default()).unwrap();
    assert!(results.intervals[0].coverage < 0.9, "{}", results.intervals[0].coverage);
}

/// The step of the export is the observer of the design, to the last bit, in both formats.
#[test]
fn the_exported_step_computes_the_bounds_of_the_design() {
    use luenberger_export::{Scalar, golden::Stepper};
    let study = read(&format!("{MOTOR}{}", observer(&format!("name = \"o\"\npoles = [-6, -9]\n{BOUNDS}")))).unwrap();
    let requested = study.observer("o").unwrap();
    let found = sampled(&study, requested, Some(0.05), None).unwrap();
    for (format, scalar) in [(Number::Binary64, Scalar::Binary64), (Number::Binary32, Scalar::Binary32)] {
        let evidence = evidence(&study, requested, &found.design, format.into());
        assert!(evidence.is_proved(), "{:?}", evidence.sentences);
        assert!(evidence.sentences[0].contains("the rounding of every operation included"), "{:?}", evidence.sentences);
        let export = exported(&study, requested, found.design.clone(), scalar, None).unwrap();
        let mut stepper = Stepper::new(&export).unwrap();
        let first = stepper.estimate();
        // (xhat, half-widths, rho): the half-widths are at least those of the first box.
        assert_eq!(first.len(), 6);
        assert!(first[2] >= 2.0 && first[3] >= 2.0, "{first:?}");
        // A plant at the corners of the disturbance.
        let held = luenberger_linalg::zero_order_hold(
            &nalgebra::dmatrix![-1.0, 2.0; -4.0, -8.0],
            &nalgebra::dmatrix![0.0, 1.0; 5.0, 0.0],
            0.05,
        )
        .unwrap();
        let mut x = nalgebra::dvector![1.5, -1.9];
        for k in 0..400_u32 {
            let z = stepper.estimate();
            for i in 0..2 {
                let (low, high) = match scalar {
                    Scalar::Binary64 => (z[i] - z[2 + i], z[i] + z[2 + i]),
                    Scalar::Binary32 => {
                        let (x, r) = (z[i] as f32, z[2 + i] as f32);
                        (f64::from(x - r), f64::from(x + r))
                    }
                };
                assert!(low <= x[i] && x[i] <= high, "sample {k}: {} in [{low}, {high}]", x[i]);
            }
            let noise = if (k / 3) % 2 == 0 { 0.0499 } else { -0.0499 };
            let (u, w) = (f64::from((0.1 * f64::from(k)).sin() as f32), if (k / 7) % 2 == 0 { 0.3 } else { -0.3 });
            stepper.step(&[u], &[f64::from((x[0] + noise) as f32)]);
            x = &held.ad * x + &held.bd * nalgebra::dvector![u, w];
        }
    }
}

#[test]
fn a_plant_in_discrete_time_has_the_sampled_observer() {
    let text = "[plant]\na = [[1, 0.1], [0, 0.9]]\nb = [[0], [0.1]]\nc = [[1, 0]]\ndt = 0.1\n\
        [simulation]\nduration = 8\nx0 = [1, 1]\nnoise = { distribution = \"uniform\", amplitude = [0.02], period = 0.1 }\n\
        [input]\nexpressions = [\"cos(t)\"]\n\
        [[observer]]\nname = \"o\"\nkind = \"interval\"\npoles = [0.4, 0.6]\ninitial_bounds = [1, 1]\n\
        bounds = { disturbance = [0.01], e = [[0], [1]] }\n";
    let study = read(text).unwrap();
    let results = execute(&study, Step::Run, &RunOptions::default()).unwrap();
    assert!(results.failures().is_empty(), "{:?}", results.failures());
    let design = results.observers[0].design.as_ref().unwrap();
    assert_eq!(design.verdict.word(), "proved", "{:?}", design.facts);
    assert_eq!(results.intervals[0].coverage_in_words(), "100 %");
}

/// What is proved supposes bounds: a simulation that does not keep them is warned of, in the report as well.
#[test]
fn a_simulation_beyond_the_bounds_is_warned_of() {
    let said = |name: &str, text: &str, own: &str| {
        let text = format!("{text}{}", observer(&format!("name = \"o\"\npoles = [-6, -9]\n{own}\n")));
        let folder = crate::studies::scratch(&format!("interval-beyond-{name}"));
        let results =
            execute(&read(&text).unwrap(), Step::Run, &RunOptions::default().output(folder.clone().into())).unwrap();
        let page = std::fs::read_to_string(folder.join("report.html")).unwrap();
        let warnings = results.warnings.iter().filter(|text| text.contains("not proved of this simulation"));
        let warnings: Vec<String> = warnings.cloned().collect();
        assert!(warnings.iter().all(|warning| page.contains(warning.as_str())), "{name}: {warnings:?}");
        warnings.join("; ")
    };
    let given = "bounds = { noise = [0.04], disturbance = [0.3], e = [[1], [0]] }";
    let gaussian = MOTOR.replace("uniform", "gaussian");
    assert_eq!(said("kept", MOTOR, BOUNDS), "");
    assert_eq!(
        said("gaussian", &gaussian, given),
        "o: its bounds are proved for noise of tacho of at most 0.04, and the noise of the simulation is Gaussian, which \
         has no bound: they are not proved of this simulation"
    );
    assert!(said("wide", MOTOR, given).contains("the noise of the simulation is up to 0.05"));
    let far = said("far", &MOTOR.replace("x0 = [1, -0.5]", "x0 = [1, -2.5]"), BOUNDS);
    assert!(far.contains("a first error of current of at most 2, and that of the simulation is 2.5"), "{far}");
}

#[test]
fn mistakes_and_refusals_are_named() {
    let mistake = |rest: &str, expected: &str| {
        let found = read(&format!("{MOTOR}{}", observer(rest))).unwrap_err().to_string();
        assert!(found.contains(expected), "{found}");
    };
    mistake("poles = [-6, -9]", "[[observer]] of the kind interval has no `bounds`");
    mistake("poles = [-6, -9]", "bounds = { noise = [0.1] }");
    // What is missing is said at once.
    let nothing = format!("{MOTOR}[[observer]]\nkind = \"interval\"\n");
    let found = read(&nothing).unwrap_err().to_string();
    for what in ["has no `initial_bounds`", "has no `bounds`", "no gain specification"] {
        assert!(found.contains(what), "{what}: {found}");
    }
    mistake(&format!("poles = [-6, -9]\nleast_width = true\n{BOUNDS}"), "`poles` conflicts with `least_width`");
    mistake(&format!("least_width = true\ncoordinates = \"modal\"\n{BOUNDS}"), "the coordinates of the plant");
    mistake(&format!("poles = [-6, -9]\ncoordinates = \"polar\"\n{BOUNDS}"), "polar");
    mistake(BOUNDS, "no gain specification");
    let text = MOTOR.to_owned() + "[[observer]]\nkind = \"interval\"\npoles = [-6, -9]\n" + BOUNDS;
    assert!(read(&text).unwrap_err().to_string().contains("initial_bounds"));
    let short = format!("[[observer]]\nkind = \"interval\"\npoles = [-6, -9]\ninitial_bounds = [1]\n{BOUNDS}");
    assert!(read(&format!("{MOTOR}{short}")).unwrap_err().to_string().contains("initial_bounds"));
    let why = |rest: &str| {
        let study = read(&format!("{MOTOR}{}", observer(rest))).unwrap();
        let results = execute(&study, Step::Design, &RunOptions::default()).unwrap();
        let failure = results.observers[0].failure.clone().unwrap();
        (failure.hypothesis.clone(), failure.advice().join("; "))
    };
    let (hypothesis, instead) = why(&format!("poles = [-6, -6]\n{BOUNDS}"));
    assert!(hypothesis.contains("not distinct enough for modal coordinates"), "{hypothesis}");
    assert!(instead.contains("distinct `poles`"), "{instead}");
    let (hypothesis, instead) = why(&format!("poles = [[-1, 9], [-1, -9]]\ncoordinates = \"plant\"\n{BOUNDS}"));
    assert!(hypothesis.contains("the width of the interval would grow"), "{hypothesis}");
    assert!(instead.contains("modal"), "{instead}");
}
