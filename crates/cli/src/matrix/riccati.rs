//! `luenberger care` and `luenberger dare`.

use super::{from, json_output};
use crate::answer::Answer;
use crate::failure::Failure;
use crate::input::{Source, json};
use crate::numbers;
use luenberger_linalg::Riccati;
use serde::Serialize;

#[derive(Serialize)]
struct Regulator {
    x: Vec<Vec<f64>>,
    k: Vec<Vec<f64>>,
    poles: Vec<[f64; 2]>,
    residual: f64,
}

/// `A'X + X A - X B R^-1 B'X + Q = 0`, `K = R^-1 B'X`.
pub(crate) fn care(source: &Source) -> Result<Answer, Failure> {
    let [a, b, q, r] = json::matrices(source, ["a", "b", "q", "r"])?;
    let found = luenberger_linalg::care(&a, &b, &q, &r).map_err(from(source))?;
    regulator("A'X + X A - X B R^-1 B'X + Q = 0, K = R^-1 B'X", &found)
}

/// `A'X A - X - A'X B (R + B'X B)^-1 B'X A + Q = 0`, `K = (R + B'X B)^-1 B'X A`.
pub(crate) fn dare(source: &Source) -> Result<Answer, Failure> {
    let [a, b, q, r] = json::matrices(source, ["a", "b", "q", "r"])?;
    let found = luenberger_linalg::dare(&a, &b, &q, &r).map_err(from(source))?;
    regulator("A'X A - X - A'X B (R + B'X B)^-1 B'X A + Q = 0, K = (R + B'X B)^-1 B'X A", &found)
}

fn regulator(equation: &str, found: &Riccati) -> Result<Answer, Failure> {
    let text = format!(
        "{equation}\n{}{}{}residual {} (relative)\n",
        numbers::matrix("X", &found.x),
        numbers::matrix("K", &found.k),
        numbers::list("poles of A - B K", &found.poles),
        numbers::size(found.residual)
    );
    let regulator = Regulator {
        x: json_output::rows(&found.x),
        k: json_output::rows(&found.k),
        poles: json_output::pairs(&found.poles),
        residual: found.residual,
    };
    Ok(Answer::new(text, &regulator)?)
}
