//! Plants in discrete time, `x+ = f(x, u)` with `dt`: gains, certificates, runs, logs of other kinds, and mistakes.
//!
//! Expected numbers: scipy 1.17.1 (`solve_discrete_are`), python-control 0.10.2 (`place`), filterpy 2.0.0
//! (`ExtendedKalmanFilter`), and the recursions of plant and predictor written out in numpy.

use luenberger_study::{RunOptions, Step, execute};

use crate::studies::{executed, last_errors, mistake, scratch, study};

const LINEAR: &str = r#"[plant]
a = [[0.9, 0.2], [-0.1, 0.8]]
b = [[0], [0.5]]
c = [[1, 0]]
d = [[0.3]]
dt = 0.1
[input]
expressions = ["sin(4*t)"]
[simulation]
x0 = [1, -1]
duration = 2
[[observer]]
name = "kalman"
kind = "kalman"
w = [[0.01, 0], [0, 0.02]]
v = 0.05
[[observer]]
name = "poles"
kind = "luenberger"
poles = [0.3, 0.4]
[[observer]]
name = "cubic"
kind = "sampled-cubic"
poles = [0.3, 0.4]
gamma = 1
period = 0.1
[[observer]]
name = "filter"
kind = "extended-kalman"
w = [[0.01, 0], [0, 0.02]]
v = 0.05
period = 0.1
"#;

#[test]
fn linear_kinds_in_discrete_time() {
    let results = executed(LINEAR, Step::Run);
    assert_eq!(results.failures(), Vec::<String>::new());
    assert_eq!(results.plant.equations, ["x+ = A x + B u", "y = C x + D u"]);
    assert_eq!(results.observability.as_ref().unwrap().rank, 2);
    let gain = |name: &str| {
        let observer = results.observers.iter().find(|observer| observer.name == name).unwrap();
        let design = observer.design.as_ref().unwrap();
        assert_eq!(design.verdict.word(), "proved", "{name}");
        design.matrices.iter().find(|matrix| matrix.name == "L").unwrap().rows.concat()
    };
    for (name, expected) in [("kalman", KALMAN), ("poles", [1.0, 0.9])] {
        for (found, expected) in gain(name).iter().zip(expected) {
            assert!((found - expected).abs() < 1e-12, "{name}: {found}, expected {expected}");
        }
    }
    for (name, expected) in [("kalman", KALMAN_LAST), ("poles", POLES_LAST)] {
        for (found, expected) in last_errors(&results, name).iter().zip(expected) {
            assert!((found.abs() - expected.abs()).abs() < 1e-12, "{name}: {found}, expected {expected}");
        }
    }
    assert!(last_errors(&results, "cubic").iter().all(|error| error.abs() < 1e-6));
    assert!(last_errors(&results, "filter").iter().all(|error| error.abs() < 0.1));
    assert!(results.warnings.iter().all(|warning| !warning.contains("zero-order hold")), "{:?}", results.warnings);
}

const KALMAN: [f64; 2] = [0.361_225_279_609_857_5, 0.073_416_536_244_710_3];
const KALMAN_LAST: [f64; 2] = [0.000_492_198_221_457_2, 0.001_111_287_774_005_4];
const POLES_LAST: [f64; 2] = [-6.572_662_28e-8, -1.644_385_945e-7];

const FILTER: &str = r#"
[[observer]]
name = "filter form"
kind = "kalman"
w = [[0.01, 0], [0, 0.02]]
v = 0.05
form = "filter"
"#;

