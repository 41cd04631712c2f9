//! `luenberger care` and `luenberger dare`: the regulator in the form of MATLAB and scipy, with S, E or both where they
//! are given, and the Kalman filter from `a`, `c` and the noise.

use super::{from, json_output};
use crate::answer::Answer;
use crate::failure::Failure;
use crate::input::Source;
use crate::input::json::{self, Form};
use crate::numbers;
use luenberger_linalg::{Kalman, LinalgError, Riccati};
use nalgebra::DMatrix;
use serde::Serialize;

#[derive(Serialize)]
struct Regulator {
    x: Vec<Vec<f64>>,
    k: Vec<Vec<f64>>,
    poles: Vec<[f64; 2]>,
    residual: f64,
    /// None where nothing is known of it.
    condition: Option<f64>,
    /// Bound of the relative error of x; none if no digit is certain.
    forward_error: Option<f64>,
}

#[derive(Serialize)]
struct Filter {
    p: Vec<Vec<f64>>,
    l: Vec<Vec<f64>>,
    poles: Vec<[f64; 2]>,
    residual: f64,
    /// None where nothing is known of it.
    condition: Option<f64>,
    /// Bound of the relative error of p; none if no digit is certain.
    forward_error: Option<f64>,
}

/// The three problems of a command, and their equations.
struct Problems {
    plain: (Plain, &'static str),
    general: (General, &'static str),
    filter: (Estimator, &'static str),
}

type Plain = fn(&DMatrix<f64>, &DMatrix<f64>, &DMatrix<f64>, &DMatrix<f64>) -> Result<Riccati, LinalgError>;
type Estimator = fn(&DMatrix<f64>, &DMatrix<f64>, &DMatrix<f64>, &DMatrix<f64>) -> Result<Kalman, LinalgError>;
type General = fn([&DMatrix<f64>; 6]) -> Result<Riccati, LinalgError>;

/// `A'X + X A - X B R^-1 B'X + Q = 0`, `K = R^-1 B'X`; `A P + P A' - P C'V^-1 C P + W = 0`, `L = P C'V^-1`.
pub(crate) fn care(source: &Source) -> Result<Answer, Failure> {
    solve(
        source,
        &Problems {
            plain: (|a, b, q, r| luenberger_linalg::care(a, b, q, r), "A'X + X A - X B R^-1 B'X + Q = 0, K = R^-1 B'X"),
            general: (
                |[a, b, q, r, s, e]| luenberger_linalg::generalized_care(a, b, q, r, s, e),
                "A'X E + E'X A - (E'X B + S) R^-1 (B'X E + S') + Q = 0, K = R^-1 (B'X E + S')",
            ),
            filter: (
                |a, c, w, v| luenberger_linalg::kalman_gain(a, c, w, v),
                "A P + P A' - P C'V^-1 C P + W = 0, L = P C'V^-1",
            ),
        },
    )
}

/// `A'X A - X - A'X B (R + B'X B)^-1 B'X A + Q = 0`, `K = (R + B'X B)^-1 B'X A`;
/// `A P A' - P - A P C'(V + C P C')^-1 C P A' + W = 0`, `L = A P C'(V + C P C')^-1`.
pub(crate) fn dare(source: &Source) -> Result<Answer, Failure> {
    solve(
        source,
        &Problems {
            plain: (
                |a, b, q, r| luenberger_linalg::dare(a, b, q, r),
                "A'X A - X - A'X B (R + B'X B)^-1 B'X A + Q = 0, K = (R + B'X B)^-1 B'X A",
            ),
            general: (
                |[a, b, q, r, s, e]| luenberger_linalg::generalized_dare(a, b, q, r, s, e),
                "A'X A - E'X E - (A'X B + S) (R + B'X B)^-1 (B'X A + S') + Q = 0, K = (R + B'X B)^-1 (B'X A + S')",
            ),
            filter: (
                |a, c, w, v| luenberger_linalg::discrete_kalman_gain(a, c, w, v),
                "A P A' - P - A P C'(V + C P C')^-1 C P A' + W = 0, L = A P C'(V + C P C')^-1",
            ),
        },
    )
}

fn solve(source: &Source, problems: &Problems) -> Result<Answer, Failure> {
    let forms = [
        Form { keys: &["a", "b", "q", "r", "s", "e"], required: 4 },
        Form { keys: &["a", "c", "w", "v"], required: 4 },
    ];
    let [a, b, q, r, s, e, c, w, v] = json::either(source, ["a", "b", "q", "r", "s", "e", "c", "w", "v"], &forms)?;
    let a = a.unwrap_or_default();
    if let Some(c) = c {
        let (gain, equation) = problems.filter;
        let found = gain(&a, &c, &w.unwrap_or_default(), &v.unwrap_or_default()).map_err(from(source))?;
        return filter(equation, &found);
    }
    let [b, q, r] = [b, q, r].map(Option::unwrap_or_default);
    if s.is_none() && e.is_none() {
        let (plain, equation) = problems.plain;
        return regulator(equation, "poles of A - B K", &plain(&a, &b, &q, &r).map_err(from(source))?);
    }
    let s = s.unwrap_or_else(|| DMatrix::zeros(b.nrows(), b.ncols()));
    let e = e.unwrap_or_else(|| DMatrix::identity(a.nrows(), a.nrows()));
    let (general, equation) = problems.general;
    regulator(equation, "poles of (A - B K, E)", &general([&a, &b, &q, &r, &s, &e]).map_err(from(source))?)
}

fn regulator(equation: &str, poles: &str, found: &Riccati) -> Result<Answer, Failure> {
    let condition = known(found.condition);
    let (error, forward_error) = numbers::forward_error(found.forward_error);
    let text = format!(
        "{equation}\n{}{}{}{}, {error}\n",
        numbers::matrix("X", &found.x),
        numbers::matrix("K", &found.k),
        numbers::list(poles, &found.poles),
        accuracy(found.residual, condition)
    );
    let regulator = Regulator {
        x: json_output::rows(&found.x),
        k: json_output::rows(&found.k),
        poles: json_output::pairs(&found.poles),
        residual: found.residual,
        condition,
        forward_error,
    };
    Ok(Answer::new(text, &regulator)?)
}

fn filter(equation: &str, found: &Kalman) -> Result<Answer, Failure> {
    let condition = known(found.condition);
    let (error, forward_error) = numbers::forward_error(found.forward_error);
    let text = format!(
        "{equation}\n{}{}{}{}, {error}\n",
        numbers::matrix("P", &found.p),
        numbers::matrix("L", &found.l),
        numbers::list("poles of A - L C", &found.poles),
        accuracy(found.residual, condition)
    );
    let filter = Filter {
        p: json_output::rows(&found.p),
        l: json_output::rows(&found.l),
        poles: json_output::pairs(&found.poles),
        residual: found.residual,
        condition,
        forward_error,
    };
    Ok(Answer::new(text, &filter)?)
}

fn known(condition: f64) -> Option<f64> {
    Some(condition).filter(|condition| condition.is_finite())
}

fn accuracy(residual: f64, condition: Option<f64>) -> String {
    let condition = condition.map_or("unknown".to_owned(), numbers::size);
    format!("residual {} (relative), condition {condition}", numbers::size(residual))
}
