//! `luenberger lyap` and `luenberger dlyap`, in python-control's form; the library's observer form is used with `A'`
//! for `A`.

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

/// `A X + X A' + Q = 0`.
pub(crate) fn lyap(source: &Source) -> Result<Answer, Failure> {
    let [a, q] = json::matrices(source, ["a", "q"])?;
    let found = luenberger_linalg::lyapunov(&a.transpose(), &q).map_err(from(source))?;
    solution("A X + X A' + Q = 0", &found.p, found.residual, found.condition, found.forward_error())
}

/// `A X A' - X + Q = 0`.
pub(crate) fn dlyap(source: &Source) -> Result<Answer, Failure> {
    let [a, q] = json::matrices(source, ["a", "q"])?;
    let found = luenberger_linalg::stein(&a.transpose(), &q).map_err(from(source))?;
    solution("A X A' - X + Q = 0", &found.p, found.residual, found.condition, found.forward_error())
}

/// Result of an equation with one unknown.
pub(super) fn solution(
    equation: &str,
    x: &DMatrix<f64>,
    residual: f64,
    condition: f64,
    forward_error: f64,
) -> Result<Answer, Failure> {
    let forward_error = Some(forward_error).filter(|bound| *bound < 1.0);
    let error = forward_error
        .map_or("no digit is certain".to_owned(), |bound| format!("error at most {}", numbers::size(bound)));
    let text = format!(
        "{equation}\n{}residual {} (relative), condition {}, {error}\n",
        numbers::matrix("X", x),
        numbers::size(residual),
        numbers::size(condition)
    );
    Ok(Answer::new(text, &Solution { x: json_output::rows(x), residual, condition, forward_error })?)
}