/// scipy and filterpy: `KalmanFilter` with P of `solve_discrete_are`, `update` on y - D u, then `predict`, 21 samples.
#[test]
fn a_kalman_filter_in_filter_form_uses_the_measurement_of_its_sample() {
    let near = |found: &[f64], expected: &[f64]| {
        assert_eq!(found.len(), expected.len());
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-12, "{found}, expected {expected}");
        }
    };
    let found = executed(&format!("{LINEAR}{FILTER}"), Step::Run);
    assert_eq!(found.failures(), Vec::<String>::new());
    let design = |name: &str| {
        let observer = found.observers.iter().find(|observer| observer.name == name).unwrap();
        observer.design.as_ref().unwrap()
    };
    let matrix = |start: &str| {
        let matrices = &design("filter form").matrices;
        matrices.iter().find(|matrix| matrix.name.starts_with(start)).unwrap().rows.concat()
    };
    near(&matrix("K"), &[0.370_671_508_701_275_6, 0.138_104_608_893_547_28]);
    near(&matrix("L"), &KALMAN);
    near(&matrix("(I - K C) P"), &FILTER_COVARIANCE);
    near(&last_errors(&found, "filter form"), &[0.000_309_754_364_129_610_8, 0.001_043_312_931_132_911_5]);
    // The certificate is that of the predictor.
    assert_eq!(design("filter form").facts, design("kalman").facts);
    assert_eq!(design("filter form").verdict.word(), "proved");

    // A measurement every other sample: the others are predicted.
    let sensor = "[[simulation.sensor]]\noutput = \"y1\"\nperiod = 0.2\n[[observer]]\nname = \"kalman\"";
    let slow = format!("{LINEAR}{FILTER}").replacen("[[observer]]\nname = \"kalman\"", sensor, 1);
    near(
        &last_errors(&executed(&slow, Step::Run), "filter form"),
        &[0.003_392_604_783_030_273, 0.006_446_077_977_559_139],
    );

    // u = r - K xhat(k|k).
    let fed = format!("{LINEAR}{FILTER}")
        .replace("[simulation]", "feedback = { k = [[0.2, 0.4]], observer = \"filter form\" }\n[simulation]");
    let folder = scratch("filter-form");
    let options = RunOptions { output: Some(folder.clone()), ..RunOptions::default() };
    execute(&study(&fed), Step::Simulate, &options).unwrap_or_else(|error| panic!("{error}"));
    let text = std::fs::read_to_string(folder.join("trajectories/filter-form.csv")).unwrap();
    let rows: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(rows[0], ["t", "x1", "x2", "u1", "y1", "x1_hat", "x2_hat", "x1_2sigma", "x2_2sigma"]);
    let row: Vec<f64> = rows.last().unwrap().iter().map(|cell| cell.parse().unwrap()).collect();
    near(&[row[1], row[2], row[5], row[6], row[3]], &FED);
}

const FILTER_COVARIANCE: [f64; 4] =
    [0.018_533_575_435_063_784, 0.006_905_230_444_677_365, 0.006_905_230_444_677_364, 0.048_792_118_982_331_684];
/// States, estimates and input at the last sample.
const FED: [f64; 5] = [
    -0.315_632_371_605_961_8,
    0.991_196_912_691_570_4,
    -0.315_942_125_970_091_3,
    0.990_153_599_760_437_6,
    0.656_485_231_913_224_9,
];

#[test]
fn an_extended_kalman_filter_of_a_map() {
    let text = r#"[plant]
f = ["x1 + 0.1*x2", "x2 - 0.981*sin(x1) + 0.1*u1"]
h = ["sin(x1)"]
dt = 0.1
[input]
expressions = ["cos(3*t)"]
[simulation]
x0 = [0.3, 0.1]
duration = 2.5
estimates = "predicted"
[[observer]]
name = "ekf"
kind = "extended-kalman"
w = [1e-3, 1e-2]
v = 0.01
period = 0.1
"#;
    let results = executed(text, Step::Run);
    assert_eq!(results.plant.equations[0], "x1+ = x1 + 0.1*x2");
    for (found, expected) in last_errors(&results, "ekf").iter().zip(EKF_LAST) {
        assert!((found.abs() - expected.abs()).abs() < 1e-12, "{found}, expected {expected}");
    }
}

const EKF_LAST: [f64; 2] = [5.876_228_554_93e-5, -1.533_059_718_29e-5];

const PENDULUM: &str = r#"[plant]
f = ["x1 + 0.1*x2", "x2 - 0.981*sin(x1) + 0.1*u1"]
h = ["x1"]
dt = 0.1
[input]
expressions = ["0.2*cos(3*t)"]
[simulation]
x0 = [0.3, 0.1]
duration = 1
"#;

/// One gain for all Jacobians of a map, given and designed.
#[test]
fn one_gain_for_a_map() {
    let observer = "[[observer]]\nkind = \"lpv\"\n";
    let region = "region = { states = [[-0.5, 0.5], [-5, 5]], inputs = [[-1, 1]] }\n";
    let given = executed(&format!("{PENDULUM}{observer}{region}gain = [[1], [2]]\n"), Step::Run);
    assert_eq!(given.failures(), Vec::<String>::new());
    for (found, expected) in last_errors(&given, "lpv").iter().zip(LPV_LAST) {
        assert!((found.abs() - expected.abs()).abs() < 1e-15, "{found}, expected {expected}");
    }
    let designed = executed(&format!("{PENDULUM}{observer}{region}decay_rate = 10\n"), Step::Design);
    let design = designed.observers[0].design.as_ref().unwrap();
    assert_eq!(design.verdict.word(), "proved");
    assert!(design.statement.contains("q^k with q = 0.36788"), "{}", design.statement);
    let fastest = executed(&format!("{PENDULUM}{observer}{region}fastest = 60\n"), Step::Design);
    let design = fastest.observers[0].design.as_ref().unwrap();
    let rate = design.numbers.iter().find(|number| number.name == "rate").unwrap().value;
    assert!(design.verdict.word() == "proved" && rate > Some(10.0) && design.evidence.is_some(), "{design:?}");
}

