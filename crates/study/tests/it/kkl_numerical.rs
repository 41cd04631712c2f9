//! Numerical KKL observers in studies: what is chosen where only the domain is given, inputs that are held, four and
//! five states, their exports, and what is refused.

use std::sync::atomic::AtomicBool;

use luenberger_export::{Scalar, golden};
use luenberger_study::deployment;
use luenberger_study::design::design;
use luenberger_study::results::{DesignReport, Results};
use luenberger_study::{RunOptions, Step, execute};

use crate::studies::{designed, mistakes, study};

const VAN_DER_POL: &str = r#"
[plant]
states = ["x", "v"]
f = ["v", "(1 - x^2)*v - x"]
h = ["x"]
[[observer]]
kind = "kkl-numerical"
domain = [[-2.3, 2.3], [-3, 3]]
points = 33
leaves = 16
samples = 2000
"#;

#[test]
fn what_was_chosen_is_reported_with_the_other_candidates() {
    let study = study(VAN_DER_POL);
    let designed = design(&study, &study.observers[0], &AtomicBool::new(false)).unwrap();
    let cutoff = designed.report.number("cutoff").unwrap();
    assert!(cutoff > 4.0, "slower filters are refused: {cutoff}");
    assert_eq!(designed.report.number("grid points per axis"), Some(33.0));
    let evidence = designed.report.evidence.unwrap();
    for part in [
        "points that were not used in the fit. Chosen: cutoff = ",
        "escape = 1 (a trajectory is unbounded backward in time)",
        "Coarse designs: cutoff ",
        "refused (the table does not resolve T)",
        "on 33 points: error ",
    ] {
        assert!(evidence.contains(part), "{part}\n{evidence}");
    }
    // The points are given: there is nothing to say of them.
    assert!(!evidence.contains("points = "), "{evidence}");
}

/// The results of a run, and the largest error that its design has measured, over the states.
fn simulated(text: &str) -> (Results, f64) {
    let results = execute(&study(text), Step::Simulate, &RunOptions::default()).unwrap();
    assert_eq!(results.failures(), Vec::<String>::new());
    let measured = results.observers[0].design.as_ref().map(largest_error);
    (results, measured.unwrap_or(f64::NAN))
}

/// The largest measured error of the left inverse, over the states.
fn largest_error(report: &DesignReport) -> f64 {
    let errors = report.numbers.iter().filter(|number| number.name.starts_with("largest error of the left inverse, "));
    errors.filter_map(|number| number.value).fold(0.0, f64::max)
}

/// The largest error of the estimate between two times.
fn error_of_run(results: &Results, (from, to): (f64, f64)) -> f64 {
    let run = &results.runs[0];
    let estimate = run.estimate.as_ref().unwrap();
    let rows = (0..run.t.len()).filter(|&k| run.t[k] >= from && run.t[k] <= to);
    rows.map(|k| (estimate.row(k) - run.x.row(k)).amax()).fold(0.0, f64::max)
}

/// Duffing's oscillator with a held force u: x'' = -x - x^3/2 + u, on orbits around its equilibrium for u.
pub(crate) const FORCED: &str = r#"
[plant]
f = ["x2", "-x1 - 0.5*x1^3 + u1"]
h = ["x1"]
[input]
law = ["if(t < 15, 0.4, if(t < 30, -0.3, 0.9))"]
jumps = [15, 30]
[simulation]
x0 = [0.5, 0.1]
duration = 45
samples = 451
[[observer]]
kind = "kkl-numerical"
domain = [[-1.5, 1.5], [-1.5, 1.5]]
inputs = [[-0.5, 0.5]]
nodes = 4
cutoff = 3
points = 17
leaves = 8
samples = 1000
"#;

