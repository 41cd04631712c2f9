//! `luenberger care` and `luenberger dare`, in the form of MATLAB and scipy: with S, E or both where they are given.

use super::{from, json_output};
use crate::answer::Answer;
use crate::failure::Failure;
use crate::input::{Source, json};
use crate::numbers;
use luenberger_linalg::{LinalgError, Riccati};
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

type Plain = fn(&DMatrix<f64>, &DMatrix<f64>, &DMatrix<f64>, &DMatrix<f64>) -> Result<Riccati, LinalgError>;
type General = fn([&DMatrix<f64>; 6]) -> Result<Riccati, LinalgError>;

/// `A'X + X A - X B R^-1 B'X + Q = 0`, `K = R^-1 B'X`.
pub(crate) fn care(source: &Source) -> Result<Answer, Failure> {
    solve(
        source,
        |a, b, q, r| luenberger_linalg::care(a, b, q, r),
        |[a, b, q, r, s, e]| luenberger_linalg::generalized_care(a, b, q, r, s, e),
        [
            "A'X + X A - X B R^-1 B'X + Q = 0, K = R^-1 B'X",
            "A'X E + E'X A - (E'X B + S) R^-1 (B'X E + S') + Q = 0, K = R^-1 (B'X E + S')",
        ],
    )
}

/// `A'X A - X - A'X B (R + B'X B)^-1 B'X A + Q = 0`, `K = (R + B'X B)^-1 B'X A`.
pub(crate) fn dare(source: &Source) -> Result<Answer, Failure> {
    solve(
        source,
        |a, b, q, r| luenberger_linalg::dare(a, b, q, r),
        |[a, b, q, r, s, e]| luenberger_linalg::generalized_dare(a, b, q, r, s, e),
        [
            "A'X A - X - A'X B (R + B'X B)^-1 B'X A + Q = 0, K = (R + B'X B)^-1 B'X A",
            "A'X A - E'X E - (A'X B + S) (R + B'X B)^-1 (B'X A + S') + Q = 0, K = (R + B'X B)^-1 (B'X A + S')",
        ],
    )
}

fn solve(source: &Source, plain: Plain, general: General, equations: [&str; 2]) -> Result<Answer, Failure> {
    let [a, b, q, r, s, e] = json::some_matrices(source, ["a", "b", "q", "r", "s", "e"], 4)?;
    let [a, b, q, r] = [a, b, q, r].map(Option::unwrap_or_default);
    if s.is_none() && e.is_none() {
        let found = plain(&a, &b, &q, &r).map_err(from(source))?;
        return regulator(equations[0], "poles of A - B K", &found);
    }
    let s = s.unwrap_or_else(|| DMatrix::zeros(b.nrows(), b.ncols()));
    let e = e.unwrap_or_else(|| DMatrix::identity(a.nrows(), a.nrows()));
    let found = general([&a, &b, &q, &r, &s, &e]).map_err(from(source))?;
    regulator(equations[1], "poles of (A - B K, E)", &found)
}

fn regulator(equation: &str, poles: &str, found: &Riccati) -> Result<Answer, Failure> {
    let condition = Some(found.condition).filter(|condition| condition.is_finite());
    let (error, forward_error) = numbers::forward_error(found.forward_error);
    let text = format!(
        "{equation}\n{}{}{}residual {} (relative), condition {}, {error}\n",
        numbers::matrix("X", &found.x),
        numbers::matrix("K", &found.k),
        numbers::list(poles, &found.poles),
        numbers::size(found.residual),
        condition.map_or("unknown".to_owned(), numbers::size)
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
