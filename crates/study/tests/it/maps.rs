//! KKL, PEB and [KKL+PEB] observers with given maps: designs, what is refused and why, and the expressions that are
//! exported beside the observers that run.

use luenberger_export::Scalar;
use luenberger_export::golden::Stepper;
use luenberger_proof::certificate::verify;
use luenberger_study::deployment;
use luenberger_study::design::Designed;
use luenberger_study::{Step, Study, execute};

use crate::messages;
use crate::studies::{designed, mistakes, read};

pub(crate) const PLANT: &str = r#"
[plant]
states = ["i1", "v2", "i3", "v4"]
f = ["(E - (1 - duty)*v2)/L1", "((1 - duty)*i1 + duty*i3)/C2", "(-duty*v2 - v4)/L3", "(i3 - G*v4)/C4"]
h = ["v2", "i3"]
parameters = { L1 = 0.01, C2 = 22.0e-6, L3 = 0.01, C4 = 22.9e-6, G = 0.0447, E = 12.0 }
inputs = ["duty"]
outputs = ["v2", "i3"]
[input]
expressions = ["0.5 + 0.1*sin(200*t)"]
[simulation]
x0 = [0.5, 24, -0.5, -12]
duration = 0.05
samples = 501
[[observer]]
region = { states = [[-5, 5], [0, 60], [-5, 5], [-60, 0]], inputs = [[0.2, 0.8]] }
initial = [0, 24, -0.5, 0]
"#;

pub(crate) const KKL: &str = r#"kind = "kkl"
phi = ["v4", "L1*i1 - C2*v2"]
lambda = ["-G/C4", "-(1 - duty)/L1"]
b = ["i3/C4", "E - duty*i3 - (1 + C2/L1)*(1 - duty)*v2"]
left_inverse = ["(xi2 + C2*v2)/L1", "v2", "i3", "xi1"]
"#;

pub(crate) const PEBO: &str = r#"kind = "pebo"
phi = ["i1", "v4 - G*L3/C4*i3"]
b = ["(E - (1 - duty)*v2)/L1", "(i3 + G*duty*v2)/C4"]
left_inverse = ["xi1", "v2", "i3", "xi2 + G*L3/C4*i3"]
s = ["v2", "i3"]
g = ["((1 - duty)*xi1 + duty*i3)/C2", "-(duty*v2 + xi2 + G*L3/C4*i3)/L3"]
m = ["(1 - duty)/C2", "-1/L3"]
alpha = 0.5
estimator = { kind = "gradient", gain = [0.001, 100] }
"#;

pub(crate) const BOTH: &str = r#"kind = "kkl-peb"
phi = ["i1", "v4"]
lambda = [0, "-G/C4"]
b = ["(E - (1 - duty)*v2)/L1", "i3/C4"]
left_inverse = ["xi1", "v2", "i3", "xi2"]
s = ["v2"]
g = ["((1 - duty)*xi1 + duty*i3)/C2"]
m = ["(1 - duty)/C2"]
alpha = 0.5
estimator = { kind = "gradient", gain = 0.001 }
"#;

const IMMERSION: &str = r#"kind = "immersion-invariance"
beta = ["chi1 + C2*50*v2", "chi2 - L3*i3"]
phi = ["i1", "v4"]
left_inverse = ["z1", "v2", "i3", "z2"]
"#;

/// Proposition 6's plant with its [KKL+PEB] observer.
pub(crate) const SIXTH: &str = r#"[plant]
f = ["exp(x3) - x1^3", "x1^2 + sin(x1) - x2", "1/(x1^2 + 1) + x1*u1"]
h = ["x1"]
[input]
expressions = ["-0.5 + 0.3*sin(t)"]
[simulation]
x0 = [0.5, 0.2, 0.1]
duration = 10
[[observer]]
kind = "kkl-peb"
region = { states = [[-2, 2], [-2, 2], [-1, 1]], inputs = [[-1, 1]] }
phi = ["x2", "x3"]
lambda = [-1, 0]
b = ["y1^2 + sin(y1)", "u1*y1 + 1/(y1^2 + 1)"]
left_inverse = ["y1", "xi1", "xi2"]
s = ["y1"]
g = ["-y1^3"]
m = ["exp(xi2)"]
missing = ["0", "ln(theta1)"]
theta = [[0.5, 2]]
theta_min = [1e-12]
theta_start = 1
alpha = 1
estimator = { kind = "gradient", gain = 5 }
"#;

