//! Exported observers that contain the plant: their steps approach the observer in continuous time, and their mistakes.
//! That they are the observers that run is in [`recorded`](crate::recorded).

use luenberger_export::Scalar;
use luenberger_export::golden::Stepper;
use luenberger_study::deployment;

use crate::studies::{mistakes, read};

const CONVERTER: &str = r#"
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
duration = 0.02
samples = 201
[[observer]]
initial = [0, 24, -0.5, 0]
"#;

const HIGH_GAIN: &str = r#"kind = "high-gain"
r = 0.005
chains = [2, 2]
alpha = [2, 1, 2, 1]
drift = ["((1 - duty)*xi2 + duty*i3)/C2", "(E - (1 - duty)*v2)/L1", "-(duty*v2 + xi4)/L3", "(i3 - G*xi4)/C4"]
shape = [1, "C2/(1 - duty)", 1, "-L3"]
estimate = ["xi2", "v2", "i3", "xi4"]
start = ["v2", "i1", "i3", "v4"]
"#;

const IMMERSION: &str = r#"kind = "immersion-invariance"
region = { states = [[-5, 5], [0, 60], [-5, 5], [-60, 0]], inputs = [[0.2, 0.8]] }
beta = ["chi1 + C2*50*v2", "chi2 - L3*i3"]
phi = ["i1", "v4"]
left_inverse = ["z1", "v2", "i3", "z2"]
"#;

/// chi has a third entry, which beta does not see at the start, and a nonlinear beta.
const WIDE: &str = r#"kind = "immersion-invariance"
region = { states = [[-5, 5], [0, 60], [-5, 5], [-60, 0]], inputs = [[0.2, 0.8]] }
order = 3
beta = ["chi1 + chi3^2/8 + C2*50*v2", "chi2 + sin(chi1)/4 - L3*i3"]
phi = ["i1", "v4"]
left_inverse = ["z1", "v2", "i3", "z2"]
start = ["i1 - C2*50*v2", "v4 + L3*i3 - sin(i1 - C2*50*v2)/4", "0"]
q = ["-chi1", "duty", "-3*chi3 + v2/10"]
rho = ["chi3", "-chi1*duty"]
"#;

/// The robot link with a flexible joint.
const JOINT: &str = r#"
[plant]
f = ["x2", "-48.6*x1 - 1.25*x2 + 48.6*x3 + 21.6*u1", "x4", "19.5*x1 - 19.5*x3 - 3.33*sin(x3) - 0.1*x4^3"]
h = ["x1", "x2"]
[input]
expressions = ["sin(t)"]
[simulation]
x0 = [0.1, 0, 0.2, 0]
duration = 2
samples = 201
[[observer]]
kind = "mean-value"
eta = 1.5
internal_error = [0.1, 0, 0.2, 0]
as_printed = "integral"
"#;

const LINEAR: &str = r#"
[plant]
a = [[0, 1, 0], [-2, -3, 1], [0, 0, -1]]
b = [[0], [1], [0.5]]
c = [[1, 0, 0], [0, 1, 0]]
d = [[0.25], [0]]
[input]
expressions = ["sin(t)"]
[simulation]
x0 = [1, 0, -1]
duration = 4
samples = 201
[[observer]]
kind = "unknown-input"
e = [[0], [1], [0]]
poles = [-1, -3, -4]
"#;

pub(crate) fn texts() -> Vec<String> {
    vec![
        format!("{CONVERTER}{HIGH_GAIN}"),
        format!("{CONVERTER}{IMMERSION}"),
        format!("{CONVERTER}{WIDE}"),
        JOINT.to_owned(),
        LINEAR.to_owned(),
        format!("{LINEAR}gamma = 0.7\n"),
    ]
}

