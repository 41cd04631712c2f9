//! Functional observers in studies.

use luenberger_study::deployment::sampled;
use luenberger_study::execute::Step;
use luenberger_study::{RunOptions, execute};

use crate::studies::{designed, read, scratch};

/// K A = 2 C and C A = K: with the pole -3, N = 3, T = K - 3 C, G = 2 - 9 and H = T B = 1.
const PLANT: &str = r#"[plant]
a = [[0, 1, 1], [1, -2, 1], [1, 2, -1]]
b = [[0], [0], [1]]
c = [[1, 0, 0]]
[input]
expressions = ["sin(t)"]
[simulation]
x0 = [1, -1, 2]
duration = 2
samples = 5
scale = [1, 1, 1]
"#;

const OBSERVER: &str = r#"[[observer]]
name = "sum"
kind = "functional"
k = [[0, 1, 1]]
poles = [-3]
"#;

#[test]
fn the_matrices_are_those_of_the_equations() {
    let found = designed(&read(&format!("{PLANT}{OBSERVER}")).unwrap()).unwrap();
    let matrix = |name: &str| found.report.matrices.iter().find(|matrix| matrix.name == name).unwrap().rows.clone();
    for (name, expected) in
        [("F", vec![-3.0]), ("G", vec![-7.0]), ("H", vec![1.0]), ("N", vec![3.0]), ("T", vec![-3.0, 1.0, 1.0])]
    {
        let rows = matrix(name);
        assert!(rows.len() == 1 && rows[0].len() == expected.len(), "{name}");
        assert!(rows[0].iter().zip(expected).all(|(x, expected)| (x - expected).abs() < 1e-12), "{name}: {rows:?}");
    }
    assert!(found.certificate.is_none() && found.report.verdict.word() == "none");
    assert!(found.report.statement.starts_with("No stability certificate"), "{}", found.report.statement);
}

/// The error starts at K x(0) = 1 and is exp(-3 t), whose root mean square over 2 is ((1 - exp(-12))/12)^(1/2). z and
/// zhat at the end are those of scipy 1.17, `solve_ivp` of plant and observer with DOP853, rtol 1e-11.
#[test]
fn it_runs_and_its_errors_are_those_of_the_functions() {
    let folder = scratch("functional");
    // The mode -3 is hidden: no poles can be placed, and a Kalman filter exists.
    let beside = "[[observer]]\nname = \"whole\"\nkind = \"kalman\"\nw = 1\nv = 1\n";
    let study = read(&format!("{PLANT}{OBSERVER}{beside}")).unwrap();
    let results =
        execute(&study, Step::Run, &RunOptions { output: Some(folder.clone().into()), ..RunOptions::default() })
            .unwrap();
    let rows = &results.simulation.as_ref().unwrap().rows;
    let merits = rows[0].merits.as_ref().unwrap();
    assert!(merits.norm.is_none() && merits.states.len() == 1);
    assert_eq!(merits.states[0].state, "z1 of sum");
    let rms = ((1.0 - (-12f64).exp()) / 12.0).sqrt();
    assert!((merits.states[0].rmse - rms).abs() < 1e-8 && (merits.states[0].initial - 1.0).abs() < 1e-15);
    // The table has the states of the other observer, and the function of this one.
    let table = results.simulation.as_ref().unwrap().state_table(&results.plant, 9).unwrap();
    let quantities: Vec<&str> = table.rows.iter().map(|row| row[0].text.as_str()).collect();
    assert_eq!(quantities, ["z1 of sum", "x1", "x2", "x3"]);
    let csv = std::fs::read_to_string(folder.join("trajectories/sum.csv")).unwrap();
    assert_eq!(csv.lines().next(), Some("t,x1,x2,x3,u1,y1,z1,z1_hat"));
    let last: Vec<f64> = csv.lines().last().unwrap().split(',').map(|cell| cell.parse().unwrap()).collect();
    for (found, expected) in last[6..].iter().zip([23.378_962_976_386, 23.376_484_224_207]) {
        assert!((found - expected).abs() < 1e-7 * expected, "{found}, expected {expected}");
    }
    assert!(folder.join("figures/functions.svg").is_file());
    let Err(refusal) = sampled(&study, &study.observers[0], Some(0.01), None) else { panic!("no export") };
    assert!(refusal.hypothesis.contains("no prediction of the output"), "{}", refusal.hypothesis);
    assert!(refusal.hints[0].contains("reduced-order"));
}

