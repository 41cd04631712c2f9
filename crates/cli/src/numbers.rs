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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_rounding_error_is_told_as_zero() {
        assert_eq!(
            (margin(2.7e-126), margin(0.333), margin(1e-14)),
            ("0".to_owned(), "0.33".to_owned(), "1e-14".to_owned())
        );
        // Digits beyond this are rounding error for large numbers, and negligible for small ones.
        assert_eq!((beside(1e-4, 1e12), beside(-1e-17, 1e-12)), (0.0, -1e-17));
    }

    #[test]
    fn columns_stand_at_their_decimal_points() {
        let m = DMatrix::from_row_slice(2, 2, &[1.25, -10.0, -100.0, 0.5]);
        assert_eq!(matrix("X", &m), "X =\n     1.25  -10\n  -100       0.5\n");
        assert_eq!(complex(Complex::new(-1.0, -2.0)), "-1 - 2i");
        assert_eq!(complex(Complex::new(-1.0, 0.0)), "-1");
    }
}
