//! `luenberger eig`.

use super::{from, table, written};
use crate::answer::Answer;
use crate::failure::Failure;
use crate::input::{Source, json};
use serde::Serialize;

#[derive(Serialize)]
struct Spectrum {
    eigenvalues: Vec<[f64; 2]>,
}

/// The eigenvalues of `A`.
pub(crate) fn eig(source: &Source) -> Result<Answer, Failure> {
    let [a] = json::matrices(source, ["a"])?;
    let found = luenberger_linalg::eigenvalues(&a).map_err(from(source))?;
    Ok(Answer::new(table::list("eigenvalues", &found), &Spectrum { eigenvalues: written::pairs(&found) })?)
}
