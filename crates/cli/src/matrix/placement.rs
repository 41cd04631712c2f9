//! `luenberger place`: K of a controller from `a` and `b`, L of an observer from `a` and `c`.

use super::{from, json_output};
use crate::answer::Answer;
use crate::failure::Failure;
use crate::input::Source;
use crate::input::json::{self, Form};
use crate::numbers;
use luenberger_linalg::Placement;
use serde::Serialize;

/// Exactly one of `k` and `l` is present.
#[derive(Serialize)]
struct Gain {
    #[serde(skip_serializing_if = "Option::is_none")]
    k: Option<Vec<Vec<f64>>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    l: Option<Vec<Vec<f64>>>,
    poles: Vec<[f64; 2]>,
    condition: f64,
}

/// `K` with the eigenvalues of `A - B K` at the poles, or `L` with those of `A - L C` there.
pub(crate) fn place(source: &Source) -> Result<Answer, Failure> {
    let forms = [Form { keys: &["a", "b"], required: 2 }, Form { keys: &["a", "c"], required: 2 }];
    let ([a, b, c], poles) = json::either_and_poles(source, ["a", "b", "c"], &forms)?;
    let a = a.unwrap_or_default();
    if let Some(c) = c {
        let found = luenberger_linalg::place_observer(&a, &c, &poles).map_err(from(source))?;
        let text = text(["A - L C", "L"], "L (y - C xhat) corrects the estimate", &found);
        return Ok(Answer::new(text, &Gain { l: Some(json_output::rows(&found.gain)), ..gain(&found) })?);
    }
    let found = luenberger_linalg::place(&a, &b.unwrap_or_default(), &poles).map_err(from(source))?;
    let text = text(["A - B K", "K"], "u = -K x", &found);
    Ok(Answer::new(text, &Gain { k: Some(json_output::rows(&found.gain)), ..gain(&found) })?)
}

fn text([closed, name]: [&str; 2], sign: &str, found: &Placement) -> String {
    format!(
        "{closed} has the poles below: {sign}\n{}{}relative error of the poles {}, condition number of the eigenvectors {}\n",
        numbers::matrix(name, &found.gain),
        numbers::list(&format!("poles of {closed}"), &found.poles),
        numbers::size(found.deviation),
        numbers::size(found.condition)
    )
}

fn gain(found: &Placement) -> Gain {
    Gain { k: None, l: None, poles: json_output::pairs(&found.poles), condition: found.condition }
}