/// The inputs of the run, 0.4 and -0.3, are not among the nodes -0.5, -0.25, 0.25, 0.5. The estimate follows the truth
/// within the largest error that the design has measured at other pairs of state and input; a jump of the input is a
/// new transient, and outside of the family the error does not tend to zero.
#[test]
fn an_observer_for_held_inputs_follows_between_the_nodes() {
    let (results, bound) = simulated(FORCED);
    let tables = results.observers[0].design.as_ref().unwrap().number("inputs with a table");
    assert_eq!(tables, Some(4.0));
    assert!(bound < 0.02, "{bound}");
    let error = |from, to| error_of_run(&results, (from, to));
    let (first, jump, second, outside) = (error(8.0, 14.9), error(15.1, 17.0), error(23.0, 29.9), error(38.0, 45.0));
    assert!(first < bound && second < bound, "{first:e} {second:e} {bound:e}");
    assert!(jump > 5.0 * second && outside > 5.0 * bound, "{jump:e} {second:e} {outside:e} {bound:e}");
    let warning = "where u1 = 0.9 is not in [-0.5, 0.5]";
    assert!(results.warnings.iter().any(|said| said.contains(warning)), "{:?}", results.warnings);
}

/// More nodes: a smaller error between them. The embedded form is measured, too.
#[test]
fn the_error_between_the_nodes_falls_with_their_number() {
    let error = |nodes: usize| {
        let text = FORCED.replace("nodes = 4", &format!("nodes = {nodes}\nform = \"embedded\""));
        let study = study(&text.replace("points = 17", "points = 13"));
        designed(&study).unwrap().report.number("largest error of the table").unwrap()
    };
    let (two, three) = (error(2), error(3));
    assert!(three < 0.5 * two, "{two:e} {three:e}");
}

/// Two oscillators with cubic springs, coupled; only the first position is measured.
pub(crate) const COUPLED: &str = r#"
[plant]
f = ["x2", "-1.5*x1 - 0.2*x1^3 + 0.5*x3", "x4", "-2.5*x3 - 0.2*x3^3 + 0.5*x1"]
h = ["x1"]
[simulation]
x0 = [0.4, 0, -0.3, 0.2]
duration = 30
samples = 301
[[observer]]
kind = "kkl-numerical"
domain = [[-0.6, 0.6], [-0.8, 0.8], [-0.6, 0.6], [-0.8, 0.8]]
cutoff = 3
points = 6
leaves = 2
degree = 3
samples = 1000
"#;

#[test]
fn four_states_are_followed_within_the_measured_error() {
    let (results, bound) = simulated(COUPLED);
    let error = error_of_run(&results, (15.0, 30.0));
    assert!(error < bound && bound < 0.2, "{error:e} {bound:e}");
}

/// An oscillator with a weak cubic spring, moved by a sine and a force that decays slowly; its position is measured.
const DISTURBED: &str = r#"
[plant]
states = ["x1", "x2", "x3", "x4", "x5"]
f = ["x2", "-x1 - 0.1*x1^3 - 0.2*x2 + x3 + x5", "2*x4", "-2*x3", "-0.05*x5"]
h = ["x1"]
[simulation]
x0 = [0.2, 0.1, 0.2, 0, 0.1]
duration = 12
samples = 121
[[observer]]
kind = "kkl-numerical"
domain = [[-0.5, 0.5], [-0.8, 0.8], [-0.3, 0.3], [-0.3, 0.3], [-0.2, 0.2]]
cutoff = 4
points = 5
rank = 8
leaves = 1
degree = 2
samples = 500
"#;

/// Five states with a table of low rank: the estimate follows within the measured error, and so do the exported steps.
#[test]
fn five_states_are_followed_with_a_table_of_low_rank() {
    let (results, bound) = simulated(DISTURBED);
    let report = results.observers[0].design.as_ref().unwrap();
    let of = |name: &str| report.number(name).unwrap();
    // 3182, of which 1500 judge; the full grid has 3125 points.
    assert!(of("largest rank of the table") <= 8.0 && of("trajectories of the table") < 4000.0, "{report:?}");
    let error = error_of_run(&results, (8.0, 12.0));
    assert!(error < bound && bound < 0.05, "{error:e} {bound:e}");
    let (first, own) = exported(DISTURBED, Scalar::Binary64, (0.7, 1.0));
    assert!(first < 0.3 * own.max(1e-3), "{first:e} {own:e}");
}

