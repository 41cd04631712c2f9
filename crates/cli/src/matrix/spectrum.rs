//! `luenberger eig`.

use super::{from, json_output};
use crate::answer::Answer;
use crate::failure::Failure;
use crate::input::given::{Given, Square};
use crate::input::json;
use crate::numbers;
use serde::Serialize;

#[derive(Serialize)]
struct Spectrum {
    eigenvalues: Vec<[f64; 2]>,
}

/// The eigenvalues of `A`.
pub(crate) fn eig(source: &Given) -> Result<Answer, Failure> {
    let [a] = json::matrices(source, Square::KEYS)?;
    let found = luenberger_linalg::eigenvalues(&a).map_err(from(source))?;
    Ok(Answer::new(numbers::list("eigenvalues", &found), &Spectrum { eigenvalues: json_output::pairs(&found) })?)
}
