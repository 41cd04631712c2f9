//! The matrix commands against python-control and scipy (`tests/golden`, written by `generate.py` there), and against
//! the residuals of their equations.

use crate::terminal::luenberger;
use luenberger_proof::wording::significant;
use nalgebra::{Complex, DMatrix};
use proptest::prelude::*;
use serde_json::{Value, json};
use std::path::Path;

/// Backward errors of both tools are a small multiple of `n eps`; the problems of `generate.py` amplify them by less
/// than 1e5.
const AGREEMENT: f64 = 1e-10;

fn matrix(value: &Value) -> DMatrix<f64> {
    let rows: Vec<Vec<f64>> = serde_json::from_value(value.clone()).unwrap();
    DMatrix::from_fn(rows.len(), rows[0].len(), |i, j| rows[i][j])
}

fn complex(value: &Value) -> Vec<Complex<f64>> {
    let pairs: Vec<[f64; 2]> = serde_json::from_value(value.clone()).unwrap();
    pairs.into_iter().map(|[re, im]| Complex::new(re, im)).collect()
}

/// Equality up to order: a one-to-one matching of the numbers.
#[track_caller]
fn assert_same_set(name: &str, found: &[Complex<f64>], mut expected: Vec<Complex<f64>>) {
    assert_eq!(found.len(), expected.len(), "{name}");
    let size = expected.iter().map(|z| z.norm()).fold(1.0, f64::max);
    for z in found {
        let (place, nearest) =
            expected.iter().enumerate().min_by(|x, y| (x.1 - z).norm().total_cmp(&(y.1 - z).norm())).unwrap();
        assert!((nearest - z).norm() <= AGREEMENT * size, "{name}: {z} and {nearest}");
        expected.remove(place);
    }
}

/// A matrix with semicolons between its rows, poles with commas between them.
fn on_the_command_line(key: &str, value: &Value) -> String {
    let numbers = |list: &Value| -> Vec<f64> { serde_json::from_value(list.clone()).unwrap() };
    let item = |item: &Value| match (key, &numbers(item)[..]) {
        ("poles", [re, im]) => format!("{re}{im:+}i"),
        (_, row) => row.iter().map(ToString::to_string).collect::<Vec<_>>().join(" "),
    };
    let items: Vec<String> = value.as_array().unwrap().iter().map(item).collect();
    items.join(if key == "poles" { "," } else { "; " })
}

/// A matrix that begins with a minus sign, an entry that is not finite, and what is neither file nor matrix.
#[test]
fn the_first_matrix_stands_where_the_file_does() {
    let place = |a: &str| luenberger(&["place", a, "--c", "1 0", "--poles", "-2,-5"], "");
    let negative = place("-1 2; 0 -3");
    let named = luenberger(&["place", "--a", "-1 2; 0 -3", "--c", "1 0", "--poles", "-2,-5"], "");
    assert_eq!((negative.code, &negative.stdout), (Some(0), &named.stdout), "{negative:?}");
    assert!(place("-.5 1;0 1").code == Some(0) && place("-1, 2; 0, -3").code == Some(0));
    let refused = |a: &str, what: &str| {
        let ran = place(a);
        assert_eq!((ran.code, ran.stderr.lines().next()), (Some(2), Some(format!("error: {what}").as_str())));
    };
    refused("0 1; 0 nan", "the matrix \"0 1; 0 nan\": \"nan\" is not a finite number");
    refused("0 1; 0 -inf", "the matrix \"0 1; 0 -inf\": \"-inf\" is not a finite number");
    refused("0 1; 0 x", "there is no file \"0 1; 0 x\", and it is no matrix: \"x\" is not a finite number");
    let alone = luenberger(&["eig", "0 1; 0 nan"], "");
    assert!(alone.code == Some(2) && alone.stderr.contains("\"nan\" is not a finite number"), "{alone:?}");
    // Options that are misspelt are found as such.
    let ran = luenberger(&["place", "-1 2; 0 -3", "--c", "1 0", "--pols", "-2,-5"], "");
    assert!(ran.stderr.contains("unexpected argument '--pols'"), "{}", ran.stderr);
}