fn study(observer: &str) -> Study {
    read(&format!("{PLANT}{observer}")).unwrap_or_else(|error| panic!("{error}"))
}

fn refused(text: &str) -> (String, String) {
    let study = read(text).unwrap_or_else(|error| panic!("{error}"));
    let results = execute(&study, Step::Design, &messages::all_alternatives()).unwrap();
    let failure = results.observers[0].failure.as_ref().unwrap_or_else(|| panic!("{:?}", results.observers[0]));
    messages::refusal(failure);
    (failure.hypothesis.clone(), failure.advice().join("; "))
}

fn number(designed: &Designed, name: &str) -> f64 {
    let found = designed.report.numbers.iter().find(|number| number.name == name);
    found.and_then(|number| number.value).unwrap_or_else(|| panic!("{name}: {:?}", designed.report.numbers))
}

fn facts(designed: &Designed) -> String {
    let lines: Vec<String> =
        designed.report.facts.iter().map(|fact| format!("{}: {}", fact.statement, fact.words)).collect();
    lines.join("\n")
}

/// The KKL observer of the converter: poles -G/C4 and -w/L1 at w = 1/2, everything proved over the region.
#[test]
fn the_maps_of_a_kkl_observer_are_proved_over_the_region() {
    let designed = designed(&study(KKL)).unwrap();
    assert_eq!(designed.report.verdict.word(), "proved");
    let mut poles: Vec<f64> = designed.report.poles.iter().map(|pole| pole[0]).collect();
    poles.sort_by(f64::total_cmp);
    for (found, expected) in poles.iter().zip([-0.0447 / 22.9e-6, -50.0]) {
        assert!((found / expected - 1.0).abs() < 1e-12, "{poles:?}");
    }
    let text = facts(&designed);
    for part in ["D phi f = Lambda phi + B: verified", "B does not depend on xi", "(phi, h) is injective: verified"] {
        assert!(text.contains(part), "{text}");
    }
    let file = designed.certificate.unwrap().file("KKLO").unwrap().to_json();
    assert!(file.contains("\"theorem\": \"kkl-error-bound\""), "{file}");
    let proved = verify(file.as_bytes()).unwrap();
    assert!(proved.statement.contains("xi' = Lambda(u, y) xi + B(u, y)"), "{}", proved.statement);
    // phi is exact: nothing is left of the error in the limit, and -w/L1 decays at 20 or faster for w >= 0.2.
    let limit = |state: &str| designed.report.number(&format!("guaranteed limit of the error of {state}"));
    assert!(["i1", "v2", "i3", "v4"].iter().all(|state| limit(state).is_some_and(|limit| limit < 1e-9)));
    let rate = designed.report.number("guaranteed rate of decay of V = sqrt(e'Pe)").unwrap();
    assert!(rate > 19.5 && rate < 20.0, "{rate}");
    assert!(
        designed.report.statement.contains("with e = xi - phi(x) and V = sqrt(e'Pe)"),
        "{}",
        designed.report.statement
    );
    // (i1, v4) to (L1 i1, v4): the least singular value of D(phi, h).
    let least = designed.report.numbers.iter().find(|number| number.name.contains("singular")).unwrap().value.unwrap();
    assert!((least - 0.01).abs() < 1e-6, "{least}");
}