/// Two inputs, held at 0.2 and 0.05: the nodes are the ends of their ranges.
#[test]
fn three_states_with_two_held_inputs_are_followed() {
    let text = r#"
[plant]
f = ["x2", "-x1 - 0.05*x1^3 + x3 + u1", "-0.05*x3 + u2"]
h = ["x1"]
[input]
law = ["0.2", "0.05"]
[simulation]
x0 = [0.3, 0.1, 0.2]
duration = 3
samples = 31
[[observer]]
kind = "kkl-numerical"
initial = [0.3, 0.1, 0.2]
domain = [[-2, 2], [-2, 2], [-1, 1]]
inputs = [[-0.3, 0.3], [-0.1, 0.1]]
nodes = 2
cutoff = 4
points = 5
leaves = 1
degree = 2
samples = 300
"#;
    let (results, bound) = simulated(text);
    assert_eq!(results.observers[0].design.as_ref().unwrap().number("inputs with a table"), Some(4.0));
    // Several time constants of the filter later.
    let error = error_of_run(&results, (2.0, 3.0));
    assert!(error < bound && bound < 0.02, "{error:e} {bound:e}");
}

/// Position x and velocity v in a double well, x'' = x - x^3, in the coordinates a = (x + v)/2 and b = (x - v)/2. The
/// square of the position is measured, which is the same in both wells. `inside` is a part of the right one, bounded by
/// an orbit: v^2/2 - x^2/2 + x^4/4 <= -0.05.
const WELL: &str = r#"
[plant]
states = ["a", "b"]
f = ["a - (a + b)^3/2", "(a + b)^3/2 - b"]
h = ["(a + b)^2"]
[simulation]
x0 = [0.6, 0.6]
duration = 20
samples = 201
[[observer]]
kind = "kkl-numerical"
initial = [0.4, 0.5]
domain = [[-0.3, 1.1], [-0.3, 1.1]]
inside = ["(a + b)^4/4 - 2*a*b <= -0.05", "a + b >= 0"]
cutoff = 4
points = 33
leaves = 16
samples = 2000
"#;

/// The box has states of both wells, which y does not tell apart; the part of it that the inequalities leave has not.
#[test]
fn a_region_that_is_no_box_is_given_by_inequalities() {
    let (results, bound) = simulated(WELL);
    let error = error_of_run(&results, (10.0, 20.0));
    assert!(error < bound && bound < 0.01, "{error:e} {bound:e}");
    // The transient of the estimate leaves the region, the state does not.
    let [warning] = &results.warnings[..] else { panic!("{:?}", results.warnings) };
    assert!(warning.contains("where the estimate does not satisfy (a + b)^4/4 - 2*a*b <= -0.05"), "{warning}");

    let whole = study(&WELL.replace("inside = [\"(a + b)^4/4 - 2*a*b <= -0.05\", \"a + b >= 0\"]\n", ""));
    let refused = design(&whole, &whole.observers[0], &AtomicBool::new(false)).unwrap_err();
    assert!(refused.hypothesis.contains("T is not injective"), "{}", refused.hypothesis);
    assert!(refused.advice().join("; ").contains("a part of it by `inside`"), "{:?}", refused.advice());

    // An orbit around the region, 1.4 times as far from the top of the hill as it: energy -0.0196.
    let (results, _) = simulated(&WELL.replace("x0 = [0.6, 0.6]", "x0 = [0.7, 0.7]"));
    let warning = "first at t = 0, where (a + b)^4/4 - 2*a*b <= -0.05 does not hold";
    assert!(results.warnings.iter().any(|said| said.contains(warning)), "{:?}", results.warnings);
}

