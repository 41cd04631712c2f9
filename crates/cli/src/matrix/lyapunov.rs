//! `luenberger lyap` and `luenberger dlyap`, with E where it is given: in python-control's form, or with `--transposed`
//! in the library's, the observer's. Python-control's form of A is the observer's of `A'`.

use super::{from, json_output};
use crate::answer::Answer;
use crate::arguments::LyapunovInput;
use crate::failure::Failure;
use crate::input::given::Lyapunov;
use crate::input::json;
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

/// `A X + X A' + Q = 0`, with E `A X E' + E X A' + Q = 0`; transposed `A'X + X A + Q = 0`, `A'X E + E'X A + Q = 0`.
pub(crate) fn lyap(input: &LyapunovInput) -> Result<Answer, Failure> {
    let Data { a, q, e } = data(input)?;
    let Some(e) = e else {
        let equation = if input.transposed { "A'X + X A + Q = 0" } else { "A X + X A' + Q = 0" };
        let found = luenberger_linalg::lyapunov(&a, &q).map_err(from(input.data.given()))?;
        return solution(equation, &found.p, found.residual, found.condition, found.forward_error());
    };
    let equation = if input.transposed { "A'X E + E'X A + Q = 0" } else { "A X E' + E X A' + Q = 0" };
    let found = luenberger_linalg::generalized_lyapunov(&a, &e, &q).map_err(from(input.data.given()))?;
    let condition = found.standard.condition * found.condition_e;
    solution(equation, &found.p, found.residual, condition, found.forward_error())
}

/// `A X A' - X + Q = 0`, with E `A X A' - E X E' + Q = 0`; transposed `A'X A - X + Q = 0`, `A'X A - E'X E + Q = 0`.
pub(crate) fn dlyap(input: &LyapunovInput) -> Result<Answer, Failure> {
    let Data { a, q, e } = data(input)?;
    let Some(e) = e else {
        let equation = if input.transposed { "A'X A - X + Q = 0" } else { "A X A' - X + Q = 0" };
        let found = luenberger_linalg::stein(&a, &q).map_err(from(input.data.given()))?;
        return solution(equation, &found.p, found.residual, found.condition, found.forward_error());
    };
    let equation = if input.transposed { "A'X A - E'X E + Q = 0" } else { "A X A' - E X E' + Q = 0" };
    let found = luenberger_linalg::generalized_stein(&a, &e, &q).map_err(from(input.data.given()))?;
    let condition = found.standard.condition * found.condition_e;
    solution(equation, &found.p, found.residual, condition, found.forward_error())
}

/// The data of the observer's form: `A'`, `Q` and, if it is given, `E'`; with `--transposed` A and E as they are.
struct Data {
    a: DMatrix<f64>,
    q: DMatrix<f64>,
    e: Option<DMatrix<f64>>,
}

fn data(input: &LyapunovInput) -> Result<Data, Failure> {
    let [a, q, e] = json::some_matrices(input.data.given(), Lyapunov::KEYS, 2)?;
    let of_observer = |m: DMatrix<f64>| if input.transposed { m } else { m.transpose() };
    Ok(Data { a: of_observer(a.unwrap_or_default()), q: q.unwrap_or_default(), e: e.map(of_observer) })
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
