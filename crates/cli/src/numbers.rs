//! Number formats of the text output: six significant digits, matrices aligned at their decimal points.

use luenberger_proof::wording::{self, significant};
use nalgebra::{Complex, DMatrix};

/// A number with six significant digits: `0.333333`, `-12`, `1.5e-9`.
pub(crate) fn number(x: f64) -> String {
    significant(x, 6)
}

/// A residual or a condition number, with two digits.
pub(crate) fn size(x: f64) -> String {
    significant(x, 2)
}

/// A bound of a relative error in words, and the bound itself if it leaves a digit.
pub(crate) fn forward_error(bound: f64) -> (String, Option<f64>) {
    if bound < 1.0 {
        (format!("error at most {}", size(bound)), Some(bound))
    } else {
        ("no digit is certain".to_owned(), None)
    }
}

/// A relative margin; values below the rounding error are printed as zero.
pub(crate) fn margin(x: f64) -> String {
    size(beside(x, 1.0))
}

/// `x`, or 0 where it is at the level of rounding errors of numbers as large as `largest`.
pub(crate) fn beside(x: f64, largest: f64) -> f64 {
    if x.abs() <= 8.0 * f64::EPSILON * largest { 0.0 } else { x }
}

/// A complex number: `-1 + 2i`, or a real one alone.
pub(crate) fn complex(z: Complex<f64>) -> String {
    wording::complex([z.re, z.im], 6)
}

/// `name =` and the rows, the columns aligned at their decimal points.
pub(crate) fn matrix(name: &str, m: &DMatrix<f64>) -> String {
    let columns: Vec<Vec<String>> = m.column_iter().map(|column| aligned(column.iter().copied())).collect();
    let mut text = format!("{name} =\n");
    for row in 0..m.nrows() {
        let line: Vec<&str> = columns.iter().map(|column| column[row].as_str()).collect();
        text.push_str(format!("  {}", line.join("  ")).trim_end());
        text.push('\n');
    }
    text
}

/// `name =` and one complex number on each line.
pub(crate) fn list<'a>(name: &str, values: impl IntoIterator<Item = &'a Complex<f64>>) -> String {
    let mut text = format!("{name} =\n");
    for value in values {
        text.extend(["  ", &complex(*value), "\n"]);
    }
    text
}

fn aligned(column: impl Iterator<Item = f64>) -> Vec<String> {
    let parts: Vec<(String, String)> = column
        .map(|x| {
            let text = number(x);
            let at = text.find(['.', 'e']).unwrap_or(text.len());
            let (whole, rest) = text.split_at(at);
            (whole.to_owned(), rest.to_owned())
        })
        .collect();
    let left = parts.iter().map(|part| part.0.len()).max().unwrap_or_default();
    let right = parts.iter().map(|part| part.1.len()).max().unwrap_or_default();
    parts.iter().map(|(whole, rest)| format!("{whole:>left$}{rest:<right$}")).collect()
}
