//! Matrices and complex numbers as JSON: lists of rows, and `[re, im]`.

use nalgebra::{Complex, DMatrix};

/// The rows of a matrix.
pub(super) fn rows(m: &DMatrix<f64>) -> Vec<Vec<f64>> {
    m.row_iter().map(|row| row.iter().copied().collect()).collect()
}

/// A complex number.
pub(super) fn pair(z: Complex<f64>) -> [f64; 2] {
    [z.re, z.im]
}

/// Complex numbers.
pub(super) fn pairs<'a>(list: impl IntoIterator<Item = &'a Complex<f64>>) -> Vec<[f64; 2]> {
    list.into_iter().map(|z| pair(*z)).collect()
}