/// The rates of the two estimators are exp(-gamma int M^2): the design measures int M'M, and with w = 1/2 and the
/// filter from zero, M = w (1 - exp(-alpha t))/C2 for the constant duty cycle.
#[test]
fn the_excitation_of_a_regression_is_that_of_its_regressor_in_closed_form() {
    let text = format!("{PLANT}{BOTH}").replace("0.5 + 0.1*sin(200*t)", "0.5");
    let designed = designed(&read(&text).unwrap()).unwrap();
    let (scale, alpha, end): (f64, f64, f64) = (0.5 / 22.0e-6, 0.5, 0.05);
    let integral = |a: f64| (1.0 - (-a * end).exp()) / a;
    let expected = scale * scale * (end - 2.0 * integral(alpha) + integral(2.0 * alpha));
    let found = number(&designed, "excitation delta along the run");
    assert!((found / expected - 1.0).abs() < 1e-5, "{found} {expected}");
    assert!(facts(&designed).contains("d s(y)/dt = g + m theta where phi(x) = xi + missing(theta): verified"));
}

#[test]
fn both_observers_of_the_converter_have_a_regression_and_only_one_a_certificate() {
    let (pebo, both) = (designed(&study(PEBO)).unwrap(), designed(&study(BOTH)).unwrap());
    assert!(pebo.certificate.is_none() && pebo.report.poles.is_empty());
    assert!(both.certificate.is_some() && (both.report.poles[0][0] + 0.0447 / 22.9e-6).abs() < 1e-9);
    assert!(pebo.report.statement.contains("phi(x) - xi is a constant"));
    let evidence = pebo.report.evidence.unwrap();
    assert!(evidence.contains("not proved for other runs"), "{evidence}");
    // Without a run there is nothing to measure.
    let text = format!("{PLANT}{BOTH}");
    let (before, rest) = text.split_once("[simulation]").unwrap();
    let without = designed_of(&format!("{before}{}", &rest[rest.find("[[observer]]").unwrap()..]));
    assert!(without.report.evidence.unwrap().contains("needs a run"));
}

fn designed_of(text: &str) -> Designed {
    designed(&read(text).unwrap_or_else(|error| panic!("{error}"))).unwrap()
}

/// Proposition 6: exp(x3) = exp(xi2) theta.
#[test]
fn what_theta_adds_may_be_nonlinear() {
    let designed = designed_of(SIXTH);
    // exp(xi2) theta = exp(x3) needs exp(a - ln b) = exp(a)/b, which the proof does not know.
    let evidence = designed.report.evidence.as_ref().unwrap();
    assert!(evidence.contains("is not proved: 273 sampled points have it") || evidence.contains("is not proved: 2"));
    let size = designed.runnable.dimensions();
    assert_eq!((size.state, size.estimate), (6, 3));
    // xi = (x2, x3) - (0, ln 1), w = y, filters at 0, theta = 1.
    let start = designed.runnable.initial(0.0, &[0.5, 0.3, -0.2], &[0.0], &[0.5]);
    assert_eq!(start.unwrap(), [0.3, -0.2, 0.5, 0.0, 0.0, 1.0]);
}

