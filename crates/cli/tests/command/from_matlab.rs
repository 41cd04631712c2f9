//! Transposes and signs in `docs/from-matlab.md`: the command and the corresponding Rust function give the same result.

use crate::terminal::luenberger;
use luenberger_linalg::{discrete_kalman_gain, kalman_gain, lyapunov, observability, place_observer, stein, sylvester};
use nalgebra::{Complex, DMatrix, dmatrix};
use serde_json::{Value, json};

/// Both use the same algorithms; a transposition may change the order of a few sums.
const ROUNDING: f64 = 1e-12;

fn rows(m: &DMatrix<f64>) -> Vec<Vec<f64>> {
    m.row_iter().map(|row| row.iter().copied().collect()).collect()
}

fn answer(command: &str, input: &Value, key: &str) -> DMatrix<f64> {
    let words: Vec<&str> = command.split(' ').collect();
    let found = luenberger(&[&words[..], &["-", "--json"]].concat(), input.to_string()).json();
    let rows: Vec<Vec<f64>> = serde_json::from_value(found[key].clone()).unwrap();
    DMatrix::from_fn(rows.len(), rows[0].len(), |i, j| rows[i][j])
}

#[track_caller]
fn assert_near(found: &DMatrix<f64>, expected: &DMatrix<f64>) {
    assert_eq!(found.shape(), expected.shape());
    let error = (found - expected).amax() / expected.amax();
    assert!(error <= ROUNDING, "{error:e}: {found}{expected}");
}

fn plant() -> (DMatrix<f64>, DMatrix<f64>) {
    (dmatrix![0.2, 1.0, 0.0; -0.5, 0.1, 0.3; 0.0, -0.2, -0.7], dmatrix![1.0, 0.5, 0.0])
}

#[test]
fn lyapunov_equations_are_transposed_and_sylvester_changes_its_sign() {
    let (a, c) = plant();
    let q = c.transpose() * &c;
    let input = json!({ "a": rows(&a), "q": rows(&q) });
    assert_near(&answer("lyap", &input, "x"), &lyapunov(&a.transpose(), &q).unwrap().p);
    assert_near(&answer("dlyap", &input, "x"), &stein(&a.transpose(), &q).unwrap().p);
    assert_near(&answer("lyap --transposed", &input, "x"), &lyapunov(&a, &q).unwrap().p);
    assert_near(&answer("dlyap --transposed", &input, "x"), &stein(&a, &q).unwrap().p);
    let b = dmatrix![4.0, 1.0; 0.0, 3.0];
    let right = dmatrix![1.0, 2.0; 3.0, 4.0; 5.0, 6.0];
    let input = json!({ "a": rows(&a), "b": rows(&b), "q": rows(&right) });
    assert_near(&answer("sylv", &input, "x"), &sylvester(&a, &b, &-right).unwrap().x);
}

#[test]
fn gains_of_observers_are_those_of_the_transposed_plant_transposed() {
    let (a, c) = plant();
    let poles = [Complex::new(-1.0, 1.0), Complex::new(-1.0, -1.0), Complex::from(-2.0)];
    let (at, ct) = (rows(&a.transpose()), rows(&c.transpose()));
    let input = json!({ "a": at, "b": ct, "poles": [[-1, 1], [-1, -1], -2] });
    assert_near(&answer("place", &input, "k").transpose(), &place_observer(&a, &c, &poles).unwrap().gain);
    let (w, v) = (DMatrix::identity(3, 3), dmatrix![2.0]);
    let input = json!({ "a": at, "b": ct, "q": rows(&w), "r": rows(&v) });
    assert_near(&answer("care", &input, "k").transpose(), &kalman_gain(&a, &c, &w, &v).unwrap().l);
    let predictor = discrete_kalman_gain(&a, &c, &w, &v).unwrap();
    assert_near(&answer("dare", &input, "k").transpose(), &predictor.l);
    // MATLAB's dlqe returns the filter gain.
    let filter = &predictor.p * c.transpose() * (&c * &predictor.p * c.transpose() + v).try_inverse().unwrap();
    assert_near(&(&a * filter), &predictor.l);
}