#[test]
fn answers_are_those_of_python_control() {
    let mut count = 0;
    for entry in std::fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden")).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|extension| extension != "json") {
            continue;
        }
        count += 1;
        let name = path.display().to_string();
        let golden: Value = serde_json::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap();
        let ran = luenberger(&[golden["command"].as_str().unwrap(), "-", "--json"], golden["input"].to_string());
        assert_eq!((ran.code, ran.stderr.as_str()), (Some(0), ""), "{name}");
        let found = ran.json();
        // The same matrices on the command line.
        let mut arguments = vec![golden["command"].as_str().unwrap().to_owned(), "--json".to_owned()];
        for (key, value) in golden["input"].as_object().unwrap() {
            arguments.extend([format!("--{key}"), on_the_command_line(key, value)]);
        }
        let given = luenberger(&arguments.iter().map(String::as_str).collect::<Vec<_>>(), "");
        assert_eq!((given.code, &given.stdout, given.stderr.as_str()), (Some(0), &ran.stdout, ""), "{name}");
        for (key, expected) in golden["answer"].as_object().unwrap() {
            match key.as_str() {
                "x" | "k" => {
                    let (found, expected) = (matrix(&found[key]), matrix(expected));
                    assert_eq!(found.shape(), expected.shape(), "{name}");
                    let error = (&found - &expected).amax() / expected.amax().max(1.0);
                    assert!(error <= AGREEMENT, "{name}: {key} differs by {error:e}");
                }
                "poles" | "eigenvalues" => assert_same_set(&name, &complex(&found[key]), complex(expected)),
                "unobservable" => {
                    let hidden: Vec<_> =
                        found[key].as_array().unwrap().iter().map(|mode| mode["eigenvalue"].clone()).collect();
                    assert_same_set(&name, &complex(&Value::Array(hidden)), complex(expected));
                }
                "rank" => assert_eq!(&found[key], expected, "{name}"),
                other => panic!("{name}: nothing compares {other}"),
            }
        }
    }
    assert_eq!(count, 24);
}

/// Exactly these keys of each answer, in this order.
#[test]
fn answers_have_the_keys_they_are_documented_with() {
    let pair = json!({ "a": [[-1, 1], [0, -2]], "q": [[1, 0], [0, 1]] });
    let riccati = json!({ "a": [[0.5]], "b": [[1]], "q": [[1]], "r": [[1]] });
    let filter = json!({ "a": [[0.5]], "c": [[1]], "w": [[1]], "v": [[1]] });
    let cases = [
        ("lyap", pair.clone(), vec!["x", "residual", "condition", "forward_error"]),
        ("dlyap", json!({ "a": [[0.5]], "q": [[1]] }), vec!["x", "residual", "condition", "forward_error"]),
        ("sylv", json!({ "a": [[1]], "b": [[2]], "q": [[1]] }), vec!["x", "residual", "condition", "forward_error"]),
        ("care", riccati.clone(), vec!["x", "k", "poles", "residual", "condition", "forward_error"]),
        ("dare", riccati, vec!["x", "k", "poles", "residual", "condition", "forward_error"]),
        ("place", json!({ "a": [[1]], "b": [[1]], "poles": [-1] }), vec!["k", "poles", "relative_errors", "condition"]),
        ("care", filter.clone(), vec!["p", "l", "poles", "residual", "condition", "forward_error"]),
        (
            "dare",
            filter,
            vec!["p", "l", "filter_gain", "filter_covariance", "poles", "residual", "condition", "forward_error"],
        ),
        (
            "place",
            json!({ "a": [[1]], "b": [[1]], "poles": [-1], "pattern": [[1]] }),
            vec!["k", "poles", "relative_errors", "condition", "free", "rank"],
        ),
        ("place", json!({ "a": [[1]], "c": [[1]], "poles": [-1] }), vec!["l", "poles", "relative_errors", "condition"]),
        ("obsv", json!({ "a": [[1]], "c": [[1]] }), vec!["rank", "unobservable", "margins"]),
        ("eig", json!({ "a": [[1]] }), vec!["eigenvalues"]),
    ];
    for (command, input, keys) in cases {
        let ran = luenberger(&[command, "-", "--json"], input.to_string());
        assert_eq!(ran.code, Some(0), "{command}: {}", ran.stderr);
        let mut from = 0;
        for key in &keys {
            let at = ran.stdout[from..].find(&format!("\"{key}\":")).unwrap_or_else(|| panic!("{command}: {key}"));
            from += at;
        }
        assert_eq!(ran.json().as_object().unwrap().len(), keys.len(), "{command}");
    }
}

