//! Sweeps over numbers of the study, and what they leave.

use luenberger_study::study::GainSpec;
use luenberger_study::{Results, RunOptions, Step, execute};

use crate::studies::{scratch, study};

fn run(text: &str) -> Results {
    execute(&study(text), Step::Sweep, &RunOptions::default()).unwrap_or_else(|error| panic!("{error}"))
}

/// e' = -(k + L) e, of which the root mean square over [0, T] is e0 sqrt((1 - exp(-2 (k + L) T)) / (2 (k + L) T)).
const DECAY: &str = r#"
[plant]
f = ["-k*level + u1"]
h = ["level"]
states = ["level"]
parameters = { k = 1 }
[input]
expressions = ["1"]
[simulation]
x0 = [2]
duration = 3
[[observer]]
name = "by hand"
kind = "luenberger"
gain = [[0.5]]
rho = 3
"#;

fn expected(rate: f64) -> f64 {
    2.0 * ((1.0 - (-2.0 * rate * 3.0).exp()) / (2.0 * rate * 3.0)).sqrt()
}

#[test]
fn a_parameter_of_the_plant_is_varied() {
    let results = run(&format!("{DECAY}[sweep]\nparameter = \"plant.k\"\nvalues = [-0.25, 0, 2]\n"));
    let rows = &results.sweep.as_ref().unwrap().rows;
    assert_eq!(rows.iter().map(|row| row.value).collect::<Vec<_>>(), [-0.25, 0.0, 2.0]);
    for (row, k) in rows.iter().zip([-0.25, 0.0, 2.0]) {
        assert!((row.states[0].rmse - expected(0.5 + k)).abs() < 1e-8, "{row:?}");
        assert_eq!((row.finished, row.percentiles.len()), (1, 0));
    }
    // Where the gain does not stabilise the error, the design says so and the others are still swept.
    let results = run(&format!("{DECAY}[sweep]\nparameter = \"plant.k\"\nvalues = [-0.6, 1]\n"));
    let sweep = results.sweep.as_ref().unwrap();
    assert_eq!((sweep.rows[0].finished, sweep.rows[1].finished), (0, 1));
    assert!(sweep.ended()[0].starts_with("by hand with plant.k = -0.6: "), "{:?}", sweep.ended());
}

#[test]
fn a_number_of_an_observer_or_of_the_simulation_is_varied() {
    let rate = DECAY.replace("gain = [[0.5]]\nrho = 3", "decay_rate = 2");
    let results = run(&format!("{rate}[sweep]\nparameter = \"observer.by hand.decay_rate\"\nvalues = [2, 8]\n"));
    let rows = &results.sweep.as_ref().unwrap().rows;
    assert!(rows[1].states[0].rmse < 0.8 * rows[0].states[0].rmse, "{rows:?}");
    let results = run(&format!("{DECAY}[sweep]\nparameter = \"simulation.duration\"\nvalues = [1, 3]\n"));
    let rows = &results.sweep.as_ref().unwrap().rows;
    assert!((rows[0].states[0].last - 2.0 * (-1.5f64).exp()).abs() < 1e-8, "{rows:?}");
    assert!((rows[1].states[0].last - 2.0 * (-4.5f64).exp()).abs() < 1e-8, "{rows:?}");
}

/// Every run of an ensemble is a line; medians and percentiles are those of the lines.
#[test]
fn every_run_is_a_line() {
    let noisy = DECAY.replace("duration = 3\n", "duration = 3\nnoise = { amplitude = [0.2], period = 0.05 }\n");
    let folder = scratch("sweep/lines");
    let options = RunOptions { output: Some(folder.clone().into()), ..RunOptions::default() };
    let text = format!("{noisy}[sweep]\nparameter = \"noise\"\nvalues = [1, 2]\nensemble = 21\n");
    let results = execute(&study(&text), Step::Sweep, &options).unwrap();
    let csv = std::fs::read_to_string(folder.join("sweep.csv")).unwrap();
    let mut lines = csv.lines();
    let head: Vec<&str> = lines.next().unwrap().split(',').collect();
    assert_eq!(head[..5], ["observer", "noise", "run", "level_initial", "level_rmse"]);
    assert_eq!(head.last(), Some(&"failure"));
    let lines: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
    assert_eq!(lines.len(), 42);
    assert!(lines.iter().all(|line| line.len() == head.len()));
    assert_eq!(lines[21][..3], ["by hand", "2", "0"]);
    for (row, lines) in results.sweep.as_ref().unwrap().rows.iter().zip(lines.chunks(21)) {
        let mut of: Vec<f64> = lines.iter().map(|line| line[4].parse().unwrap()).collect();
        of.sort_by(f64::total_cmp);
        // Of 21 values the 2nd, the 11th and the 20th: ceil(21 q).
        let percentiles: Vec<f64> = row.percentiles.iter().map(|p| p.states[0].rmse).collect();
        assert_eq!((row.states[0].rmse, percentiles), (of[10], vec![of[1], of[19]]));
        assert!(of[0] < of[20]);
    }
    for figure in ["sweep", "sweep-pareto"] {
        assert!(folder.join(format!("figures/{figure}.svg")).exists(), "{figure}");
    }
}