/// The steps of a target follow the observer of a region that is no box.
#[test]
fn a_region_that_is_no_box_is_exported() {
    let (first, own) = exported(WELL, Scalar::Binary64, (0.5, 1.0));
    assert!(first < 0.3 * own.max(1e-3), "{first:e} {own:e}");
}

#[test]
fn what_has_no_table_is_refused_with_its_memory() {
    let refused = |text: &str| {
        let study = study(text);
        match design(&study, &study.observers[0], &AtomicBool::new(false)) {
            Err(failure) => (failure.hypothesis.clone(), failure.advice().join("; ")),
            other => panic!("{other:?}"),
        }
    };
    let (hypothesis, alternative) = refused(&FORCED.replace("inputs = [[-0.5, 0.5]]\nnodes = 4\n", ""));
    assert!(hypothesis.contains("needs their range, `inputs`; this plant has 1 input"), "{hypothesis}");
    assert!(alternative.contains("hint: inputs = [[lower, upper]], if"), "{alternative}");

    let seven = DISTURBED
        .replace("\"x5\"]\nf", "\"x5\", \"x6\", \"x7\"]\nf")
        .replace("\"-0.05*x5\"", "\"-0.05*x5\", \"x7\", \"-x6\"")
        .replace("0, 0.1]", "0, 0.1, 0, 0]")
        .replace("[-0.2, 0.2]]", "[-0.2, 0.2], [-1, 1], [-1, 1]]");
    let (hypothesis, _) = refused(&seven);
    assert!(hypothesis.contains("of 2 to 6 states") && hypothesis.ends_with("has 7 states"), "{hypothesis}");

    let (hypothesis, alternative) = refused(&DISTURBED.replace("rank = 8", "rank = 1"));
    assert!(hypothesis.contains("of the width of T") && alternative.contains("`rank`"), "{hypothesis} {alternative}");

    // 52^4 = 7311616 coefficients of 5 numbers; 45^4 < 2^22 < 46^4.
    let (hypothesis, alternative) = refused(&COUPLED.replace("points = 6", "points = 50"));
    assert!(hypothesis.contains("7310000 coefficients, 292 MB"), "{hypothesis}");
    assert!(hypothesis.contains("which is 43 points per axis"), "{hypothesis}");
    assert!(alternative.contains("fewer `points`"), "{alternative}");

    // All tables of a family count: 33 of 402^2 coefficients.
    let (hypothesis, alternative) =
        refused(&FORCED.replace("points = 17", "points = 400").replace("nodes = 4", "nodes = 33"));
    assert!(hypothesis.contains("5330000 coefficients"), "{hypothesis}");
    assert!(alternative.contains("fewer `points` or `nodes`"), "{alternative}");

    // y = x1^2 does not tell (x1, x2) from (-x1, -x2) without a force: the first node is named.
    let folded = FORCED.replace("h = [\"x1\"]", "h = [\"x1^2\"]").replace(" + u1", " + 0*u1");
    let (hypothesis, _) = refused(&folded);
    assert!(hypothesis.contains("at the held input u = [-0.5]: T is not injective"), "{hypothesis}");
}

