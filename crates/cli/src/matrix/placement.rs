//! `luenberger place`: K of a controller from `a` and `b`, L of an observer from `a` and `c`.

use super::{from, json_output};
use crate::answer::Answer;
use crate::arguments::PlacementInput;
use crate::failure::Failure;
use crate::input::given::PolePlacement;
use crate::input::json::{self, Form};
use crate::numbers;
use luenberger_linalg::{Placement, StructuredPlacement};
use nalgebra::{Complex, DMatrix};
use serde::Serialize;
use std::fmt::Write;

/// Largest relative error of a pole that passes without a warning.
const MISSED: f64 = 0.1;

/// Exactly one of `k` and `l` is present.
#[derive(Serialize)]
struct Gain {
    #[serde(skip_serializing_if = "Option::is_none")]
    k: Option<Vec<Vec<f64>>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    l: Option<Vec<Vec<f64>>>,
    poles: Vec<[f64; 2]>,
    relative_errors: Vec<f64>,
    condition: f64,
    /// With a pattern: the number of free entries, and of the poles that they move independently.
    #[serde(skip_serializing_if = "Option::is_none")]
    free: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    rank: Option<usize>,
    /// Why the gain should not be used.
    #[serde(skip_serializing_if = "Option::is_none")]
    warning: Option<String>,
}

/// `K` with the eigenvalues of `A - B K` at the poles, or `L` with those of `A - L C` there.
pub(crate) fn place(input: &PlacementInput) -> Result<Answer, Failure> {
    let source = input.data.given();
    let forms =
        [Form { keys: &["a", "b", "pattern"], required: 2 }, Form { keys: &["a", "c", "pattern"], required: 2 }];
    let ([a, b, c, pattern], poles) = json::either_and_poles(source, PolePlacement::KEYS, &forms)?;
    let a = a.unwrap_or_default();
    let pattern = pattern.map(|pattern| free_entries(&pattern)).transpose()?;
    let (names, sign) = if c.is_some() {
        (["A - L C", "L"], "L (y - C xhat) corrects the estimate")
    } else {
        (["A - B K", "K"], "u = -K x")
    };
    let b = b.unwrap_or_default();
    let (found, structure) = match (&c, pattern) {
        (Some(c), None) => (luenberger_linalg::place_observer(&a, c, &poles).map_err(from(source))?, None),
        (None, None) => (luenberger_linalg::place(&a, &b, &poles).map_err(from(source))?, None),
        (c, Some(free)) => {
            let found = match c {
                Some(c) => luenberger_linalg::place_observer_structured(&a, c, &poles, &free),
                None => luenberger_linalg::place_structured(&a, &b, &poles, &free),
            };
            let StructuredPlacement { placement, is_placed, free, rank, .. } = found.map_err(from(source))?;
            (placement, Some(Structure { is_placed, free, rank }))
        }
    };
    let relative_errors = relative_errors(&found, &poles);
    let warning = warning(&found, &poles, &relative_errors).or_else(|| {
        let missed = structure.as_ref().is_some_and(|structure| !structure.is_placed);
        missed
            .then(|| "no gain of this pattern with these poles was found: those above are the nearest found".to_owned())
    });
    let mut text = text(names, sign, &found, &relative_errors, warning.as_deref());
    if let Some(Structure { free, rank, .. }) = structure {
        _ = writeln!(text, "entries that are free {free}, poles that they move independently {rank}");
    }
    let is_negative = warning.is_some() && !input.accept_inexact;
    let rows = Some(json_output::rows(&found.gain));
    let (k, l) = if c.is_some() { (None, rows) } else { (rows, None) };
    let poles = json_output::pairs(&found.poles);
    let (free, rank) = structure.map(|structure| (structure.free, structure.rank)).unzip();
    let gain = Gain { k, l, poles, relative_errors, condition: found.condition, free, rank, warning };
    Ok(Answer::new(text, &gain)?.negative(is_negative))
}

/// How a gain with zeros was found.
struct Structure {
    is_placed: bool,
    free: usize,
    rank: usize,
}

/// The free entries of a gain: those that are 1 in a matrix of zeros and ones.
fn free_entries(pattern: &DMatrix<f64>) -> Result<DMatrix<bool>, Failure> {
    if pattern.iter().all(|entry| *entry == 0.0 || *entry == 1.0) {
        return Ok(pattern.map(|entry| entry == 1.0));
    }
    Err(Failure::Usage("\"pattern\" has 0 where the gain must be 0, and 1 elsewhere"))
}

/// The error of each pole, relative to the desired one; of one at zero, to the largest and to A.
fn relative_errors(found: &Placement, desired: &[Complex<f64>]) -> Vec<f64> {
    let relative = |(error, pole): (&f64, &Complex<f64>)| {
        if *error == 0.0 {
            0.0
        } else if pole.norm() == 0.0 {
            found.deviation
        } else {
            error / pole.norm()
        }
    };
    found.errors.iter().zip(desired).map(relative).collect()
}

/// A region of stability: its name, and whether a pole is in it.
type Side = (&'static str, fn(&Complex<f64>) -> bool);

/// Poles that are missed, or on the wrong side: of the imaginary axis if all desired ones are on its left, else of the
/// unit circle if all are within.
fn warning(found: &Placement, desired: &[Complex<f64>], relative_errors: &[f64]) -> Option<String> {
    let sides: [Side; 2] =
        [("the left half-plane", |pole| pole.re < 0.0), ("the unit circle", |pole| pole.norm() < 1.0)];
    let side = sides.iter().find(|(_, inside)| desired.iter().all(inside));
    let left = side.and_then(|(name, inside)| found.poles.iter().find(|pole| !inside(pole)).map(|pole| (name, pole)));
    if let Some((name, pole)) = left {
        return Some(format!("the closed loop is unstable: the pole {} is not in {name}", numbers::complex(*pole)));
    }
    let (largest, at) = relative_errors.iter().zip(desired).max_by(|x, y| x.0.total_cmp(y.0))?;
    (*largest > MISSED)
        .then(|| format!("the pole {} is missed by {} times its size", numbers::complex(*at), numbers::size(*largest)))
}

fn text(
    [closed, name]: [&str; 2],
    sign: &str,
    found: &Placement,
    relative_errors: &[f64],
    warning: Option<&str>,
) -> String {
    let largest = relative_errors.iter().copied().fold(0.0, f64::max);
    let warning = warning.map(|text| format!("warning: {text}\n")).unwrap_or_default();
    format!(
        "{closed} has the poles below: {sign}\n{}{}largest relative error of a pole {}, condition number of the eigenvectors {}\n{warning}",
        numbers::matrix(name, &found.gain),
        numbers::list(&format!("poles of {closed}"), &found.poles),
        numbers::size(largest),
        numbers::size(found.condition)
    )
}