/// The command does the transposing: `a`, `c` give what `A'`, `C'` give, transposed.
#[test]
fn the_observer_keys_need_no_transpose() {
    let a = dmatrix![0.2, 1.0, 0.0; -0.5, 0.1, 0.3; 0.0, -0.2, -0.7];
    for c in [dmatrix![1.0, 0.5, 0.0], dmatrix![1.0, 0.5, 0.0; 0.0, 1.0, -2.0]] {
        let p = c.nrows();
        let (at, ct) = (rows(&a.transpose()), rows(&c.transpose()));
        let (w, v) = (dmatrix![2.0, 0.5, 0.0; 0.5, 1.0, 0.1; 0.0, 0.1, 3.0], DMatrix::from_diagonal_element(p, p, 2.0));
        let dual = json!({ "a": at, "b": ct, "q": rows(&w), "r": rows(&v) });
        let observer = json!({ "a": rows(&a), "c": rows(&c), "w": rows(&w), "v": rows(&v) });
        for command in ["care", "dare"] {
            assert_near(&answer(command, &observer, "l"), &answer(command, &dual, "k").transpose());
            assert_near(&answer(command, &observer, "p"), &answer(command, &dual, "x"));
            assert_near(&answer(command, &observer, "poles"), &answer(command, &dual, "poles"));
        }
        let poles = json!([[-1, 1], [-1, -1], -2]);
        let observer = json!({ "a": rows(&a), "c": rows(&c), "poles": poles });
        let dual = json!({ "a": at, "b": ct, "poles": poles });
        assert_near(&answer("place", &observer, "l"), &answer("place", &dual, "k").transpose());
        assert_near(&answer("place", &observer, "poles"), &answer("place", &dual, "poles"));
    }
}

/// With E too, `--transposed` is the same as A' and E' by hand; the solutions differ from those without it.
#[test]
fn transposed_lyapunov_equations_are_those_of_the_transposed_matrices() {
    let (a, _) = plant();
    let q = dmatrix![2.0, 0.5, 0.0; 0.5, 1.0, 0.1; 0.0, 0.1, 3.0];
    let e = dmatrix![1.0, 0.5, 0.0; 0.0, 2.0, 0.0; 0.3, 0.0, 1.0];
    let data = |a: &DMatrix<f64>, e: &DMatrix<f64>| {
        [json!({ "a": rows(a), "q": rows(&q) }), json!({ "a": rows(a), "q": rows(&q), "e": rows(e) })]
    };
    for (input, by_hand) in data(&a, &e).into_iter().zip(data(&a.transpose(), &e.transpose())) {
        for command in ["lyap", "dlyap"] {
            let found = answer(&format!("{command} --transposed"), &input, "x");
            assert_near(&found, &answer(command, &by_hand, "x"));
            assert!((&found - answer(command, &input, "x")).amax() > 0.1 * found.amax());
        }
    }
}

/// python-control 0.10.2, `dlqe([[0.9, 0.2], [0, 0.7]], eye(2), [[1, 0]], eye(2), [[2]])`, returns the predictor gain.
#[test]
fn dlqe_of_python_control_is_the_predictor() {
    let (a, c) = (dmatrix![0.9, 0.2; 0.0, 0.7], dmatrix![1.0, 0.0]);
    let found = discrete_kalman_gain(&a, &c, &DMatrix::identity(2, 2), &dmatrix![2.0]).unwrap().l;
    // The reference is printed to eight decimals.
    assert!((found - dmatrix![0.46338713; 0.06883806]).amax() <= 1e-8);
}

#[test]
fn controllability_is_observability_transposed() {
    let a = dmatrix![-1.0, 0.0; 0.0, -2.0];
    let b = dmatrix![1.0; 0.0];
    assert_eq!(observability(&a.transpose(), &b.transpose()).unwrap().rank, 1);
    let input = json!({ "a": rows(&a.transpose()), "c": rows(&b.transpose()) });
    assert_eq!(luenberger(&["obsv", "-", "--json"], input.to_string()).json()["rank"], 1);
}