/// Noise that enters by G and is correlated with that of the measurement. scipy 1.17.1, `solve_continuous_are` and
/// `solve_discrete_are` of the transposed plant with `G W G'` and `s = G S`; M and P - M C P by numpy.
#[test]
fn filters_of_correlated_noises_are_those_of_scipy() {
    let input = |a: Value| {
        json!({
            "a": a, "c": [[1, 0], [1, 1]], "g": [[1, 0], [0.5, 2]], "w": [[1, 0.2], [0.2, 0.5]],
            "v": [[0.4, 0.1], [0.1, 0.3]], "s": [[0.2, 0.1], [0.05, -0.1]]
        })
    };
    let near = |found: &Value, expected: Value| {
        let error = (matrix(found) - matrix(&expected)).amax();
        assert!(error <= AGREEMENT, "{error:e}: {found}");
    };
    let run = |command: &str, a: Value| luenberger(&[command, "-", "--json"], input(a).to_string()).json();
    let found = run("care", json!([[0, 1], [-2, -0.3]]));
    near(&found["l"], json!([[1.0138705753264836, 1.1711651063578135], [-0.07527670779674048, 2.6018253179231365]]));
    let found = run("dare", json!([[0.9, 0.2], [-0.1, 0.8]]));
    near(&found["p"], json!([[0.9050288425720321, 0.790317327854126], [0.790317327854126, 3.1817650298389153]]));
    near(&found["l"], json!([[0.5810615526122965, 0.2307562436934277], [-0.15445388601192944, 0.5254238818439592]]));
    let gain = json!([[0.5163794732182366, 0.12874326974792616], [-0.5291169679881118, 0.8248159917935894]]);
    near(&found["filter_gain"], gain);
    let covariance = json!([[0.2194261162620873, -0.1291651880158856], [-0.1291651880158856, 0.32369828875515205]]);
    near(&found["filter_covariance"], covariance);
}

/// Two sensors that differ by a thousandth in their time constants: within a hundredth only their sum is seen, and the
/// difference has the mean of the two poles.
#[test]
fn a_tolerance_hides_what_is_smaller() {
    let input = json!({ "a": [[-1, 0], [0, -1.001]], "c": [[1, 1]] }).to_string();
    let run = |arguments: &[&str]| luenberger(arguments, input.clone()).json();
    assert_eq!(run(&["obsv", "-", "--json"])["rank"], 2);
    assert_eq!(run(&["obsv", "-", "--json", "--tolerance", "1e-6"])["rank"], 2);
    let found = run(&["obsv", "-", "--json", "--tolerance", "0.01"]);
    assert_eq!((&found["rank"], &found["tolerance"]), (&json!(1), &json!(0.01)));
    let [re, im] = serde_json::from_value::<[f64; 2]>(found["unobservable"][0]["eigenvalue"].clone()).unwrap();
    assert!((re + 1.0005).abs() < 1e-12 && im == 0.0, "{found}");
}

/// One delay for both inputs; the closed form of an integrator: `x+ = x + r u[k-2] + (h - r) u[k-1]`.
#[test]
fn a_delay_is_that_of_every_input() {
    let input = json!({ "a": [[0]], "b": [[1, 2]] }).to_string();
    let found = luenberger(&["c2d", "-", "--period", "0.5", "--delay", "0.625", "--json"], input).json();
    let expected =
        [[1.0, 0.375, 0.125, 0.75, 0.25], [0.0; 5], [0.0, 1.0, 0.0, 0.0, 0.0], [0.0; 5], [0.0, 0.0, 0.0, 1.0, 0.0]];
    assert!((matrix(&found["a"]) - DMatrix::from_fn(5, 5, |i, j| expected[i][j])).amax() < 1e-15, "{found}");
    assert_eq!(found["delays"], json!([0.625, 0.625]));
}

/// An error of a feedback gain shows in the poles: a transposed or negated gain gives different ones.
#[test]
fn several_inputs_place_the_poles_of_a_minus_b_k() {
    let (a, b) = (json!([[0, 1, 0], [0, 0, 1], [3, -2, 1]]), json!([[0, 1], [1, 0], [0, 2]]));
    let poles = json!([-2, [-1, 1], [-1, -1]]);
    let found = luenberger(&["place", "-", "--json"], json!({ "a": a, "b": b, "poles": poles }).to_string()).json();
    let closed = matrix(&a) - matrix(&b) * matrix(&found["k"]);
    let rows: Vec<Vec<f64>> = closed.row_iter().map(|row| row.iter().copied().collect()).collect();
    let spectrum = luenberger(&["eig", "-", "--json"], json!({ "a": rows }).to_string()).json();
    let expected = vec![Complex::new(-2.0, 0.0), Complex::new(-1.0, 1.0), Complex::new(-1.0, -1.0)];
    assert_same_set("place", &complex(&spectrum["eigenvalues"]), expected.clone());
    assert_same_set("place", &complex(&found["poles"]), expected);
    assert!(found["condition"].as_f64().unwrap() >= 1.0);
}

