//! Plants in discrete time, `x+ = f(x, u)` with `dt`: gains, certificates, runs, logs of other kinds, and mistakes.
//!
//! Expected numbers: scipy 1.17.1 (`solve_discrete_are`), python-control 0.10.2 (`place`), filterpy 2.0.0
//! (`ExtendedKalmanFilter`), and the recursions of plant and predictor written out in numpy.

use luenberger_export::Scalar;
use luenberger_observers::SampledObserver;
use luenberger_proof::statement::Format;
use luenberger_study::deployment::{self, SampledDesign};
use luenberger_study::{RunOptions, Step, execute};
use nalgebra::DVector;

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
    let options = RunOptions { output: Some(folder.clone().into()), ..RunOptions::default() };
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

/// The plant of `docs/commands/place.md`: the position of a double integrator and a bias are measured, and the error is
/// zero after two steps. L is that of the two deadbeat observers of the parts, (2, 1/dt) and 1.
#[test]
fn all_poles_at_zero_with_two_outputs() {
    let text = "[plant]\na = [[1, 0.1, 0], [0, 1, 0], [0, 0, 1]]\nc = [[1, 0, 0], [0, 0, 1]]\ndt = 0.1\n\
        [simulation]\nx0 = [1, -1, 2]\nduration = 0.2\n\
        [[observer]]\nname = \"deadbeat\"\nkind = \"luenberger\"\npoles = [0, 0, 0]\n";
    let results = executed(text, Step::Run);
    let design = results.observers[0].design.as_ref().unwrap();
    assert_eq!(design.verdict.word(), "proved");
    let l = design.matrices.iter().find(|matrix| matrix.name == "L").unwrap().rows.concat();
    for (found, expected) in l.iter().zip([2.0, 0.0, 10.0, 0.0, 0.0, 1.0]) {
        assert!((found - expected).abs() < 1e-12, "{l:?}");
    }
    assert!(last_errors(&results, "deadbeat").iter().all(|error| error.abs() < 1e-12));
    // One step earlier it is not.
    let earlier = executed(&text.replace("duration = 0.2", "duration = 0.1"), Step::Run);
    assert!(last_errors(&earlier, "deadbeat")[1].abs() > 1.0);
}

/// `x+ = 5/4 x`: the noise of covariance V leaves `X = L^2 V/(1 - (5/4 - L)^2)`, least for `L = 9/20`, the pole 4/5 and
/// `X = 9/16 V`; at a factor of 1/2 for `L = 3/4` and `X = 3/4 V`. The gain does not depend on V.
#[test]
fn the_least_noise_with_a_rate_in_closed_form() {
    let designed = |keys: &str| {
        let text = format!("[plant]\na = [[1.25]]\nc = [[1]]\ndt = 0.5\n[[observer]]\nkind = \"luenberger\"\n{keys}\n");
        executed(&text, Step::Design).observers[0].clone()
    };
    let half = 2.0 * 2f64.ln();
    for (rate, noise, l, x) in [
        (0.1, "[1]", 0.45, 9.0 / 16.0),
        (0.1, "[1e-14]", 0.45, 9.0 / 16.0),
        (0.1, "[1e8]", 0.45, 9.0 / 16.0),
        (half, "[1]", 0.75, 0.75),
        (half, "[1e-14]", 0.75, 0.75),
    ] {
        let observer = designed(&format!("decay_rate = {rate}\nnoise = {noise}"));
        let design = observer.design.unwrap_or_else(|| panic!("{:?}", observer.failure));
        assert_eq!(design.verdict.word(), "proved");
        let found = design.matrices[0].rows[0][0];
        assert!((found - l).abs() < 1e-3 * l, "{rate} {noise}: L = {found}");
        let gain = design.number("noise gain").unwrap();
        assert!((gain - f64::sqrt(x)).abs() < 1e-3, "{rate} {noise}: {gain}");
        // The factor of a step, rounded up.
        let said = design.statement.to_string();
        let factor: f64 =
            said.split("at least as fast as ").nth(1).unwrap().split("^k").next().unwrap().parse().unwrap();
        let exact = (-rate * 0.5).exp();
        assert!(factor >= exact && factor < exact * (1.0 + 1e-5), "{said}");
    }
    // |L| >= 3/4 for the factor 1/2.
    let bounded = designed(&format!("decay_rate = {half}\nmax_gain = 0.8"));
    let l = bounded.design.unwrap_or_else(|| panic!("{:?}", bounded.failure)).matrices[0].rows[0][0];
    assert!((0.75..0.8).contains(&l), "{l}");
    let failure = designed(&format!("decay_rate = {half}\nmax_gain = 0.7")).failure.unwrap();
    assert!(failure.hypothesis.contains("infeasible"), "{failure:?}");
    let failure = designed("decay_rate = 100").failure.unwrap();
    assert!(failure.hypothesis.contains("the decay rate times the period"), "{failure:?}");
    // The largest margin of the inequality alone.
    assert_eq!(designed("lmi = true").design.unwrap().verdict.word(), "proved");
}