/// With g1 = 50 and g2 = 1 the distance obeys `d1' = -g1 (1 - u) d1`, `d2' = -(G/C4 + g2) d2`: proved for all u of the
/// region, with the eigenvalues of u = 1/2.
#[test]
fn the_manifold_of_an_immersion_attracts_over_the_region() {
    let designed = designed(&study(IMMERSION)).unwrap();
    assert_eq!(designed.report.verdict.word(), "proved", "{:?}", designed.report);
    let mut poles: Vec<f64> = designed.report.poles.iter().map(|pole| pole[0]).collect();
    poles.sort_by(f64::total_cmp);
    for (found, expected) in poles.iter().zip([-0.0447 / 22.9e-6 - 1.0, -25.0]) {
        assert!((found / expected - 1.0).abs() < 1e-12, "{poles:?}");
    }
    assert!(facts(&designed).contains("D_chi beta has full row rank (A4): verified"));
    assert!(designed.certificate.unwrap().file("I&I").unwrap().to_json().contains("hurwitz"));
    // The motion of chi is that of the paper: chi1' = -g1 (w (chi1 + C2 g1 v2) + u i3) + (E - w v2)/L1.
    let (chi, u, y) = ([0.3, -11.0], [0.4], [23.0, -0.6]);
    let motion = designed.runnable.motion(0.0, &chi, &u, &y).unwrap();
    let (w, v4) = (1.0 - u[0], chi[1] - 0.01 * y[1]);
    let first = -50.0 * (w * (chi[0] + 22.0e-6 * 50.0 * y[0]) + u[0] * y[1]) + (12.0 - w * y[0]) / 0.01;
    let second = (y[1] - 0.0447 * v4) / 22.9e-6 - (u[0] * y[0] + v4);
    assert!((motion[0] - first).abs() < 1e-9 * first.abs() && (motion[1] - second).abs() < 1e-9 * second.abs());
    // With gains that repel nothing is proved of the attractivity, and said so.
    let repelling = self::designed(&study(&IMMERSION.replace("C2*50*v2", "-C2*50*v2"))).unwrap();
    assert!(repelling.certificate.is_none() && repelling.report.verdict.word() == "measured");
    let statement = &repelling.report.statement;
    assert!(statement.contains("It is not to be expected that it attracts"), "{statement}");
    assert!(repelling.report.evidence.unwrap().contains("attracts (A5) is not proved"));
}

#[test]
pub(crate) fn maps_that_are_wrong_are_refused_with_the_place() {
    let with = |from: &str, to: &str, of: &str| {
        assert!(of.contains(from), "{from}");
        format!("{PLANT}{}", of.replace(from, to))
    };
    for (text, hypothesis, alternative) in [
        // A slip of the hand: the residual is C2/L1 w v2.
        (with("(1 + C2/L1)*", "", KKL), "phi does not solve D phi f = Lambda phi + B: the residual of row 2", "differ"),
        (with("(xi2 + C2*v2)/L1", "xi2/L1", KKL), "`left_inverse` is not a left inverse of phi: at i1 = ", "phi^L"),
        // v2 is between 0 and 60.
        (
            with("(xi2 + C2*v2)/L1", "(xi2 + C2*v2)/L1 + 0*ln(v2 - 5)", KKL),
            "`left_inverse` has no finite value at i1 = ",
            "a smaller `region`",
        ),
        (
            with("lambda = [\"-G/C4\", \"-(1 - duty)/L1\"]", "lambda = [0, \"-(1 - duty)/L1\"]", KKL)
                .replace("\"i3/C4\"", "\"i3/C4 - G/C4*xi1\""),
            "Lambda is not Hurwitz",
            "kkl-peb",
        ),
        (
            with("g = [\"((1 - duty)*xi1", "g = [\"(duty*xi1", BOTH),
            "row 1 of `s`, `g` and `m` is no regression: d s(y)/dt and g + m theta differ by at least",
            "the point named",
        ),
        (with("m = [\"(1 - duty)/C2\"]", "m = [\"(1 - duty)/C2*(1 + xi1)\"]", BOTH), "is no regression", "`missing`"),
        (
            with("m = [\"(1 - duty)/C2\"]", "m = [\"(1 - duty)/C2\"]\nwindow = 0.01", BOTH)
                .replace("0.5 + 0.1*sin(200*t)", "if(t < 0.02, 1, 0.5)")
                .replace("[[0.2, 0.8]]", "[[0.2, 1]]"),
            "not exciting along the run of [simulation]: over the 0.01 after t = 0 the least eigenvalue of int M'M is 0",
            "excites",
        ),
    ] {
        let (found, instead) = refused(&text);
        assert!(found.contains(hypothesis), "{found}\n{hypothesis}");
        assert!(instead.contains(alternative), "{instead}");
    }
    // (A4).
    let flat = IMMERSION
        .replace("[\"chi1 + C2*50*v2\", ", "[\"chi2 + C2*50*v2\", ")
        .replace("left_inverse", "start = [0, 0]\nleft_inverse");
    let (found, _) = refused(&format!("{PLANT}{flat}"));
    assert!(
        found.contains("D_chi beta does not have the rank 2 (A4): its least singular value is 0 at i1 = "),
        "{found}"
    );
    // No input, and none is named.
    let text = "[plant]\nf = [\"-x1\"]\nh = [\"x1\"]\n[[observer]]\nkind = \"kkl\"\nphi = [\"ln(x1)\"]\nlambda = [-2]\nb = [0]\nleft_inverse = [\"y1\"]\nregion = { states = [[-1, 1]] }\n";
    let (found, _) = refused(text);
    assert!(found.contains("has no value at the state [") && !found.contains("input"), "{found}");
    // Two states with one image.
    let folded = "[plant]\nf = [\"-x1\", \"-x2\"]\nh = [\"x1\"]\n[[observer]]\nkind = \"kkl\"\nphi = [\"x2^2\"]\nlambda = [-2]\nb = [0]\nleft_inverse = [\"y1\", \"sqrt(abs(xi1))\"]\nregion = { states = [[-1, 1], [-1, 1]] }\n";
    let (found, _) = refused(folded);
    assert!(found.contains("(phi, h) is not injective on the box"), "{found}");
}

