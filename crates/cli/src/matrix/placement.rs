//! `luenberger place`.

use super::{from, json_output};
use crate::answer::Answer;
use crate::failure::Failure;
use crate::input::{Source, json};
use crate::numbers;
use serde::Serialize;

#[derive(Serialize)]
struct Gain {
    k: Vec<Vec<f64>>,
    poles: Vec<[f64; 2]>,
    condition: f64,
}

/// `K` with the eigenvalues of `A - B K` at the poles.
pub(crate) fn place(source: &Source) -> Result<Answer, Failure> {
    let ([a, b], poles) = json::matrices_and_poles(source, ["a", "b"])?;
    let found = luenberger_linalg::place(&a, &b, &poles).map_err(from(source))?;
    let text = format!(
        "A - B K has the poles below: u = -K x\n{}{}relative error of the poles {}, condition number of the eigenvectors {}\n",
        numbers::matrix("K", &found.gain),
        numbers::list("poles of A - B K", &found.poles),
        numbers::size(found.deviation),
        numbers::size(found.condition)
    );
    let gain =
        Gain { k: json_output::rows(&found.gain), poles: json_output::pairs(&found.poles), condition: found.condition };
    Ok(Answer::new(text, &gain)?)
}