/// A mode that no output sees falls by 0.9 at a step: slower than `exp(-2 dt)` for dt = 0.1, faster than `exp(-dt)`.
#[test]
fn a_hidden_mode_limits_the_rate() {
    let designed = |rate: &str| {
        let text = format!(
            "[plant]\na = [[0.5, 0], [0, 0.9]]\nc = [[1, 0]]\ndt = 0.1\n[[observer]]\nkind = \"luenberger\"\ndecay_rate = {rate}\n"
        );
        executed(&text, Step::Design).observers[0].clone()
    };
    assert_eq!(designed("1").design.unwrap().verdict.word(), "proved");
    let failure = designed("2").failure.unwrap();
    assert!(failure.hypothesis.contains("unobservable mode"), "{failure:?}");
    assert!(
        failure
            .alternatives
            .iter()
            .any(|way| way.words().contains("decay_rate = 1") || way.words().contains("lmi = true")),
        "{failure:?}"
    );
}

/// `x+ = x/2 + u + d`: for a constant d and both poles at zero `L = (3/2, 1)`, and the estimates are exact after two
/// samples; with d rising by `dt r` at a sample, they lag.
#[test]
fn disturbances_are_estimated_at_samples() {
    let plant = "[plant]\na = [[0.5]]\nb = [[1]]\nc = [[1]]\ndt = 0.1\n[input]\nexpressions = [\"sin(t)\"]\n\
        [truth]\nf = [\"0.5*x1 + u1 + 3\"]\nh = [\"x1\"]\n[simulation]\nx0 = [1]\nduration = 0.3\n[[observer]]\nname = \"o\"\n";
    for kind in ["kind = \"proportional-integral\"", "kind = \"extended-state\""] {
        let results = executed(&format!("{plant}{kind}\ne = [[1]]\npoles = [0, 0]\n"), Step::Run);
        let design = results.observers[0].design.as_ref().unwrap();
        assert_eq!(design.verdict.word(), "proved");
        let l = design.matrices[0].rows.concat();
        assert!((l[0] - 1.5).abs() < 1e-12 && (l[1] - 1.0).abs() < 1e-12, "{l:?}");
        let said = design.statement.to_string();
        assert!(
            said.contains(
                "For a constant disturbance d the errors of x and of d tend to 0, for all x(0), xhat(0) and d."
            ),
            "{said}"
        );
        assert!(last_errors(&results, "o")[0].abs() < 1e-12, "{:?}", last_errors(&results, "o"));
    }
}

/// The exactly sampled chain of two integrators, h = 1/10: `(z - 3/5)^3` for `A = [1 1 0; 0 1 h; 0 0 1]`,
/// `L = (6/5, 12/25, 0.064/h)` by hand: with `w = z - 1` the polynomial is `w^3 + l1 w^2 + l2 w + h l3`.
#[test]
fn a_ramp_is_estimated_in_units_of_time() {
    let plant = "[plant]\na = [[1]]\nc = [[1]]\ndt = 0.1\n[truth]\nf = [\"x1 + 2 + 5*t\"]\nh = [\"x1\"]\n\
        [simulation]\nx0 = [1]\nduration = 6\n[[observer]]\nname = \"o\"\nkind = \"extended-state\"\ne = [[1]]\norder = 2\n";
    // exp(-w h) = 3/5.
    let omega = -10.0 * 0.6f64.ln();
    for gain in ["poles = [0.6, 0.6, 0.6]".to_owned(), format!("bandwidth = {omega}")] {
        let results = executed(&format!("{plant}{gain}\n"), Step::Run);
        let design = results.observers[0].design.as_ref().unwrap();
        assert_eq!(design.verdict.word(), "proved");
        let l = design.matrices[0].rows.concat();
        for (found, expected) in l.iter().zip([1.2, 0.48, 0.64]) {
            assert!((found - expected).abs() < 1e-9, "{l:?}");
        }
        let said = design.statement.to_string();
        assert!(said.contains("For a disturbance d that is linear in t the errors of x and of d tend to 0"), "{said}");
        assert!(last_errors(&results, "o")[0].abs() < 1e-9, "{:?}", last_errors(&results, "o"));
    }
}

/// A disturbance at rest that no output sees has an invariant zero at 1: `x1+ = x2`, `x2+ = d`, `y = x2 - x1`.
#[test]
fn a_constant_disturbance_that_is_hidden_at_samples() {
    let observer = "[[observer]]\nkind = \"proportional-integral\"\ne = [[0], [1]]\n";
    let plant = "[plant]\na = [[0, 1], [0, 0]]\nc = [[-1, 1]]\ndt = 0.1\n";
    let results = executed(&format!("{plant}{observer}lmi = true\n"), Step::Design);
    let failure = results.observers[0].failure.clone().unwrap();
    assert!(failure.hypothesis.contains("A x + E d = x and C x = 0"), "{failure:?}");
    assert!(failure.hypothesis.contains("an invariant zero of (A, E, C) at 1"), "{failure:?}");
    let cubic = format!("{}{observer}poles = [0.1, 0.2, 0.3]\ngamma = 1\n", plant.replace("[[-1, 1]]", "[[1, 0]]"));
    let results = executed(&cubic, Step::Design);
    let failure = results.observers[0].failure.clone().unwrap();
    assert!(failure.hypothesis.contains("a cubic term, `gamma`, is for plants in continuous time"), "{failure:?}");
}