#[test]
pub(crate) fn mistakes_in_maps_are_reported_at_their_place() {
    for (from, to, of, message, expected) in [
        ("phi = [\"v4\", ", "phi = [\"v5\", ", KKL, "there is no `v5`", "cannot be read"),
        // A state is no argument of B.
        ("b = [\"i3/C4\"", "b = [\"i1/C4\"", KKL, "there is no `i1`", "cannot be read"),
        ("b = [\"i3/C4\"", "b = [\"x1\"", KKL, "there is no `x1`", "cannot be read"),
        ("\"v2\", \"i3\", \"xi1\"]", "\"v2\", \"xi1\"]", KKL, "`left_inverse` has 3 expressions", "expected 4"),
        ("\"v2\", \"i3\", \"xi1\"]", "\"v2\", \"i3\", \"duty\"]", KKL, "there is no `duty`", "cannot be read"),
        ("lambda = [\"-G/C4\", ", "lambda = [", KKL, "the diagonal `lambda` has length 1", "expected 2 x 2"),
        (
            "lambda = [\"-G/C4\", ",
            "lambda = [[-1, 0], ",
            KKL,
            "row 2 of `lambda` is the text",
            "a matrix of expressions",
        ),
        ("lambda = [\"-G/C4\", ", "lambda = [true, ", KKL, "entry 1 of `lambda` is true", "an expression or a number"),
        ("lambda = [\"-G/C4\", ", "lambda = [\"-xi1\", ", KKL, "there is no `xi1`", "cannot be read"),
        ("kind = \"kkl\"\n", "kind = \"kkl\"\nalpha = 1\n", KKL, "`alpha` is not a key", "phi"),
        ("g = [", "g = [0, ", BOTH, "`g` has 2 expressions, and `s` has 1 row", "expected 1 expression"),
        (
            "m = [\"(1 - duty)/C2\"]",
            "m = [[1, 2]]",
            BOTH,
            "`m` has 2 columns, and Lambda has 1 row of zeros",
            "`missing`",
        ),
        ("alpha = 0.5", "alpha = 0", BOTH, "`alpha` is 0", "positive"),
        ("gain = 0.001", "gain = -1", BOTH, "Gamma", "positive gain"),
        ("kind = \"gradient\"", "kind = \"drem\"", BOTH, "no extension", "`forgetting` or `filters`"),
        (
            "kind = \"gradient\", ",
            "kind = \"drem\", filters = [1], ",
            PEBO,
            "1 number of `filters` make 4 equations",
            "`forgetting`",
        ),
        (
            "alpha = 0.5",
            "alpha = 0.5\ntheta_min = [0, 0]",
            BOTH,
            "`theta_min` has length 2, and `m` has 1 column",
            "length 1",
        ),
        (
            "alpha = 0.5",
            "alpha = 0.5\ntheta = [[0, 1], [0, 1]]",
            BOTH,
            "`theta` has 2 pairs, and the regression has 1",
            "1 pair",
        ),
        ("[\"chi1 + C2", "[\"2*chi1 + C2", IMMERSION, "`beta` is not chi plus a function of the outputs", "`start`"),
        ("[\"chi1 + C2", "[\"xi1 + C2", IMMERSION, "there is no `xi1`", "cannot be read"),
        ("[\"z1\", ", "[\"chi1\", ", IMMERSION, "there is no `chi1`", "cannot be read"),
        ("\"chi2 - L3*i3\"]", "\"chi2 - L3*i3 + t\"]", IMMERSION, "`beta` depends on the time t", "without t"),
        ("\"v4\"]", "\"v4 + t\"]", IMMERSION, "`phi` depends on the time t", "without t"),
        ("\"z2\"]", "\"z2 + 0*t\"]", IMMERSION, "`left_inverse` depends on the time t", "without t"),
        ("phi = [", "start = [\"t\", \"0\"]\nphi = [", IMMERSION, "`start` depends on the time t", "without t"),
        ("phi = [", "q = [\"t\", \"0\"]\nphi = [", IMMERSION, "`q` depends on the time t", "without t"),
        ("phi = [", "rho = [\"t\", \"0\"]\nphi = [", IMMERSION, "`rho` depends on the time t", "without t"),
        (
            "phi = [\"i1\", \"v4\"]",
            "phi = [\"i1\"]",
            IMMERSION,
            "`beta` has 2 expressions, and `phi` has 1 row",
            "1 expression",
        ),
        (
            "phi = [\"i1\"",
            "q = [1]\nphi = [\"i1\"",
            IMMERSION,
            "`q` has 1 expression, and the observer has 2 states chi",
            "2 expr",
        ),
    ] {
        assert!(of.contains(from), "{from}");
        let found = mistakes(&format!("{PLANT}{}", of.replace(from, to)));
        assert!(found[0].message.contains(message), "{found:?}");
        assert!(format!("{} {:?}", found[0].expected, found[0].help).contains(expected), "{found:?}");
        assert!(found[0].line > 15, "{found:?}");
    }
    let unbounded = format!("{PLANT}{KKL}").replace("inputs = [[0.2, 0.8]]", "inputs = [[0.2, inf]]");
    assert!(read(&unbounded).unwrap_err().to_string().contains("`region` has no finite bounds of duty"));
    let moving = SIXTH.replace("ln(theta1)", "ln(theta1) + t");
    assert!(read(&moving).unwrap_err().to_string().contains("`missing` depends on the time t"));
    let parameter = format!("{PLANT}{KKL}").replace("E = 12.0 }", "E = 12.0, xi1 = 1 }");
    assert!(read(&parameter).unwrap_err().to_string().contains("`xi1` cannot be the name of a parameter"));
}

/// With ever shorter periods the exported step approaches the observer in continuous time, at first order or better.
#[test]
fn the_exported_step_approaches_the_observer() {
    // The filter of y starts at the output that the first estimate predicts.
    let study = read(&SIXTH.replace("alpha = 1\n", "alpha = 1\ninitial = [0.5, 0, 0]\n")).unwrap();
    let observer = &study.observers[0];
    let errors: Vec<f64> = [0.04, 0.02, 0.01]
        .into_iter()
        .map(|period| {
            let sampled = deployment::sampled(&study, observer, Some(period), None).unwrap();
            let record = deployment::record(&study, observer, &sampled).unwrap();
            let export = deployment::exported(&study, observer, sampled.design, Scalar::Binary64, None).unwrap();
            let mut stepper = Stepper::new(&export).unwrap();
            let steps: Vec<Vec<f64>> = record.samples.iter().map(|(u, y)| stepper.step(u, y)).collect();
            let difference = record.difference(&steps).unwrap();
            difference.late.iter().copied().fold(0.0, f64::max)
        })
        .collect();
    assert!(errors[0] < 0.05 && errors[1] < 0.6 * errors[0] && errors[2] < 0.6 * errors[1], "{errors:?}");
}
