//! Matrix products by faer on nalgebra's storage, without a copy.
//!
//! Single-threaded: several equations can be solved in parallel by the caller.

use faer::linalg::matmul::matmul;
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::{Accum, MatMut, MatRef, Par};
use nalgebra::DMatrix;

/// Read-only faer view of the matrix.
pub(crate) fn view(m: &DMatrix<f64>) -> MatRef<'_, f64> {
    MatRef::from_column_major_slice(m.as_slice(), m.nrows(), m.ncols())
}

/// Mutable faer view of the matrix.
pub(crate) fn view_mut(m: &mut DMatrix<f64>) -> MatMut<'_, f64> {
    let (rows, cols) = m.shape();
    MatMut::from_column_major_slice_mut(m.as_mut_slice(), rows, cols)
}

/// Up to this many multiplications a plain loop is faster than faer's kernel selection.
const LOOP: usize = 27;

/// `D := D + alpha L R` ([`Accum::Add`]) or `D := alpha L R` ([`Accum::Replace`]).
pub(crate) fn multiply(mut d: MatMut<'_, f64>, accum: Accum, alpha: f64, l: MatRef<'_, f64>, r: MatRef<'_, f64>) {
    let (rows, cols, inner) = (d.nrows(), d.ncols(), l.ncols());
    if rows * cols * inner <= LOOP {
        for j in 0..cols {
            for i in 0..rows {
                let sum: f64 = (0..inner).map(|k| l[(i, k)] * r[(k, j)]).sum();
                let before = if accum == Accum::Add { d[(i, j)] } else { 0.0 };
                d[(i, j)] = before + alpha * sum;
            }
        }
        return;
    }
    matmul(d, accum, l, r, alpha, Par::Seq);
}

/// Up to this order the whole product is faster than its upper triangle.
const WHOLE: usize = 24;

/// As [`multiply`] for the upper triangle of `D`; entries below it are undefined afterwards.
pub(crate) fn multiply_upper(d: MatMut<'_, f64>, accum: Accum, alpha: f64, l: MatRef<'_, f64>, r: MatRef<'_, f64>) {
    if d.nrows() <= WHOLE {
        return multiply(d, accum, alpha, l, r);
    }
    let full = BlockStructure::Rectangular;
    triangular::matmul(d, BlockStructure::TriangularUpper, accum, l, full, r, full, alpha, Par::Seq);
}

/// Copies the upper triangle below the diagonal.
pub(crate) fn mirror(mut d: MatMut<'_, f64>) {
    for j in 0..d.ncols() {
        for i in 0..j {
            d[(j, i)] = d[(i, j)];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Both code paths, for all shapes and transpositions; integers make the sums exact.
    #[test]
    fn products_of_any_shape() {
        for (rows, inner, cols) in [(1, 1, 1), (3, 3, 3), (2, 0, 3), (0, 2, 2), (3, 4, 3), (1, 27, 1), (5, 6, 7)] {
            let l = DMatrix::from_fn(rows, inner, |i, k| (1 + i + 3 * k) as f64);
            let r = DMatrix::from_fn(inner, cols, |k, j| (2 + 5 * k) as f64 - j as f64);
            let start = DMatrix::from_fn(rows, cols, |i, j| (i * j) as f64);
            let (lt, rt) = (l.transpose(), r.transpose());
            for (left, right) in [(view(&l), view(&r)), (view(&lt).transpose(), view(&rt).transpose())] {
                let (mut added, mut replaced) = (start.clone(), DMatrix::from_element(rows, cols, f64::NAN));
                multiply(view_mut(&mut added), Accum::Add, -2.0, left, right);
                multiply(view_mut(&mut replaced), Accum::Replace, 3.0, left, right);
                assert_eq!(added, &start - &l * &r * 2.0);
                assert_eq!(replaced, &l * &r * 3.0);
            }
        }
    }
}