#[test]
fn the_condition_that_fails_is_named() {
    let why = |text: &str| match designed(&read(text).unwrap()) {
        Err(failure) => (failure.hypothesis.clone(), failure.advice()),
        other => panic!("{other:?}"),
    };
    // K A = [1 -2 1] = C + C A - 3 K, and no other combination gives it.
    let (said, ways) = why(&format!("{PLANT}{}", OBSERVER.replace("[[0, 1, 1]]", "[[0, 1, 0]]").replace("-3", "-1")));
    assert!(said.contains("has the eigenvalue -3") && said.contains("second condition"), "{said}");
    // The mode is hidden and stable: a gain for the whole state leaves it where it is.
    assert!(
        ways[0].starts_with("alternative: kind = \"kalman\"") && ways.contains(&"hint: other rows of `k`".to_owned())
    );
    let chain = "[plant]\na = [[0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1], [0, 0, 0, 0]]\nc = [[1, 0, 0, 0]]\n";
    let (said, ways) = why(&format!("{chain}{}", OBSERVER.replace("[[0, 1, 1]]", "[[0, 0, 1, 0]]")));
    assert!(
        said.contains("row 1 of K A") && said.contains("residual 1 ") && said.contains("first condition"),
        "{said}"
    );
    // With x4 among the functions the second condition fails at 0: s x3 = x4, s x4 = 0, and neither x3 nor x4 in y, y'.
    assert!(ways[0].starts_with("alternative: kind = \"reduced-order\""), "{ways:?}");
    let chain = "[plant]\na = [[0, 1, 0], [0, 0, 1], [0, 0, 0]]\nc = [[1, 0, 0]]\n";
    let (said, ways) = why(&format!("{chain}{}", OBSERVER.replace("[[0, 1, 1]]", "[[0, 1, 0]]")));
    assert!(said.contains("first condition"), "{said}");
    let with_its_rate = "alternative: k = [[0, 1, 0], [0, 0, 1]], poles = [-3, -3.3] in place of k, poles: ";
    assert!(ways[0].starts_with(with_its_rate), "{ways:?}");
}

#[test]
fn bad_values_are_reported() {
    let wrong = |text: String, message: &str| {
        let said = read(&text).unwrap_err().to_string();
        assert!(said.contains(message), "{said}");
    };
    wrong(format!("{PLANT}{}", OBSERVER.replace("[[0, 1, 1]]", "[[0, 1]]")), "`k` is 1 x 2");
    wrong(format!("{PLANT}{}", OBSERVER.replace("[-3]", "[-3, -4]")), "`poles` has length 2, and `k` has 1 row");
    wrong(format!("{PLANT}{}", OBSERVER.replace("[-3]", "[3]")), "left half plane");
    wrong(format!("{PLANT}{}", OBSERVER.replace("poles = [-3]\n", "")), "`poles`");
    let fed = PLANT.replace("[simulation]", "feedback = { gain = [[1, 1, 1]], observer = \"sum\" }\n[simulation]");
    wrong(format!("{fed}{OBSERVER}"), "the estimate of the whole state");
    let sweep = "[sweep]\nparameter = \"noise\"\nvalues = [1]\n";
    wrong(format!("{PLANT}{OBSERVER}{sweep}"), "[sweep] compares estimates of the state");
    let discrete = "[plant]\na = [[0.5]]\nc = [[1]]\ndt = 0.1\n";
    wrong(format!("{discrete}{}", OBSERVER.replace("[[0, 1, 1]]", "[[1]]")), "unit circle");
    wrong(format!("{PLANT}{OBSERVER}order = \"most\"\n"), "most");
    let few = OBSERVER.replace("[[0, 1, 1]]", "[[0, 1, 1], [1, 0, 0]]");
    wrong(format!("{PLANT}{few}order = \"least\"\n"), "`poles` has length 1, and `k` has 2 rows");
}

