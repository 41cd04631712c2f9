//! `luenberger lyap` and `luenberger dlyap`, in python-control's form, with E where it is given; the library's observer
//! form is used with `A'` for `A`.

use super::{from, json_output};
use crate::answer::Answer;
use crate::failure::Failure;
use crate::input::{Source, json};
use crate::numbers;
use nalgebra::DMatrix;
use serde::Serialize;

/// Solution of a linear matrix equation.
#[derive(Serialize)]
pub(super) struct Solution {
    x: Vec<Vec<f64>>,
    residual: f64,
    condition: f64,
    /// Bound of the relative error of x; none if no digit is certain.
    forward_error: Option<f64>,
}

/// `A X + X A' + Q = 0`, with E `A X E' + E X A' + Q = 0`.
pub(crate) fn lyap(source: &Source) -> Result<Answer, Failure> {
    let Data { a, q, e } = data(source)?;
    let Some(e) = e else {
        let found = luenberger_linalg::lyapunov(&a, &q).map_err(from(source))?;
        return solution("A X + X A' + Q = 0", &found.p, found.residual, found.condition, found.forward_error());
    };
    let found = luenberger_linalg::generalized_lyapunov(&a, &e, &q).map_err(from(source))?;
    let condition = found.standard.condition * found.condition_e;
    solution("A X E' + E X A' + Q = 0", &found.p, found.residual, condition, found.forward_error())
}

/// `A X A' - X + Q = 0`, with E `A X A' - E X E' + Q = 0`.
pub(crate) fn dlyap(source: &Source) -> Result<Answer, Failure> {
    let Data { a, q, e } = data(source)?;
    let Some(e) = e else {
        let found = luenberger_linalg::stein(&a, &q).map_err(from(source))?;
        return solution("A X A' - X + Q = 0", &found.p, found.residual, found.condition, found.forward_error());
    };
    let found = luenberger_linalg::generalized_stein(&a, &e, &q).map_err(from(source))?;
    let condition = found.standard.condition * found.condition_e;
    solution("A X A' - E X E' + Q = 0", &found.p, found.residual, condition, found.forward_error())
}

/// `A'`, `Q` and, if it is given, `E'`.
struct Data {
    a: DMatrix<f64>,
    q: DMatrix<f64>,
    e: Option<DMatrix<f64>>,
}

fn data(source: &Source) -> Result<Data, Failure> {
    let [a, q, e] = json::some_matrices(source, ["a", "q", "e"], 2)?;
    Ok(Data { a: a.unwrap_or_default().transpose(), q: q.unwrap_or_default(), e: e.map(|e| e.transpose()) })
}

/// Result of an equation with one unknown.
pub(super) fn solution(
    equation: &str,
    x: &DMatrix<f64>,
    residual: f64,
    condition: f64,
    forward_error: f64,
) -> Result<Answer, Failure> {
    let (error, forward_error) = numbers::forward_error(forward_error);
    let text = format!(
        "{equation}\n{}residual {} (relative), condition {}, {error}\n",
        numbers::matrix("X", x),
        numbers::size(residual),
        numbers::size(condition)
    );
    Ok(Answer::new(text, &Solution { x: json_output::rows(x), residual, condition, forward_error })?)
}
