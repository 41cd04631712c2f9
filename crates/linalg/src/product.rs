//! Matrix products by faer on nalgebra's storage, without a copy.
//!
//! Single-threaded: several equations can be solved in parallel by the caller.

use faer::linalg::matmul::matmul;
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::{Accum, MatMut, MatRef, Par};
use nalgebra::DMatrix;

/// Read-only faer view of the matrix.
pub fn view(m: &DMatrix<f64>) -> MatRef<'_, f64> {
    MatRef::from_column_major_slice(m.as_slice(), m.nrows(), m.ncols())
}

/// Mutable faer view of the matrix.
pub fn view_mut(m: &mut DMatrix<f64>) -> MatMut<'_, f64> {
    let (rows, cols) = m.shape();
    MatMut::from_column_major_slice_mut(m.as_mut_slice(), rows, cols)
}

/// Up to this many multiplications a plain loop is faster than faer's kernel selection.
const LOOP: usize = 27;

/// `D := D + alpha L R` ([`Accum::Add`]) or `D := alpha L R` ([`Accum::Replace`]).
pub fn multiply(mut d: MatMut<'_, f64>, accum: Accum, alpha: f64, l: MatRef<'_, f64>, r: MatRef<'_, f64>) {
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
