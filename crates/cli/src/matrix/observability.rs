//! `luenberger obsv`.

use super::{from, json_output};
use crate::answer::Answer;
use crate::arguments::ObservabilityInput;
use crate::failure::Failure;
use crate::input::given::Pair;
use crate::input::json;
use crate::numbers;
use luenberger_lmi::proof_matrix;
use luenberger_proof::statement::hidden_motion;
use nalgebra::Complex;
use serde::Serialize;

#[derive(Serialize)]
struct Seen {
    rank: usize,
    unobservable: Vec<Hidden>,
    margins: Vec<Margin>,
    /// The relative tolerance, if one is given.
    #[serde(skip_serializing_if = "Option::is_none")]
    tolerance: Option<f64>,
}

#[derive(Serialize)]
struct Hidden {
    eigenvalue: [f64; 2],
    direction: Vec<[f64; 2]>,
}

#[derive(Serialize)]
struct Margin {
    eigenvalue: [f64; 2],
    margin: f64,
}

/// Observability margin of each mode.
pub(crate) fn obsv(input: &ObservabilityInput) -> Result<Answer, Failure> {
    let source = input.data.given();
    let [a, c] = json::matrices(source, Pair::KEYS)?;
    let found = match input.tolerance {
        Some(tolerance) => luenberger_linalg::observability_within(&a, &c, tolerance),
        None => luenberger_linalg::observability(&a, &c),
    };
    let found = found.map_err(from(source))?;
    let is_hidden = || hidden_motion(&proof_matrix(&a), &proof_matrix(&c)).is_ok_and(|hidden| hidden.is_some());
    let verdict = if found.is_observable() {
        "observable".to_owned()
    } else if is_hidden() {
        "not observable".to_owned()
    } else if let Some(tolerance) = input.tolerance {
        format!("not observable within the tolerance {}", numbers::number(tolerance))
    } else {
        "not observable to working precision".to_owned()
    };
    let mut text = format!("rank {} of {}: {verdict}\n", found.rank, found.order);
    for mode in &found.modes {
        let (eigenvalue, margin) = (numbers::complex(mode.eigenvalue), numbers::margin(mode.margin));
        text.extend(["  mode ", &eigenvalue, ": margin ", &margin, "\n"]);
    }
    for mode in &found.unobservable {
        // The direction has unit length.
        let entry =
            |v: &Complex<f64>| numbers::complex(Complex::new(numbers::beside(v.re, 1.0), numbers::beside(v.im, 1.0)));
        let direction: Vec<String> = mode.direction.iter().map(entry).collect();
        text.extend(["unobservable: ", &numbers::complex(mode.eigenvalue), " along [", &direction.join(", "), "]\n"]);
    }
    let hidden = |mode: &luenberger_linalg::Mode| Hidden {
        eigenvalue: json_output::pair(mode.eigenvalue),
        direction: json_output::pairs(mode.direction.iter()),
    };
    let margin =
        |mode: &luenberger_linalg::Mode| Margin { eigenvalue: json_output::pair(mode.eigenvalue), margin: mode.margin };
    let seen = Seen {
        rank: found.rank,
        unobservable: found.unobservable.iter().map(hidden).collect(),
        margins: found.modes.iter().map(margin).collect(),
        tolerance: input.tolerance,
    };
    Ok(Answer::new(text, &seen)?)
}