/// An observer that is fed back is designed for the varied plant, too: both see u = -3 xhat.
#[test]
fn the_observer_that_is_fed_back_follows_the_plant() {
    let fed = DECAY
        .replace("[input]\nexpressions = [\"1\"]\n", "[input]\nfeedback = { k = [[3]], observer = \"fed\" }\n")
        + "[[observer]]\nname = \"fed\"\nkind = \"luenberger\"\npoles = [-4]\ninitial = [2]\n";
    let text = format!("{fed}[sweep]\nparameter = \"plant.k\"\nvalues = [0.5, 1.5]\nobservers = [\"by hand\"]\n");
    let rows = run(&text).sweep.unwrap().rows;
    for (row, k) in rows.iter().zip([0.5, 1.5]) {
        assert!((row.states[0].rmse - expected(0.5 + k)).abs() < 1e-8, "{row:?}");
    }
}

/// A sampled observer in the loop puts the scores of the others on its samples, whether it is compared or not: of
/// e = 2 exp(-(k + L) t) at t = 0, 0.5, .., 3.
#[test]
fn the_samples_of_the_observer_in_the_loop_are_those_of_the_scores() {
    let fed = DECAY
        .replace("[input]\nexpressions = [\"1\"]\n", "[input]\nfeedback = { k = [[3]], observer = \"fed\" }\n")
        + "[[observer]]\nname = \"fed\"\nkind = \"extended-kalman\"\nw = 1\nv = 1\nperiod = 0.5\ninitial = [2]\n";
    let text = format!("{fed}[sweep]\nparameter = \"plant.k\"\nvalues = [0.5, 1.5]\nobservers = [\"by hand\"]\n");
    let sweep = run(&text).sweep.unwrap();
    for (row, k) in sweep.rows.iter().zip([0.5, 1.5]) {
        let squares: f64 = (0..7).map(|sample| 4.0 * (-(0.5 + k) * f64::from(sample)).exp()).sum();
        let expected = (squares / 7.0).sqrt();
        assert!((row.states[0].rmse - expected).abs() < 1e-8, "{row:?}, expected {expected}");
    }
}

/// The poles of a plant in discrete time are `z = exp(s dt)`: twice as fast is their square, toward 0 and not beyond
/// the circle. Decay rates are per unit of time in both times.
#[test]
fn poles_in_discrete_time_are_taken_to_the_power() {
    let text = |observer: &str| {
        format!(
            "[plant]\na = [[1, 0.1], [0, 1]]\nb = [[0.005], [0.1]]\nc = [[1, 0]]\ndt = 0.1\n[simulation]\nx0 = [0, 1]\n\
             duration = 2\n[[observer]]\nname = \"observer\"\n{observer}\n"
        )
    };
    let poles = |keys: &str, factor: f64| -> Vec<[f64; 2]> {
        let study = study(&text(keys));
        let faster = study.observers[0].kind.faster(factor, study.plant.dt);
        let placed = match faster.gain().map(|linear| &linear.gain) {
            Some(GainSpec::Poles(poles)) => poles.as_slice(),
            _ => faster.poles().unwrap(),
        };
        placed.iter().map(|pole| [pole.re, pole.im]).collect()
    };
    let near = |found: &[[f64; 2]], expected: &[[f64; 2]]| {
        let distance = |(a, b): (&[f64; 2], &[f64; 2])| (a[0] - b[0]).hypot(a[1] - b[1]);
        assert!(found.iter().zip(expected).all(|pair| distance(pair) < 1e-15), "{found:?}");
        assert_eq!(found.len(), expected.len());
    };
    // (0.3 + 0.4i)^2 = 0.09 - 0.16 + 0.24i.
    let pair = "kind = \"luenberger\"\npoles = [[0.3, 0.4], [0.3, -0.4]]";
    near(&poles(pair, 2.0), &[[-0.07, 0.24], [-0.07, -0.24]]);
    // The square root of 0.64; a negative pole keeps its sign, whatever the factor is.
    near(&poles("kind = \"luenberger\"\npoles = [0.64, -0.25]", 0.5), &[[0.8, 0.0], [-0.5, 0.0]]);
    near(&poles("kind = \"reduced-order\"\npoles = [0.9]", 3.0), &[[0.729, 0.0]]);
    near(&poles("kind = \"functional\"\nk = [[0, 1]]\npoles = [0.5]", 2.0), &[[0.25, 0.0]]);
    // With x1 known at the start the error of x2 is z^(k f) at sample k. No design is refused for poles beyond 1.
    let swept = "[sweep]\nparameter = \"poles\"\nvalues = [0.5, 1, 2]\n";
    let results = run(&(text("kind = \"reduced-order\"\npoles = [0.9]") + swept));
    let rows = &results.sweep.as_ref().unwrap().rows;
    assert!(rows.iter().all(|row| row.failure.is_none() && row.finished == 1), "{rows:?}");
    for row in rows {
        let last = row.states[1].last;
        assert!((last.abs() - 0.9_f64.powf(20.0 * row.value)).abs() < 1e-9, "{row:?}");
    }
}