/// Python: `xhat+ = f(xhat, u) + L (x1 - xhat1)` from 0, beside the plant.
const LPV_LAST: [f64; 2] = [0.000_790_651_868_394_665_1, 0.007_163_783_207_754_848];

/// What cannot be is refused with the vertices, and other kinds are offered that exist in discrete time.
#[test]
fn no_gain_for_a_map() {
    let region = "region = { states = [[-0.5, 0.5], [-5, 5]], inputs = [[-1, 1]] }\n";
    for (keys, words, instead) in [
        ("gain = [[0], [0]]\n", "an eigenvalue that is not inside the unit circle", "decay_rate = 0 in place of gain"),
        ("decay_rate = 1e3\n", "LMI infeasible at decay rate 1000", "extended-kalman"),
    ] {
        let failed = executed(&format!("{PENDULUM}[[observer]]\nkind = \"lpv\"\n{region}{keys}"), Step::Design);
        let failure = failed.observers[0].failure.as_ref().unwrap();
        assert!(failure.hypothesis.contains(words), "{failure:?}");
        assert!(failure.alternatives.iter().any(|way| way.words().contains(instead)), "{failure:?}");
        assert!(failure.alternatives.iter().all(|way| !way.words().contains("lipschitz")), "{failure:?}");
    }
}

/// Every other kind says that it is for continuous time.
#[test]
fn other_kinds_say_so() {
    let plant = "[plant]\nf = [\"x1 + 0.1*x2\", \"x2 - 0.1*sin(x1)\"]\nh = [\"x1\"]\ndt = 0.1\n[simulation]\nx0 = [1, 0]\nduration = 1\n";
    for kind in [
        "kind = \"lipschitz\"\ndecay_rate = 1",
        "kind = \"mean-value\"\nregion = { states = [[-2, 2], [-2, 2]] }",
        "kind = \"high-gain\"\nr = 0.1\nchains = [2]",
        "kind = \"kkl-numerical\"\ndomain = [[-2, 2], [-2, 2]]\ncutoff = 1",
        "kind = \"cubic\"\ngain = [[0.5], [0.5]]\ngamma = 1",
    ] {
        let results = executed(&format!("{plant}[[observer]]\n{kind}\n"), Step::Design);
        let failure = results.observers[0].failure.clone().unwrap_or_else(|| panic!("{kind} fits"));
        assert!(
            failure.hypothesis.contains("is for plants in continuous time, and this one has dt = 0.1"),
            "{}",
            failure.hypothesis
        );
        assert!(failure.alternatives.iter().any(|way| way.words().contains("extended-kalman")), "{failure:?}");
    }
    for (old, new, words) in [
        (
            "poles = [0.3, 0.4]\n[[observer]]",
            "decay_rate = 1\n[[observer]]",
            "`decay_rate` and `lmi` are for plants in continuous time",
        ),
        (
            "poles = [0.3, 0.4]\n[[observer]]",
            "gain = [[0], [0]]\nrho = 2\n[[observer]]",
            "`rho` and `q` are for plants in continuous time",
        ),
        (
            "poles = [0.3, 0.4]\n[[observer]]",
            "gain = [[3], [0]]\n[[observer]]",
            "A - L C has an eigenvalue that is not inside the unit circle",
        ),
        (
            "gamma = 1\nperiod = 0.1",
            "gamma = 1\nperiod = 0.2",
            "period = 0.2, and the plant is in discrete time with dt = 0.1",
        ),
    ] {
        let text = LINEAR.replace(old, new);
        assert!(text != LINEAR, "{old}");
        let results = executed(&text, Step::Design);
        let failures: Vec<_> = results.observers.iter().filter_map(|observer| observer.failure.clone()).collect();
        assert!(failures.iter().any(|failure| failure.hypothesis.contains(words)), "{new}: {failures:?}");
    }
}

#[test]
fn mistakes_have_their_place() {
    for (old, new, line, message) in [
        ("dt = 0.1", "dt = 0", 6, "`dt` is 0"),
        ("poles = [0.3, 0.4]", "poles = [0.3, -1]", 20, "the pole -1 is not inside the unit circle"),
        ("duration = 2\n", "duration = 2\nhold = 0.05\n", 12, "`hold` differs from `dt` = 0.1"),
        ("[input]", "[operating_point]\n[input]", 7, "[operating_point] is for plants in continuous time"),
    ] {
        let found = mistake(&LINEAR.replacen(old, new, 1));
        assert!(found.message.contains(message), "{new}: {found:?}");
        assert_eq!(found.line, line, "{new}: {found:?}");
    }
    let builtin = mistake("[plant]\nbuiltin = \"cuk\"\ndt = 0.1\n");
    assert!(builtin.message.contains("the plants of the library are in continuous time"), "{builtin:?}");
}