/// The same equations hold for samples: with the pole f, N = -f, T = K + f C and G = 2 - f^2. The error of z is
/// `f^k T x(0)` from w(0) = T initial = 0: T x(0) = 1.5 for f = 1/2. With D it is the same.
#[test]
fn it_runs_at_samples() {
    let at_samples =
        PLANT.replace("[input]", "dt = 0.1\n[input]").replace("duration = 2\nsamples = 5", "duration = 0.5");
    let observer = OBSERVER.replace("[-3]", "[0.5]");
    for (k, plant) in [at_samples.clone(), at_samples.replace("dt = 0.1", "dt = 0.1\nd = [[3]]")].iter().enumerate() {
        let study = read(&format!("{plant}{observer}")).unwrap();
        let found = designed(&study).unwrap();
        let matrix = |name: &str| found.report.matrices.iter().find(|m| m.name == name).unwrap().rows.concat();
        for (name, expected) in [("F", 0.5), ("G", 1.75), ("H", 1.0), ("N", -0.5)] {
            assert!((matrix(name)[0] - expected).abs() < 1e-13, "{name}: {:?}", matrix(name));
        }
        assert!(found.report.statement.contains("is e+ = F e") && found.certificate.is_none());
        let folder = scratch(&format!("functional-of-samples-{k}"));
        execute(&study, Step::Run, &RunOptions { output: Some(folder.clone().into()), ..RunOptions::default() })
            .unwrap();
        let csv = std::fs::read_to_string(folder.join("trajectories/sum.csv")).unwrap();
        assert_eq!(csv.lines().next(), Some("t,x1,x2,x3,u1,y1,z1,z1_hat"));
        for (sample, line) in csv.lines().skip(1).enumerate() {
            let row: Vec<f64> = line.split(',').map(|x| x.parse().unwrap()).collect();
            let expected = 1.5 * 0.5f64.powi(i32::try_from(sample).unwrap());
            assert!((row[6] - row[7] - expected).abs() < 1e-12 * (1.0 + row[6].abs()), "{row:?}");
        }
        assert!(csv.lines().count() > 5);
        sampled(&study, &study.observers[0], None, None).unwrap();
    }
}

/// x2 + 2 x3 of a chain of three: n - p = 2 states, and with the poles -3 and -4 the error of z is that of
/// `(s + 3)(s + 4)`. From a first estimate without an error there is none at any time.
#[test]
fn an_observer_of_least_order_is_found() {
    let text = "[plant]\na = [[0, 1, 0], [0, 0, 1], [0, 0, 0]]\nb = [[0], [0], [1]]\nc = [[1, 0, 0]]\nd = [[0.5]]\n[input]\nexpressions = [\"cos(t)\"]\n\
        [simulation]\nx0 = [1, -1, 2]\nduration = 1\nsamples = 5\n[[observer]]\nname = \"z\"\nkind = \"functional\"\nk = [[0, 1, 2]]\n\
        poles = [-3, -4, -5]\norder = \"least\"\ninitial = [1, -1, 2]\n";
    let study = read(text).unwrap();
    let found = designed(&study).unwrap();
    let expected = "The order is 2: 1 further function below those of `k` in K, and to working precision no observer of a lower order has the first ones of these poles.";
    assert!(found.report.statement.contains(expected), "{}", found.report.statement);
    assert_eq!(found.report.poles.len(), 2);
    assert!((found.report.poles[0][0] + 4.0).abs() < 1e-10 && (found.report.poles[1][0] + 3.0).abs() < 1e-10);
    let folder = scratch("functional-least");
    let results =
        execute(&study, Step::Run, &RunOptions { output: Some(folder.clone().into()), ..RunOptions::default() })
            .unwrap();
    let merits = results.simulation.as_ref().unwrap().rows[0].merits.as_ref().unwrap();
    assert!(merits.states.len() == 1 && merits.states[0].rmse < 1e-7, "{:?}", merits.states);
    // Luenberger 1966: one function takes no more states than the longest chain less one, here 1 and not n - p = 2.
    let two = "[plant]\na = [[0, 1, 0, 0], [0, 0, 0, 0], [0, 0, 0, 1], [0, 0, 0, 0]]\nc = [[1, 0, 0, 0], [0, 0, 1, 0]]\n\
        [[observer]]\nkind = \"functional\"\nk = [[0, 1, 0, 3]]\npoles = [-3, -4]\norder = \"least\"\n";
    let found = designed(&read(two).unwrap()).unwrap();
    assert!(found.report.poles.len() == 1 && found.report.statement.contains("The order is 1: no further function"));
}