#[test]
pub(crate) fn bad_settings_are_reported_at_their_place() {
    let ranges = "inputs = [[-0.5, 0.5]]\nnodes = 4";
    for (text, from, to, message, expected) in [
        (DISTURBED, "rank = 8", "rank = 33", "`rank` is 33", "at most 32"),
        (DISTURBED, "rank = 8", "rank = 0", "`rank` is 0", "at least 1"),
        (COUPLED, "leaves = 2", "rank = 8", "`rank` for a plant with 4 states", "all points of the grid"),
        (FORCED, ranges, "inputs = [[0.2, -0.2]]", "pair 1 of `inputs` goes from 0.2 to -0.2", "lower <= upper"),
        (FORCED, ranges, "inputs = [[-1, inf]]", "pair 1 of `inputs` is from -1 to inf", "finite ends"),
        (FORCED, ranges, "inputs = [[1, 1]]", "pair 1 of `inputs` is from 1 to 1", "the lower one less"),
        (FORCED, ranges, "inputs = [[-1, 1], [0, 1]]", "`inputs` has 2 pairs, and the plant has 1 input", "1 pair"),
        (FORCED, ranges, "inputs = [[-1, 1]]\nnodes = 1", "`nodes` is 1", "at least 2"),
        (FORCED, ranges, "inputs = [[-1, 1]]\nnodes = 100", "`nodes` is 100", "at most 33"),
        (FORCED, ranges, "nodes = 5", "`nodes` without `inputs`", "the range of each input"),
        (WELL, "a + b >= 0", "a + b", "`a + b` is no inequality between two numbers", "cannot be read"),
        (WELL, "a + b >= 0", "a + b == 0", "`a + b == 0` is no inequality", "cannot be read"),
        (WELL, "a + b >= 0", "a >= 0 && b >= 0", "`a >= 0 && b >= 0` is no inequality", "cannot be read"),
        (WELL, "a + b >= 0", "a + c >= 0", "there is no `c`", "cannot be read"),
        (WELL, "a + b >= 0", "a + b >= t", "`inside` depends on the time t", "without t"),
    ] {
        let text = text.replace(from, to);
        let found = mistakes(&text);
        assert!(found[0].message.contains(message), "{message}: {found:?}");
        assert!(format!("{} {:?}", found[0].expected, found[0].help).contains(expected), "{found:?}");
    }
}

/// Largest differences along the run of a study, of the exported step from the observer in continuous time and of that
/// observer from the truth, over the samples of these shares of the run.
fn exported(text: &str, scalar: Scalar, (from, to): (f64, f64)) -> (f64, f64) {
    let study = study(text);
    let observer = &study.observers[0];
    let sampled = deployment::sampled(&study, observer, Some(0.02), None).unwrap_or_else(|why| panic!("{why:?}"));
    let record = deployment::record(&study, observer, &sampled).unwrap();
    let export = deployment::exported(&study, observer, sampled.design, scalar, None).unwrap();
    let estimates = golden::replay(&export, &record.samples).unwrap();
    let rows = |share: f64| (share * estimates.len() as f64) as usize;
    let largest = |a: &[Vec<f64>], b: &[Vec<f64>]| {
        let both = a.iter().flatten().zip(b.iter().flatten()).skip(rows(from) * a[0].len());
        both.take((rows(to) - rows(from)) * a[0].len()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    };
    (largest(&estimates, &record.estimates), largest(&record.estimates, &record.states))
}

/// The step of the target follows the observer of the study, in both forms, at inputs between the nodes and after a
/// jump.
#[test]
fn held_inputs_are_exported_in_both_forms() {
    for (form, scalar) in [("interpolated", Scalar::Binary64), ("embedded", Scalar::Binary32)] {
        let text = FORCED.replace("nodes = 4", &format!("nodes = 4\nform = \"{form}\""));
        let text = text.replace("duration = 45\nsamples = 451", "duration = 29\nsamples = 291");
        let (first, own) = exported(&text, scalar, (0.3, 0.5));
        assert!(first < 0.3 * own.max(1e-3), "{form}: {first:e} {own:e}");
        // The input jumps at t = 15.
        let (second, own) = exported(&text, scalar, (0.85, 1.0));
        assert!(second < 0.3 * own.max(1e-3), "{form}: {second:e} {own:e}");
    }
}

#[test]
fn four_states_are_exported() {
    let study = study(&COUPLED.replace("points = 6", "points = 5\nform = \"embedded\""));
    let observer = &study.observers[0];
    let sampled = deployment::sampled(&study, observer, Some(0.02), None).unwrap_or_else(|why| panic!("{why:?}"));
    let export = deployment::exported(&study, observer, sampled.design, Scalar::Binary32, None).unwrap();
    let files = export.c().unwrap();
    assert!(files.iter().any(|file| file.text.contains("float z[5]; /**< Target states.")));
}