/// The same for an observer with two outputs: L is n x p.
#[test]
fn several_outputs_place_the_poles_of_a_minus_l_c() {
    let (a, c) = (json!([[0, 1, 0], [0, 0, 1], [3, -2, 1]]), json!([[0, 1, 0], [1, 0, 2]]));
    let poles = json!([-2, [-1, 1], [-1, -1]]);
    let found = luenberger(&["place", "-", "--json"], json!({ "a": a, "c": c, "poles": poles }).to_string()).json();
    let closed = matrix(&a) - matrix(&found["l"]) * matrix(&c);
    let rows: Vec<Vec<f64>> = closed.row_iter().map(|row| row.iter().copied().collect()).collect();
    let spectrum = luenberger(&["eig", "-", "--json"], json!({ "a": rows }).to_string()).json();
    let expected = vec![Complex::new(-2.0, 0.0), Complex::new(-1.0, 1.0), Complex::new(-1.0, -1.0)];
    assert_same_set("place", &complex(&spectrum["eigenvalues"]), expected.clone());
    assert_same_set("place", &complex(&found["poles"]), expected);
}

/// For n = 1 transposing changes nothing, and the answers are known: `L = (a - pole)/c`; `2 a p - c^2 p^2/v + w = 0`.
#[test]
fn observers_of_one_state() {
    let found = luenberger(&["place", "-", "--json"], r#"{"a": [[1]], "c": [[2]], "poles": [-5]}"#).json();
    assert_eq!(found["l"], json!([[3.0]]));
    let input = json!({ "a": [[0]], "c": [[2]], "w": [[9]], "v": [[4]] });
    let found = luenberger(&["care", "-", "--json"], input.to_string()).json();
    // p^2 = w v/c^2 = 9, L = p c/v = 3/2.
    let near = |key: &str, expected: f64| {
        let value = found[key][0][0].as_f64().unwrap();
        assert!((value - expected).abs() <= 10.0 * f64::EPSILON * expected, "{key} = {value}");
    };
    near("p", 3.0);
    near("l", 1.5);
    for command in ["lyap", "dlyap"] {
        let input = r#"{"a": [[-0.5]], "q": [[3]], "e": [[2]]}"#;
        let [plain, transposed] = [vec![], vec!["--transposed"]]
            .map(|more| luenberger(&[&[command, "-", "--json"], &more[..]].concat(), input).json()["x"].clone());
        assert_eq!(plain, transposed, "{command}");
    }
}

#[test]
fn a_repeated_pole_with_one_input_has_no_condition() {
    let input = json!({ "a": [[0, 1], [3, 2]], "b": [[0], [1]], "poles": [-1, -1] }).to_string();
    assert_eq!(luenberger(&["place", "-", "--json"], &input).json()["condition"], Value::Null);
    let text = luenberger(&["place", "-"], &input).stdout;
    assert!(text.contains("condition number of the eigenvectors inf"), "{text}");
}

#[test]
fn a_hidden_mode_is_named_with_its_direction() {
    let input = json!({ "a": [[-1, 0], [0, -2]], "c": [[1, 0]] }).to_string();
    let seen = luenberger(&["obsv", "-", "--json"], &input).json();
    assert_eq!(seen["rank"], 1);
    assert_eq!(seen["unobservable"], json!([{ "eigenvalue": [-2.0, 0.0], "direction": [[0.0, 0.0], [1.0, 0.0]] }]));
    let margins = seen["margins"].as_array().unwrap();
    // sigma_min of [A + I; C] for A = diag(-1, -2), C = [1 0] is 1, and |[A; C]| = sqrt 6 before scaling; scaling
    // changes the value but not its order of magnitude.
    assert!(margins[0]["margin"].as_f64().unwrap() > 0.1 && margins[1]["margin"].as_f64().unwrap() < 1e-15);
    let text = luenberger(&["obsv", "-"], &input);
    assert_eq!(text.code, Some(0));
    assert!(text.stdout.starts_with("rank 1 of 2: not observable\n"), "{}", text.stdout);
    assert!(text.stdout.contains("unobservable: -2 along [0, 1]"), "{}", text.stdout);
}

/// Margins have two digits, and what is rounding error is zero; its size is in the JSON.
#[test]
fn margins_at_the_level_of_rounding_are_zero() {
    let (mut rounding, mut small, mut large) = (0, 0, 0);
    for a in ["[[-1, 0], [0, -2]]", "[[-1.5, 0.4], [0.4, -1.5]]", "[[-1, 0], [0, -1.0000000000001]]"] {
        let input = format!("{{\"a\": {a}, \"c\": [[1, 1]]}}");
        let margins = luenberger(&["obsv", "-", "--json"], &input).json()["margins"].clone();
        let text = luenberger(&["obsv", "-"], &input).stdout;
        let written: Vec<&str> = text.lines().filter_map(|line| Some(line.split_once(": margin ")?.1)).collect();
        assert_eq!(written.len(), 2, "{text}");
        for (written, margin) in written.into_iter().zip(margins.as_array().unwrap()) {
            let margin = margin["margin"].as_f64().unwrap();
            let is_rounding = margin <= 8.0 * f64::EPSILON;
            let expected = if is_rounding { "0".to_owned() } else { significant(margin, 2) };
            assert_eq!(written, expected, "{margin:e}");
            match margin {
                0.0 => {}
                _ if is_rounding => rounding += 1,
                _ if margin < 1e-10 => small += 1,
                _ => large += 1,
            }
        }
    }
    assert!(rounding > 0 && small > 0 && large > 0, "{rounding} {small} {large}");
}

#[test]
fn matrices_for_people_are_aligned() {
    let input = r#"{"a": [[-0.5, 0], [0, -0.005]], "q": [[2, 0], [0, 1]]}"#;
    let text = luenberger(&["lyap", "-"], input).stdout;
    assert!(text.starts_with("A X + X A' + Q = 0\nX =\n  2    0\n  0  100\nresidual "), "{text}");
    let half = "[[-0.5, 0], [0, -0.5]]";
    let input = format!("{{\"a\": {half}, \"b\": {half}, \"q\": [[1.25, -10], [-100, 0.5]]}}");
    let text = luenberger(&["sylv", "-"], input).stdout;
    assert!(text.contains("\nX =\n     1.25  -10\n  -100       0.5\n"), "{text}");
    let spectrum = |a: &str| luenberger(&["eig", "-"], format!("{{\"a\": {a}}}")).stdout;
    assert_eq!(spectrum("[[-1, 2], [-2, -1]]"), "eigenvalues =\n  -1 + 2i\n  -1 - 2i\n");
    assert_eq!(spectrum("[[-1]]"), "eigenvalues =\n  -1\n");
}

proptest! {
    // Each case runs a process.
    #![proptest_config(ProptestConfig::with_cases(12))]

    /// Numbers are printed without loss: X read back solves the equation to rounding, with A scaled by 1e-6 to 1e6.
    #[test]
    fn printed_solutions_solve_their_equations(
        (n, entries) in (1..=5_usize).prop_flat_map(|n| (Just(n), prop::collection::vec(-1.0..1.0_f64, 2 * n * n))),
        decade in -6..=6_i32,
    ) {
        let units = 10.0_f64.powi(decade);
        // Row sums below n: with n on the diagonal every eigenvalue has a real part below -1/2 after scaling.
        let a = DMatrix::from_fn(n, n, |i, j| units * (entries[i * n + j] - if i == j { n as f64 + 0.5 } else { 0.0 }));
        let half = DMatrix::from_fn(n, n, |i, j| entries[n * n + i * n + j]);
        let q = &half + half.transpose();
        let rows = |m: &DMatrix<f64>| m.row_iter().map(|r| r.iter().copied().collect::<Vec<_>>()).collect::<Vec<_>>();
        let ran = luenberger(&["lyap", "-", "--json"], json!({ "a": rows(&a), "q": rows(&q) }).to_string());
        prop_assert_eq!(ran.code, Some(0));
        let found = ran.json();
        let x = matrix(&found["x"]);
        let defect = (&a * &x + &x * a.transpose() + &q).norm() / (2.0 * a.norm() * x.norm() + q.norm()).max(f64::MIN_POSITIVE);
        // Bartels and Stewart: a few roundings for each of n steps. Printing with 16 digits instead of exactly would
        // add an error of the same order, with six digits one of 1e-6.
        prop_assert!(defect <= 50.0 * n as f64 * f64::EPSILON, "{defect:e}");
        prop_assert!(found["residual"].as_f64().unwrap() <= 50.0 * n as f64 * f64::EPSILON);
    }

    /// Doubles in shortest decimal form are printed in the same form, at any scale. (Within one matrix they are of
    /// comparable size: an eigenvalue below the rounding error of another may be lost.)
    #[test]
    fn doubles_survive_the_way_through(entries in prop::collection::vec(-1.0..1.0_f64, 1..=3), exponent in -400..=400_i32) {
        let n = entries.len();
        let diagonal = |i: usize, j: usize| if i == j { entries[i] * 2f64.powi(exponent) } else { 0.0 };
        let rows: Vec<Vec<f64>> = (0..n).map(|i| (0..n).map(|j| diagonal(i, j)).collect()).collect();
        let found = luenberger(&["eig", "-", "--json"], json!({ "a": rows }).to_string()).json();
        for (i, row) in rows.iter().enumerate() {
            let has = complex(&found["eigenvalues"]).iter().any(|z| z.re == row[i] && z.im == 0.0);
            prop_assert!(has, "{:e} is not among {}", row[i], found);
        }
    }
}

/// A pair that determines its poles to no digit: the closed loop of the rounded gain has the poles -.0015 +- 9.96i.
#[test]
fn a_missed_pole_is_said() {
    let input = json!({ "a": [[1e-3, 1], [0, -1e9]], "c": [[1, 0]], "poles": [-1e-3, -2e-3] }).to_string();
    let ran = luenberger(&["place", "-"], input.clone());
    assert_eq!(ran.code, Some(1));
    assert!(ran.stdout.contains("warning: the pole -0.001 is missed by "), "{}", ran.stdout);
    assert!(ran.stdout.contains("largest relative error of a pole "), "{}", ran.stdout);
    let ran = luenberger(&["place", "-", "--json", "--accept-inexact"], input);
    assert_eq!(ran.code, Some(0));
    let found = ran.json();
    assert!(found["relative_errors"][0].as_f64().unwrap() > 1e3, "{found}");
    assert!(found["warning"].as_str().unwrap().contains("-0.001"), "{found}");
}

/// The plant of Doyle and Stein 1979, `(s + 2)/((s + 1)(s + 3))`, with K = [50 10] and L = [30 -50]: with
/// the observer a phase margin of 14.81 degrees, with the state 85.94 (scipy 1.17, `brentq` on `|L| - 1`). At 10 the
/// loop of state feedback is `(10 s + 50)/((s + 1)(s + 3))`.
#[test]
fn margins_of_doyle_and_stein() {
    let plant = r#""a": [[0, 1], [-3, -4]], "b": [[0], [1]], "c": [[2, 1]], "k": [[50, 10]]"#;
    let asked = |more: &str| {
        let ran = luenberger(
            &["bode", "-", "--json", "--from", "1", "--to", "10", "--points", "2"],
            format!("{{{plant}{more}}}"),
        );
        assert_eq!(ran.code, Some(0), "{}", ran.stderr);
        serde_json::from_str::<Value>(&ran.stdout).unwrap()
    };
    let phase = |answer: &Value| answer["loops"][0]["channels"][0]["phase_margins"][0].clone();
    let near = |found: &Value, expected: f64| (found.as_f64().unwrap() - expected).abs() < 1e-9 * expected.abs();
    let state = asked("");
    assert!(near(&phase(&state)[0], 10.592506335407393) && near(&phase(&state)[1], 85.93743518358802), "{state}");
    let s = Complex::new(0.0, 10.0);
    let expected = (s * 10.0 + 50.0) / ((s + 1.0) * (s + 3.0));
    let response = &state["responses"][0];
    assert_eq!(state["frequencies"], json!([1.0, 10.0]));
    assert!(near(&response["magnitude"][0][0][1], expected.norm()), "{response}");
    assert!(near(&response["phase"][0][0][1], expected.arg().to_degrees()), "{response}");
    let observer = asked(r#", "l": [[30], [-50]]"#);
    assert_eq!(observer["loops"][0]["stable"], json!(true));
    let at = phase(&observer);
    assert!(near(&at[0], 12.603965107996462) && near(&at[1], 14.813229735636607), "{observer}");
    let names: Vec<&Value> = observer["loops"].as_array().unwrap().iter().map(|one| &one["name"]).collect();
    assert_eq!(names, ["loop at the inputs", "loop at the outputs"]);
}
