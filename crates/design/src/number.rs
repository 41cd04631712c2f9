//! Numbers in formulas in their usual form: `2P`, not `2(1e0)P`.

use core::fmt;

use luenberger_proof::wording::{self, shortest, significant};
use nalgebra::{Complex, Dim, Matrix, RawStorage};

/// `x` in front of a symbol: nothing for 1.
///
/// ```
/// use luenberger_design::number::coefficient;
/// assert_eq!(format!("{}P, {}P", coefficient(2.0), coefficient(1.0)), "2P, P");
/// ```
pub fn coefficient(x: f64) -> String {
    if x == 1.0 { String::new() } else { shortest(x) }
}

/// A number of a message, with three significant digits.
pub(crate) fn short(x: f64) -> String {
    significant(x, 3)
}

/// A complex number of a message, with six significant digits.
pub(crate) fn complex(z: Complex<f64>) -> String {
    wording::complex([z.re, z.im], 6)
}

/// Significant digits of a matrix: for people, nothing is claimed with them.
pub(crate) const DIGITS: usize = 6;

/// `L = [7; 10]`, as MATLAB writes it.
pub(crate) fn write_matrix<R: Dim, C: Dim>(
    f: &mut fmt::Formatter<'_>,
    name: &str,
    m: &Matrix<f64, R, C, impl RawStorage<f64, R, C>>,
) -> fmt::Result {
    let row = |row: usize| m.row(row).iter().map(|x| significant(*x, DIGITS)).collect::<Vec<_>>().join(", ");
    writeln!(f, "{name} = [{}]", (0..m.nrows()).map(row).collect::<Vec<_>>().join("; "))
}