/// `e+ = e/2 + w - v/2`, |w| <= 1, |v| <= 1/5: 2.2 in the end, and no quadratic function is worse for one state. With d
/// moving by `rate dt` = 1/10 at a sample and both poles at 1/2: `e+ = F e + (0, 1) w`, F with the characteristic
/// polynomial `(z - 1/2)^2`, `F = [0 1; -1/4 1]`.
#[test]
fn errors_are_bounded_under_bounded_noise_at_samples() {
    let bounds = |results: &luenberger_study::Results, names: &[&str]| -> Vec<f64> {
        let observer = &results.observers[0];
        let design = observer.design.as_ref().unwrap_or_else(|| panic!("{:?}", observer.failure));
        assert_eq!(design.verdict.word(), "proved");
        let said = design.statement.to_string();
        assert!(
            said.contains("Under all noise and disturbances within `bounds`, the error in the end is at most"),
            "{said}"
        );
        names.iter().map(|name| design.number(&format!("bound of the error of {name}")).unwrap()).collect()
    };
    let plant = "[plant]\na = [[1]]\nc = [[1]]\ndt = 0.1\n[[observer]]\nname = \"o\"\n";
    let results = executed(
        &format!("{plant}kind = \"luenberger\"\npoles = [0.5]\nbounds = {{ noise = [0.2], disturbance = [1] }}\n"),
        Step::Design,
    );
    let found = bounds(&results, &["x1"])[0];
    assert!((2.2..2.203).contains(&found), "{found}");
    let text = format!(
        "{plant}kind = \"proportional-integral\"\ne = [[1]]\npoles = [0.5, 0.5]\nrate = [1]\nbounds = {{ noise = [0] }}\n"
    );
    // All bounds 0 but that of the rate.
    assert!(crate::studies::read(&text).is_err());
    let results = executed(&text.replace("noise = [0]", "noise = [1e-9]"), Step::Design);
    let found = bounds(&results, &["x1", "d1"]);
    // The largest errors are 0.4 both, by summing |F^k (0, 1)|/10 in numpy; the least weighted ellipsoid has 0.492 and
    // 0.4135, by scipy's solve_discrete_lyapunov over the factor.
    for (found, expected) in found.iter().zip([0.491_999_4, 0.413_483_3]) {
        assert!((found - expected).abs() < 0.003, "{found} {expected}");
    }
}

/// The step that is exported has the bits of the observer that runs, and a certificate.
#[test]
fn a_disturbance_at_samples_is_exported() {
    let text = "[plant]\na = [[1, 0.1], [0, 0.9]]\nb = [[0], [0.1]]\nc = [[1, 0]]\ndt = 0.1\n[simulation]\nx0 = [1, 0]\nduration = 2\n\
        [[observer]]\nname = \"o\"\nkind = \"extended-state\"\ne = [[0], [0.1]]\norder = 2\nbandwidth = 8\n";
    let (study, running) = (study(text), study(text));
    let designed = crate::studies::designed(&running).unwrap();
    let observer = &study.observers[0];
    let sampled = deployment::sampled(&study, observer, None, None).unwrap();
    let evidence = deployment::evidence(&study, observer, &sampled.design, Format::Binary64.into());
    // Of the plant with the chain among its states, which a sentence says.
    let said = evidence.sentences.join(" ");
    assert!(evidence.is_proved() && said.contains("e+ = (A - L C) e: for all x(0) and xhat(0)"), "{said}");
    assert!(said.contains("with disturbances whose derivative of order 2 is 0 among its states"), "{said}");
    let SampledDesign::Linear(step) = &sampled.design else { panic!("a linear step") };
    let mut state = DVector::from_vec(sampled.design.initial(observer));
    assert_eq!(state.len(), 4);
    for k in 0..20 {
        let (u, y) = ([0.3 - 0.1 * f64::from(k)], [(0.7 * f64::from(k)).sin()]);
        let next = designed.runnable.motion(0.1 * f64::from(k), state.as_slice(), &u, &y).unwrap();
        step.observer.step(0.0, &mut state, &DVector::from_column_slice(&u), &DVector::from_column_slice(&y));
        let bits = |all: &[f64]| all.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(state.as_slice()), bits(&next));
        assert_eq!(designed.runnable.estimate(0.0, &next, &u, &y).unwrap(), next[..2]);
    }
    let exported = deployment::exported(&study, observer, sampled.design, Scalar::Binary64, None).unwrap();
    assert_eq!(exported.observer().dimensions().state, 4);
}