/// With shorter periods the exported step approaches the observer in continuous time.
#[test]
fn exported_steps_approach_the_observer() {
    for (text, period) in texts().into_iter().zip([2e-5, 2e-5, 2e-5, 2e-3, 2e-3, 2e-3]) {
        let study = read(&text).unwrap_or_else(|error| panic!("{error}"));
        let observer = &study.observers[0];
        let errors: Vec<f64> = [2.0 * period, period]
            .into_iter()
            .map(|period| {
                let sampled =
                    deployment::sampled(&study, observer, Some(period), None).unwrap_or_else(|why| panic!("{why:?}"));
                let record = deployment::record(&study, observer, &sampled).unwrap();
                let export = deployment::exported(&study, observer, sampled.design, Scalar::Binary64, None).unwrap();
                let mut stepper = Stepper::new(&export).unwrap();
                let steps: Vec<Vec<f64>> = record.samples.iter().map(|(u, y)| stepper.step(u, y)).collect();
                record.difference(&steps).unwrap().late.iter().copied().fold(0.0, f64::max)
            })
            .collect();
        let scale = study.simulation.as_ref().unwrap().x0.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        assert!(errors[1] < 0.01 * scale && errors[1] < 0.7 * errors[0], "{text}\n{errors:?}");
    }
}

#[test]
fn an_iteration_has_no_export_and_says_what_has() {
    for printed in ["least-squares", "root"] {
        let study = read(&JOINT.replace("\"integral\"", &format!("\"{printed}\""))).unwrap();
        let refused = deployment::sampled(&study, &study.observers[0], Some(0.01), None).unwrap_err();
        assert!(refused.hypothesis.contains("its number of steps depends on the data"), "{}", refused.hypothesis);
        assert!(refused.hints[0].starts_with("as_printed = \"integral\""));
    }
}

#[test]
pub(crate) fn mistakes_in_given_chains_are_reported_at_their_place() {
    let with = |from: &str, to: &str| format!("{CONVERTER}{}", HIGH_GAIN.replace(from, to));
    let input = |from: &str, to: &str| format!("{}{HIGH_GAIN}", CONVERTER.replace(from, to));
    let expressions = "expressions = [\"0.5 + 0.1*sin(200*t)\"]";
    let short = "kind = \"high-gain\"\nr = 1\nchains = [1, 1]\ndrift = [0, 0]\n";
    for (text, message, expected) in [
        (with("chains = [2, 2]", "chains = [2, 1]"), "`chains` is [2, 1], and `drift` has 4 rows", "add to 4"),
        (with("alpha = [2, 1, 2, 1]", "alpha = [2, 1]"), "`alpha` has length 2, and `drift` has 4 rows", "length 4"),
        (with("shape = [1, ", "shape = ["), "`shape` has 3 expressions, and `drift` has 4 rows", "4 expressions"),
        (with("\"C2/(1 - duty)\"", "\"xi1\""), "there is no `xi1`", "cannot be read"),
        (
            with("estimate = [\"xi2\", ", "estimate = ["),
            "`estimate` has 3 expressions, and the plant has 4 states",
            "4",
        ),
        (with("drift = [", "# drift = ["), "`shape` is given, and `drift` is not", "`drift`"),
        (format!("{CONVERTER}{short}"), "`drift` has 2 rows, the plant has 4 states, and `estimate` is", "`estimate`"),
        (input(expressions, "law = [\"duty\"]"), "there is no `duty`", "cannot be read"),
        (
            input(expressions, "law = [\"1\", \"2\"]"),
            "`law` has 2 expressions, and the plant has 1 input",
            "1 expression",
        ),
        (input(expressions, &format!("{expressions}\nlaw = [\"v2\"]")), "`expressions` conflicts with `law`", "one of"),
        (input(expressions, &format!("{expressions}\njumps = [1]")), "`jumps` without a `law`", "a `law`"),
    ] {
        let found = mistakes(&text);
        assert!(found[0].message.contains(message), "{message}: {found:?}");
        assert!(format!("{} {:?}", found[0].expected, found[0].help).contains(expected), "{found:?}");
    }
}
