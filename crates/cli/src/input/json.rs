//! JSON input of the matrix commands: matrices as lists of rows, poles as numbers or `[re, im]`.
//!
//! Only the keys of the command are accepted. Every mistake is reported with line and column.

use super::given::Given;
pub(crate) use super::json_matrix::Form;
use super::json_matrix::{Document, Found};
use crate::failure::Failure;
use nalgebra::{Complex, DMatrix};
use serde::de::DeserializeSeed;

/// The matrices with these keys; other keys are errors.
pub(crate) fn matrices<const N: usize>(source: &Given, keys: [&'static str; N]) -> Result<[DMatrix<f64>; N], Failure> {
    Ok(some_matrices(source, keys, N)?.map(Option::unwrap_or_default))
}

/// The matrices with these keys, of which all but the first `required` may be absent.
pub(crate) fn some_matrices<const N: usize>(
    source: &Given,
    keys: [&'static str; N],
    required: usize,
) -> Result<[Option<DMatrix<f64>>; N], Failure> {
    either(source, keys, &[Form { keys: &keys, required }])
}

/// The matrices of exactly one of the forms; `keys` are those of all forms.
pub(crate) fn either<const N: usize>(
    source: &Given,
    keys: [&'static str; N],
    forms: &[Form<'_>],
) -> Result<[Option<DMatrix<f64>>; N], Failure> {
    Ok(document(source, Document { keys, forms, poles: None })?.0)
}

/// Matrices, and the numbers under the key `poles`.
pub(crate) type WithPoles<const N: usize> = ([Option<DMatrix<f64>>; N], Vec<Complex<f64>>);

/// The matrices of exactly one of the forms, and the numbers under the key `poles`.
pub(crate) fn either_and_poles<const N: usize>(
    source: &Given,
    keys: [&'static str; N],
    forms: &[Form<'_>],
) -> Result<WithPoles<N>, Failure> {
    document(source, Document { keys, forms, poles: Some("poles") })
}

fn document<const N: usize>(source: &Given, document: Document<'_, N>) -> Result<Found<N>, Failure> {
    let text = source.text()?;
    let mut reader = serde_json::Deserializer::from_str(&text);
    document.deserialize(&mut reader).and_then(|found| reader.end().map(|()| found)).map_err(|error| {
        let (line, column) = (error.line().max(1), error.column().max(1));
        let whole = error.to_string();
        let place = format!(" at line {} column {}", error.line(), error.column());
        let mut message = whole.strip_suffix(&place).unwrap_or(&whole).to_owned();
        if matches!(source, Given::Here(_)) {
            return Failure::Given(message);
        }
        if let Some(word) = not_a_number(&text, line, column) {
            message = format!("{word} is not a JSON number, and every entry must be finite");
        } else if text.trim().is_empty() {
            "the input is empty, and a JSON object is expected".clone_into(&mut message);
        }
        Failure::Json { origin: source.to_string(), line, column, message }
    })
}

/// The word for a non-finite number (NaN, Infinity), which Python's `json.dump` and others write, if one is at the
/// place where the reader stopped.
fn not_a_number(text: &str, line: usize, column: usize) -> Option<&'static str> {
    let line = text.lines().nth(line.checked_sub(1)?)?;
    // The column is that of the first letter, or of the letter after a sign.
    let from = line.get(column.saturating_sub(2)..)?;
    let word = from.trim_start_matches([' ', '[', ',', ':', '\t']);
    ["NaN", "nan", "-Infinity", "Infinity", "-inf", "inf"]
        .into_iter()
        .find(|name| word.starts_with(name) && from.len() - word.len() <= 1)
}
